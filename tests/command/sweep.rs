//! `srp sweep`: what is varied moves what is measured, a sweep goes on where it was, and its rows can be had again.

use super::{folder, misused, refused, srp, write};
use serde_json::Value;
use std::path::Path;

const PROGRAM: &str = "#include <stdio.h>\nfloat a[64], b[64];\n\
    int main(void) { float s = 0; for (int i = 0; i < 64; i++) { b[i] = i + 0.5f; a[i] = 1 / b[i] + b[i]; }\n\
    for (int i = 0; i < 64; i++) s += a[i]; printf(\"%f\\n\", s); return 0; }\n";

fn json(folder: &Path, args: &[&str]) -> Value {
    let output = srp(folder, args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "srp {args:?}: {said}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn figure(row: &Value, column: &str) -> f64 {
    row["outcome"]["figures"][column]
        .as_f64()
        .unwrap_or_else(|| panic!("{column} of {row}"))
}

/// The rows with these settings.
fn with<'a>(report: &'a Value, settings: &[(&str, &str)]) -> Vec<&'a Value> {
    let rows = report["rows"].as_array().expect("rows").iter();
    rows.filter(|row| {
        settings
            .iter()
            .all(|(name, value)| row["settings"][name] == *value)
    })
    .collect()
}

#[test]
fn what_is_varied_moves_what_is_measured() {
    let folder = folder("sweep");
    write(&folder, "program.c", PROGRAM);
    let report = json(
        &folder,
        &[
            "sweep",
            "--set",
            "op[class=fadd].latency=2,9",
            "--set",
            "array.contexts=32,128",
            "--program",
            "program.c",
            "--measure",
            "ii,cycles,area",
            "--json",
        ],
    );
    assert_eq!(report["planned"], 4);
    let slow = with(&report, &[("op[class=fadd].latency", "9")]);
    let fast = with(&report, &[("op[class=fadd].latency", "2")]);
    assert_eq!((slow.len(), fast.len()), (2, 2));
    for (slow, fast) in slow.iter().zip(&fast) {
        // The sum is a chain of additions.
        assert!(figure(slow, "ii") > figure(fast, "ii"));
        assert!(figure(slow, "cycles") > figure(fast, "cycles"));
        assert_ne!(slow["machine_hash"], fast["machine_hash"]);
    }
    for latency in ["2", "9"] {
        let of = |contexts| {
            with(
                &report,
                &[
                    ("op[class=fadd].latency", latency),
                    ("array.contexts", contexts),
                ],
            )[0]
        };
        assert!(figure(of("32"), "area") < figure(of("128"), "area"));
    }
    // Sensitivities say the same.
    let sensitivities = report["analyses"][0]["sensitivities"]
        .as_array()
        .expect("a list");
    let explained = |parameter: &str, objective: &str| {
        let mut all = sensitivities.iter();
        let found = all.find(|s| s["parameter"] == parameter && s["objective"] == objective);
        found.and_then(|s| s["explained"].as_f64()).expect("a part")
    };
    assert!(explained("op[class=fadd].latency", "cycles") > 0.99);
    assert!(explained("array.contexts", "area") > 0.9);
    assert!(explained("array.contexts", "cycles") < 0.01);
    assert!(folder.join("sweep/report.html").exists());
}

#[test]
fn a_point_is_what_render_makes_of_its_machine() {
    let folder = folder("sweep_show");
    let report = json(
        &folder,
        &[
            "sweep",
            "--set",
            "dram.latency-ns=0,400",
            "--set",
            "special[function=rcp].bits=8,exact",
            "--scene",
            "default",
            "--size",
            "16x12",
            "--measure",
            "cycles,energy,psnr",
            "--json",
            "-o",
            "out",
        ],
    );
    let near = &with(
        &report,
        &[
            ("dram.latency-ns", "0"),
            ("special[function=rcp].bits", "exact"),
        ],
    )[0];
    let far = &with(
        &report,
        &[
            ("dram.latency-ns", "400"),
            ("special[function=rcp].bits", "exact"),
        ],
    )[0];
    let coarse = &with(
        &report,
        &[
            ("dram.latency-ns", "400"),
            ("special[function=rcp].bits", "8"),
        ],
    )[0];
    assert!(figure(near, "cycles") < figure(far, "cycles"));
    assert_eq!(figure(near, "psnr"), figure(far, "psnr"));
    assert!(figure(coarse, "psnr") < figure(far, "psnr"));
    let point = coarse["point"].to_string();
    let shown = srp(&folder, &["sweep", "show", "out", &point, "-o", "mine.xml"]);
    let command = String::from_utf8_lossy(&shown.stderr).into_owned();
    assert!(
        command.contains("--machine mine.xml --size 16x12"),
        "{command}"
    );
    let mut args: Vec<&str> = command.split_whitespace().skip(1).collect();
    args.push("--json");
    let account = json(&folder, &args);
    assert_eq!(account["cycles"].as_f64(), Some(figure(coarse, "cycles")));
    assert_eq!(
        account["energy"]["total_mj"].as_f64(),
        Some(figure(coarse, "energy"))
    );
}

#[test]
fn shards_threads_and_stops_change_nothing() {
    let folder = folder("sweep_shards");
    write(&folder, "program.c", PROGRAM);
    let plan = "programs = [\"program.c\"]\nmeasure = [\"cycles\", \"area\"]\nsample = \"lhs:6\"\nseed = 3\n\
                [set]\n\"op[class=fadd].latency\" = \"1..8\"\n\"array.rows\" = [3, 4]\n";
    write(&folder, "plan.toml", plan);
    let whole = srp(
        &folder,
        &["sweep", "plan.toml", "-o", "whole", "--threads", "1"],
    );
    assert_eq!(whole.status.code(), Some(0));
    for shard in ["1/2", "0/2"] {
        let part = srp(
            &folder,
            &["sweep", "plan.toml", "-o", "parts", "--shard", shard],
        );
        assert_eq!(part.status.code(), Some(0));
        // A kill may leave half a line.
        let rows = std::fs::read_dir(folder.join("parts/rows")).expect("rows");
        for file in rows.flatten() {
            let mut text = std::fs::read(file.path()).expect("a file");
            text.extend(b"{\"key\":\"half a l");
            std::fs::write(file.path(), text).expect("it can be written");
        }
    }
    let again = srp(&folder, &["sweep", "plan.toml", "-o", "parts"]);
    let said = String::from_utf8_lossy(&again.stderr);
    assert!(said.contains("6 rows known from an earlier run"), "{said}");
    let engine = [
        "sweep",
        "plan.toml",
        "-o",
        "engine",
        "--engine",
        "{}",
        "--jobs",
        "4",
    ];
    let jobs = srp(&folder, &engine);
    let said = String::from_utf8_lossy(&jobs.stderr);
    assert_eq!(jobs.status.code(), Some(0), "{said}");
    let table = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a table");
    assert_eq!(table("whole/results.csv"), table("engine/results.csv"));
    assert_eq!(table("whole/results.csv"), table("parts/results.csv"));
    assert_eq!(table("whole/results.csv").lines().count(), 7);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = folder("sweep_wrong");
    misused(&folder, &["sweep"], &["nothing is varied"]);
    misused(
        &folder,
        &["sweep", "--set", "array.rows"],
        &["PARAMETER=VALUES"],
    );
    misused(
        &folder,
        &["sweep", "--set", "array.rows=2", "--shard", "2/2"],
        &["N/M"],
    );
    misused(
        &folder,
        &["sweep", "--set", "array.rows=4", "--build", "0123"],
        &["another build of srp"],
    );
    misused(
        &folder,
        &["sweep", "--set", "aray.rows=4,5"],
        &["did you mean `array`?"],
    );
    misused(
        &folder,
        &["sweep", "--set", "array.row=4,5"],
        &["no value of it makes a machine", "row"],
    );
    misused(
        &folder,
        &["sweep", "--set", "op.latency=1"],
        &["[class=alu]"],
    );
    misused(&folder, &["sweep", "--set", "rows=1"], &["sets nothing"]);
    misused(
        &folder,
        &["sweep", "--set", "array.rows=1..4"],
        &["a grid needs values"],
    );
    misused(
        &folder,
        &["sweep", "--set", "array.rows=4", "--measure", "speed"],
        &["ii, cycles, energy"],
    );
    misused(
        &folder,
        &[
            "sweep",
            "--set",
            "array.rows=4",
            "--measure",
            "energy",
            "--fidelity",
            "sampled",
        ],
        &["has no energy"],
    );
    refused(
        &folder,
        &["sweep", "report", "nowhere"],
        &["folder of a sweep"],
    );
    write(&folder, "plan.toml", "meassure = [\"ii\"]\n");
    refused(
        &folder,
        &["sweep", "plan.toml"],
        &["plan.toml:1:1", "meassure"],
    );
}
