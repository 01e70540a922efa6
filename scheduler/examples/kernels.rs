//! Schedules the loops of divided programs and prints a table: initiation intervals beside their bounds, the length
//! of schedules beside the least, their contexts and moves, and the seconds of processor time that they took.
//!
//! `cargo run --release -p srp-scheduler --example kernels -- FEWEST MACHINE.xml FILE.dre.xml...`, where loops of fewer
//! operations are left out. `srp compile --emit dre` writes such files.

mod seconds;

use seconds::cpu_seconds;
use srp_archdesc::Unwatched;
use srp_ir::check::check_loop;
use srp_ir::dre;
use srp_scheduler::modulo;
use std::process::ExitCode;

/// Prints the table; true if every schedule is right.
fn run(args: &[String]) -> Result<bool, String> {
    let [fewest, machine, files @ ..] = args else {
        return Err("FEWEST MACHINE.xml FILE.dre.xml...".to_owned());
    };
    let fewest: usize = fewest.parse().map_err(|e| format!("{fewest}: {e}"))?;
    let text = |path: &str| std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"));
    let arch = srp_archdesc::parse(machine, &text(machine)?).map_err(|e| format!("{e:?}"))?;
    println!("loop                     nodes bound    II  least length   contexts moves  seconds");
    let mut right = true;
    for file in files {
        println!("{file}");
        let program = dre::read(&text(file)?).map_err(|e| format!("{file}:{e}"))?;
        for dfg in program.kernels.values() {
            let nodes = dfg.nodes.len();
            if nodes < fewest {
                continue;
            }
            let start = cpu_seconds();
            let options = modulo::Options::default();
            let scheduled = modulo::schedule(dfg, &arch.srp, &options, &Unwatched);
            let seconds = cpu_seconds() - start;
            let scheduled = scheduled.map_err(|why| format!("{}: {why}", dfg.name))?;
            let schedule = &scheduled.schedule;
            let moves = schedule.ops.values().filter(|op| op.is_move).count();
            println!(
                "{:24} {nodes:5} {:5} {:5} {:6} {:6} {:10} {moves:5} {seconds:8.2}",
                dfg.name,
                scheduled.bounds.min_ii(),
                schedule.ii,
                scheduled.least_length,
                schedule.length,
                schedule.contexts(),
            );
            let wrong = check_loop(schedule, &arch.srp);
            wrong.iter().for_each(|violation| println!("  {violation}"));
            right &= wrong.is_empty();
        }
    }
    Ok(right)
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match run(&args) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}
