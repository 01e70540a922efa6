//! Asks questions of the exact way on a 4x4 mesh by each SAT solver, and prints the answers and the seconds of
//! processor time.
//!
//! `cargo run --release -p srp-scheduler --features cadical --example solvers -- QUESTION...`, where a question is
//! `GRAPH:II:SLACK` for a timed formula or `GRAPH:II:LAPS:DEPTH` for a folded one, and `GRAPH.edges` and `GRAPH.ops`
//! are files.

mod seconds;

use seconds::cpu_seconds;
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::isa::Class;
use srp_archdesc::xml::{StandardArray, standard};
use srp_ir::graph::{Options, read_edges};
use srp_scheduler::modulo::{self, Fold, Scope, Solver};
use std::process::ExitCode;

fn ask(question: &str, arch: &Arch) -> Result<(), String> {
    let (name, numbers) = question.split_once(':').ok_or("GRAPH:II:SLACK")?;
    let numbers = numbers.split(':').map(|n| n.parse::<u32>());
    let numbers: Result<Vec<u32>, _> = numbers.collect();
    let (ii, scope) = match numbers.map_err(|e| format!("{question}: {e}"))?[..] {
        [ii, slack] => (ii, Scope::Timed { slack }),
        [ii, laps, depth] => (ii, Scope::Folded(Fold { laps, depth })),
        _ => return Err(format!("{question}: GRAPH:II:SLACK or GRAPH:II:LAPS:DEPTH")),
    };
    let source = |ending: &str| {
        let path = format!("{name}.{ending}");
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{path}: {e}"))?;
        Ok::<_, String>(Source::new(path, text))
    };
    let options = Options {
        any_op: Some(Class::Alu),
    };
    let graph = read_edges(&source("edges")?, &source("ops")?, &options);
    let graph = graph.map_err(|e| format!("{name}: {e:?}"))?;
    let solvers = [
        Solver::Batsat,
        #[cfg(feature = "cadical")]
        Solver::Cadical,
    ];
    for solver in solvers {
        let start = cpu_seconds();
        let outcome = modulo::ask(&graph.dfg, &arch.srp, (ii, scope), solver, &Unwatched);
        let outcome = outcome.map_err(|e| e.to_string())?;
        let (short, seconds) = (
            question.rsplit('/').next().unwrap_or(""),
            cpu_seconds() - start,
        );
        println!("{short:32} {solver:?} {seconds:8.2} s  {outcome:?}");
    }
    Ok(())
}

fn main() -> ExitCode {
    let mesh = standard(&StandardArray::mesh(4, 4)).expect("a mesh there is");
    let arch = srp_archdesc::parse("mesh.xml", &mesh).expect("it is a machine");
    for question in std::env::args().skip(1) {
        if let Err(why) = ask(&question, &arch) {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
