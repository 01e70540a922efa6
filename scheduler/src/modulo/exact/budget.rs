//! Capacity limits: for every resource and slot, the literals that compete for it.

use super::encode::Encoding;
use super::formula::Lit;
use crate::modulo::problem::Problem;
use crate::modulo::table::Item;
use srp_archdesc::arch::{Fu, FuOp, Resource, Wire};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::Place;

/// Literals that compete in each slot, by resource.
pub(super) struct Budget {
    pub(super) ii: i32,
    pub(super) issue: EntityMap<Fu, Vec<Vec<Lit>>>,
    pub(super) outs: EntityMap<Place, Vec<Vec<Lit>>>,
    pub(super) wires: EntityMap<Wire, Vec<Vec<Lit>>>,
    wire_of: EntityMap<Place, Option<Wire>>,
    pub(super) held: EntityMap<Place, Vec<Vec<Lit>>>,
    pub(super) reads: EntityMap<Place, Vec<Vec<Lit>>>,
    pub(super) writes: EntityMap<Place, Vec<Vec<Lit>>>,
    pub(super) shared: EntityMap<Resource, Vec<Vec<Lit>>>,
}

impl Budget {
    pub(super) fn new(problem: &Problem<'_>, ii: u32) -> Budget {
        let slots = vec![Vec::new(); ii as usize];
        let places = || EntityMap::filled(problem.graph.places.len(), slots.clone());
        Budget {
            ii: ii as i32,
            issue: EntityMap::filled(problem.srp.fus.len(), slots.clone()),
            outs: places(),
            wires: EntityMap::filled(problem.srp.wires.len(), slots.clone()),
            wire_of: (problem.graph.places.keys())
                .map(|place| problem.graph.as_wire(place))
                .collect(),
            held: places(),
            reads: places(),
            writes: places(),
            shared: EntityMap::filled(problem.srp.resources.len(), slots.clone()),
        }
    }

    pub(super) fn slot(&self, time: i32) -> usize {
        time.rem_euclid(self.ii) as usize
    }

    pub(super) fn issue(&mut self, fu: Fu, time: i32, timing: &FuOp, literal: Lit) {
        for k in 0..timing.interval as i32 {
            let slot = self.slot(time + k);
            self.issue[fu][slot].push(literal);
            for &resource in &timing.uses {
                self.shared[resource][slot].push(literal);
            }
        }
    }

    pub(super) fn item(&mut self, item: Item, literal: Lit) {
        let (resource, time) = match item {
            Item::Out(place, time) => (&mut self.outs[place], time),
            Item::Held(place, time, _) => (&mut self.held[place], time),
            Item::Written(place, time, ..) => (&mut self.writes[place], time),
            Item::Read(place, time, ..) => (&mut self.reads[place], time),
            Item::Wire(place, time, _) => match self.wire_of[place] {
                Some(wire) => (&mut self.wires[wire], time),
                None => return,
            },
            Item::Move(..) | Item::Kept(..) => return,
        };
        resource[time.rem_euclid(self.ii) as usize].push(literal);
    }

    /// Results that nobody waits for take their output all the same.
    pub(super) fn landings(&mut self, problem: &Problem<'_>, encoding: &Encoding) {
        for (node, starts) in encoding.starts.iter() {
            for &(fu, time, literal) in starts {
                let op = problem.dfg.nodes[node].op;
                let Some(place) = problem.graph.result_place(fu, op) else {
                    continue;
                };
                let lands = time + problem.timing(node, fu).latency as i32;
                if !encoding
                    .items
                    .contains_key(&(node, Item::Out(place, lands)))
                {
                    self.item(Item::Out(place, lands), literal);
                }
            }
        }
    }
}
