//! VLIW code: each bundle by itself, then the operations under way between bundles, along all
//! paths.

mod bundle;
mod flow;
mod objects;
mod sequence;
mod state;

pub use sequence::check_sequence;

use super::{Place, Rule, Violation};
use crate::dre::scheduled::{Bundle, Control, ScheduledDre};
use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::entity::Entity;

/// All rules that the VLIW code of `dre` breaks on a machine, by place.
pub fn check_control(dre: &ScheduledDre, arch: &Arch) -> Vec<Violation> {
    let (srp, sram_bytes) = (&arch.srp, arch.system.sram_bytes);
    let mut violations = Vec::new();
    if dre.image.len() > sram_bytes as usize {
        violations.push(Violation {
            at: Place::Program,
            rule: Rule::Range,
            message: format!(
                "the image has {} bytes, the SRAM {}",
                dre.image.len(),
                sram_bytes
            ),
        });
    }
    ranges(dre, srp, &mut violations);
    for (number, bundle) in dre.bundles.iter() {
        bundle::check(number, bundle, dre, srp, &mut violations);
    }
    // Paths are followed only where bundles can be understood.
    if violations.is_empty() {
        violations = flow::check(dre, srp);
    }
    violations.sort();
    violations.dedup();
    violations
}

/// The numbers that lead to bundles and kernels.
fn ranges(dre: &ScheduledDre, srp: &Srp, violations: &mut Vec<Violation>) {
    let mut out_of_range = |at, what: &str| {
        violations.push(Violation {
            at,
            rule: Rule::Range,
            message: format!("{what} does not exist"),
        });
    };
    let exists = |bundle: Bundle| dre.bundles.get(bundle).is_some();
    if !exists(dre.start) {
        out_of_range(Place::Program, "the first bundle");
    }
    for entry in dre.functions.iter().filter(|f| !exists(f.bundle)) {
        out_of_range(Place::Program, &format!("the entry of `{}`", entry.name));
    }
    for (number, bundle) in dre.bundles.iter() {
        let at = Place::Transfer(number);
        match bundle.control.as_ref().map(|(control, _)| control) {
            Some(
                Control::Jump(target)
                | Control::Branch { target, .. }
                | Control::Call { target, .. },
            ) if !exists(*target) => out_of_range(at, "the target"),
            Some(Control::Launch(kernel)) if dre.kernels.get(*kernel).is_none() => {
                out_of_range(at, "the kernel");
            }
            Some(Control::Call { .. } | Control::CallReg { .. }) => {
                let back = number.index() + srp.branch_delay as usize + 1;
                if back >= dre.bundles.len() {
                    out_of_range(at, "the bundle to return to");
                }
            }
            _ => {}
        }
    }
}
