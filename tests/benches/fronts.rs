//! The fronts of a search beside those of a grid: `cargo build --release && cargo bench -p srp-tests --bench fronts` simulates
//! all combinations of a few knobs of the default frame in full, searches the same settings, and prints the time of
//! both, and how far the search's fronts stay behind the grid's.
//!
//! A point of the grid is reached within a part *p* where the search has one whose error (root of the mean squared
//! difference from binary64) and cost are at most 1 + *p* times its own. Each row has the largest *p* of an axis.
//! `SRP_FRONTS_SIZE=160x120` takes frames of another size. `SRP` is another build of the command.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

const KNOBS: [&str; 3] = ["slab reciprocal", "reciprocal square root", "exp2 and log2"];

const AXES: [&str; 3] = ["frame_cycles", "area", "energy"];

/// The target that both have.
const TARGET: f64 = 45.0;

/// A report, and the seconds that it took.
fn study(folder: &Path, name: &str, size: &str, grid: bool) -> (Value, f64) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let built = root.join("target/release/srp");
    let mut command = Command::new(std::env::var_os("SRP").map_or(built, PathBuf::from));
    command
        .current_dir(folder)
        .env("SRP_CACHE", folder.join(name).join("cache"));
    command.args(["accuracy", "--size", size, "--json", "-o", name]);
    command.args(["--target", &format!("psnr={TARGET},leaks=0")]);
    command.args(KNOBS.iter().flat_map(|knob| ["--knob", knob]));
    command.args(match grid {
        true => &["--grid"][..],
        false => &["--trials", "36"],
    });
    let start = Instant::now();
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.expect("build the command with `cargo build --release`");
    let seconds = start.elapsed().as_secs_f64();
    assert!(output.status.success(), "the {name} failed");
    let report = serde_json::from_slice(&output.stdout).expect("a report");
    (report, seconds)
}

/// Error and cost of the trials that keep to the target.
fn points(report: &Value, axis: &str) -> Vec<(f64, f64)> {
    let trials = report["trials"].as_array().expect("trials");
    let point = |trial: &Value| {
        let psnr = trial["all"]["psnr"].as_f64().unwrap_or(f64::INFINITY);
        let keeps =
            psnr >= TARGET && trial["leaks"]["leaks"] == 0 && trial["not_exercised"] == false;
        let cost = trial["costs"][axis].as_f64().expect("a cost");
        keeps.then(|| (10f64.powf(-psnr / 20.0), cost))
    };
    trials.iter().filter_map(point).collect()
}

fn main() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fronts");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("the target folder can be written");
    let size = std::env::var("SRP_FRONTS_SIZE").unwrap_or_else(|_| "320x240".to_owned());
    let (search, searched) = study(&folder, "search", &size, false);
    let (grid, simulated) = study(&folder, "grid", &size, true);
    let count = |report: &Value| report["trials"].as_array().map_or(0, Vec::len);
    println!("| {size} | trials | seconds |");
    println!("| grid | {} | {simulated:.0} |", count(&grid));
    println!("| search | {} | {searched:.0} |", count(&search));
    println!("| axis | the search stays behind by at most |");
    for axis in AXES {
        let found = points(&search, axis);
        let behind = |&(error, cost): &(f64, f64)| {
            let each = found.iter().map(|(e, c)| (e / error).max(c / cost) - 1.0);
            each.fold(f64::INFINITY, f64::min).max(0.0)
        };
        let most = points(&grid, axis).iter().map(behind).fold(0.0, f64::max);
        println!("| {axis} | {:.2} % |", 100.0 * most);
    }
}
