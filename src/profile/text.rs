//! A profile as text.

use super::frame;
use super::listing::{File, Listing};
use super::{columns, has_energy, in_words, largest, microjoules, percent, tried};
use crate::count::count;
use srp_runtime::digits::thousands;
use srp_studies::profile::{LoopProfile, Parts, Profile};
use std::fmt::Write as _;

/// Widths of the columns of cycles, and of names.
const CYCLES: usize = 13;
const NAME: usize = 20;

/// The profile, the largest costs first, then loops, functions, and the source.
pub(super) fn text(title: &str, profile: &Profile, listing: &Listing) -> String {
    let mut out = String::new();
    write(&mut out, title, profile, listing).expect("writing to a String does not fail");
    out
}

fn write(out: &mut String, title: &str, profile: &Profile, listing: &Listing) -> std::fmt::Result {
    let all = profile.parts.total();
    writeln!(
        out,
        "{title} on {}: {} cycles of {}",
        profile.machine,
        thousands(all),
        count(profile.cores, "core")
    )?;
    for (part, cycles) in profile.parts.named() {
        if cycles > 0 {
            let share = percent(cycles, all);
            let (cycles, words) = (thousands(cycles), in_words(part));
            writeln!(out, "{cycles:>CYCLES$} {share:>5} %  {part:8} {words}")?;
        }
    }
    writeln!(out, "\nlargest costs of single lines")?;
    for (line, part, cycles) in largest(profile) {
        let share = percent(cycles, all);
        writeln!(
            out,
            "{:>CYCLES$} {share:>5} %  {line}: {}",
            thousands(cycles),
            in_words(part)
        )?;
    }
    if !profile.advice.is_empty() {
        writeln!(out, "\nwhat to do")?;
    }
    for advice in &profile.advice {
        let (share, reason) = (format!("{:.1}", 100.0 * advice.share), &advice.reason);
        writeln!(
            out,
            "{:CYCLES$} {share:>5} %  {reason} {}",
            "", advice.change
        )?;
        if !advice.set.is_empty() {
            writeln!(out, "{:CYCLES$}          {}", "", tried(advice))?;
        }
    }
    if !profile.loops.is_empty() {
        loops(out, &profile.loops, all)?;
    }
    writeln!(
        out,
        "\n{:NAME$} {:>CYCLES$} {:>7}{}",
        "function",
        "cycles",
        "share",
        heads(&profile.parts)
    )?;
    for f in &profile.functions {
        let total = f.parts.total();
        let share = percent(total, all);
        let cells = cells(&f.parts, &profile.parts);
        writeln!(
            out,
            "{:NAME$} {:>CYCLES$} {share:>5} %{cells}",
            f.shown(),
            thousands(total)
        )?;
    }
    out.push_str(&frame::as_text(profile));
    let (long, short) = listing.files.split_at(listing.shown(all));
    for file in long {
        source(out, file, profile)?;
    }
    if !short.is_empty() {
        writeln!(out, "\nother files")?;
    }
    for file in short {
        let cycles = file.cost.parts.total();
        let (share, cycles) = (percent(cycles, all), thousands(cycles));
        writeln!(out, "{cycles:>CYCLES$} {share:>5} %  {}", file.name)?;
    }
    let nowhere = listing.nowhere.parts.total();
    if nowhere > 0 {
        let cycles = thousands(nowhere);
        writeln!(out, "\n{cycles:>CYCLES$} in code of no line")?;
    }
    Ok(())
}

fn loops(out: &mut String, loops: &[LoopProfile], all: u64) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:NAME$} {:>CYCLES$} {:>7} {:>4} {:>9} {:>10} {:>18} {:>9} {:>11}",
        "loop on the array",
        "cycles",
        "share",
        "II",
        "launches",
        "iterations",
        "least, most",
        "switch",
        "standing still"
    )?;
    for l in loops {
        let total = l.parts.total();
        let mean = l.iterations.all as f64 / l.launches.max(1) as f64;
        writeln!(
            out,
            "{:NAME$} {:>CYCLES$} {:>5} % {:>4} {:>9} {:>10} {:>18} {:>9} {:>11}",
            l.kernel,
            thousands(total),
            percent(total, all),
            l.ii,
            thousands(l.launches),
            format!("{mean:.1}"),
            format!("{}, {}", l.iterations.fewest, l.iterations.most),
            thousands(l.parts.switch),
            thousands(l.parts.memory_stall + l.parts.texture_stall + l.parts.sram_stall)
        )?;
    }
    Ok(())
}

/// The heads of the columns that have any cycles.
fn heads(all: &Parts) -> String {
    let named = all.named();
    let head = |i: usize| format!(" {:>11}", named[i].0);
    columns(all).into_iter().map(head).collect()
}

/// The cells of these columns.
fn cells(parts: &Parts, all: &Parts) -> String {
    let named = parts.named();
    let cell = |i: usize| match named[i].1 {
        0 => format!(" {:>11}", ""),
        cycles => format!(" {:>11}", thousands(cycles)),
    };
    columns(all).into_iter().map(cell).collect()
}

fn source(out: &mut String, file: &File, profile: &Profile) -> std::fmt::Result {
    let (all, cycles) = (&profile.parts, file.cost.parts.total());
    let energy = |text: &str| match has_energy(profile) {
        true => format!(" {text:>9}"),
        false => String::new(),
    };
    writeln!(
        out,
        "\n{}: {} cycles, {} %\n{:>CYCLES$} {:>7}{}{}",
        file.name,
        thousands(cycles),
        percent(cycles, all.total()),
        "cycles",
        "share",
        energy("µJ"),
        heads(all)
    )?;
    for (i, stretch) in file.stretches.iter().enumerate() {
        if i > 0 {
            writeln!(out, "{:>CYCLES$}", "...")?;
        }
        for line in stretch {
            let cycles = line.cost.parts.total();
            let (number, text) = (line.number, line.text.trim_end());
            let (cycles, share) = match cycles {
                0 => (String::new(), String::new()),
                _ => (
                    thousands(cycles),
                    format!("{} %", percent(cycles, all.total())),
                ),
            };
            let cells = cells(&line.cost.parts, all);
            let energy = energy(&microjoules(line.cost.mj));
            writeln!(
                out,
                "{cycles:>CYCLES$} {share:>7}{energy}{cells} {number:>6} | {text}"
            )?;
        }
    }
    Ok(())
}
