//! Warnings about units of special functions.

use super::super::findings::Findings;
use super::super::raw;
use super::dead_if_given;
use crate::arch::Arch;
use crate::chip;
use crate::precision::{Approx, Refine};
use crate::structure::Special;

/// Warns of attributes that a function's unit leaves without effect.
pub(super) fn remarks(found: &Findings, machine: &raw::Machine, arch: &Arch) {
    for raw in &machine.special {
        let Some(special) = function(raw) else {
            continue;
        };
        let precision = &arch.precision;
        // A square root in code is a product with the inverse root, which has the same attributes.
        let root = matches!(special, Special::Sqrt | Special::Rsqrt) && in_code(precision.sqrt);
        if !root {
            steps(found, raw, precision.of(special));
        }
        if raw.datapath.is_some() && !shares(special, arch) {
            let why = "no function of this structure shares it in a unit";
            let help =
                "give the same number to another function of the unit, of the same structure";
            dead_if_given(found, &raw.datapath, "datapath", why, help);
        }
    }
    let tni = (machine.system.as_ref()).and_then(|system| system.tni.as_ref());
    for raw in tni.into_iter().flat_map(|tni| &tni.special) {
        steps(found, raw, arch.system.tni.rcp);
        let why = "the T&I unit has no other function";
        dead_if_given(found, &raw.datapath, "datapath", why, "leave it out");
    }
}

fn function(raw: &raw::Special) -> Option<Special> {
    let name = &raw.function.as_ref()?.value;
    let mut all = Special::ALL.into_iter();
    all.find(|special| special.name() == name)
}

fn in_code(approx: Approx) -> bool {
    matches!(
        approx,
        Approx::Table {
            refine: Refine::Code,
            ..
        }
    )
}

/// The form of steps that are not taken.
fn steps(found: &Findings, raw: &raw::Special, approx: Approx) {
    if matches!(approx, Approx::Table { steps: 0, .. }) {
        let (why, help) = ("no steps are taken", "give `steps`");
        dead_if_given(found, &raw.fused, "fused", why, help);
        dead_if_given(found, &raw.refine, "refine", why, help);
    }
}

/// True if the datapath of a function makes units other than they would be without it.
fn shares(special: Special, arch: &Arch) -> bool {
    let mut alone = arch.clone();
    alone.builds.of_mut(special).datapath = None;
    let [with, without] = [arch, &alone].map(chip::specials_um2);
    (with - without).abs() > 1.0
}
