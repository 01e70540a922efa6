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
    // Contexts are most of what the area differs by, and registers of the adder's pipeline the rest.
    let (contexts, adder) = (
        explained("array.contexts", "area"),
        explained("op[class=fadd].latency", "area"),
    );
    assert!(contexts > adder && adder > 0.0 && contexts + adder > 0.9);
    assert!(explained("array.contexts", "cycles") < 0.01);
    assert!(folder.join("sweep/report.html").exists());
}

#[test]
fn levels_of_simulation_are_compared() {
    let folder = folder("sweep_levels");
    let levels = "fidelity=functional,analytic,cycle";
    let args = [
        "sweep",
        "--set",
        levels,
        "--measure",
        "cycles",
        "--size",
        "8x6",
        "--json",
    ];
    let report = json(&folder, &args);
    let row = |level| with(&report, &[("fidelity", level)])[0].clone();
    let why = row("functional")["outcome"]["failed"].to_string();
    assert!(why.contains("has no cycles"), "{why}");
    let (estimate, cycles) = (
        figure(&row("analytic"), "cycles"),
        figure(&row("cycle"), "cycles"),
    );
    assert!(estimate > 0.0 && cycles > 0.0 && estimate != cycles);
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
            "--set",
            "effect:shadow=on,off",
            "--scene",
            "default",
            "--size",
            "16x12",
            "--measure",
            "cycles,energy,psnr",
            "--effort",
            "0.05",
            "--json",
            "-o",
            "out",
        ],
    );
    let near = &with(
        &report,
        &[
            ("effect:shadow", "on"),
            ("dram.latency-ns", "0"),
            ("special[function=rcp].bits", "exact"),
        ],
    )[0];
    let far = &with(
        &report,
        &[
            ("effect:shadow", "on"),
            ("dram.latency-ns", "400"),
            ("special[function=rcp].bits", "exact"),
        ],
    )[0];
    let coarse = &with(
        &report,
        &[
            ("effect:shadow", "off"),
            ("dram.latency-ns", "400"),
            ("special[function=rcp].bits", "8"),
        ],
    )[0];
    assert!(figure(near, "cycles") < figure(far, "cycles"));
    assert_eq!(figure(near, "psnr"), figure(far, "psnr"));
    assert!(figure(coarse, "psnr") < figure(far, "psnr"));
    let shadowless = &with(
        &report,
        &[
            ("effect:shadow", "off"),
            ("dram.latency-ns", "400"),
            ("special[function=rcp].bits", "exact"),
        ],
    )[0];
    assert!(figure(shadowless, "cycles") < figure(far, "cycles"));
    assert!(figure(shadowless, "psnr") < figure(far, "psnr"));
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
    write(&folder, "p.c", "int main(void) { return 0; }\n");
    let energy = [
        "sweep",
        "--program",
        "p.c",
        "--set",
        "array.rows=2,4",
        "--measure",
        "energy",
    ];
    misused(
        &folder,
        &energy,
        &["a program has no energy", "ii, cycles or area"],
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
    let rows = ["sweep", "--set", "array.rows=4"];
    let with = |more: &[&str], says: &str| misused(&folder, &[&rows, more].concat(), &[says]);
    with(&["--objective", "speed"], "cycles, cycles.half-interval");
    with(&["--objective", "area,max:area"], "an objective already");
    with(&["--sample", "search:8:9"], "search:N:P");
    with(
        &["--objective", "energy", "--fidelity", "sampled"],
        "has no energy",
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

/// A loop with operations enough for every size of a small array.
const WIDE_LOOP: &str = "float a[64], b[64];\n\
    int main(void) { for (int i = 0; i < 64; i++) { float x = b[i];\n\
    a[i] = x * x + (x + 1.0f) * (x - 2.0f) + (x * 3.0f - 5.0f) * (x + 7.0f); } return (int)a[5]; }\n";

/// Sizes of an array, by a tenth of the usual effort: 108 points, of which each takes some milliseconds. No unit of an array
/// of one column has floats, so that it cannot take the loop.
const SIZES: &[&str] = &[
    "sweep",
    "--machine",
    "tiny",
    "--set",
    "array.rows=1:6:1",
    "--set",
    "array.cols=1:6:1",
    "--set",
    "array.contexts=32,64,128",
    "--program",
    "loop.c",
    "--measure",
    "ii,area",
    "--effort",
    "0.1",
];

/// The figures of the points that are marked as the front, each once.
fn front(report: &Value, columns: [&str; 2]) -> Vec<[String; 2]> {
    let points = report["analyses"][0]["front"].as_array().expect("points");
    let rows = report["rows"].as_array().expect("rows").iter();
    let of_front = rows.filter(|row| points.contains(&row["point"]));
    let figures = of_front.map(|row| columns.map(|column| figure(row, column).to_string()));
    let mut figures: Vec<[String; 2]> = figures.collect();
    figures.sort();
    figures.dedup();
    figures
}

#[test]
fn a_search_finds_the_front_of_the_whole_grid() {
    let folder = folder("sweep_search");
    write(&folder, "loop.c", WIDE_LOOP);
    let grid = json(&folder, &[SIZES, &["-o", "grid", "--json"]].concat());
    let whole = front(&grid, ["ii", "area"]);
    assert!(whole.len() > 3, "{whole:?}");
    for seed in ["1", "2"] {
        // Rows of the grid are not measured again.
        let search = [
            "-o",
            "grid",
            "--sample",
            "search:60",
            "--seed",
            seed,
            "--json",
        ];
        let found = json(&folder, &[SIZES, &search].concat());
        assert_eq!(found["rows"].as_array().map(Vec::len), Some(60));
        assert_eq!(front(&found, ["ii", "area"]), whole, "seed {seed}");
        let invalid = found["rows"].as_array().into_iter().flatten();
        let invalid = invalid.filter(|row| row["outcome"]["figures"].is_null());
        let valid = found["search"]["generations"][7]["valid"].as_u64();
        assert_eq!(valid, Some(60 - invalid.count() as u64));
        let volumes = found["search"]["generations"]
            .as_array()
            .expect("a list")
            .iter();
        let volumes: Vec<f64> = volumes.filter_map(|g| g["hypervolume"].as_f64()).collect();
        assert!(
            volumes.is_sorted() && volumes[0] < volumes[7],
            "{volumes:?}"
        );
    }
    // Other objectives, another front: of a single one, its best points.
    let largest = [
        "--sample",
        "search:40",
        "--objective",
        "max:area.srp",
        "-o",
        "grid",
        "--json",
    ];
    let found = json(&folder, &[SIZES, &largest].concat());
    let best = &front(&found, ["area.srp", "area.srp"]);
    let rows = grid["rows"].as_array().expect("rows").iter();
    let areas = rows.filter(|row| !row["outcome"]["figures"].is_null());
    let most = areas.map(|row| figure(row, "area.srp")).fold(0.0, f64::max);
    assert_eq!(best[..], [[most.to_string(), most.to_string()]]);
    let generations = found["search"]["generations"].as_array().expect("a list");
    assert_eq!(generations.last().expect("one")["best"][0], most);
    let report = srp(&folder, &["sweep", "report", "grid"]);
    let said = String::from_utf8_lossy(&report.stdout);
    assert!(
        said.contains("search for largest area.srp: 40 points, 7 a generation"),
        "{said}"
    );
}

#[test]
fn a_search_is_the_same_however_it_is_run() {
    let folder = folder("sweep_search_again");
    write(&folder, "loop.c", WIDE_LOOP);
    let search = [SIZES, &["--sample", "search:36:12", "--seed", "5"]].concat();
    let run = |args: &[&str]| {
        let output = srp(&folder, &[&search, args].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{args:?}: {said}");
        said
    };
    let table = |name: &str| {
        std::fs::read_to_string(folder.join(name).join("results.csv")).expect("a table")
    };
    run(&["-o", "whole", "--threads", "1"]);
    assert_eq!(table("whole").lines().count(), 37);
    run(&["-o", "threads", "--threads", "2"]);
    assert_eq!(table("threads"), table("whole"));
    // The engine starts three shards for each generation.
    run(&["-o", "engine", "--engine", "{}", "--jobs", "3"]);
    assert_eq!(table("engine"), table("whole"));
    // A kill in the middle: the same command goes on.
    let rows = || {
        let files = std::fs::read_dir(folder.join("killed/rows"))
            .into_iter()
            .flatten();
        let texts = files
            .flatten()
            .filter_map(|f| std::fs::read_to_string(f.path()).ok());
        texts.map(|text| text.lines().count()).sum::<usize>()
    };
    let mut victim = std::process::Command::new(env!("CARGO_BIN_EXE_srp"))
        .current_dir(&folder)
        .args(&search)
        .args(["-o", "killed", "--threads", "1"])
        .env("SRP_CACHE", folder.join("another-cache"))
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the command can be started");
    while rows() < 15 && victim.try_wait().is_ok_and(|ended| ended.is_none()) {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    victim.kill().expect("it is ours");
    victim.wait().expect("it is ours");
    assert!(
        !folder.join("killed/results.csv").exists(),
        "it was killed too late"
    );
    let said = run(&["-o", "killed"]);
    assert!(said.contains("known from an earlier run"), "{said}");
    assert_eq!(table("killed"), table("whole"));
    // A shard goes as far as the rows of the others let it: first half of a generation, then all of it and half of the next.
    for known in ["18 of 36 rows known so far", ""] {
        run(&["-o", "shards", "--shard", "0/2"]);
        run(&["-o", "shards", "--shard", "1/2"]);
        let report = srp(&folder, &["sweep", "report", "shards"]);
        let report = String::from_utf8_lossy(&report.stdout).into_owned();
        assert!(report.contains(known), "{report}");
        assert_eq!(report.contains("so far\n"), !known.is_empty(), "{report}");
    }
    run(&["-o", "shards"]);
    assert_eq!(table("shards"), table("whole"));
}

/// Reads a table by a reader of others; prints rows as JSON.
const READER: &str = "import json, sys, pyarrow.parquet as parquet\n\
    table = parquet.read_table(sys.argv[1])\n\
    print(json.dumps({'types': {f.name: str(f.type) for f in table.schema}, 'rows': table.to_pylist()}))";

#[test]
fn others_read_the_columns_of_a_sweep() {
    let folder = folder("sweep_columns");
    write(&folder, "loop.c", WIDE_LOOP);
    let report = json(
        &folder,
        &[SIZES, &["--sample", "search:12:6", "--json"]].concat(),
    );
    let file = std::fs::read(folder.join("sweep/results.parquet")).expect("a table");
    assert!(file.starts_with(b"PAR1") && file.ends_with(b"PAR1"));
    let read = std::process::Command::new("python3")
        .current_dir(&folder)
        .args(["-c", READER, "sweep/results.parquet"])
        .output();
    let Some(read) = read.ok().filter(|read| read.status.success()) else {
        println!("skipped: there is no pyarrow for python3");
        return;
    };
    let table: Value = serde_json::from_slice(&read.stdout).expect("JSON");
    for (column, kind) in [
        ("point", "int64"),
        ("array.rows", "int64"),
        ("area", "double"),
        ("seconds", "double"),
        ("machine_hash", "string"),
    ] {
        assert_eq!(table["types"][column], kind, "{column}");
    }
    let rows = report["rows"].as_array().expect("rows");
    let read = table["rows"].as_array().expect("rows");
    assert_eq!((rows.len(), read.len()), (12, 12));
    for (row, read) in rows.iter().zip(read) {
        let same = [
            "point",
            "subject",
            "subject_hash",
            "build",
            "host",
            "seconds",
            "key",
        ];
        for column in same {
            assert_eq!(read[column], row[column], "{column} of {row}");
        }
        let rows_set = row["settings"]["array.rows"].as_str();
        assert_eq!(rows_set, Some(read["array.rows"].to_string().as_str()));
        for column in ["ii", "area", "area.srp"] {
            assert_eq!(read[column], row["outcome"]["figures"][column]);
        }
        let generation = row["point"].as_u64().map(|point| point / 6);
        assert_eq!(read["generation"].as_u64(), generation);
        let is_valid = read["outcome"] == "figures";
        assert_eq!(is_valid, read["error"].is_null());
        assert_eq!(is_valid, !read["machine_hash"].is_null());
    }
    assert!(read.iter().any(|row| row["outcome"] == "invalid"));
}
