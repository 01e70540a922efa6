//! `srp units`: a certificate of every special function of a machine, over all mantissas.

use crate::cli;
use crate::failure::Failure;
use crate::interrupt;
use crate::talk::{self, Progress};
use serde::Serialize;
use srp_archdesc::arch::Approx;
use srp_archdesc::certify::{Certificate, Function, certify};
use srp_toolchain::machine;
use std::fmt::Write as _;

/// The certificates of a machine.
#[derive(Serialize)]
struct Report {
    machine: String,
    /// Special functions of the SRP, with the steps that the program takes.
    srp: Vec<Certificate>,
    /// The reciprocal of the T&I unit.
    tni: Certificate,
}

/// Runs `srp units`.
pub(crate) fn run(args: &cli::Units) -> Result<(), Failure> {
    let arch = machine::read(&args.file)?;
    let progress = Progress::steps("trying every mantissa", Function::ALL.len() as u64 + 1);
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
    let report = Report {
        machine: arch.name.clone(),
        srp: srp?,
        tni: tried(Function::ALL.len(), Function::Rcp, arch.system.tni.rcp)?,
    };
    drop(progress);
    if args.json {
        let json = serde_json::to_string_pretty(&report).map_err(Failure::message)?;
        return Ok(talk::print(json + "\n")?);
    }
    let mut out = String::new();
    text(&mut out, &report).expect("writing to a String does not fail");
    Ok(talk::print(out)?)
}

fn text(out: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(out, "units of `{}` over all mantissas", report.machine)?;
    writeln!(
        out,
        "{:<10}{:<30}{:>13}  {:<10}{:>11}{:>7}{:>11}{:>10}{:>8}",
        "", "", "largest ulp", "at", "mean ulp", "bits", "rounded", "monotone", "2^k"
    )?;
    for certificate in &report.srp {
        line(out, certificate.function.name(), certificate)?;
    }
    line(out, "T&I rcp", &report.tni)?;
    writeln!(
        out,
        "bits: of log2, sin and cos absolute; 2^k: powers of two have exact results"
    )
}

fn line(out: &mut String, name: &str, c: &Certificate) -> std::fmt::Result {
    let made = match c.table_bits {
        None => "exact".to_owned(),
        Some(bits) if c.steps == 0 => format!("table of {bits} bits"),
        Some(bits) => {
            let fused = if c.fused { "" } else { " not fused" };
            let plural = if c.steps == 1 { "" } else { "s" };
            format!("{bits} bits + {} step{plural}{fused}", c.steps)
        }
    };
    let answer = |answer: Option<bool>| match answer {
        None => "–",
        Some(true) => "yes",
        Some(false) => "no",
    };
    writeln!(
        out,
        "{name:<10}{made:<30}{:>13.4}  {:<#10x}{:>11.4}{:>7.1}{:>10.3}%{:>10}{:>8}",
        c.worst_ulp,
        c.worst_at,
        c.mean_ulp,
        c.correct_bits,
        100.0 * c.rounded,
        answer(c.monotone),
        answer(c.powers_exact)
    )
}
