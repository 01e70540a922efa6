//! A sentence about each setting: what it does to picture and costs.

use super::setting::TOGETHER;
use super::summary::AttributionSummary as Attribution;
use super::target::relative_cycles;
use super::trial::Trial;
use std::fmt::Write as _;

/// The part of the squared error from which on a source is named.
const NAMED: f64 = 0.3;

/// The part beyond which another source makes up for most of what one contributes.
const CANCELS: f64 = 2.0;

/// The change from one value to another, in percent.
fn change(now: f64, before: f64) -> f64 {
    match before > 0.0 {
        true => 100.0 * (now / before - 1.0),
        false => 0.0,
    }
}

/// Says what a setting does. Cycles that differ by no more than the noise do not differ.
pub(super) fn of(trial: &Trial, base: &Trial, noise: f64) -> String {
    let mut text = match trial.knob.as_str() {
        TOGETHER => format!("All of {}", trial.value),
        knob => format!("{knob}: {}", trial.value),
    };
    if trial.not_exercised {
        return text + ": not exercised, the frame does not use the unit.";
    }
    text += ": ";
    text += &match (trial.all.psnr, base.all.psnr) {
        (Some(now), _) if trial.is_sampling() => {
            format!("{now:.1} dB of the picture with the most samples and bounces")
        }
        (None, _) => "no byte of the picture is off".to_owned(),
        (Some(now), Some(before)) if (now - before).abs() < 0.05 => "as good a picture".to_owned(),
        (Some(now), Some(before)) if now > before => format!("{:.1} dB won", now - before),
        (Some(now), Some(before)) => format!("{:.1} dB lost", before - now),
        (Some(now), None) => format!("the picture falls to {now:.1} dB"),
    };
    if trial.all.beyond_8 != base.all.beyond_8 && !trial.is_sampling() {
        let (now, before) = (trial.all.beyond_8, base.all.beyond_8);
        let _ = write!(
            text,
            ", {now} pixels off by more than 8 levels ({before} before)"
        );
    }
    if trial.attribution.all_flips() > 0 {
        let (looked, of) = trial.attribution.tiles;
        let flips = trial.attribution.flips_in_words();
        let _ = write!(
            text,
            ", decided otherwise in {looked} of {of} tiles: {flips}"
        );
    }
    let Attribution {
        sources,
        squared_error,
        picture_error,
        ..
    } = &trial.attribution;
    // Of an error that is made elsewhere, what rounds is no reason.
    let made = (squared_error / picture_error).min(1.0);
    if let Some(worst) = (sources.first()).filter(|s| s.part.abs() * made > NAMED) {
        let name = worst.name();
        let _ = match sources.iter().find(|s| s.part * worst.part < 0.0) {
            Some(other) if worst.part.abs() > CANCELS => write!(
                text,
                ", the errors of {name} and {} make up for each other",
                other.name()
            ),
            _ => write!(
                text,
                ", {:.0} % of the error from {name}",
                100.0 * worst.part
            ),
        };
    }
    if trial.leaks.leaks != base.leaks.leaks {
        let (now, aimed) = (trial.leaks.leaks, trial.leaks.aimed);
        let _ = write!(text, ", {now} of {aimed} rays at edges get through");
    }
    let (now, before) = (&trial.costs, &base.costs);
    for (kernel, ii) in &now.ii {
        match before.ii.get(kernel) {
            Some(old) if old != ii => {
                let _ = write!(text, ", II of `{kernel}` {old} → {ii}");
            }
            _ => {}
        }
    }
    for (what, change) in [
        (
            "cycles of the frame",
            change(relative_cycles(trial, base, noise), 1.0),
        ),
        ("energy", change(now.energy, before.energy)),
        ("area", change(now.area, before.area)),
    ] {
        if change.abs() >= 0.05 {
            let _ = write!(text, ", {change:+.1} % {what}");
        }
    }
    text + "."
}
