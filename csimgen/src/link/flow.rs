//! Values on their way through a kernel, from the cycle in which they are made to the one in which
//! they stand in their places, as steps of contexts.

use super::Linker;
use super::order::sequence;
use crate::spec::{Action, Cell, Landing, Origin, Role, Step};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dre::scheduled::{ModuloSchedule, RegAt};
use std::collections::BTreeMap;

/// A value on its way.
pub(super) struct Flow {
    /// The name of its cells in flight.
    pub(super) name: String,
    /// The cycle of iteration 0 in which it is made.
    pub(super) time: u32,
    /// Cycles until it stands in its places.
    pub(super) latency: u32,
    /// Its type; `None` for a store, which has no value.
    pub(super) ty: Option<Ty>,
    /// Its places.
    pub(super) dests: Vec<Dest>,
    /// Who makes it.
    pub(super) origin: Origin,
    /// Where it comes from.
    pub(super) at: u32,
}

/// A place of a value.
pub(super) enum Dest {
    /// An output.
    Place(Place),
    /// A register.
    Reg(RegAt),
}

/// A kernel's contexts in the making.
pub(super) struct Contexts {
    kernel: u32,
    ii: u32,
    /// The steps of each context, with the latency of their results: of two that write the same cell,
    /// the older stays.
    steps: Vec<Vec<(u32, Step)>>,
    /// The steps that keep earlier values of outputs, the same in every context.
    past: Vec<Step>,
    /// Stores for halves of split steps, by type.
    spare: BTreeMap<Ty, Vec<u32>>,
}

impl Contexts {
    /// Empty contexts of a kernel.
    pub(super) fn new(kernel: u32, schedule: &ModuloSchedule) -> Contexts {
        Contexts {
            kernel,
            ii: schedule.ii,
            steps: vec![Vec::new(); schedule.ii as usize],
            past: Vec::new(),
            spare: BTreeMap::new(),
        }
    }

    /// Keeps the values of `place` of the last `delay` cycles. Returns their store, the latest first.
    pub(super) fn add_past(&mut self, linker: &mut Linker, place: Place, delay: u32) -> u32 {
        let output = &linker.stores[place.index()];
        let (name, ty) = (format!("{}_past", output.name), output.ty);
        let store = linker.add_store(name, ty, delay, Role::Flight(self.kernel));
        for index in 0..delay {
            let from = match index {
                0 => linker.place_cell(place, 0),
                _ => Cell::new(store, index - 1),
            };
            self.past.push(Step {
                stage: None,
                action: Action::Copy(from),
                ty: Some(ty),
                dests: vec![Cell::new(store, index)],
                landing: Landing::InPlace,
                origin: Origin::Way,
                at: 0,
            });
        }
        store
    }

    /// Adds the steps of a value: its making by `action`, and its landing.
    ///
    /// A value with a latency over 1 is made into a flight cell and lands from there. If the next
    /// iteration's value is made before it lands, the cells form a chain along which values move
    /// each time one is made.
    pub(super) fn add_flow(&mut self, linker: &mut Linker, flow: &Flow, action: Action) {
        let landing = flow.time + flow.latency - 1;
        let chain = (flow.latency > 1 && !flow.dests.is_empty()).then(|| {
            let depth = (flow.latency - 2) / self.ii + 1;
            let ty = flow.ty.unwrap_or(Ty::Word);
            let store = linker.add_store(flow.name.clone(), ty, depth, Role::Flight(self.kernel));
            (store, depth)
        });
        let (made, lands) = (Some(flow.time / self.ii), Some(landing / self.ii));
        let dests = flow.dests(linker, i64::from(landing / self.ii));
        let context = |t: u32| (t % self.ii) as usize;
        let (making, arriving) = (context(flow.time), context(landing));
        let Some((store, depth)) = chain else {
            self.steps[making].push((1, flow.step(made, action, dests)));
            return;
        };
        let cell = |index| Cell::new(store, index);
        let step = flow.step(made, action, vec![cell(0)]);
        self.steps[making].push((1, step));
        for index in 1..depth {
            let action = Action::Copy(cell(index - 1));
            let step = flow.way(None, action, vec![cell(index)]);
            self.steps[making].push((1, step));
        }
        let step = flow.way(lands, Action::Copy(cell(depth - 1)), dests);
        self.steps[arriving].push((flow.latency, step));
    }

    /// The contexts, each in order.
    pub(super) fn finish(mut self, linker: &mut Linker) -> Vec<Vec<Step>> {
        let mut contexts = Vec::new();
        for mut steps in std::mem::take(&mut self.steps) {
            steps.sort_by_key(|(latency, _)| *latency);
            let steps = steps.into_iter().map(|(_, step)| step);
            let steps = steps.chain(self.past.iter().cloned()).collect();
            let mut taken: BTreeMap<Ty, usize> = BTreeMap::new();
            contexts.push(sequence(steps, |step| {
                let ty = step.ty.expect("a step that writes has a result");
                let number = taken.entry(ty).or_default();
                let cell = self.spare(linker, ty, *number);
                *number += 1;
                Some(Step {
                    action: Action::Copy(cell),
                    dests: std::mem::replace(&mut step.dests, vec![cell]),
                    origin: Origin::Way,
                    ..step.clone()
                })
            }));
        }
        contexts
    }

    /// A cell for the time between the halves of a step.
    fn spare(&mut self, linker: &mut Linker, ty: Ty, number: usize) -> Cell {
        let stores = self.spare.entry(ty).or_default();
        if stores.len() == number {
            let name = format!("spare_{ty}{number}");
            stores.push(linker.add_store(name, ty, 1, Role::Flight(self.kernel)));
        }
        Cell::new(stores[number], 0)
    }
}

impl Flow {
    /// The cells that the value of the iteration `back` before the last is written into.
    fn dests(&self, linker: &Linker, back: i64) -> Vec<Cell> {
        let cell = |dest: &Dest| match dest {
            Dest::Reg(reg) => linker.register(*reg, back),
            Dest::Place(place) => linker.place_cell(*place, 0),
        };
        self.dests.iter().map(cell).collect()
    }

    fn step(&self, stage: Option<u32>, action: Action, dests: Vec<Cell>) -> Step {
        Step {
            stage,
            action,
            ty: self.ty,
            dests,
            landing: Landing::InPlace,
            origin: self.origin,
            at: self.at,
        }
    }

    /// A step that brings the value, once it is made, on its way.
    fn way(&self, stage: Option<u32>, action: Action, dests: Vec<Cell>) -> Step {
        Step {
            origin: Origin::Way,
            ..self.step(stage, action, dests)
        }
    }
}
