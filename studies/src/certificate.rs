//! Certificates that a smaller II is impossible.

use crate::Error;
use crate::proofs::{self, Impossible};
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::watch::Stage;
use srp_archdesc::xml;
use srp_ir::dfg::{Dfg, Node};
use srp_scheduler::modulo;
use srp_toolchain::Session;

/// A certificate that a loop has no schedule with an II.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Certificate {
    /// The formula, as DIMACS CNF. Comments say of what it speaks, and what each variable stands for.
    pub formula: Vec<u8>,
    /// The proof that it cannot be satisfied, as DRAT.
    pub steps: Vec<u8>,
}

/// The claim that the II one below a loop's is impossible, if that was proved.
pub fn claim(ii: u32, impossible: &[modulo::Impossible]) -> Option<modulo::Impossible> {
    impossible.iter().find(|proof| proof.ii + 1 == ii).copied()
}

/// Proves a claim again, and keeps the proof. Nodes may have names in the graph's file.
///
/// # Errors
///
/// The watch ended the work.
pub fn certify(
    dfg: &Dfg,
    names: Option<&EntityMap<Node, String>>,
    arch: &Arch,
    claim: modulo::Impossible,
    session: &Session<'_>,
) -> Result<Certificate, Error> {
    let _stage = Stage::unknown(session.watch, "proving");
    let mut formula = header(dfg, names, arch, claim).into_bytes();
    let mut steps = Vec::new();
    let certificate = modulo::Certificate {
        formula: &mut formula,
        steps: &mut steps,
    };
    match modulo::certify(dfg, &arch.srp, claim, session.watch, certificate) {
        true => Ok(Certificate { formula, steps }),
        false => Err(srp_toolchain::Error::Cancelled.into()),
    }
}

/// The comments that say what the formula is about, one `c WORD: …` a line, and then the nodes.
fn header(
    dfg: &Dfg,
    names: Option<&EntityMap<Node, String>>,
    arch: &Arch,
    claim: modulo::Impossible,
) -> String {
    // A comment is one line of printable words.
    let line = |text: &str| text.replace(|c: char| c.is_control(), " ");
    let machine = blake3::hash(xml::write(arch).as_bytes()).to_hex();
    let mut header = format!(
        "c graph: {}\nc machine: {}\nc machine-blake3: {machine}\nc ii: {}\nc formula: {}\nc claim: {}\n\
         c meaning: docs/proofs.md\n",
        line(&dfg.name),
        line(&arch.name),
        claim.ii,
        proofs::formula(claim.scope),
        Impossible::of(&claim).in_words(),
    );
    for (node, data) in dfg.nodes.iter() {
        let name = names.map_or(String::new(), |names| format!(" {}", line(&names[node])));
        header += &format!("c node: {node} {}{name}\n", data.op);
    }
    header
}
