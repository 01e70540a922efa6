//! What to do about the largest costs of a frame: changes of the machine that its own counts speak for.

use super::model::{Advice, Profile};
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Class;
use srp_archdesc::system::{BankSpec, CacheSpec, MAX_SRAM_BANKS, SystemSpec};
use srp_runtime::system::{CoreReport, Report};
use srp_runtime::tni::PipeCounters;

/// The part of all cycles from which on something is worth a word.
const WORTH: f64 = 0.05;

/// The part of its cycles from which on a pipeline works that it is what others wait for.
const BUSY: f64 = 0.6;

/// What to do about the largest costs of a frame, the largest first.
pub(super) fn advice(profile: &Profile, report: &Report, arch: &Arch) -> Vec<Advice> {
    let system = &arch.system;
    let all = profile.parts.total().max(1) as f64;
    let parts = &profile.parts;
    let (wait, memory, texture) = (parts.wait, parts.memory_stall, parts.texture_stall);
    let mut found = Vec::new();
    match saturated(report, system, (wait + memory + texture) as f64 / all) {
        // Whoever waits for lines waits for that.
        Some(advice) => found.push(advice),
        None => {
            found.push(waits(report, system, wait as f64 / all));
            let data = Stalled {
                names: ["data-cache", "data cache"],
                class: Class::Cload,
                loads: "loads",
                spec: system.data_cache,
                stall: |core| core.memory_stall,
                misses: |core| core.data_cache.misses,
            };
            let textures = Stalled {
                names: ["texture-cache", "texture cache"],
                class: Class::Tex,
                loads: "samples",
                spec: system.texture_cache,
                stall: |core| core.texture_stall,
                misses: |core| core.texture_cache.misses,
            };
            for (stalled, cycles) in [(data, memory), (textures, texture)] {
                if stalled.spec.blocking {
                    found.push(stalls(report, arch, cycles as f64 / all, &stalled));
                }
            }
        }
    }
    found.push(instruction_stalls(
        system,
        parts.instruction_stall as f64 / all,
    ));
    found.push(context_stalls(arch, parts.context_stall as f64 / all));
    if let Some(banks) = system.sram_banks {
        found.push(bank_stalls(banks, parts.sram_stall as f64 / all));
    }
    found.extend(loops(profile, all));
    found.retain(|advice| advice.share >= WORTH);
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

/// Everything waits for lines that come through a bus or from a memory that is busy.
fn saturated(report: &Report, system: &SystemSpec, share: f64) -> Option<Advice> {
    let bus = &report.bus;
    let (moving, what) = match bus.answers >= bus.requests {
        true => (bus.answers, "answers take"),
        false => (bus.requests, "requests and writes take"),
    };
    if moving >= BUSY {
        let width = system.bus.width;
        return Some(Advice {
            share,
            reason: format!(
                "Cores and T&I units wait for lines that come one after the other: {what} {:.0} % of the bus's cycles.",
                100.0 * moving
            ),
            change: format!("A wider bus: bus.width is {width}."),
            set: vec![("bus.width".to_owned(), (2 * width).to_string())],
        });
    }
    let channels = &report.dram.channels;
    let busiest = channels.iter().map(|channel| channel.busy);
    let busy = busiest.fold(0.0, f64::max);
    (busy >= BUSY).then(|| Advice {
        share,
        reason: format!(
            "Cores and T&I units wait for lines from a memory that moves data in {:.0} % of its cycles.",
            100.0 * busy
        ),
        change: format!("More channels: dram.channels is {}.", system.dram.channels),
        set: vec![(
            "dram.channels".to_owned(),
            (2 * system.dram.channels).to_string(),
        )],
    })
}

/// The part of its cycles in which the first stage of a kind of pipelines has work, of so many in a core.
fn works(pipes: &PipeCounters, count: u32, report: &Report) -> f64 {
    let cores = report.cores.len() as f64;
    let cycles = report.cycles as f64 * f64::from(report.tni_mhz) / f64::from(report.srp_mhz);
    pipes.account.work as f64 / (cycles * cores * f64::from(count)).max(1.0)
}

/// Cores wait for T&I units: these are busy, or have too little to do at a time.
fn waits(report: &Report, system: &SystemSpec, share: f64) -> Advice {
    let counts = report.tni();
    let (trvs, ists) = (system.tni.trvs, system.tni.ists);
    let parts = [
        ("TRV_PRE", "tni.trvs", trvs, &counts.pre),
        ("TRV_AABB", "tni.trvs", trvs, &counts.aabb),
        ("TRV_POST", "tni.trvs", trvs, &counts.post),
        ("IST", "tni.ists", ists, &counts.ist),
    ];
    let parts = parts.map(|(name, attribute, count, pipes)| {
        (works(pipes, count, report), name, attribute, count)
    });
    let busiest = parts.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let (work, name, attribute, count) = busiest.unwrap_or((0.0, "", "tni.trvs", trvs));
    if work >= BUSY {
        return Advice {
            share,
            reason: format!(
                "The cores wait for their T&I units, whose {name} has work in {:.0} % of the cycles.",
                100.0 * work
            ),
            change: format!("More units: {attribute} is {count}."),
            set: vec![(attribute.to_owned(), (2 * count).to_string())],
        };
    }
    let (of, work) = (report.tni().unit.dispatch, 100.0 * work);
    let part = |cycles: u64| 100.0 * cycles as f64 / of.total().max(1) as f64;
    let waits = format!(
        "The cores wait for their T&I units, which wait themselves: even {name} has work in {work:.0} % of the cycles only"
    );
    if of.empty >= of.full {
        let (rays, hits) = (system.buffers.ray_buffers, system.buffers.hit_buffers);
        let more = 2 * hits;
        return Advice {
            share,
            reason: format!(
                "{waits}, for no ray is there to be let in in {:.0} % of them: too few packets are on the way at a time.",
                part(of.empty)
            ),
            change: format!(
                "More packets on the way: hit-buffers is {hits} and ray-buffers {rays}."
            ),
            set: vec![
                ("buffers.hit-buffers".to_owned(), more.to_string()),
                ("buffers.ray-buffers".to_owned(), (more + 1).to_string()),
            ],
        };
    }
    let waits = format!(
        "{waits}, while rays stand before them in {:.0} %",
        part(of.full)
    );
    let stacks = system.tni.stacks;
    let (reason, change, attribute, value) = match system.tni.rau_rows {
        0 => (
            format!("{waits}: a ray whose line is not there holds up all behind it."),
            "Rows in which rays stand aside until their lines are there: tni.rau-rows is 0."
                .to_owned(),
            "tni.rau-rows",
            RAU_ROWS,
        ),
        _ => (
            format!("{waits}: all stacks of the traversal units are taken."),
            format!("More rays at a time: tni.stacks is {stacks}."),
            "tni.stacks",
            2 * stacks,
        ),
    };
    Advice {
        share,
        reason,
        change,
        set: vec![(attribute.to_owned(), value.to_string())],
    }
}

/// The largest part of a miss, in cycles, that a load is worth being scheduled for: its value waits in registers.
const LONGEST: u32 = 48;

/// Lines that a cache is worth being able to wait for at a time, where it does not block.
const MISSES: u32 = 16;

/// Rows in which rays stand aside, as the machine that comes along has them.
const RAU_ROWS: u32 = 8;

/// A cache that its core stands still for, and the loads that go through it.
struct Stalled {
    /// As attributes name it, and in words.
    names: [&'static str; 2],
    /// The class of its loads, and what these are called.
    class: Class,
    loads: &'static str,
    spec: CacheSpec,
    stall: fn(&CoreReport) -> u64,
    misses: fn(&CoreReport) -> u64,
}

/// Cores stand still for one of their caches.
fn stalls(report: &Report, arch: &Arch, share: f64, stalled: &Stalled) -> Advice {
    let Stalled {
        names: [name, cache],
        class,
        loads,
        ..
    } = stalled;
    let sum = |of: fn(&CoreReport) -> u64| -> u64 { report.cores.iter().map(of).sum() };
    let mean = sum(stalled.stall) as f64 / sum(stalled.misses).max(1) as f64;
    let now = arch.srp.least_latency(*class).unwrap_or(1);
    let latency = ((mean / 2.0) as u32).min(LONGEST).max(now);
    let misses = stalled.spec.misses.max(MISSES);
    Advice {
        share,
        reason: format!(
            "A core stands still from each miss of its {cache} until the line is there, {mean:.0} cycles in the mean."
        ),
        change: format!(
            "A cache that does not block, and {loads} that are scheduled as if they took {latency} cycles (now {now}): loops \
             go on meanwhile."
        ),
        set: vec![
            (format!("{name}.blocking"), "false".to_owned()),
            (format!("{name}.misses"), misses.to_string()),
            (format!("op[class={class}].latency"), latency.to_string()),
        ],
    }
}

/// Cores stand still for bundles.
fn instruction_stalls(system: &SystemSpec, share: f64) -> Advice {
    let bytes = system.instruction_cache.map_or(0, |cache| cache.bytes);
    Advice {
        share,
        reason: format!(
            "A core stands still from each miss of its instruction cache, of {bytes} bytes, until the line is there."
        ),
        change: "A larger cache, or one with more ways.".to_owned(),
        set: vec![("instruction-cache.size".to_owned(), (2 * bytes).to_string())],
    }
}

/// Cores stand still for contexts.
fn context_stalls(arch: &Arch, share: f64) -> Advice {
    let contexts = arch.srp.contexts;
    Advice {
        share,
        reason: format!(
            "A core stands still at each launch of a loop that is not among the {contexts} contexts of its configuration \
             memory."
        ),
        change: "A deeper configuration memory.".to_owned(),
        set: vec![("array.contexts".to_owned(), (2 * contexts).to_string())],
    }
}

/// Cores stand still for banks of their SRAM.
fn bank_stalls(banks: BankSpec, share: f64) -> Advice {
    let number = match banks.count {
        1 => "the only bank".to_owned(),
        count => format!("one of the {count} banks"),
    };
    let packets = match banks.shared {
        true => ", and while packets of the T&I unit go through all of them",
        false => "",
    };
    let set = match banks.count {
        MAX_SRAM_BANKS.. => Vec::new(),
        count => vec![("sram.banks".to_owned(), (2 * count).to_string())],
    };
    Advice {
        share,
        reason: format!(
            "A core stands still where accesses of a cycle meet in {number} of its SRAM{packets}."
        ),
        change: "More banks, or arrays of a loop that do not begin in the same one.".to_owned(),
        set,
    }
}

/// The loop that takes most cycles on the array.
fn loops(profile: &Profile, all: f64) -> Option<Advice> {
    let longest = profile.loops.iter().max_by_key(|l| l.parts.array)?;
    let (share, name) = (longest.parts.array as f64 / all, &longest.kernel);
    Some(Advice {
        share,
        reason: format!(
            "{name} begins an iteration every {} cycles, {:.0} a launch.",
            longest.ii,
            longest.iterations.all as f64 / longest.launches.max(1) as f64
        ),
        change: format!("`srp report` says what bounds its II: --kernel {name} --what-if."),
        set: Vec::new(),
    })
}
