//! `srp units`: a certificate of every special function of a machine, over all mantissas.

use crate::cli;
use crate::failure::Failure;
use crate::talk::{self, Progress};
use crate::{document, interrupt};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::{Approx, Arch};
use srp_archdesc::certify::{Certificate, Function, certify};
use srp_archdesc::cost::special::{Unit, unit};
use srp_archdesc::structure::{Special, Structure};
use srp_toolchain::envelope::{About, Contents};
use std::fmt::Write as _;

/// The certificates of a machine.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Report {
    /// The machine's name, which the envelope has.
    #[serde(skip)]
    machine: String,
    /// Cycles, area and energy of the functions of the SRP, in the order of [`Special::ALL`].
    costs: Vec<Cost>,
    /// Special functions of the SRP, with the steps that the program takes.
    srp: Vec<Certificate>,
    /// Fast functions of the SRP, as far as it has units for them.
    fast: Vec<FastUnit>,
    /// The reciprocal of the T&I unit.
    tni: Certificate,
}

impl Contents for Report {
    const FORMAT: &'static str = "srp-units";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp units --json`";
}

/// What a fast unit is worth.
#[derive(Serialize, JsonSchema)]
struct FastUnit {
    unit: Special,
    certificate: Certificate,
}

/// The cost of the unit of a function.
#[derive(Serialize, JsonSchema)]
struct Cost {
    function: Special,
    #[serde(flatten)]
    unit: Unit,
}

/// Runs `srp units`.
pub(crate) fn run(args: &cli::Units) -> Result<(), Failure> {
    let arch = args.machine.read()?;
    let fast: Vec<Special> = arch.precision.specials().filter(|s| s.is_fast()).collect();
    let all = Function::ALL.len() + fast.len() + 1;
    let progress = Progress::steps("trying every mantissa", all as u64);
    let tried = |done: usize, function: Function, approx: Approx| {
        interrupt::end_if_requested()?;
        let certificate = certify(function, approx);
        progress.at(done as u64 + 1);
        Ok::<_, Failure>(certificate)
    };
    let functions = Function::ALL.iter().enumerate();
    let srp: Result<Vec<_>, _> = interrupt::looked_for(|| {
        functions
            .map(|(i, &f)| tried(i, f, f.of(&arch.precision)))
            .collect()
    });
    let fast = fast.iter().enumerate().filter_map(|(i, &unit)| {
        let function = Function::ALL
            .into_iter()
            .find(|f| f.special() == unit.ordinary())?;
        let done = Function::ALL.len() + i;
        let certificate = tried(done, function, arch.precision.of(unit));
        Some(certificate.map(|certificate| FastUnit { unit, certificate }))
    });
    let fast: Result<Vec<_>, Failure> = interrupt::looked_for(|| fast.collect());
    let report = Report {
        machine: arch.name.clone(),
        costs: (arch.precision.specials())
            .map(|special| Cost {
                function: special,
                unit: arch.special_unit(special),
            })
            .collect(),
        srp: srp?,
        fast: fast?,
        tni: tried(all - 1, Function::Rcp, arch.system.tni.rcp)?,
    };
    drop(progress);
    if args.json {
        let json = document::json(About::machine(&arch), &report)?;
        return Ok(talk::print(json)?);
    }
    let mut out = String::new();
    let written = text(&mut out, &report).and_then(|()| costs(&mut out, &arch));
    written.expect("writing to a String does not fail");
    Ok(talk::print(out)?)
}

fn text(out: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(out, "units of `{}` over all mantissas", report.machine)?;
    writeln!(
        out,
        "{:<11}{:<45}{:>11}{:>13}  {:<10}{:>11}{:>7}{:>11}{:>10}{:>8}",
        "", "", "bound ulp", "largest ulp", "at", "mean ulp", "bits", "rounded", "monotone", "2^k"
    )?;
    for certificate in &report.srp {
        line(out, certificate.function.name(), certificate)?;
    }
    for FastUnit { unit, certificate } in &report.fast {
        line(out, unit.name(), certificate)?;
    }
    line(out, "T&I rcp", &report.tni)?;
    writeln!(
        out,
        "bound: what is promised of every result, by which --max-ulp chooses; largest: what was found; bits: of log2, \
         sin and cos absolute; 2^k: powers of two have exact results"
    )
}

/// How a unit is made.
fn made(structure: Structure, bits: u32, steps: u32, fused: bool) -> String {
    let first = match structure {
        Structure::Table if steps == 0 => format!("table of {bits} bits"),
        Structure::Table => format!("{bits} bits"),
        other => format!("{other}, {bits} bits"),
    };
    let fused = if fused { "" } else { " not fused" };
    match steps {
        0 => first,
        1 => format!("{first} + 1 step{fused}"),
        _ => format!("{first} + {steps} steps{fused}"),
    }
}

/// Cycles, area and energy of each unit, and how they come about.
fn costs(out: &mut String, arch: &Arch) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:<11}{:>9}{:>10}{:>10}{:>10}  at 65 nm and the clock of the unit",
        "cost", "latency", "interval", "mm²", "pJ"
    )?;
    let tni = &arch.system.tni;
    let rcp = unit(
        Special::Rcp,
        tni.rcp,
        &tni.rcp_build,
        arch.system.tni_mhz_at_65nm(),
    );
    let class = || "class".to_owned();
    let of_srp = arch.precision.specials().map(|special| {
        let unit = arch.special_unit(special);
        let cycles = [unit.latency, unit.interval].map(|n| n.map_or_else(class, |n| n.to_string()));
        (special.name(), unit, cycles, "the class's cycles")
    });
    let of_tni = [tni.rcp_latency, tni.rcp_interval].map(|n| n.to_string());
    let of_tni = ("T&I rcp", rcp, of_tni, "SimTRaX's unit");
    for (name, unit, [latency, interval], unsaid) in of_srp.chain([of_tni]) {
        let why = match unit.latency {
            Some(_) => unit.why.clone(),
            None => format!("exact, and nothing said of how: {unsaid}"),
        };
        writeln!(
            out,
            "{name:<11}{:>9}{:>10}{:>10.5}{:>10.2}  {why}",
            latency,
            interval,
            unit.area_um2 * 1e-6,
            unit.energy_pj,
        )?;
    }
    writeln!(
        out,
        "an `<op>` that gives latency or interval of its class overrides what follows from structure in the SRP"
    )
}

fn line(out: &mut String, name: &str, c: &Certificate) -> std::fmt::Result {
    let made = match (c.structure, c.table_bits) {
        (Some(structure), Some(bits)) => made(structure, bits, c.steps, c.fused),
        _ => "exact".to_owned(),
    };
    let answer = |answer: Option<bool>| match answer {
        None => "–",
        Some(true) => "yes",
        Some(false) => "no",
    };
    // A relative error is so many units in the last place at most, where they are smallest beside the result.
    let bound = match c.function.is_absolute() {
        true => "–".to_owned(),
        false => format!("{:.1}", libm::exp2(24.0 - c.promised_bits)),
    };
    writeln!(
        out,
        "{name:<11}{made:<45}{bound:>11} {:>12.4}  {:<#10x}{:>11.4}{:>7.1}{:>10.3}%{:>10}{:>8}",
        c.worst_ulp,
        c.worst_at,
        c.mean_ulp,
        c.correct_bits,
        100.0 * c.rounded,
        answer(c.monotone),
        answer(c.powers_exact)
    )
}
