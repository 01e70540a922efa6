//! Initiation intervals of the loops of `kernels/micro` and of the frame, on an array of 4×4 and one of 8×8:
//! the II, its bound, the proof or the obstacle, and the time of the scheduler, one loop at a time.
//!
//! `cargo bench -p srp-tests --bench micro [-- LOOP…]`: those whose names begin with a word given.

use srp_archdesc::Unwatched;
use srp_ir::dfg::Dfg;
use srp_ir::split;
use srp_scheduler::modulo::{self, Scheduled};
use srp_tests::{compiled, machine, suites};
use std::time::{Duration, Instant};

/// The result for a loop.
struct Row {
    nodes: usize,
    result: Result<Scheduled, modulo::Unschedulable>,
    time: Duration,
}

fn main() {
    let words = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let wanted: Vec<String> = words.collect();
    let is_wanted = |dfg: &Dfg| wanted.is_empty() || wanted.iter().any(|w| dfg.name.starts_with(w));
    for name in ["sgrt", "wide"] {
        let arch = machine(name);
        println!("\n{name}: {}×{}", arch.srp.rows, arch.srp.cols);
        println!(
            "{:24} {:>5} {:>4} {:>5} {:>9}  proof",
            "loop", "nodes", "II", "bound", "ms"
        );
        let mut rows = Vec::new();
        for suite in suites() {
            let program = compiled(&suite.sources, &arch);
            let program = program.unwrap_or_else(|e| panic!("{}: {e}", suite.name));
            let kernels = split::split(&program).dre.kernels;
            for dfg in kernels.values().filter(|&dfg| is_wanted(dfg)) {
                let start = Instant::now();
                let result =
                    modulo::schedule(dfg, &arch.srp, &modulo::Options::default(), &Unwatched);
                let row = Row {
                    nodes: dfg.nodes.len(),
                    result,
                    time: start.elapsed(),
                };
                show(&dfg.name, &row);
                rows.push(row);
            }
        }
        summary(name, &rows);
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The smallest II that is neither below the bound nor proved impossible.
fn least(scheduled: &Scheduled) -> u32 {
    let is_impossible = |ii: &u32| scheduled.impossible.iter().any(|i| i.ii == *ii);
    let from_bound = scheduled.bounds.min_ii()..;
    let open = from_bound.into_iter().find(|ii| !is_impossible(ii));
    open.expect("some II is possible")
}

/// Describes what is proved of the IIs between the bound and the one reached.
fn proof(scheduled: &Scheduled) -> String {
    let (ii, bound) = (scheduled.schedule.ii, scheduled.bounds.min_ii());
    let (least, slack) = (
        least(scheduled),
        scheduled.impossible.first().map(|i| i.slack()),
    );
    let proved = slack.map(|slack| match slack {
        None => format!("below {least} impossible"),
        Some(slack) => format!("below {least} impossible (slack {slack})"),
    });
    let open = (least < ii).then(|| {
        let failed = scheduled.why_not_lower.as_ref();
        failed.map_or_else(|| "open".to_owned(), |failed| format!("open: {failed}"))
    });
    match (proved, open) {
        _ if ii == bound => "the bound".to_owned(),
        (Some(proved), Some(open)) => format!("{proved}; {open}"),
        (proved, open) => proved.or(open).unwrap_or_default(),
    }
}

fn show(name: &str, row: &Row) {
    let (nodes, time) = (row.nodes, milliseconds(row.time));
    match &row.result {
        Ok(scheduled) => {
            let (ii, bound) = (scheduled.schedule.ii, scheduled.bounds.min_ii());
            let proof = proof(scheduled);
            println!("{name:24} {nodes:5} {ii:4} {bound:5} {time:9.1}  {proof}");
        }
        Err(e) => println!("{name:24} {nodes:5}    -     - {time:9.1}  {e}"),
    }
}

/// The share of loops at their bound, at what is proved, the largest gap, and the times.
fn summary(machine: &str, rows: &[Row]) {
    let mut times: Vec<Duration> = rows.iter().map(|row| row.time).collect();
    times.sort();
    let (Some(&worst), Some(&median)) = (times.last(), times.get(times.len() / 2)) else {
        return println!("no loop of that name");
    };
    let done: Vec<&Scheduled> = rows.iter().filter_map(|r| r.result.as_ref().ok()).collect();
    let share = |is: &dyn Fn(&Scheduled) -> bool| {
        let count = done.iter().filter(|s| is(s)).count();
        let all = rows.len();
        format!(
            "{count} of {all} ({:.1} %)",
            100.0 * count as f64 / all as f64
        )
    };
    let gap = done.iter().map(|s| s.schedule.ii - s.bounds.min_ii()).max();
    println!(
        "{machine}: {} loops at the bound, {} at it or at the least II that is not proved \
         impossible, largest gap {}",
        share(&|s| s.schedule.ii == s.bounds.min_ii()),
        share(&|s| s.schedule.ii == least(s)),
        gap.unwrap_or(0),
    );
    println!(
        "{machine}: median {:.1} ms, worst {:.1} ms, all {:.1} s",
        milliseconds(median),
        milliseconds(worst),
        times.iter().sum::<Duration>().as_secs_f64(),
    );
}
