//! A profile as one self-contained page: the parts of the time as a bar, tables, and the source with a bar at
//! each line.

use super::listing::{File, Listing};
use super::{PARTS, anchor, columns, has_energy, in_words, largest, microjoules, percent, tried};
use super::{drawing, flame, frame};
use maud::{Markup, html};
use srp_runtime::digits::thousands;
use srp_studies::profile::{Parts, Profile};

const STYLE: &str = include_str!("page.css");

/// The page.
pub(super) fn page(title: &str, profile: &Profile, listing: &Listing) -> String {
    let all = profile.parts.total();
    let most = (listing.files.iter())
        .flat_map(|file| file.stretches.iter().flatten())
        .map(|line| line.cost.parts.total())
        .max()
        .unwrap_or(0);
    let body = html! {
        main {
            h1 { "Profile of " (title) small.soft { " on " (profile.machine) } }
            p { (thousands(all)) " cycles of " (profile.cores)
                @if profile.cores == 1 { " core" } @else { " cores" } }
            (bar(&profile.parts, all))
            div.summary.scroll { (legend(&profile.parts)) }
            @if !profile.advice.is_empty() { (what_to_do(profile)) }
            @if let Some(timeline) = &profile.timeline { (drawing::timeline(profile, timeline)) }
            (flame::flame(profile))
            (drawing::areas(profile))
            section {
                h3 { "Largest costs of single lines" }
                ul { @for (line, part, cycles) in largest(profile) {
                    li { b { (percent(cycles, all)) " %" } " " a href=(format!("#{}", anchor(&line))) { code { (line) } }
                        ": " (in_words(part)) }
                } }
            }
            @if !profile.loops.is_empty() { div.summary.scroll { (loops(profile)) } }
            div.summary.scroll { (functions(profile)) }
            (frame::on_page(profile))
            @for file in &listing.files { (source(file, &profile.parts, most, has_energy(profile))) }
        }
    };
    crate::page::page(&format!("Profile of {title}"), STYLE, &body)
}

fn what_to_do(profile: &Profile) -> Markup {
    html! {
        section {
            h3 { "What to do" }
            ul { @for advice in &profile.advice {
                li { b { (format!("{:.1}", 100.0 * advice.share)) " %" } " " (advice.reason) " " (with_code(&advice.change))
                    @if !advice.set.is_empty() { " " code { (tried(advice)) } } }
            } }
        }
    }
}

/// Words of which those between back quotes are code.
fn with_code(words: &str) -> Markup {
    html! {
        @for (i, part) in words.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

/// A bar whose parts have the widths of parts of `whole`.
fn bar(parts: &Parts, whole: u64) -> Markup {
    html! {
        div.bar {
            @for ((class, _), (part, cycles)) in PARTS.iter().zip(parts.named()) {
                @if cycles > 0 {
                    span class=(class) title=(format!("{part}: {} cycles", thousands(cycles)))
                        style=(format!("width:{:.3}%", 100.0 * cycles as f64 / whole.max(1) as f64)) {}
                }
            }
        }
    }
}

fn legend(parts: &Parts) -> Markup {
    let all = parts.total();
    html! {
        table {
            tr { th { "part" } th { "cycles" } th { "share" } th.words { "" } }
            @for ((class, words), (part, cycles)) in PARTS.iter().zip(parts.named()) {
                @if cycles > 0 {
                    tr {
                        td { span class={ "key " (class) } {} " " (part) }
                        td { (thousands(cycles)) } td { (percent(cycles, all)) " %" }
                        td.words { (words) }
                    }
                }
            }
        }
    }
}

fn loops(profile: &Profile) -> Markup {
    let all = profile.parts.total();
    html! {
        table {
            tr {
                th { "loop on the array" } th { "cycles" } th { "share" } th { "II" } th { "launches" }
                th { "iterations" } th { "least, most" } th { "switch" } th { "standing still" }
            }
            @for l in &profile.loops {
                tr {
                    td { code { (l.kernel) } @if let Some(at) = &l.at { " " small.soft { (at) } } }
                    td { (thousands(l.parts.total())) }
                    td { (percent(l.parts.total(), all)) " %" }
                    td { (l.ii) } td { (thousands(l.launches)) }
                    td { (format!("{:.1}", l.iterations.all as f64 / l.launches.max(1) as f64)) }
                    td { (l.iterations.fewest) ", " (l.iterations.most) }
                    td { (thousands(l.parts.switch)) }
                    td { (thousands(l.parts.memory_stall + l.parts.texture_stall + l.parts.sram_stall)) }
                }
            }
        }
    }
}

fn functions(profile: &Profile) -> Markup {
    let all = profile.parts.total();
    let columns = columns(&profile.parts);
    let heads = profile.parts.named();
    html! {
        table {
            tr { th { "function" } th { "cycles" } th { "share" }
                @for &i in &columns { th { (heads[i].0) } } }
            @for f in &profile.functions {
                tr {
                    td { code { (f.shown()) } } td { (thousands(f.parts.total())) }
                    td { (percent(f.parts.total(), all)) " %" }
                    @for &i in &columns { td { (blank(f.parts.named()[i].1)) } }
                }
            }
        }
    }
}

/// Cycles, nothing where there are none.
fn blank(cycles: u64) -> String {
    match cycles {
        0 => String::new(),
        _ => thousands(cycles),
    }
}

fn source(file: &File, all: &Parts, most: u64, has_energy: bool) -> Markup {
    let (cycles, total) = (file.cost.parts.total(), all.total());
    html! {
        section.scroll {
            div.head { h2 { code { (file.name) } }
                span.soft { (thousands(cycles)) " cycles, " (percent(cycles, total)) " %"
                    @if has_energy { ", " (microjoules(file.cost.mj)) " µJ" } } }
            table.source {
                tr.soft { th.cycles { "cycles" } @if has_energy { th.cycles { "µJ" } } th {} th {} th {} }
                @for (i, stretch) in file.stretches.iter().enumerate() {
                    @if i > 0 { tr { td colspan="5" .soft { "⋯" } } }
                    @for line in stretch {
                        tr id=(anchor(&format!("{}:{}", file.name, line.number))) {
                            td.cycles { (blank(line.cost.parts.total())) }
                            @if has_energy { td.cycles { (microjoules(line.cost.mj)) } }
                            td.share { @if line.cost.parts.total() > 0 { (bar(&line.cost.parts, most)) } }
                            td.number { (line.number) }
                            td { code { (line.text.trim_end()) } }
                        }
                    }
                }
            }
        }
    }
}
