//! The energy of a frame as text.

use srp_studies::energy::Energy;
use std::fmt::Write as _;

/// Parts with their shares, largest first, and what a ray takes.
pub(crate) fn text(energy: &Energy) -> String {
    let mut out = String::new();
    write(&mut out, energy).expect("writing to a String does not fail");
    out
}

fn write(out: &mut String, energy: &Energy) -> std::fmt::Result {
    writeln!(
        out,
        "\nenergy at 65 nm: {:.4} mJ, {:.0} pJ a ray, {:.3} W",
        energy.total_mj, energy.pj_per_ray, energy.watts
    )?;
    let mut parts = energy.parts.clone();
    parts.retain(|share| share.mj > 0.0);
    parts.sort_by(|a, b| b.mj.total_cmp(&a.mj));
    for share in parts {
        writeln!(
            out,
            "{:26} {:>12.5} mJ {:>6.1} %",
            share.part.name(),
            share.mj,
            100.0 * share.mj / energy.total_mj
        )?;
    }
    let chip: Vec<String> = (energy.chip_mj.iter())
        .map(|(technology, mj)| format!("{} nm {mj:.4}", technology.nm))
        .collect();
    writeln!(out, "without system memory, mJ: {}", chip.join(", "))
}
