//! What to do about the largest costs of a frame: changes of the machine that its own counts speak for.

use super::model::{Advice, Profile};
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Class;
use srp_archdesc::system::{BankSpec, MAX_SRAM_BANKS, SystemSpec};
use srp_runtime::system::Report;
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
    let mut found = vec![waits(report, system, parts.wait as f64 / all)];
    if system.data_cache.blocking {
        found.push(data_stalls(report, arch, parts.memory_stall as f64 / all));
    }
    if system.texture_cache.blocking {
        found.push(texture_stalls(parts.texture_stall as f64 / all));
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
    let (rays, hits) = (system.buffers.ray_buffers, system.buffers.hit_buffers);
    let more = 2 * hits;
    Advice {
        share,
        reason: format!(
            "The cores wait for their T&I units, which wait themselves: even {name} has work in {:.0} % of the cycles only, \
             for too few packets are on the way at a time.",
            100.0 * work
        ),
        change: format!("More packets on the way: hit-buffers is {hits} and ray-buffers {rays}."),
        set: vec![
            ("buffers.hit-buffers".to_owned(), more.to_string()),
            ("buffers.ray-buffers".to_owned(), (more + 1).to_string()),
        ],
    }
}

/// The largest part of a miss, in cycles, that a load is worth being scheduled for: its value waits in registers.
const LONGEST: u32 = 48;

/// Cores stand still for their data caches.
fn data_stalls(report: &Report, arch: &Arch, share: f64) -> Advice {
    let read = report.dram.mean_read_ns * f64::from(report.srp_mhz) / 1000.0;
    let now = arch.srp.least_latency(Class::Cload).unwrap_or(1);
    let latency = ((read / 2.0) as u32).min(LONGEST).max(now);
    let misses = arch.system.data_cache.misses.max(16);
    let set = [
        ("data-cache.blocking", "false".to_owned()),
        ("data-cache.misses", misses.to_string()),
        ("op[class=cload].latency", latency.to_string()),
    ];
    Advice {
        share,
        reason: format!(
            "A core stands still from each miss of its data cache until the line is there, {read:.0} cycles in the mean."
        ),
        change: format!(
            "A cache that does not block, and loads that are scheduled as if they took half of that (now {now}): loops \
             go on meanwhile."
        ),
        set: set
            .map(|(attribute, value)| (attribute.to_owned(), value))
            .into(),
    }
}

/// Cores stand still for their texture caches.
fn texture_stalls(share: f64) -> Advice {
    Advice {
        share,
        reason: "A core stands still from each miss of its texture cache until the line is there."
            .to_owned(),
        change: "A cache that does not block: the core goes on until the value is due.".to_owned(),
        set: vec![("texture-cache.blocking".to_owned(), "false".to_owned())],
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
