//! `srp accuracy`: knobs really turn, trials are kept, and what is at fault is refused.

use super::{ended, folder, misused, refused, srp, write};
use serde_json::Value;
use std::path::Path;

/// A floor and a wall that share an edge, none of them along an axis, where distances are exact.
const SCENE: &str = "v -2 0 2\nv 2 0.3 2\nv 2 0.9 -2\nv -2 0.5 -2\nv 2 3 -2.5\nv -2 3 -2.2\n\
                     f 1 2 3 4\nf 4 3 5 6\n";

const ARGS: &[&str] = &[
    "accuracy",
    "scene.obj",
    "--camera",
    "0,2,5/0,-0.2,-1/50",
    "--size",
    "32x24",
    "--knob",
    "T&I reciprocal",
    "--knob",
    "intersection",
    "--target",
    "psnr=40",
    "--json",
];

fn report(folder: &Path) -> (Value, Vec<u8>) {
    let output = srp(folder, ARGS);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let value = serde_json::from_slice(&output.stdout).expect("JSON");
    (value, output.stdout)
}

#[test]
fn knobs_turn_and_trials_are_kept() {
    let folder = folder("accuracy");
    write(&folder, "scene.obj", SCENE);
    let (report, text) = report_twice(&folder);
    let trials = report["trials"].as_array().expect("trials");
    let trial = |knob: &str, value: &str| {
        let found = (trials.iter()).find(|t| t["knob"] == knob && t["value"] == value);
        found.unwrap_or_else(|| panic!("no {knob} {value} in {text}"))
    };
    let number = |v: &Value| v.as_f64().expect("a number");
    let base = trial("", "as it is");
    assert!(number(&base["costs"]["frame_cycles"]) > 0.0);
    assert_eq!(base["leaks"]["leaks"], 0);
    assert!(number(&base["leaks"]["aimed"]) > 0.0);
    // Eight bits are no twenty-four: distances are off, and the unit is smaller.
    let coarse = trial("T&I reciprocal", "8 bits");
    assert!(number(&coarse["leaks"]["ulp_99"]) > 100.0 * number(&base["leaks"]["ulp_99"]).max(1.0));
    assert!(number(&coarse["costs"]["area"]) < number(&base["costs"]["area"]));
    let woop = trial("intersection", "woop");
    assert!(number(&woop["costs"]["area"]) > number(&base["costs"]["area"]));
    // The noise is known, prices are told, and settings are combined until none is left.
    assert!(number(&report["cycle_noise"]) < 0.5);
    assert_eq!(
        base["cycles_in_other_orders"].as_array().map(Vec::len),
        Some(4)
    );
    assert!(!report["prices"].as_array().expect("prices").is_empty());
    assert_eq!(report["closed"], true);
    let together = trials.iter().filter(|t| t["knob"] == "together");
    assert!(together.count() > 0, "{text}");
    let page = std::fs::read_to_string(folder.join("accuracy/report.html")).expect("the page");
    assert!(page.contains("T&amp;I reciprocal: 8 bits") && !page.contains("http"));
    for (trial, name) in [
        (base, "-as-it-is"),
        (coarse, "T-I-reciprocal-8-bits"),
        (woop, "intersection-woop"),
    ] {
        renders_again(&folder, trial, name);
    }
}

/// Renders a trial from the machine that was kept: the same picture, cycles and PSNR.
fn renders_again(folder: &Path, trial: &Value, name: &str) {
    let machine = format!("accuracy/trials/{name}.xml");
    let args = [
        "render",
        "scene.obj",
        "--camera",
        "0,2,5/0,-0.2,-1/50",
        "--size",
        "32x24",
        "--engine",
        "interp",
        "--machine",
        &machine,
        "-o",
        "again.png",
        "--json",
    ];
    let output = srp(folder, &args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{name}: {said}");
    let read =
        |path: &str| std::fs::read(folder.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    let again = read("again.png");
    assert!(
        again == read(&format!("accuracy/trials/{name}.png")),
        "{name}"
    );
    let account: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(account["cycles"], trial["costs"]["frame_cycles"], "{name}");
    let pixels = |bytes: &[u8]| image::load_from_memory(bytes).expect("a picture").to_rgb8();
    let (found, reference) = (pixels(&again), pixels(&read("accuracy/reference.png")));
    let pairs = found.as_raw().iter().zip(reference.as_raw());
    let squares = pairs.map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
    let mean = squares.sum::<f64>() / found.as_raw().len() as f64;
    let psnr = 10.0 * (255.0 * 255.0 / mean).log10();
    let told = trial["all"]["psnr"].as_f64().expect("some byte differs");
    assert!((psnr - told).abs() < 1e-9, "{name}: {psnr} {told}");
    // The raw floats, the lowest row first, round to the same bytes.
    let raw = read("accuracy/reference.pfm");
    let head = b"PF\n32 24\n-1.0\n";
    assert!(raw.starts_with(head));
    let floats: Vec<f32> = (raw[head.len()..].chunks_exact(4))
        .map(|b| f32::from_le_bytes(b.try_into().expect("four bytes")))
        .collect();
    for (row, floats) in floats.chunks(3 * 32).rev().enumerate() {
        let bytes = &reference.as_raw()[row * 96..][..96];
        let near = |(&f, &b): (&f32, &u8)| (f - f32::from(b)).abs() <= 0.5001;
        assert!(floats.iter().zip(bytes).all(near), "row {row}");
    }
}

/// A knob of a unit that the scene does not use.
const UNUSED: [&str; 2] = ["--knob", "sine and cosine"];

/// The study of a small frame of `scene.obj`.
fn of_small_frame(folder: &Path, more: &[&str]) -> Value {
    let frame = [
        "accuracy",
        "scene.obj",
        "--camera",
        "0,2,5/0,-0.2,-1/50",
        "--size",
        "16x8",
        "--json",
    ];
    let output = ended(folder, &[&frame[..], more].concat(), 0);
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// A formula of a kernel that is not the renderer's is no rounding: the report says so, and the pixel has both.
#[test]
fn what_kernels_compute_otherwise_is_no_rounding() {
    let folder = folder("accuracy-otherwise");
    write(&folder, "scene.obj", SCENE);
    ended(&folder, &["new", "kernels", "mine"], 0);
    let tile = std::fs::read_to_string(folder.join("mine/tile.c")).expect("a kernel");
    let other = tile.replace("0.25f * light", "0.35f * light");
    assert_ne!(other, tile);
    write(&folder, "mine/tile.c", &other);
    let of = |more: &[&str]| {
        let found = of_small_frame(&folder, &[&UNUSED[..], more].concat());
        let found = &found["trials"][0]["attribution"];
        let figure = |name: &str| found[name].as_f64().expect("a figure");
        (figure("picture_error"), figure("squared_error"))
    };
    let (plain, changed) = (of(&[]), of(&["--kernels", "mine"]));
    assert!(
        changed.0 > 1e4 && changed.0 > 100.0 * plain.0,
        "{plain:?} {changed:?}"
    );
    assert!(
        changed.1 < 1.0,
        "roundings are as small as before: {changed:?}"
    );
    let pixel = of_small_frame(&folder, &["--kernels", "mine", "--pixel", "8,6"]);
    let levels = |name: &str| pixel[name][0].as_f64().expect("a level");
    assert!((levels("exact") - levels("value")).abs() < 0.1, "{pixel}");
    assert!(
        (levels("exact") - levels("reference")).abs() > 1.0,
        "{pixel}"
    );
}

#[test]
fn units_that_a_frame_does_not_use_get_no_credit() {
    let folder = folder("accuracy-unused");
    write(&folder, "scene.obj", SCENE);
    let report = of_small_frame(&folder, &UNUSED);
    let trials = report["trials"].as_array().expect("trials");
    let area = &trials[0]["costs"]["area"];
    for trial in &trials[1..] {
        assert_eq!(trial["not_exercised"], true);
        assert_eq!(
            trial["costs"]["area"], *area,
            "a unit that nothing uses saves nothing"
        );
    }
    assert_eq!(report["cheapest"], 0);
    assert_eq!(report["front"], serde_json::json!([0]));
}

/// The report, which is the same to the byte when it is asked for again.
fn report_twice(folder: &Path) -> (Value, String) {
    let (value, first) = report(folder);
    let (_, second) = report(folder);
    assert!(first == second, "kept trials are not tried again");
    (value, String::from_utf8_lossy(&first).into_owned())
}

#[test]
fn knobs_and_targets_at_fault_are_refused() {
    let folder = folder("accuracy_at_fault");
    misused(
        &folder,
        &["accuracy", "--knob", "taste"],
        &["taste", "intersection"],
    );
    let output = srp(&folder, &["accuracy", "--target", "beauty=1"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn kernels_take_the_place_of_scenes() {
    let folder = folder("accuracy-kernel");
    write(
        &folder,
        "f.c",
        "float f(float x)\n{\n    return 1.0f / (x - 0.5f);\n}\n",
    );
    let args = [
        "accuracy", "f.c", "--range", "x=1:2", "--points", "64", "--trials", "4", "--json", "-o",
        "out",
    ];
    let output = srp(&folder, &args);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let kernel = &report["kernels"][0];
    assert_eq!(kernel["name"], "f");
    let trials = kernel["trials"].as_array().expect("trials");
    assert_eq!(trials.len(), 4);
    assert!(
        trials[0]["bound"]["relative"]
            .as_f64()
            .is_some_and(|b| b < 1e-6)
    );
    // The machine of a trial is one that the command takes.
    assert_eq!(
        srp(&folder, &["machine", "check", "out/f-0.xml"])
            .status
            .code(),
        Some(0)
    );
    assert_eq!(srp(&folder, &args).stdout, output.stdout);
    refused(
        &folder,
        &["accuracy", "f.c"],
        &["no parameter or object has a range"],
    );
    misused(
        &folder,
        &["accuracy", "f.c", "--range", "x=1:2", "--size", "8x8"],
        &["--size is of scenes"],
    );
    misused(
        &folder,
        &["accuracy", "--range", "x=1:2"],
        &["--range is of kernels"],
    );
    misused(
        &folder,
        &["accuracy", "f.c", "--range", "x=2:1"],
        &["the range of `x` is empty"],
    );
    write(&folder, "wrong.fpcore", "(FPCore (x)\n  (+ x y))");
    refused(
        &folder,
        &["accuracy", "wrong.fpcore"],
        &["wrong.fpcore:2:8: nothing is called `y`"],
    );
}

#[test]
fn names_of_no_parameter_are_refused() {
    let folder = folder("accuracy_names");
    write(
        &folder,
        "f.c",
        "float f(float first, const float *samples) { return first * samples[0]; }\n",
    );
    let args = [
        "accuracy",
        "f.c",
        "--function",
        "f",
        "--range",
        "samples=0:1",
    ];
    let with = |more: &[&'static str]| [&args[..], more].concat();
    refused(
        &folder,
        &with(&["--range", "frist=1:2"]),
        &[
            "--range frist: f has no such parameter",
            "did you mean `first`?",
        ],
    );
    refused(
        &folder,
        &with(&["--range", "first=1:2", "--length", "sampels=4"]),
        &["--length sampels", "did you mean `samples`?"],
    );
}
