//! The report as one self-contained page: a table, the picture's quality against what it costs, and
//! maps of what is off.

mod plot;

use super::folder::Folder;
use super::text::{decibels, intervals, marks, name, noise, percent, search_in_words, unit};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use maud::{Markup, html};
use plot::Plot;
use srp_studies::accuracy::{AttributionSummary, Report, Trial};

const STYLE: &str = "
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(24rem, 1fr)); gap: 1rem 2rem; }
.plots figure, .maps figure { margin: 0; } figcaption { color: var(--soft); font-size: .82rem; margin-bottom: .2rem; }
.plot .axis { stroke: var(--edge); } .plot .grid { stroke: var(--line); } .plot text { font-size: 11px; fill: var(--soft); }
.plot circle { fill: var(--integer); fill-opacity: .75; } .plot circle.best { fill: var(--float); } .plot circle.base { fill: var(--good); r: 6px; } .plot circle.far { fill: none; stroke: var(--integer); stroke-width: 1.6; }
.plot path { fill: none; stroke: var(--float); stroke-width: 1.4; stroke-dasharray: 4 3; }
.maps { display: grid; grid-template-columns: repeat(auto-fill, minmax(16rem, 1fr)); gap: 1rem; } .maps img { width: 100%; image-rendering: pixelated; border-radius: 4px; background: #000; }
tr.best td:first-child { color: var(--float); font-weight: 600; } tr.cheapest td { background: color-mix(in srgb, var(--good) 12%, transparent); } td.hole { color: var(--above); font-weight: 600; }
.summary td:first-child { min-width: 19rem; max-width: 26rem; } .summary td.words { min-width: 20rem; line-height: 1.2; } .summary th, .summary td { padding: .3rem .5rem; } .attribution td, .attribution th { padding: .15rem .8rem .15rem 0; text-align: right; } .attribution td { white-space: nowrap; } .attribution .words { text-align: left; white-space: normal; } .attribution .words code { white-space: nowrap; } details { margin: .3rem 0; } summary { cursor: pointer; } .bar { display: inline-block; width: 8rem; height: .5rem; border-radius: 3px; background: var(--line); overflow: hidden; } .bar i { display: block; height: 100%; background: var(--float); }
td code { font-size: .8em; }
";

/// The page.
pub(super) fn page(report: &Report, folder: &Folder) -> String {
    let (width, height) = report.size;
    let title = format!("What accuracy costs: {}", report.scene);
    let body = html! {
        main {
            h1 { (title) }
            p.soft {
                (report.triangles) " triangles, " (width) "×" (height) " pixels, machine " code { (report.machine) }
                "; every picture is held against a renderer in binary64. Target: " code { (report.target) } "."
            }
            @if !report.complete { p.above { "Interrupted: these settings were tried until then." } }
            (conclusion(report))
            section { h2 { "Picture against cost" } (plots(report)) }
            div.summary.scroll { (table(report)) }
            @if let Some(base) = report.trials.first() { (attributed(&base.attribution)) }
            section { h2 { "In words" } ul { @for s in &report.sentences { li { (s) } } } }
            section {
                h2 { "What is off" }
                p.soft { "Differences of a channel from binary64: black is none, red some, white 32 levels or more." }
                (maps(report, folder))
            }
            section { h2 { "Decisions that changed a pixel" } (decisions(report)) }
        }
    };
    crate::page::page(&title, STYLE, &body)
}

fn conclusion(report: &Report) -> Markup {
    let cheapest = report.cheapest.map(|i| &report.trials[i]);
    html! {
        section {
            h2 { "Cheapest that keeps to the target" }
            @match cheapest {
                Some(trial) if !trial.how.is_empty() => {
                    p { (name(trial)) }
                    p { code { (trial.how) } }
                }
                Some(_) => p { "The machine as it is." },
                None => p.above { "Nothing that was tried keeps to it." },
            }
            p.soft { (search_in_words(report)) " " (noise(report)) }
            table.attribution {
                tr { th { "Mcycles, least" } th { "most" } th.words { "in any of these orders of tiles" } }
                @for (trial, [least, most]) in intervals(report) {
                    tr {
                        td { (format!("{:.3}", least as f64 / 1e6)) } td { (format!("{:.3}", most as f64 / 1e6)) }
                        td.words { (name(trial)) }
                    }
                }
            }
            h2 { "What a dB costs" }
            table.attribution {
                tr { th { "at least" } th { "cycles" } th { "area" } th { "energy" } th.words { "settings" } }
                @for price in &report.prices {
                    tr {
                        td { (format!("{:.0} dB", price.decibels)) }
                        td { (percent(price.cycles)) " %" } td { (percent(price.area)) " %" } td { (percent(price.energy)) " %" }
                        td.words {
                            @for (n, &i) in price.trials.iter().enumerate() {
                                @if !price.trials[..n].contains(&i) { div { (name(&report.trials[i])) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn plots(report: &Report) -> Markup {
    type Cost = fn(&Trial) -> f64;
    let costs: [(&str, Cost); 4] = [
        ("million cycles of the frame", |t| {
            t.costs.frame_cycles as f64 / 1e6
        }),
        ("mm² of all cores", |t| t.costs.area),
        ("mJ of the frame", |t| t.costs.energy),
        ("seconds of the host", |t| t.costs.host_seconds),
    ];
    let alike: Vec<Trial> = (report.trials.iter())
        .filter(|t| !t.is_sampling())
        .cloned()
        .collect();
    html! {
        div.plots {
            @for (what, cost) in costs {
                figure {
                    figcaption { "PSNR in dB against " (what) }
                    (Plot::of(&alike, cost, name).svg())
                }
            }
        }
        p.soft {
            "Green: the machine as it is. On the line: no other setting has a better picture for less. "
            "Rings at the right cost more than the axis shows; the pointer over a dot says which it is."
        }
    }
}

fn table(report: &Report) -> Markup {
    let mega = |n: u64| format!("{:.3}", n as f64 / 1e6);
    html! {
        table {
            tr {
                th { "setting" } th { "" } th { "PSNR" } th { "agreeing" } th { "FLIP" } th { "> 1/255" } th { "> 8/255" }
                th { "flips" } th { "leaks" } th { "t, ulp" } th { "unit, ulp" } th { "SRP Mcyc" } th { "T&I Mcyc" } th { "frame Mcyc" }
                th { "MB" } th { "mJ" } th { "mm²" } th { "host s" } th.words { "how" }
            }
            @for (i, t) in report.trials.iter().enumerate() {
                tr.best[report.front.contains(&i)].cheapest[report.cheapest == Some(i)] {
                    td { (name(t)) } td { (marks(report, i)) }
                    td { (decibels(t.all.psnr)) } td { (decibels(t.agreeing.psnr)) } td { (format!("{:.5}", t.all.flip)) }
                    td { (t.all.beyond_1) } td { (t.all.beyond_8) }
                    td { (t.attribution.all_flips()) }
                    td.hole[t.leaks.leaks > 0] { (t.leaks.leaks) }
                    td { (format!("{:.1}", t.leaks.ulp_99)) } td { (unit(t)) }
                    td { (mega(t.costs.srp_cycles)) } td { (mega(t.costs.tni_cycles)) }
                    td { (mega(t.costs.frame_cycles)) }
                    td { (format!("{:.2}", t.costs.dram_bytes as f64 / 1e6)) }
                    td { (format!("{:.2}", t.costs.energy)) } td { (format!("{:.2}", t.costs.area)) }
                    td { (format!("{:.2}", t.costs.host_seconds)) }
                    td.words { code { (t.how) } }
                }
            }
        }
        p.soft {
            "No other setting has a better picture for * fewer cycles, a less area, e less energy; < cheapest that keeps to the "
            "target; ! rays get through; - not exercised: the frame does not use the unit, and the setting gets no credit."
        }
    }
}

/// Where the errors of the machine as it is come from.
fn attributed(summary: &AttributionSummary) -> Markup {
    html! {
        section.attribution {
            h2 { "Where the error comes from, as it is" }
            p.soft {
                "The program was run with shadows in binary64 in " (summary.tiles.0) " of " (summary.tiles.1)
                " tiles; " (format!("{:.1}", 100.0 * summary.named)) " % of what roundings make is named. " (summary.of_picture_in_words()) " "
                "Decisions that binary64 makes otherwise: " (summary.flips_in_words()) ", on " (summary.flipped_pixels) " pixels."
            }
            table {
                tr { th { "part" } th { "" } th { "pixels" } th { "flips" } th.words { "line and operation, or unit" } }
                @for s in summary.sources.iter().filter(|s| s.part.abs() >= 5e-4 || s.flips > 0) {
                    tr {
                        td { (format!("{:.1} %", 100.0 * s.part)) }
                        td { span.bar { i style={ "width:" (format!("{:.1}", (100.0 * s.part).clamp(0.0, 100.0))) "%" } {} } }
                        td { (s.pixels) } td { (s.flips) } td.words { code { (s.name()) } }
                    }
                }
            }
            @for n in &summary.non_finite { p.above { (n) } }
        }
    }
}

/// The pixels of each trial that another decision changed, and why it fell.
fn decisions(report: &Report) -> Markup {
    let some = |t: &&Trial| !t.attribution.decisions.is_empty();
    html! {
        p.soft {
            "Of each setting the pixels that are off by most, among the tiles that were run with shadows in binary64. "
            code { "srp accuracy --pixel X,Y" } " says more of one."
        }
        @for trial in report.trials.iter().filter(some) {
            details {
                summary { (name(trial)) " " span.soft { (trial.all.beyond_8) " pixels off by more than 8 levels" } }
                table.attribution {
                    tr {
                        th { "pixel" } th { "levels" } th.words { "decision" } th.words { "at" } th.words { "decided" }
                        th.words { "because of errors of" }
                    }
                    @for d in &trial.attribution.decisions {
                        tr {
                            td { (d.pixel.0) "," (d.pixel.1) } td { (d.levels) } td.words { (d.kind) }
                            td.words { code { (d.at) } } td.words { (d.what) }
                            td.words { @for s in &d.because { div { code { (s) } } } }
                        }
                    }
                }
            }
        }
    }
}

fn maps(report: &Report, folder: &Folder) -> Markup {
    html! {
        div.maps {
            @for trial in report.trials.iter().filter(|t| t.all.beyond_1 > 0) {
                @if let Some(png) = folder.map(trial) {
                    figure {
                        figcaption { (name(trial)) " " span.soft { (decibels(trial.all.psnr)) " dB" } }
                        img alt=(name(trial)) loading="lazy"
                            src={ "data:image/png;base64," (BASE64_STANDARD.encode(png)) };
                    }
                }
            }
        }
    }
}
