//! The report as text.

use srp_studies::accuracy::{AttributionSummary, Report, TOGETHER, Trial};
use std::fmt::Write as _;

/// PSNR in words.
pub(super) fn decibels(psnr: Option<f64>) -> String {
    psnr.map_or_else(|| "exact".to_owned(), |p| format!("{p:.2}"))
}

/// The largest error of the unit that is set.
pub(super) fn unit(trial: &Trial) -> String {
    trial
        .unit
        .map_or_else(String::new, |u| match u.largest < 1000.0 {
            true => format!("{:.2}", u.largest),
            false => format!("{:.0}", u.largest),
        })
}

/// Where the errors of the machine as it is come from.
fn attributed(summary: &AttributionSummary) -> String {
    let (looked, of) = summary.tiles;
    let mut text = format!(
        "\nWhere the error comes from, as it is ({looked} of {of} tiles; {:.1} % of the roundings' \
         named)\n\n{}\n\n{:>7} {:>7} {:>6}  line and operation, or unit\n",
        100.0 * summary.named,
        summary.of_picture_in_words().replace(". ", ".\n"),
        "part",
        "pixels",
        "flips"
    );
    for s in summary
        .sources
        .iter()
        .filter(|s| s.part.abs() >= 5e-4 || s.flips > 0)
    {
        let _ = writeln!(
            text,
            "{:>6.1}% {:>7} {:>6}  {}",
            100.0 * s.part,
            s.pixels,
            s.flips,
            s.name()
        );
    }
    let _ = writeln!(
        text,
        "\nDecisions that binary64 makes otherwise: {}, on {} pixels.",
        summary.flips_in_words(),
        summary.flipped_pixels
    );
    for n in &summary.non_finite {
        let _ = writeln!(text, "{n}");
    }
    text
}

/// The marks of a line: on a front, the cheapest that meets the target, a hole, a unit that is not used.
pub(super) fn marks(report: &Report, i: usize) -> String {
    let mut marks = String::new();
    let fronts = [
        (&report.front, '*'),
        (&report.front_area, 'a'),
        (&report.front_energy, 'e'),
    ];
    marks.extend(
        fronts
            .iter()
            .filter(|(front, _)| front.contains(&i))
            .map(|(_, mark)| *mark),
    );
    if report.trials[i].not_exercised {
        marks.push('-');
    }
    if report.cheapest == Some(i) {
        marks.push('<');
    }
    if report.trials[i].leaks.leaks > 0 {
        marks.push('!');
    }
    marks
}

fn heading(report: &Report) -> String {
    let (width, height) = report.size;
    format!(
        "{}: {} triangles, {width}x{height} pixels, machine `{}`; target {}",
        report.scene, report.triangles, report.machine, report.target
    )
}

/// The report as text.
pub(super) fn text(report: &Report) -> String {
    let mut text = heading(report) + "\n\n";
    let width = (report.trials.iter())
        .filter(|t| t.knob != TOGETHER)
        .map(|t| t.knob.chars().count() + t.value.chars().count() + 1)
        .max()
        .unwrap_or(0);
    let _ = writeln!(
        text,
        "{:width$}  {:>7} {:>7} {:>7} {:>6} {:>6} {:>6} {:>6} {:>7} {:>7} {:>9} {:>9} {:>9} {:>7} {:>7} {:>7} {:>7}",
        "setting",
        "dB",
        "agree",
        "FLIP",
        ">1",
        ">8",
        "flips",
        "leaks",
        "t ulp",
        "ulp",
        "SRP Mcyc",
        "T&I Mcyc",
        "frame",
        "MB",
        "mJ",
        "mm2",
        "host s"
    );
    for (i, trial) in report.trials.iter().enumerate() {
        let name = match trial.knob.as_str() {
            TOGETHER => {
                let _ = writeln!(text, "{}:", trial.value);
                TOGETHER.to_owned()
            }
            knob => format!("{knob} {}", trial.value).trim().to_owned(),
        };
        let (c, a) = (&trial.costs, &trial.all);
        let mega = |n: u64| n as f64 / 1e6;
        let _ = writeln!(
            text,
            "{name:width$}  {:>7} {:>7} {:>7.5} {:>6} {:>6} {:>6} {:>6} {:>7.1} {:>7} {:>9.3} {:>9.3} {:>9.3} {:>7.2} \
             {:>7.2} {:>7.2} {:>7.2} {}",
            decibels(a.psnr),
            decibels(trial.agreeing.psnr),
            a.flip,
            a.beyond_1,
            a.beyond_8,
            trial.attribution.all_flips(),
            trial.leaks.leaks,
            trial.leaks.ulp_99,
            unit(trial),
            mega(c.srp_cycles),
            mega(c.tni_cycles),
            mega(c.frame_cycles),
            mega(c.dram_bytes),
            c.energy,
            c.area,
            c.host_seconds,
            marks(report, i)
        );
    }
    text += "\nNo other setting has a better picture for * fewer cycles, a less area, e less energy; < cheapest that \
             keeps\nto the target (cycles times energy times area); ! rays get through between triangles; - not \
             exercised:\nthe frame does not use the unit, and the setting gets no credit\n\n";
    let _ = writeln!(text, "{}\n", noise(report));
    text += "  frame Mcycles  in any of these orders\n";
    for (trial, [least, most]) in intervals(report) {
        let mega = |n: u64| n as f64 / 1e6;
        let (least, most, name) = (mega(least), mega(most), name(trial));
        let _ = writeln!(text, "{least:>7.3} {most:>7.3}  {name}");
    }
    text.push('\n');
    text += &prices(report);
    for sentence in &report.sentences {
        let _ = writeln!(text, "{sentence}");
    }
    if let Some(base) = report.trials.first() {
        text += &attributed(&base.attribution);
    }
    if let Some(cheapest) = report.cheapest.map(|i| &report.trials[i]) {
        let _ = match cheapest.how.is_empty() {
            true => writeln!(
                text,
                "\nNothing cheaper than the machine as it is keeps to the target. {}",
                search_in_words(report)
            ),
            false => writeln!(
                text,
                "\nCheapest that keeps to the target: {}\n{}",
                cheapest.how,
                search_in_words(report)
            ),
        };
    }
    if !report.complete {
        text += "\nInterrupted: say it again, and it goes on from here.\n";
    }
    text
}

/// Says how far cycles differ with the order of tiles.
pub(super) fn noise(report: &Report) -> String {
    let first = report.trials.first();
    format!(
        "The settings on the front were simulated in {} other orders of tiles too. From one order to another, their cycles \
         beside those of the machine as it is differ by up to {:.2} %; differences up to that count as none.",
        first.map_or(0, |t| t.cycles_in_other_orders.len()),
        100.0 * report.cycle_noise
    )
}

/// A trial's knob and value.
pub(super) fn name(trial: &Trial) -> String {
    match trial.knob.as_str() {
        "" | TOGETHER => trial.value.clone(),
        knob => format!("{knob}: {}", trial.value),
    }
}

/// The settings that were tried in other orders of tiles, with their least and most cycles in all orders.
pub(super) fn intervals(report: &Report) -> Vec<(&Trial, [u64; 2])> {
    let known = |t: &&Trial| !t.cycles_in_other_orders.is_empty();
    let interval = |t: &Trial| {
        let all = || {
            t.cycles_in_other_orders
                .iter()
                .chain([&t.costs.frame_cycles])
        };
        [all().min(), all().max()].map(|c| c.copied().unwrap_or_default())
    };
    report
        .trials
        .iter()
        .filter(known)
        .map(|t| (t, interval(t)))
        .collect()
}

/// Says whether better settings may exist.
pub(super) fn search_in_words(report: &Report) -> String {
    let refused = match report.screened {
        0 => String::new(),
        n => format!(" {n} combinations miss the target by their picture and were not simulated."),
    };
    match (report.complete, report.closed) {
        (false, _) => String::new(),
        _ if report.exhaustive => {
            "All combinations were simulated: no setting is better.".to_owned()
        }
        (_, true) => format!(
            "No setting found is better: every one that differs from the best in one knob was tried, misses the target, \
             or is predicted to cost more.{refused}"
        ),
        _ => format!("Better combinations may exist: --trials ended the search.{refused}"),
    }
}

/// A part of a cost as a change in percent.
pub(super) fn percent(part: f64) -> String {
    match part == 1.0 {
        true => "0".to_owned(),
        false => format!("{:+.1}", 100.0 * (part - 1.0)),
    }
}

/// Says what a dB costs.
fn prices(report: &Report) -> String {
    let mut text =
        "What a dB costs (least of a setting without leaks, % of the machine as it is)\n\n\
                    at least   cycles     area   energy\n"
            .to_owned();
    for price in &report.prices {
        let _ = writeln!(
            text,
            "{:>5.0} dB {:>8} {:>8} {:>8}",
            price.decibels,
            percent(price.cycles),
            percent(price.area),
            percent(price.energy)
        );
    }
    text + "\n"
}
