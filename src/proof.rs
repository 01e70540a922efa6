//! Certificates that a smaller II is impossible, and what reports say of proofs and of the searches for them.

use crate::count::count;
use crate::failure::Failure;
use crate::files;
use crate::talk;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::{Dfg, Node};
use srp_scheduler::modulo::Impossible;
use srp_studies::certificate::{certify, claim};
use srp_studies::proofs::{Impossible as Proof, Search, reach};
use srp_toolchain::Session;
use std::path::{Path, PathBuf};

/// A loop, its II, and what was proved about smaller ones.
pub(crate) struct Proved<'a> {
    pub(crate) dfg: &'a Dfg,
    /// The names of its nodes in the file of a graph.
    pub(crate) names: Option<&'a EntityMap<Node, String>>,
    pub(crate) ii: u32,
    pub(crate) impossible: &'a [Impossible],
}

/// The file of the formula that belongs to a proof.
pub(crate) fn formula_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".cnf");
    name.into()
}

/// Fails now if [`write()`] to this path would fail later.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    files::check_writable(&formula_path(path))?;
    files::check_writable(path)
}

/// Writes the certificate that the II one below the loop's is impossible: the proof to `path`, as
/// DRAT, and its formula beside it, as DIMACS CNF. `loops` must hold one such loop.
pub(crate) fn write(
    path: &Path,
    loops: &[Proved<'_>],
    arch: &Arch,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let mut proved = (loops.iter()).filter_map(|l| Some((l, claim(l.ii, l.impossible)?)));
    let Some((proved_loop, claim)) = proved.next() else {
        let why = "no proof to write: of no loop was the II below proved impossible; \
                   one that reaches its bound needs none, others may need more time";
        return Err(Failure::message(why));
    };
    let dfg = proved_loop.dfg;
    let more: Vec<&str> = proved.map(|(other, _)| other.dfg.name.as_str()).collect();
    if !more.is_empty() {
        return Err(Failure::Message(format!(
            "one proof at a time: choose {} or {} (a kernel with --kernel, a graph by its file)",
            dfg.name,
            more.join(" or ")
        )));
    }
    let certificate = certify(dfg, proved_loop.names, arch, claim, session)?;
    files::write(&formula_path(path), &certificate.formula)?;
    files::write(path, &certificate.steps)?;
    talk::say(format_args!(
        "{}: of {}, {}",
        path.display(),
        dfg.name,
        Proof::of(&claim).in_words()
    ));
    Ok(())
}

/// A sentence that says how much was asked, and why it ended; none where nothing was asked.
pub(crate) fn searched(search: &Search) -> Option<String> {
    let (first, last) = (search.asked.first()?.ii, search.asked.last()?.ii);
    let iis = match first == last {
        true => format!("II = {first}"),
        false => format!("II = {first} to {last}"),
    };
    let steps: u64 = search.asked.iter().map(|asked| asked.steps).sum();
    let (questions, steps) = (
        count(search.asked.len() as u32, "formula"),
        count(steps, "step"),
    );
    let why = match search.stopped.as_str() {
        "at-bound" => "the II is the bound",
        "impossible" => "every lower II is impossible",
        "nothing-left" => "all questions were asked",
        "time" => "its time was used up",
        _ => "its steps were used up",
    };
    Some(format!(
        "the exact search tried {iis} by {questions} in {steps} (--json lists them), and ended: {why}"
    ))
}

/// Proofs in words, one sentence for those of IIs in a row by the same formula: `II = 2 to 4 are impossible, by formulas
/// (folded, laps 1, depth 2)`.
pub(crate) fn proved(proofs: &[Proof]) -> Vec<String> {
    let alike =
        |a: &Proof, b: &Proof| a.ii + 1 == b.ii && (a.slack, &a.formula) == (b.slack, &b.formula);
    let sentence = |group: &[Proof]| {
        let (first, last) = (&group[0], &group[group.len() - 1]);
        let (ii, formula) = (last.ii, &last.formula);
        match group.len() {
            1 => format!("{}, by a formula ({formula})", first.in_words()),
            _ => format!(
                "II = {} to {ii} are {}, by formulas ({formula})",
                first.ii,
                reach(first.slack)
            ),
        }
    };
    proofs.chunk_by(alike).map(sentence).collect()
}
