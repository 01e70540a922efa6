//! [`Table`]: the modulo reservation table. It tells who takes each resource in each of the II
//! slots, and if something more fits.
//!
//! A value takes *items*: a place in a cycle, a unit's issue slot for a move, a file's port. Two
//! routes of the same value share items, so each is counted, and the resource is taken while the
//! count is not zero.

use super::problem::{Problem, Tag};
use rustc_hash::FxHashMap;
use srp_archdesc::arch::{Carrier, Fu, FuOp, Resource, Wire};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;
use std::hash::{Hash, Hasher};

/// Something that the route of a value takes. Times are those of iteration 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Item {
    /// The value stands in an output in a cycle.
    Out(Place, i32),
    /// The value stands in a register of a file in a cycle.
    Held(Place, i32, Tag),
    /// The value is written into a file and stands there from a cycle on.
    Written(Place, i32, Tag, Via),
    /// A register of a file is read by a unit in a cycle.
    Read(Place, i32, Tag, Fu),
    /// A unit issues a move of the value in a cycle, which it takes from its read path `.2`.
    Move(Fu, i32, u32, Tag),
    /// A wire takes the value in a cycle, from the place `.2`.
    Wire(Place, i32, Place),
    /// A register of a file is taken in every cycle.
    Kept(Place, Tag),
}

/// One word is hashed, without what seldom tells two items of a value apart.
impl Hash for Item {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let (kind, place, time) = match *self {
            Item::Out(place, time) => (0, place.index(), time),
            Item::Held(place, time, _) => (1, place.index(), time),
            Item::Written(place, time, ..) => (2, place.index(), time),
            Item::Read(place, time, ..) => (3, place.index(), time),
            Item::Move(fu, time, ..) => (4, fu.index(), time),
            Item::Kept(place, _) => (5, place.index(), 0),
            Item::Wire(place, time, _) => (6, place.index(), time),
        };
        state.write_u64((place as u64 * 8 + kind) << 32 | u64::from(time as u32));
    }
}

/// How a value gets into a file.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(super) enum Via {
    /// As the result of a unit.
    Result(Fu),
    /// Over a link or a wire, past the unit.
    Over(Carrier),
}

/// Who holds an issue slot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Issuer {
    /// A node of the loop.
    Node(Node),
    /// A move of a node's value.
    Move(Node),
}

/// The modulo reservation table of one attempt.
#[derive(Clone)]
pub(super) struct Table {
    /// Initiation interval.
    pub(super) ii: u32,
    /// Items of each value, counted.
    items: EntityMap<Node, FxHashMap<Item, u32>>,
    /// The writes among them: file, cycle and tag.
    writes_of: EntityMap<Node, Vec<(Place, i32, Tag)>>,
    /// Who holds each unit's issue slot.
    issue: EntityMap<Fu, Vec<Option<Issuer>>>,
    /// Which value, of which cycle, stands in each output.
    outs: EntityMap<Place, Vec<Option<(Node, i32)>>>,
    /// Which value each wire takes, of which cycle and from where.
    wires: EntityMap<Wire, Vec<Option<(Node, Item)>>>,
    /// The wire of each place that is one.
    wire_of: EntityMap<Place, Option<Wire>>,
    /// Registers held of each file.
    held: EntityMap<Place, Vec<u32>>,
    reads: EntityMap<Place, Vec<u32>>,
    writes: EntityMap<Place, Vec<u32>>,
    shared: EntityMap<Resource, Vec<u32>>,
    limits: Limits,
}

/// Capacities by place and resource.
#[derive(Clone)]
struct Limits {
    registers: EntityMap<Place, u32>,
    reads: EntityMap<Place, u32>,
    writes: EntityMap<Place, u32>,
    shared: EntityMap<Resource, u32>,
}

impl Table {
    pub(super) fn new(problem: &Problem<'_>, ii: u32) -> Table {
        let (srp, graph) = (problem.srp, &problem.graph);
        let slots = ii as usize;
        let per_file = |limit: fn(&srp_archdesc::arch::FileSpec) -> u32| {
            (graph.places.keys())
                .map(|p| graph.as_file(p).map_or(0, |rf| limit(&srp.files[rf])))
                .collect()
        };
        Table {
            ii,
            items: EntityMap::filled(problem.dfg.nodes.len(), FxHashMap::default()),
            writes_of: EntityMap::filled(problem.dfg.nodes.len(), Vec::new()),
            issue: EntityMap::filled(srp.fus.len(), vec![None; slots]),
            outs: EntityMap::filled(graph.places.len(), vec![None; slots]),
            wires: EntityMap::filled(srp.wires.len(), vec![None; slots]),
            wire_of: graph.places.keys().map(|p| graph.as_wire(p)).collect(),
            held: EntityMap::filled(graph.places.len(), vec![0; slots]),
            reads: EntityMap::filled(graph.places.len(), vec![0; slots]),
            writes: EntityMap::filled(graph.places.len(), vec![0; slots]),
            shared: EntityMap::filled(srp.resources.len(), vec![0; slots]),
            limits: Limits {
                registers: per_file(|f| f.size),
                reads: per_file(|f| f.read_ports),
                writes: per_file(|f| f.write_ports),
                shared: srp.resources.values().map(|r| r.count).collect(),
            },
        }
    }

    /// The slot of a cycle.
    pub(super) fn slot(&self, time: i32) -> usize {
        time.rem_euclid(self.ii as i32) as usize
    }

    /// Takes `count` registers of a file in every cycle, for values that do not belong to a node.
    /// False, and nothing taken, where they do not fit.
    pub(super) fn keep(&mut self, place: Place, count: u32) -> bool {
        let fits = self.held[place]
            .iter()
            .all(|&h| h + count <= self.limits.registers[place]);
        if fits {
            self.held[place].iter_mut().for_each(|h| *h += count);
        }
        fits
    }

    /// Gives registers taken by [`keep`](Self::keep) back.
    pub(super) fn unkeep(&mut self, place: Place, count: u32) {
        self.held[place].iter_mut().for_each(|h| *h -= count);
    }

    /// True if the value of `node` has this item already.
    pub(super) fn has(&self, node: Node, item: Item) -> bool {
        match item {
            Item::Out(place, time) => {
                let slot = self.slot(time);
                matches!(self.outs[place][slot], Some((n, t)) if n == node && t == time)
            }
            _ => self.items[node].contains_key(&item),
        }
    }

    /// True if the value of `node` has this item already or could take it.
    pub(super) fn fits(&self, node: Node, item: Item, timing: Option<&FuOp>) -> bool {
        if self.has(node, item) {
            return true;
        }
        match item {
            Item::Out(place, time) => self.outs[place][self.slot(time)].is_none(),
            Item::Held(place, time, _) => {
                self.held[place][self.slot(time)] < self.limits.registers[place]
            }
            Item::Written(place, time, ..) => {
                self.writes[place][self.slot(time)] < self.limits.writes[place]
            }
            Item::Read(place, time, ..) => {
                self.reads[place][self.slot(time)] < self.limits.reads[place]
            }
            Item::Move(fu, time, ..) => timing.is_some_and(|t| self.issues(fu, time, t)),
            Item::Wire(place, time, _) => self.on_wire(place, time).is_none(),
            Item::Kept(place, _) => self.held[place]
                .iter()
                .all(|&h| h < self.limits.registers[place]),
        }
    }

    /// What a wire takes in a cycle (of any iteration).
    fn on_wire(&self, place: Place, time: i32) -> Option<(Node, Item)> {
        self.wire_of[place].and_then(|wire| self.wires[wire][self.slot(time)])
    }

    fn set_wire(&mut self, place: Place, time: i32, taken: Option<(Node, Item)>) {
        let slot = self.slot(time);
        if let Some(wire) = self.wire_of[place] {
            self.wires[wire][slot] = taken;
        }
    }

    /// True if the value of `node` is already written into a file in this cycle under another tag:
    /// a result goes into at most one register of a file.
    pub(super) fn written_otherwise(&self, node: Node, place: Place, time: i32, tag: Tag) -> bool {
        self.writes_of[node]
            .iter()
            .any(|&(p, t, other)| p == place && t == time && other != tag)
    }

    /// True if a unit can issue an operation with this timing in this cycle.
    pub(super) fn issues(&self, fu: Fu, time: i32, timing: &FuOp) -> bool {
        timing.interval <= self.ii
            && (0..timing.interval as i32).all(|k| {
                let slot = self.slot(time + k);
                self.issue[fu][slot].is_none()
                    && timing
                        .uses
                        .iter()
                        .all(|&r| self.shared[r][slot] < self.limits.shared[r])
            })
    }

    /// Takes a unit's issue slot and the shared resources of an operation.
    pub(super) fn take_issue(&mut self, fu: Fu, time: i32, timing: &FuOp, issuer: Issuer) {
        for k in 0..timing.interval as i32 {
            let slot = self.slot(time + k);
            self.issue[fu][slot] = Some(issuer);
            timing.uses.iter().for_each(|&r| self.shared[r][slot] += 1);
        }
    }

    /// Gives an issue slot back.
    pub(super) fn release_issue(&mut self, fu: Fu, time: i32, timing: &FuOp) {
        for k in 0..timing.interval as i32 {
            let slot = self.slot(time + k);
            self.issue[fu][slot] = None;
            timing.uses.iter().for_each(|&r| self.shared[r][slot] -= 1);
        }
    }

    /// Who holds a unit's issue slot in a cycle.
    pub(super) fn issuer(&self, fu: Fu, time: i32) -> Option<Issuer> {
        self.issue[fu][self.slot(time)]
    }

    /// Whose value stands in an output in a cycle (of any iteration).
    pub(super) fn standing(&self, place: Place, time: i32) -> Option<Node> {
        self.outs[place][self.slot(time)].map(|(node, _)| node)
    }

    /// Takes an item for the value of `node`; the timing is that of the unit for a move.
    pub(super) fn take(&mut self, node: Node, item: Item, timing: Option<&FuOp>) {
        let count = self.items[node].entry(item).or_insert(0);
        *count += 1;
        if *count > 1 {
            return;
        }
        if let Item::Written(place, time, tag, _) = item {
            self.writes_of[node].push((place, time, tag));
        }
        match item {
            Item::Out(place, time) => {
                let slot = self.slot(time);
                self.outs[place][slot] = Some((node, time));
            }
            Item::Move(fu, time, ..) => {
                let timing = timing.expect("a move comes with its timing");
                self.take_issue(fu, time, timing, Issuer::Move(node));
            }
            Item::Wire(place, time, _) => self.set_wire(place, time, Some((node, item))),
            _ => self.count(item, 1),
        }
    }

    /// Gives an item back.
    pub(super) fn release(&mut self, node: Node, item: Item, timing: Option<&FuOp>) {
        let count = (self.items[node].get_mut(&item)).expect("only taken items are released");
        *count -= 1;
        if *count > 0 {
            return;
        }
        self.items[node].remove(&item);
        if let Item::Written(place, time, tag, _) = item {
            let writes = &mut self.writes_of[node];
            let index = writes.iter().position(|w| *w == (place, time, tag));
            writes.swap_remove(index.expect("a write that is released was taken"));
        }
        match item {
            Item::Out(place, time) => {
                let slot = self.slot(time);
                self.outs[place][slot] = None;
            }
            Item::Move(fu, time, ..) => {
                let timing = timing.expect("a move comes with its timing");
                self.release_issue(fu, time, timing);
            }
            Item::Wire(place, time, _) => self.set_wire(place, time, None),
            _ => self.count(item, u32::MAX),
        }
    }

    /// Adds `by` (modulo 2^32, so that all ones subtracts one) to what a counted item takes.
    fn count(&mut self, item: Item, by: u32) {
        let add = |counts: &mut Vec<u32>, slot: usize| counts[slot] = counts[slot].wrapping_add(by);
        match item {
            Item::Held(place, time, _) => {
                let slot = self.slot(time);
                add(&mut self.held[place], slot);
            }
            Item::Written(place, time, ..) => {
                let slot = self.slot(time);
                add(&mut self.writes[place], slot);
            }
            Item::Read(place, time, ..) => {
                let slot = self.slot(time);
                add(&mut self.reads[place], slot);
            }
            Item::Kept(place, _) => {
                (0..self.ii as usize).for_each(|slot| add(&mut self.held[place], slot));
            }
            Item::Out(..) | Item::Move(..) | Item::Wire(..) => {}
        }
    }

    /// Takes a read port of each of these files in a cycle; the first that has none left, and nothing taken, where they
    /// do not suffice.
    pub(super) fn take_reads(&mut self, places: &[Place], time: i32) -> Result<(), Place> {
        let slot = self.slot(time);
        for (i, &place) in places.iter().enumerate() {
            if self.reads[place][slot] >= self.limits.reads[place] {
                self.release_reads(&places[..i], time);
                return Err(place);
            }
            self.reads[place][slot] += 1;
        }
        Ok(())
    }

    /// Gives these read ports back.
    pub(super) fn release_reads(&mut self, places: &[Place], time: i32) {
        let slot = self.slot(time);
        places
            .iter()
            .for_each(|&place| self.reads[place][slot] -= 1);
    }

    /// The last cycle in which a value stands anywhere, and from the next of which on holding it and going on
    /// cost something; the smallest number where it has nothing.
    pub(super) fn last_cycle(&self, node: Node) -> i32 {
        let cycle = |item: &Item| match *item {
            Item::Out(_, time) | Item::Held(_, time, _) => time,
            // On wires the value goes on in the same cycle, also for nothing.
            Item::Wire(_, time, _) => time + 1,
            _ => i32::MIN,
        };
        self.items[node].keys().map(cycle).max().unwrap_or(i32::MIN)
    }

    /// The items of a node's value, in no order.
    pub(super) fn items_of(&self, node: Node) -> impl Iterator<Item = Item> {
        self.items[node].keys().copied()
    }

    /// All items of a node's value, sorted.
    pub(super) fn items(&self, node: Node) -> Vec<Item> {
        let mut items: Vec<_> = self.items[node].keys().copied().collect();
        items.sort_unstable();
        items
    }
}
