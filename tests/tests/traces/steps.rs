//! The interpreter by single cycles: its saved state and what it did, without anything of a trace.

use super::Case;
use srp_archdesc::isa::Ty;
use srp_csimgen::Interpreter;
use srp_csimgen::spec::{Role, SimSpec, Store};
use srp_runtime::core::{Activity, Core, CoreState};
use std::ops::Range;

/// The state before each cycle, and the activity in it.
pub(crate) struct Steps {
    states: Vec<CoreState>,
    activities: Vec<Activity>,
}

impl Steps {
    pub(crate) fn of(case: &Case) -> Steps {
        let mut core = Interpreter::new(&case.spec);
        let mut bus = case.bus();
        let mut steps = Steps {
            states: vec![core.save().expect("it saves")],
            activities: Vec::new(),
        };
        while bus.exit.is_none() {
            let run = core.run(&mut bus, 1).expect("no trap");
            if let Activity::Halted(_) = run.activity {
                break;
            }
            assert_eq!(run.cycles, 1);
            steps.activities.push(run.activity);
            steps.states.push(core.save().expect("it saves"));
        }
        steps
    }

    pub(crate) fn len(&self) -> usize {
        self.activities.len()
    }

    pub(crate) fn activity(&self, cycle: u64) -> Activity {
        self.activities[cycle as usize]
    }

    /// True if registers of a kernel were set between the state before this cycle and the cycle.
    pub(crate) fn enters(&self, cycle: u64) -> bool {
        let at = cycle as usize;
        let is_array = |a: &Activity| matches!(a, Activity::Array(_));
        let now = self.activities.get(at).is_some_and(is_array);
        now && !(at > 0 && is_array(&self.activities[at - 1]))
    }

    /// The cycles on the array of each launch of a kernel.
    pub(crate) fn launches(&self, kernel: u32) -> Vec<Range<u64>> {
        let mut launches = Vec::new();
        let mut begun = None;
        for (cycle, activity) in (0..).zip(self.activities.iter().map(Some).chain([None])) {
            let is_on = activity == Some(&Activity::Array(kernel));
            match (is_on, begun) {
                (true, None) => begun = Some(cycle),
                (false, Some(first)) => {
                    launches.push(first..cycle);
                    begun = None;
                }
                _ => {}
            }
        }
        launches
    }

    /// The lanes of every cell before a cycle.
    pub(crate) fn cells(&self, spec: &SimSpec, cycle: u64) -> Cells {
        cells(spec, &self.states[cycle as usize])
    }
}

/// The lanes of every cell by store.
pub(crate) type Cells = Vec<(usize, Vec<Vec<u32>>)>;

/// The lanes of every cell by store, rotating files in their physical order: so cores save them.
pub(crate) fn cells(spec: &SimSpec, state: &CoreState) -> Cells {
    let mut words = state.words.iter().copied();
    let mut stores: Vec<(usize, &Store)> = spec.stores.iter().enumerate().collect();
    stores.sort_by_key(|(_, store)| match store.role {
        Role::Flight(kernel) => Some(kernel),
        _ => None,
    });
    let mut next = || words.next().expect("a word for each");
    let store = |(number, store): (usize, &Store)| {
        if store.role == Role::Rotating {
            next();
        }
        let lanes = if store.ty == Ty::Vec { 4 } else { 1 };
        let cell = |_| (0..lanes).map(|_| next()).collect();
        (number, (0..store.size).map(cell).collect())
    };
    stores.into_iter().map(store).collect()
}
