//! The reports as one self-contained page.

use super::text::{bound, intervals, ranges, search_in_words, short, ulps, words};
use super::{machine_name, marks, shown};
use maud::{Markup, html};
use srp_studies::kernel::{Costs, Measure, Origins, Report, Trial};

const STYLE: &str = "
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(22rem, 1fr)); gap: 1rem 2rem; } .plots figure { margin: 0; }
figcaption { color: var(--soft); font-size: .82rem; margin-bottom: .2rem; }
.plot .axis { stroke: var(--edge); } .plot text { font-size: 11px; fill: var(--soft); }
.plot circle { fill: var(--integer); fill-opacity: .6; } .plot circle.best { fill: var(--float); fill-opacity: 1; } .plot circle.base { fill: var(--good); fill-opacity: 1; r: 6px; }
.plot path { fill: none; stroke: var(--float); stroke-width: 1.4; stroke-dasharray: 4 3; }
tr.cheapest td { background: color-mix(in srgb, var(--good) 12%, transparent); }
td.words, th.words { text-align: left; } td code { font-size: .8em; } .scroll td, .scroll th { padding-right: .9rem; } table.origins td { padding: .1rem .8rem .1rem 0; }
";

/// The costs of a trial.
type Cost = fn(&Trial) -> f64;

/// The page.
pub(super) fn page(reports: &[Report]) -> String {
    let title = match reports {
        [report] => format!("What accuracy costs: {}", report.name),
        _ => "What accuracy costs".to_owned(),
    };
    let body = html! {
        main {
            h1 { (title) }
            @for report in reports { (section(report)) }
        }
    };
    crate::page::page(&title, STYLE, &body)
}

fn section(report: &Report) -> Markup {
    let costs: [(&str, &[usize], Cost); 3] = [
        ("cycles of an evaluation", &report.front_cycles, |t| {
            t.costs.cycles
        }),
        ("mm² of an SRP", &report.front_area, |t| t.costs.area),
        ("pJ of an evaluation", &report.front_energy, |t| {
            t.costs.energy
        }),
    ];
    html! {
        section {
            h2 { (report.name) }
            p.soft {
                code { (report.file) } ", machine " code { (report.machine) } ": " (ranges(report)) ". "
                (report.points) " points; target " code { (report.target) } ". " (search_in_words(report))
            }
            div.plots {
                @for (what, front, cost) in costs {
                    figure {
                        figcaption { "Bits lost against " (what) }
                        (plot(report, front, cost))
                    }
                }
            }
            div.scroll { (table(report)) }
            (rewrites(report))
            (origins("as it is", &report.origins))
            @if let Some(found) = &report.cheapest_origins { (origins("with the cheapest", found)) }
        }
    }
}

fn table(report: &Report) -> Markup {
    html! {
        table {
            tr {
                th.words { "setting" } th { "" } th { "bits lost" } th { "ulps" } th { "relative" } th { "bound" } th { "II" }
                th { "cycles" } th { "mm²" } th { "pJ" } th.words { "how" } th.words { "machine" }
            }
            @for i in shown(report) {
                @let t = &report.trials[i];
                tr.cheapest[report.cheapest == Some(i)] {
                    td.words { (words(t)) } td { (marks(report, i)) }
                    td { (format!("{:.2}", t.error.bits)) } td { (ulps(&t.error)) } td { (short(t.error.relative)) } td { (bound(t)) }
                    td { (intervals(&t.costs)) } td { (format!("{:.1}", t.costs.cycles)) } td { (format!("{:.4}", t.costs.area)) }
                    td { (format!("{:.1}", t.costs.energy)) }
                    td.words { code { (t.how) } } td.words { code { (machine_name(report, i)) } }
                }
            }
        }
    }
}

fn rewrites(report: &Report) -> Markup {
    html! {
        @if let (Some(base), [_, ..]) = (report.trials.first(), report.rewrites.as_slice()) {
            h3 { "Rewrites, each alone" }
            div.scroll {
                table {
                    tr {
                        th.words { "rewrite" } th { "bits lost" } th { "ulps" } th { "II" } th { "cycles" } th { "pJ" }
                        th.words { "gain" } th.words { "what it makes of what" } th.words { "how" }
                    }
                    tr { td.words { "as it is" } (figures(&base.error, &base.costs)) td {} td {} td {} }
                    @for found in &report.rewrites {
                        tr {
                            td.words { (found.name) }
                            @match &found.failed {
                                Some(why) => { td colspan="5" { "cannot be tried: " (why) } }
                                None => { (figures(&found.error, &found.costs)) }
                            }
                            td.words { (found.gain.words()) } td.words { (found.what) } td.words { code { (found.how) } }
                        }
                    }
                }
            }
        }
    }
}

/// Cells of a rewrite's line.
fn figures(error: &Measure, costs: &Costs) -> Markup {
    html! {
        td { (format!("{:.2}", error.bits)) } td { (ulps(error)) } td { (intervals(costs)) }
        td { (format!("{:.1}", costs.cycles)) } td { (format!("{:.1}", costs.energy)) }
    }
}

fn origins(when: &str, found: &Origins) -> Markup {
    html! {
        @if !found.origins.is_empty() {
            h3 { "Where the error comes from, " (when) }
            table.origins {
                @for origin in found.origins.iter().take(10) {
                    tr {
                        td { (format!("{:.1} %", 100.0 * origin.share)) }
                        td.words { code { (origin.at) " " (origin.operation) } }
                    }
                }
            }
        }
    }
}

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 260.0;
const MARGIN: f64 = 40.0;

/// Bits lost upwards, the cost to the right.
fn plot(report: &Report, front: &[usize], cost: Cost) -> Markup {
    let possible: Vec<usize> = (0..report.trials.len())
        .filter(|&i| report.trials[i].failed.is_none() && report.trials[i].not_exercised.is_empty())
        .collect();
    let trial = |i: usize| &report.trials[i];
    let costs = || possible.iter().map(|&i| cost(trial(i)));
    let (least, most) = (
        costs().fold(f64::INFINITY, f64::min),
        costs().fold(0.0, f64::max),
    );
    let bits = possible
        .iter()
        .map(|&i| trial(i).error.bits)
        .fold(1.0, f64::max);
    let place = |i: usize| {
        let across = (cost(trial(i)) - least) / (most - least).max(1e-12);
        let up = trial(i).error.bits / bits;
        let x = MARGIN + across * (WIDTH - 2.0 * MARGIN);
        (x, HEIGHT - MARGIN - up * (HEIGHT - 2.0 * MARGIN))
    };
    let line = front.iter().enumerate().map(|(n, &i)| {
        let (x, y) = place(i);
        if n == 0 {
            format!("M{x:.1} {y:.1}")
        } else {
            format!("V{y:.1}H{x:.1}")
        }
    });
    let line: String = line.collect();
    let bottom = HEIGHT - MARGIN;
    html! {
        svg.plot viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" {
            line.axis x1=(MARGIN) y1=(bottom) x2=(WIDTH - MARGIN) y2=(bottom) {}
            line.axis x1=(MARGIN) y1=(bottom) x2=(MARGIN) y2=(MARGIN) {}
            text x=(MARGIN) y=(bottom + 16.0) text-anchor="middle" { (short(least)) }
            text x=(WIDTH - MARGIN) y=(bottom + 16.0) text-anchor="middle" { (short(most)) }
            text x=(MARGIN - 6.0) y=(bottom) text-anchor="end" { "0" }
            text x=(MARGIN - 6.0) y=(MARGIN + 4.0) text-anchor="end" { (format!("{bits:.1}")) }
            path d=(line) {}
            @for &i in &possible {
                @let (x, y) = place(i);
                circle.best[front.contains(&i)].base[i == 0] cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="4" {
                    title { (words(trial(i))) ": " (format!("{:.2}", trial(i).error.bits)) " bits, " (short(cost(trial(i)))) }
                }
            }
        }
    }
}
