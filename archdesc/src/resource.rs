//! [`ResourceGraph`]: the machine as a router sees it. Derived from [`Srp`], never edited.
//!
//! A value lives, cycle by cycle, in *places*: the output register of a unit, its predicate
//! output, or a register file. From a place it can be *read* into an operand of a unit in the same
//! cycle (or `delay` cycles later over a registered link), or *transferred* into a register file,
//! where it can be read from the next cycle on.
//!
//! Rules of time, which the checker and both simulators follow:
//! * an operation issued at `t` with latency `l` reads its operands at `t`; its result stands in the
//!   unit's output, and in at most one register file the unit writes, from cycle `t + l`;
//! * an output keeps its value until the next result of the unit replaces it;
//! * a transfer over a link of delay `d` of a value that stands in an output at `t` stands in the
//!   file from cycle `t + d + 1`;
//! * a register may be read in the very cycle before the one in which its next value stands there.

use crate::arch::{FileKind, Fu, Link, RegFile, Srp};
use crate::entity;
use crate::entity::{Entity, EntityMap};
use crate::isa::{Opcode, Ty};

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
    /// The link it goes over; `None` for the unit's own output and for register files.
    pub link: Option<Link>,
}

/// A way from an output into a register file, past the unit that owns the file's port.
#[derive(Clone, Copy, Debug)]
pub struct Transfer {
    /// The output it starts from.
    pub from: Place,
    /// The file it ends in.
    pub to: Place,
    /// Cycles on the link; the value stands in the file `delay + 1` cycles later.
    pub delay: u32,
    /// Widest value it carries, in bits.
    pub width: u32,
    /// The link it goes over.
    pub link: Link,
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
    /// The places that each unit can read, in a fixed order: own output, own predicate output, links, files.
    pub reads: EntityMap<Fu, Vec<ReadPath>>,
    /// Files that each unit's results can be written into directly.
    pub writes: EntityMap<Fu, Vec<Place>>,
    /// Transfers out of each place.
    pub transfers: EntityMap<Place, Vec<Transfer>>,
}

impl ResourceGraph {
    /// The routing resources of `srp`.
    pub fn of(srp: &Srp) -> ResourceGraph {
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

        let mut graph = ResourceGraph {
            reads: EntityMap::filled(srp.fus.len(), Vec::new()),
            writes: EntityMap::filled(srp.fus.len(), Vec::new()),
            transfers: EntityMap::filled(places.len(), Vec::new()),
            places,
            out,
            pred_out,
            file,
        };
        graph.add_outputs(srp);
        graph.add_files(srp);
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
                    link: None,
                });
            }
        }
        for (link, l) in srp.links.iter() {
            for (from, width) in self.carried(srp, link) {
                let path = ReadPath {
                    from,
                    to: l.to,
                    delay: l.delay,
                    width,
                    link: Some(link),
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
                    link: None,
                });
            }
            for &fu in &spec.writers {
                self.writes[fu].push(place);
                if !spec.from_links {
                    continue;
                }
                for (link, l) in srp.links.iter().filter(|(_, l)| l.to == fu) {
                    for (from, width) in self.carried(srp, link) {
                        let width = width.min(spec.width);
                        let transfer = Transfer {
                            from,
                            to: place,
                            delay: l.delay,
                            width,
                            link,
                        };
                        self.transfers[from].push(transfer);
                    }
                }
            }
        }
    }

    /// The outputs that a link carries, each with the width of its widest value there. A link of
    /// the predicate network does not carry the data output of a unit whose predicates have their
    /// own.
    fn carried(&self, srp: &Srp, link: Link) -> Vec<(Place, u32)> {
        let l = &srp.links[link];
        let predicates_only = l.width == 1 && srp.fus[l.from].pred_out;
        self.outputs(l.from)
            .map(|from| (from, self.places[from].width))
            .filter(|&(_, width)| width == 1 || !predicates_only)
            .map(|(from, width)| (from, width.min(l.width)))
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
        }
    }

    /// True if the registers of `place` advance with the iteration.
    pub fn rotates(&self, srp: &Srp, place: Place) -> bool {
        self.as_file(place)
            .is_some_and(|rf| srp.files[rf].kind == FileKind::Rotating)
    }

    /// The index of the first place that is a file; the ones before are outputs.
    pub fn first_file(&self) -> usize {
        self.file
            .values()
            .next()
            .map_or(self.places.len(), |p| p.index())
    }
}
