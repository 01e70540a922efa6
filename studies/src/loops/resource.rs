//! Names of resources that the operations of a loop share.

use srp_archdesc::arch::Srp;
use srp_scheduler::demand::Need;

/// Returns the name of a need, in words.
pub(super) fn resource_name(need: &Need, srp: &Srp) -> String {
    match need {
        Need::Array => "all operations".to_owned(),
        Need::Shared(resource) => srp.resources[*resource].name.clone(),
        Need::Units(classes) => {
            let names: Vec<&str> = classes.iter().map(|c| c.name()).collect();
            names.join(", ")
        }
    }
}
