//! A measurement as text, for people.

use srp_archdesc::arch::Arch;
use srp_runtime::tni::{PipeCounters, TniCounters};
use srp_studies::figure::Quantity;
use srp_studies::survey::Estimate;
use srp_studies::tni::Energy;
use srp_studies::tni::{Measure, Memories};
use srp_studies::views::{Job, Measured};
use std::fmt::Write as _;

/// The whole report.
pub(super) fn report(
    arch: &Arch,
    job: &Job<'_>,
    measured: &Measured,
    private: Option<&Measure>,
) -> String {
    let mut out = String::new();
    let all = &measured.all;
    write_report(&mut out, arch, job, measured).expect("writing to a String does not fail");
    if let Some(private) = private {
        out += &format!(
            "\nwith a memory for each unit: {:.2} Mrays/s, {:.3} of the above, {:.1} cycles a node visit\n{}",
            private.mrays_per_second,
            private.mrays_per_second / all.mrays_per_second,
            private.cycles_per_visit,
            private.memory.text()
        );
    }
    out
}

fn write_report(
    out: &mut String,
    arch: &Arch,
    job: &Job<'_>,
    measured: &Measured,
) -> std::fmt::Result {
    let (all, views) = (&measured.all, &measured.outcomes);
    writeln!(
        out,
        "{}: {} {} rays of {} view(s), {} unit(s) of `{}` at {} MHz, {}",
        job.scene.name,
        measured.sample.as_ref().map_or(all.rays, |s| s.rays),
        job.rays.name(),
        job.views(),
        job.units,
        arch.name,
        arch.system.tni_mhz,
        match job.memories {
            Memories::Shared => "one memory",
            Memories::Private => "a memory for each",
        }
    )?;
    match &measured.sample {
        Some(s) => writeln!(
            out,
            "sampled, seed {}: of {} blocks of 16 packets {} were looked at without time, {} run; what has no \
             interval is of those that were run",
            s.seed, s.blocks, s.looked, s.run
        )?,
        None if measured.one_in > 1 => {
            writeln!(
                out,
                "sampled: one run of packets in {}, from cold caches, of which intervals know nothing",
                measured.one_in
            )?;
        }
        None => {}
    }
    for figure in measured.intervals(job) {
        let Estimate { value, half_width } = figure.estimate;
        let (name, unit) = (figure.quantity, figure.quantity.unit());
        writeln!(out, "  {name:24} {value:>10.3} ± {half_width:.3} {unit}")?;
    }
    let error = match all.relative_error {
        Some(error) => format!(" ± {:.2} (95 %)", error * all.mrays_per_second),
        None => String::new(),
    };
    write!(out, "\n{:.2}{error} Mrays/s", all.mrays_per_second)?;
    match measured.sample {
        Some(_) => writeln!(out)?,
        None => writeln!(
            out,
            " while units have rays, {:.2} cycles a ray and unit; {} cycles until the last is done",
            all.counters.unit.active_cycles as f64 / all.rays.max(1) as f64,
            all.cycles
        )?,
    }
    let at_work = views.iter().map(|v| v.at_work).max().unwrap_or(0);
    if at_work < u64::from(job.units) {
        writeln!(out, "  {at_work} of {} units had rays", job.units)?;
    }
    if measured.sample.is_none() && views.len() > 1 {
        let each = views.iter().map(|view| {
            let one = Measure::of(std::slice::from_ref(view), job.units, job.spec);
            format!("{:.2}", one.mrays_per_second)
        });
        let each: Vec<String> = each.collect();
        writeln!(out, "  by view: {}", each.join(", "))?;
    }
    writeln!(
        out,
        "a ray: {:.2} inner nodes, {:.2} leaves, {:.2} triangle tests; {:.2} ways through \
         sub-pipelines, {:.2} of them without work",
        all.inner_visits, all.leaf_visits, all.triangle_tests, all.passes, all.idle_passes
    )?;
    writeln!(
        out,
        "  {:.1} cycles in the unit, {:.1} a node visit",
        all.residence, all.cycles_per_visit
    )?;
    writeln!(
        out,
        "TRV busy {:.1} %, AABB issuing {:.1} %; IST busy {:.1} %, issuing {:.1} %",
        100.0 * all.trv_busy,
        100.0 * all.trv_issue,
        100.0 * all.ist_busy,
        100.0 * all.ist_issue
    )?;
    writeln!(
        out,
        "hits: TRV L1 {:.1} %, TRV L2 {:.1} %, IST L1 {:.1} %; memory {:.2} GB/s",
        100.0 * all.trv_l1,
        100.0 * all.trv_l2,
        100.0 * all.ist_l1,
        all.gigabytes_per_second
    )?;
    writeln!(
        out,
        "waiting for lines: {:.2} rays a unit, {:.2} lines of level 1 outstanding",
        all.waiting_rays, all.outstanding
    )?;
    counters(out, &all.counters)?;
    let energy = Energy::of(&arch.system.tni, &all.counters);
    if energy.total() > 0.0 {
        writeln!(
            out,
            "energy of tests and caches: {:.4} mJ, {:.2} nJ a ray: boxes {:.0} %, triangles {:.0} %, caches \
         {:.0} %",
            energy.total(),
            1e6 * energy.total() / all.rays.max(1) as f64,
            100.0 * energy.boxes / energy.total(),
            100.0 * energy.triangles / energy.total(),
            100.0 * energy.caches / energy.total()
        )?;
    }
    accounts(out, &all.counters)?;
    if measured.sample.is_some() {
        write!(
            out,
            "\nwith the rays that lead to blocks and that keep them company:"
        )?;
    }
    write!(out, "\n{}", all.memory.text())
}

fn counters(out: &mut String, c: &TniCounters) -> std::fmt::Result {
    let s = &c.stacks;
    writeln!(
        out,
        "{} box tests, {} triangle tests ({} nearer), {} of {} rays hit, {} void",
        c.box_tests, c.triangle_tests, c.accepted, c.unit.hits, c.unit.rays, c.unit.void_rays
    )?;
    writeln!(
        out,
        "stacks: {} pushes, {} pops, {} culled, {} overflows, {} restarts",
        s.pushes, s.pops, s.culled, s.overflows, s.restarts
    )?;
    for (name, rau) in [("TRV", &c.trv_rau), ("IST", &c.ist_rau)] {
        writeln!(
            out,
            "{name} accumulation: {} rows opened, {} rays joined, {} retried",
            rau.opened, rau.joined, rau.retried
        )?;
    }
    Ok(())
}

/// Where every cycle of every unit went.
fn accounts(out: &mut String, c: &TniCounters) -> std::fmt::Result {
    let parts: [(&str, &PipeCounters); 4] = [
        ("TRV_PRE", &c.pre),
        ("TRV_AABB", &c.aabb),
        ("TRV_POST", &c.post),
        ("IST", &c.ist),
    ];
    write!(out, "\n{:9} {:>14}", "cycles", "all")?;
    for (name, _) in c.pre.account.rows() {
        write!(out, " {name:>11}")?;
    }
    writeln!(out)?;
    for (name, pipe) in parts {
        let total = pipe.account.total();
        write!(out, "{name:9} {total:>14}")?;
        for (_, cycles) in pipe.account.rows() {
            write!(out, " {:>9.2} %", share(cycles, total))?;
        }
        writeln!(out)?;
    }
    let d = &c.unit.dispatch;
    let total = d.total();
    writeln!(
        out,
        "{:9} {total:>14}  dispatching {:.2} %, all units full {:.2} %, no ray {:.2} %",
        "RD",
        share(d.work, total),
        share(d.full, total),
        share(d.empty, total)
    )
}

fn share(part: u64, all: u64) -> f64 {
    if all == 0 {
        0.0
    } else {
        100.0 * part as f64 / all as f64
    }
}
