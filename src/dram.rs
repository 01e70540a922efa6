//! `srp dram`

use crate::cli::dram::Dram;
use crate::failure::Failure;
use crate::files::Kind;
use crate::{document, files, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::diagnostic;
use srp_archdesc::dram::{DramSpec, FIXED, presets};
use srp_runtime::digits::thousands;
use srp_runtime::memory::dram::trace::{self, Replay};
use srp_runtime::memory::dram::{ChannelCounters, DramReport, Memory};
use srp_toolchain::envelope::{About, Contents};

/// How a trace went: the sums over the channels, and everything in detail.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Summary {
    /// The file of the trace.
    trace: String,
    /// Requests of the trace.
    requests: u64,
    /// Those that the memory took.
    taken: u64,
    /// Cycles for which the requester waited for room.
    refused_cycles: u64,
    /// Cycles of the memory's clock.
    cycles: u64,
    gigabytes_per_second: f64,
    reads: u64,
    writes: u64,
    /// From a request to its last word.
    mean_read_cycles: f64,
    max_read_cycles: u64,
    activates: u64,
    precharges: u64,
    refreshes: u64,
    read_row_hits: u64,
    write_row_hits: u64,
    memory: DramReport,
}

impl Contents for Summary {
    const FORMAT: &'static str = "srp-dram";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp dram --json`";
}

/// Runs `srp dram`.
pub(crate) fn run(args: &Dram) -> Result<(), Failure> {
    if args.presets {
        return Ok(talk::print(list())?);
    }
    let Some(path) = &args.trace else {
        return Err(Failure::usage("there is no trace to run"));
    };
    let (spec, about) = memory(args)?;
    let source = files::read_source(path, Kind::Trace)?;
    let bytes = trace::default_bytes(&spec);
    let requests = trace::parse(&source.name, &source.text, bytes).map_err(|errors| {
        Failure::Reported(diagnostic::render_all(
            &errors,
            &source.text,
            talk::colour(),
        ))
    })?;
    let mut device = Memory::new(&spec);
    let replay = trace::replay(&mut device, requests.offers(), args.cycles);
    let summary = summary(source.name, requests.requests() as u64, replay, &spec);
    let out = match args.json {
        true => document::json(about, &summary)?,
        false => text(&summary),
    };
    Ok(talk::print(out)?)
}

/// The named memories and where they come from.
fn list() -> String {
    let named: String = presets()
        .iter()
        .map(|preset| format!("{}\n    {}\n", preset.name, preset.source))
        .collect();
    named + "fixed\n    Every access takes 340 ns; two channels of 32 bits at 800 MHz.\n"
}

/// The memory that the command line names, and the machine that it is of.
fn memory(args: &Dram) -> Result<(DramSpec, About), Failure> {
    match args.preset.as_deref() {
        None => {
            let arch = args.machine.read()?;
            let about = About::machine(&arch);
            Ok((arch.system.dram, about))
        }
        Some(name) => {
            let mut presets = presets().into_iter();
            let preset = presets.find(|preset| preset.name == name);
            let spec = preset.map_or(FIXED, |preset| preset.spec);
            Ok((spec, About::default()))
        }
    }
}

fn summary(trace: String, requests: u64, replay: Replay, spec: &DramSpec) -> Summary {
    let sum = |of: &dyn Fn(&ChannelCounters) -> u64| replay.counters.channels.iter().map(of).sum();
    let counters = &replay.counters;
    let memory = DramReport::of(spec, 1, replay.cycles, counters.clone());
    Summary {
        trace,
        requests,
        taken: replay.taken,
        refused_cycles: replay.refused_cycles,
        cycles: replay.cycles,
        gigabytes_per_second: memory.gigabytes_per_second,
        reads: counters.reads,
        writes: counters.writes,
        mean_read_cycles: counters.read_cycles as f64 / counters.reads.max(1) as f64,
        max_read_cycles: counters.max_read_cycles,
        activates: sum(&|c| c.activates),
        precharges: sum(&|c| c.precharges),
        refreshes: sum(&|c| c.refreshes),
        read_row_hits: sum(&|c| c.read_row_hits),
        write_row_hits: sum(&|c| c.write_row_hits),
        memory,
    }
}

fn text(s: &Summary) -> String {
    format!(
        "{}: {} of {} requests taken in {} cycles at {} MHz; the requester waited for room in {}\n\
         {:.3} GB/s; {} reads and {} writes answered, reads after {:.2} cycles, at most {}\n\
         {} activations, {} precharges, {} refreshes; {} reads and {} writes hit their row\n\n{}",
        s.trace,
        thousands(s.taken),
        thousands(s.requests),
        thousands(s.cycles),
        s.memory.mhz,
        thousands(s.refused_cycles),
        s.gigabytes_per_second,
        thousands(s.reads),
        thousands(s.writes),
        s.mean_read_cycles,
        thousands(s.max_read_cycles),
        thousands(s.activates),
        thousands(s.precharges),
        thousands(s.refreshes),
        thousands(s.read_row_hits),
        thousands(s.write_row_hits),
        s.memory.text(),
    )
}
