//! Certificates that a smaller II is impossible.

use crate::Error;
use srp_archdesc::arch::Srp;
use srp_archdesc::watch::Stage;
use srp_ir::dfg::Dfg;
use srp_scheduler::modulo::{self, Impossible};
use srp_toolchain::Session;

/// A certificate that a loop has no schedule with an II, within a horizon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Certificate {
    /// The formula, as DIMACS CNF.
    pub formula: Vec<u8>,
    /// The proof that it cannot be satisfied, as DRAT.
    pub steps: Vec<u8>,
}

/// The claim that the II one below a loop's is impossible, if that was proved.
pub fn claim(ii: u32, impossible: &[Impossible]) -> Option<Impossible> {
    impossible.iter().find(|proof| proof.ii + 1 == ii).copied()
}

/// Proves a claim again, and keeps the proof.
///
/// # Errors
///
/// The watch ended the work.
pub fn certify(
    dfg: &Dfg,
    srp: &Srp,
    claim: Impossible,
    session: &Session<'_>,
) -> Result<Certificate, Error> {
    let _stage = Stage::unknown(session.watch, "proving");
    let (mut formula, mut steps) = (Vec::new(), Vec::new());
    let certificate = modulo::Certificate {
        formula: &mut formula,
        steps: &mut steps,
    };
    match modulo::certify(dfg, srp, claim, session.watch, certificate) {
        true => Ok(Certificate { formula, steps }),
        false => Err(srp_toolchain::Error::Cancelled.into()),
    }
}
