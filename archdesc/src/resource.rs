//! [`ResourceGraph`]: the machine as a router sees it. Derived from [`Srp`], never edited.
//!
//! A value lives, cycle by cycle, in *places*: the output register of a unit, its predicate
//! output, a register file, or for a single cycle a wire. From a place it can be *read* into an operand of
//! a unit in the same cycle (or `delay` cycles later over a registered link), *transferred* into a register
//! file, where it can be read from the next cycle on, or go on to a wire by a *hop*.
//!
//! Rules of time, which the checker and both simulators follow:
//! * an operation issued at `t` with latency `l` reads its operands at `t`; its result stands in the
//!   unit's output, and in at most one register file the unit writes, from cycle `t + l`;
//! * an output keeps its value until the next result of the unit replaces it;
//! * a transfer over a link of delay `d` of a value that stands in an output at `t` stands in the
//!   file from cycle `t + d + 1`;
//! * a wire of delay `d` that takes a value at `t` has it for a unit that reads it, and for a wire that takes
//!   it from there, at `t + d`; a transfer from it stands in the file from cycle `t + d + 1`. It takes one
//!   value in a cycle, from an output or from another wire, and a value that passes wires without delays
//!   passes [`Srp::hops`] of them at most;
//! * a register may be read in the very cycle before the one in which its next value stands there.

use crate::arch::{Carrier, FileKind, Fu, Input, RegFile, Srp, Wire, WireSpec};
use crate::entity;
use crate::entity::EntityMap;
use crate::isa::{Opcode, Ty};
use std::collections::BTreeSet;

entity! {
    /// A place where a value can stand.
    Place = "pl";
}

/// The kind of a [`Place`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceKind {
    /// The output register of a unit: one value.
    Out(Fu),
    /// The predicate output register of a unit: one value.
    PredOut(Fu),
    /// A register file: as many values as it has registers.
    File(RegFile),
    /// A wire: one value, for one cycle.
    Wire {
        /// The wire.
        wire: Wire,
        /// How many wires the value has passed in this cycle, this one among them; 0 where the graph does not
        /// tell them apart.
        hop: u32,
    },
}

/// A place and what fits in it.
#[derive(Clone, Copy, Debug)]
pub struct PlaceSpec {
    /// Its kind.
    pub kind: PlaceKind,
    /// Widest value it holds, in bits.
    pub width: u32,
    /// Values it holds at once.
    pub capacity: u32,
}

/// A way from a place into the operands of a unit.
#[derive(Clone, Copy, Debug)]
pub struct ReadPath {
    /// Where the value stands.
    pub from: Place,
    /// The unit that reads it.
    pub to: Fu,
    /// Cycles on the way: reading at `t` gets what stood there at `t - delay`.
    pub delay: u32,
    /// Widest value it carries, in bits.
    pub width: u32,
    /// The link or wire it goes over; `None` for the unit's own output and for register files.
    pub over: Option<Carrier>,
}

/// A way from an output or a wire into a register file, past the unit that owns the file's port.
#[derive(Clone, Copy, Debug)]
pub struct Transfer {
    /// The output or wire it starts from.
    pub from: Place,
    /// The file it ends in.
    pub to: Place,
    /// Cycles on the way; the value stands in the file `delay + 1` cycles later.
    pub delay: u32,
    /// Widest value it carries, in bits.
    pub width: u32,
    /// The link or wire it goes over.
    pub over: Carrier,
}

/// A way from an output or a wire on to a wire.
#[derive(Clone, Copy, Debug)]
pub struct Hop {
    /// The output or wire it starts from.
    pub from: Place,
    /// The wire it ends on.
    pub to: Place,
    /// Cycles on the way: the registers of the wire that it starts from.
    pub delay: u32,
    /// Widest value that goes this way, in bits.
    pub width: u32,
}

/// The routing resources of a machine.
#[derive(Clone, Debug)]
pub struct ResourceGraph {
    /// All places.
    pub places: EntityMap<Place, PlaceSpec>,
    /// The output register of each unit.
    pub out: EntityMap<Fu, Place>,
    /// The place of each unit's predicate results: its predicate output, or its data output.
    pub pred_out: EntityMap<Fu, Place>,
    /// The place of each file.
    pub file: EntityMap<RegFile, Place>,
    /// The places of each wire: one, or one for every number of hops by which a value can come to it.
    pub wire: EntityMap<Wire, Vec<Place>>,
    /// The places that each unit can read, in a fixed order: own output, own predicate output, links, files, wires.
    pub reads: EntityMap<Fu, Vec<ReadPath>>,
    /// Files that each unit's results can be written into directly.
    pub writes: EntityMap<Fu, Vec<Place>>,
    /// Transfers out of each place.
    pub transfers: EntityMap<Place, Vec<Transfer>>,
    /// Hops out of each place.
    pub hops: EntityMap<Place, Vec<Hop>>,
}

impl ResourceGraph {
    /// The routing resources of `srp`, each wire a single place.
    pub fn of(srp: &Srp) -> ResourceGraph {
        let wire = |wire| PlaceKind::Wire { wire, hop: 0 };
        ResourceGraph::with(srp, srp.wires.keys().map(|w| vec![wire(w)]).collect())
    }

    /// The same with a place for every number of hops by which a value can come to a wire, so that every way
    /// through the graph keeps to [`Srp::hops`] and no way goes in a circle within a cycle.
    pub fn by_hops(srp: &Srp) -> ResourceGraph {
        let mut kinds: EntityMap<Wire, Vec<PlaceKind>> =
            EntityMap::filled(srp.wires.len(), Vec::new());
        let mut before: EntityMap<Wire, bool> = EntityMap::filled(srp.wires.len(), false);
        for hop in 1..=srp.hops {
            let comes = |input: &Input| match *input {
                Input::Unit(_) => hop == 1,
                Input::Wire(from) if srp.wires[from].delay > 0 => hop == 1,
                Input::Wire(from) => before[from],
            };
            let comes = |spec: &WireSpec| spec.from.iter().any(comes);
            before = srp.wires.values().map(comes).collect();
            for wire in srp.wires.keys().filter(|&wire| before[wire]) {
                kinds[wire].push(PlaceKind::Wire { wire, hop });
            }
        }
        ResourceGraph::with(srp, kinds)
    }

    fn with(srp: &Srp, wires: EntityMap<Wire, Vec<PlaceKind>>) -> ResourceGraph {
        let mut places = EntityMap::new();
        let mut out = EntityMap::new();
        let mut pred_out = EntityMap::new();
        for (fu, spec) in srp.fus.iter() {
            let data = places.push(PlaceSpec {
                kind: PlaceKind::Out(fu),
                width: spec.width,
                capacity: 1,
            });
            out.push(data);
            pred_out.push(if spec.pred_out {
                places.push(PlaceSpec {
                    kind: PlaceKind::PredOut(fu),
                    width: 1,
                    capacity: 1,
                })
            } else {
                data
            });
        }
        let file: EntityMap<RegFile, Place> = srp
            .files
            .iter()
            .map(|(rf, f)| {
                places.push(PlaceSpec {
                    kind: PlaceKind::File(rf),
                    width: f.width,
                    capacity: f.size,
                })
            })
            .collect();

        let wire = wires.iter().map(|(wire, kinds)| {
            let place = |&kind| PlaceSpec {
                kind,
                width: srp.wires[wire].width,
                capacity: 1,
            };
            kinds.iter().map(|kind| places.push(place(kind))).collect()
        });
        let wire = wire.collect();
        let mut graph = ResourceGraph {
            reads: EntityMap::filled(srp.fus.len(), Vec::new()),
            writes: EntityMap::filled(srp.fus.len(), Vec::new()),
            transfers: EntityMap::filled(places.len(), Vec::new()),
            hops: EntityMap::filled(places.len(), Vec::new()),
            places,
            out,
            pred_out,
            file,
            wire,
        };
        graph.add_outputs(srp);
        graph.add_files(srp);
        graph.add_wires(srp);
        graph
    }

    fn add_outputs(&mut self, srp: &Srp) {
        for fu in srp.fus.keys() {
            for from in self.outputs(fu) {
                let width = self.places[from].width;
                self.reads[fu].push(ReadPath {
                    from,
                    to: fu,
                    delay: 0,
                    width,
                    over: None,
                });
            }
        }
        for (link, l) in srp.links.iter() {
            for (from, width) in self.carried(srp, l.from, l.width) {
                let path = ReadPath {
                    from,
                    to: l.to,
                    delay: l.delay,
                    width,
                    over: Some(Carrier::Link(link)),
                };
                self.reads[l.to].push(path);
            }
        }
    }

    fn add_files(&mut self, srp: &Srp) {
        for (rf, spec) in srp.files.iter() {
            let place = self.file[rf];
            for &fu in &spec.readers {
                let width = spec.width;
                self.reads[fu].push(ReadPath {
                    from: place,
                    to: fu,
                    delay: 0,
                    width,
                    over: None,
                });
            }
            for &fu in &spec.writers {
                self.writes[fu].push(place);
                if !spec.from_links {
                    continue;
                }
                for (link, l) in srp.links.iter().filter(|(_, l)| l.to == fu) {
                    for (from, width) in self.carried(srp, l.from, l.width) {
                        let width = width.min(spec.width);
                        let transfer = Transfer {
                            from,
                            to: place,
                            delay: l.delay,
                            width,
                            over: Carrier::Link(link),
                        };
                        self.transfers[from].push(transfer);
                    }
                }
            }
        }
    }

    fn add_wires(&mut self, srp: &Srp) {
        for (wire, spec) in srp.wires.iter() {
            for i in 0..self.wire[wire].len() {
                let from = self.wire[wire][i];
                for &to in &spec.to {
                    self.reads[to].push(ReadPath {
                        from,
                        to,
                        delay: spec.delay,
                        width: spec.width,
                        over: Some(Carrier::Wire(wire)),
                    });
                }
            }
            self.add_hops(srp, wire);
        }
        for (rf, spec) in srp.files.iter().filter(|(_, spec)| spec.from_links) {
            let writers: BTreeSet<Fu> = spec.writers.iter().copied().collect();
            let fed = |wire: &WireSpec| wire.to.iter().any(|fu| writers.contains(fu));
            for (wire, w) in srp.wires.iter().filter(|(_, wire)| fed(wire)) {
                for &from in &self.wire[wire] {
                    self.transfers[from].push(Transfer {
                        from,
                        to: self.file[rf],
                        delay: w.delay,
                        width: w.width.min(spec.width),
                        over: Carrier::Wire(wire),
                    });
                }
            }
        }
    }

    /// The ways on to a wire: from outputs and wires with registers by the first hop, from other wires by one
    /// hop more than they were reached by.
    fn add_hops(&mut self, srp: &Srp, wire: Wire) {
        let spec = &srp.wires[wire];
        // Hops that a value has made with this one, where it comes from, cycles, width.
        let mut ways: Vec<(u32, Place, u32, u32)> = Vec::new();
        for &input in &spec.from {
            match input {
                Input::Unit(fu) => {
                    let outputs = self.carried(srp, fu, spec.width).into_iter();
                    ways.extend(outputs.map(|(from, width)| (1, from, 0, width)));
                }
                Input::Wire(before) => {
                    let WireSpec { delay, width, .. } = srp.wires[before];
                    let width = width.min(spec.width);
                    ways.extend(self.wire[before].iter().map(|&from| {
                        let hop = if delay > 0 { 1 } else { self.hop(from) + 1 };
                        (hop, from, delay, width)
                    }));
                }
            }
        }
        for &to in &self.wire[wire] {
            let hop = self.hop(to);
            for &(_, from, delay, width) in ways.iter().filter(|way| hop == 0 || way.0 == hop) {
                self.hops[from].push(Hop {
                    from,
                    to,
                    delay,
                    width,
                });
            }
        }
    }

    /// The hops by which a value has come to a place.
    fn hop(&self, place: Place) -> u32 {
        match self.places[place].kind {
            PlaceKind::Wire { hop, .. } => hop,
            _ => 0,
        }
    }

    /// The outputs of a unit that a link or wire of a width carries, each with the width of its widest value
    /// there. Those of the predicate network do not carry the data output of a unit whose predicates have
    /// their own.
    fn carried(&self, srp: &Srp, from: Fu, most: u32) -> Vec<(Place, u32)> {
        let predicates_only = most == 1 && srp.fus[from].pred_out;
        self.outputs(from)
            .map(|from| (from, self.places[from].width))
            .filter(|&(_, width)| width == 1 || !predicates_only)
            .map(|(from, width)| (from, width.min(most)))
            .collect()
    }

    /// The output places of a unit: one, or two where predicates have their own.
    pub fn outputs(&self, fu: Fu) -> impl Iterator<Item = Place> + use<> {
        let (data, pred) = (self.out[fu], self.pred_out[fu]);
        std::iter::once(data).chain((pred != data).then_some(pred))
    }

    /// Where the result of `op` stands when `fu` runs it; `None` where it has no result.
    pub fn result_place(&self, fu: Fu, op: Opcode) -> Option<Place> {
        op.result().map(|ty| match ty {
            Ty::Pred => self.pred_out[fu],
            Ty::Word | Ty::Vec => self.out[fu],
        })
    }

    /// The wire behind a place, if it is one.
    pub fn as_wire(&self, place: Place) -> Option<Wire> {
        match self.places[place].kind {
            PlaceKind::Wire { wire, .. } => Some(wire),
            _ => None,
        }
    }

    /// The file behind a place, if it is one.
    pub fn as_file(&self, place: Place) -> Option<RegFile> {
        match self.places[place].kind {
            PlaceKind::File(rf) => Some(rf),
            _ => None,
        }
    }

    /// The name of a place, as in generated code.
    pub fn name(&self, srp: &Srp, place: Place) -> String {
        match self.places[place].kind {
            PlaceKind::Out(fu) => format!("{}_out", srp.fus[fu].name),
            PlaceKind::PredOut(fu) => format!("{}_p", srp.fus[fu].name),
            PlaceKind::File(rf) => srp.files[rf].name.clone(),
            PlaceKind::Wire { wire, .. } => srp.wires[wire].name.clone(),
        }
    }

    /// True if the registers of `place` advance with the iteration.
    pub fn rotates(&self, srp: &Srp, place: Place) -> bool {
        self.as_file(place)
            .is_some_and(|rf| srp.files[rf].kind == FileKind::Rotating)
    }
}
