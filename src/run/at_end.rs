//! Where a program stands when its run is over, whichever engine ran it.

use crate::failure::Failure;
use srp_csimgen::preamble::sequencer::Place;
use srp_csimgen::{Recorder, SimSpec, link};
use srp_ir::check::Checked;
use srp_runtime::core::Core;

/// Most open calls that are told.
const MOST_CALLS: usize = 16;

/// A core after its run.
pub(super) struct AtEnd {
    pub(super) spec: SimSpec,
    /// The interpreter in the state of the engine that ran: it has all registers in order.
    pub(super) core: Recorder,
}

impl AtEnd {
    /// A core that has run this program; `None` after a trap, where no engine keeps its state.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels.
    pub(super) fn of(core: &dyn Core, program: &Checked) -> Result<Option<AtEnd>, Failure> {
        let spec = link(program).map_err(Failure::message)?;
        let mut in_order = Recorder::new(&spec);
        let is_known = core.save().is_some_and(|state| in_order.restore(&state));
        Ok(is_known.then_some(AtEnd {
            spec,
            core: in_order,
        }))
    }

    /// Where it goes on, and the calls that are open, innermost first: a note each.
    pub(super) fn notes(&self) -> String {
        let spec = &self.spec;
        let at = |position: Option<u32>| {
            let place = position.and_then(|p| spec.position(p));
            place.map_or(String::new(), |place| format!(" at {place}"))
        };
        let stands = match self.core.place() {
            Place::Bundle(number) => {
                let bundle = &spec.bundles[number as usize];
                let steps = bundle.steps.iter().map(|step| step.at);
                let mut positions = steps.chain(bundle.control.iter().map(|(_, at)| *at));
                let known = positions.find(|&p| spec.position(p).is_some());
                let function = spec.function_of(number).unwrap_or("start");
                format!("it stands in `{function}`{}", at(known))
            }
            Place::Context {
                kernel, iteration, ..
            } => {
                let kernel = &spec.kernels[kernel as usize];
                let (name, place) = (&kernel.name, at(Some(kernel.at)));
                format!(
                    "it stands in iteration {iteration} of the loop `{name}`{place}, on the array"
                )
            }
            Place::Switch => "it stands between VLIW code and array".to_owned(),
            Place::Halted(_) | Place::Faulted(_) => return String::new(),
        };
        let calls = self.core.open_calls().take(MOST_CALLS);
        let calls = calls.filter_map(|position| spec.position(position));
        let calls = calls.map(|place| format!("\nnote: called at {place}"));
        format!("\nnote: {stands}{}", calls.collect::<String>())
    }
}
