//! `srp diff`: what it names sums to the difference of the whole, and runs that do not fit are refused.

use super::{folder, refused, srp, write};
use serde_json::Value;
use std::path::Path;

const PROGRAM: &str = "\
static int a[64];
static int b[64];
int main(void)
{
    for (int i = 0; i < 64; i++)
        a[i] = i * 3;
    int s = 0;
    for (int i = 0; i < 64; i++)
        s += a[i] ^ b[i];
    return s & 63;
}
";

/// The comparison of two files of a folder, and the status that it ended with.
fn diff(folder: &Path, old: &str, new: &str, more: &[&str]) -> (Value, Option<i32>) {
    let args = [&["diff", old, new, "--json"], more].concat();
    let output = srp(folder, &args);
    let message = String::from_utf8_lossy(&output.stderr);
    let json = serde_json::from_slice(&output.stdout);
    (
        json.unwrap_or_else(|e| panic!("{e}: {message}")),
        output.status.code(),
    )
}

fn difference(change: &Value) -> f64 {
    change["new"].as_f64().unwrap_or(0.0) - change["old"].as_f64().unwrap_or(0.0)
}

fn section<'a>(comparison: &'a Value, name: &str) -> &'a [Value] {
    let mut sections = comparison["sections"].as_array().expect("a list").iter();
    let section = sections.find(|s| s["name"] == name);
    let changes = section.and_then(|s| s["changes"].as_array());
    changes.unwrap_or_else(|| panic!("{name} is a section"))
}

fn sum(comparison: &Value, name: &str) -> f64 {
    section(comparison, name).iter().map(difference).sum()
}

/// Runs a program and writes its profile.
fn profiled(folder: &Path, text: &str, to: &str) {
    write(folder, "a.c", text);
    srp(folder, &["run", "a.c", "--profile", to]);
}

#[test]
fn lines_of_an_edited_program_sum_to_the_difference() {
    let folder = folder("diff-profiles");
    profiled(&folder, PROGRAM, "old.json");
    // A line above moves all others, and the second loop waits for a multiplication.
    let edited = PROGRAM.replace("static int b", "\nstatic int b");
    let edited = edited.replace("s += a[i] ^ b[i]", "s = (s ^ b[i]) * a[i]");
    profiled(&folder, &edited, "new.json");
    let (comparison, status) = diff(&folder, "old.json", "new.json", &[]);
    assert_eq!(status, Some(1), "it got slower");
    let whole = difference(&comparison["cycles"]);
    assert!(whole > 0.0);
    for name in ["cycles by part", "cycles by line"] {
        assert_eq!(sum(&comparison, name), whole, "{name}: {comparison:#}");
    }
    let lines = section(&comparison, "cycles by line");
    // The loop's control or its body, as the schedule has their operations in one cycle or another.
    let slowest = lines[0]["what"].as_str().expect("a line");
    assert!(["a.c:9", "a.c:10"].contains(&slowest), "{comparison:#}");
    assert!(
        !lines.iter().any(|l| l["what"] == "a.c:7"),
        "the first loop only moved"
    );
    let loops = section(&comparison, "cycles by loop on the array");
    let why = loops[0]["why"].to_string();
    assert!(why.contains("II 1 → "), "{why}");
    let (_, status) = diff(&folder, "old.json", "new.json", &["--tolerance", "1000"]);
    assert_eq!(status, Some(0), "not by so much");
    let (same, status) = diff(&folder, "old.json", "old.json", &[]);
    assert_eq!((difference(&same["cycles"]), status), (0.0, Some(0)));
}

#[test]
fn parts_of_two_frames_sum_to_the_difference() {
    let folder = folder("diff-frames");
    let render = |machine: &str, size: &str, to: &str| {
        let picture = [
            "render",
            "--size",
            size,
            "--machine",
            machine,
            "-o",
            "a.png",
            "--report",
            to,
        ];
        let output = srp(&folder, &picture);
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    render("sgrt", "24x16", "old.json");
    render("decoupled", "24x16", "new.json");
    let (comparison, _) = diff(&folder, "old.json", "new.json", &[]);
    let machines = [0, 1].map(|i| comparison["machines"][i]["name"].clone());
    assert_eq!(machines, ["sgrt", "decoupled"]);
    // Four cores are busy or idle in each cycle of the frame.
    let whole = 4.0 * difference(&comparison["cycles"]);
    assert!(whole != 0.0);
    assert_eq!(sum(&comparison, "cycles of all cores"), whole);
    let energy = comparison["figures"].as_array().expect("a list").iter();
    let energy = energy
        .filter(|f| f["what"] == "energy, mJ")
        .map(difference)
        .next();
    let parts = sum(&comparison, "energy");
    assert!(
        (parts - energy.expect("a figure")).abs() < 1e-9,
        "{comparison:#}"
    );

    render("sgrt", "16x16", "small.json");
    profiled(&folder, PROGRAM, "profile.json");
    refused(
        &folder,
        &["diff", "old.json", "small.json"],
        &["24 and 16 pixels wide"],
    );
    refused(
        &folder,
        &["diff", "old.json", "profile.json"],
        &["profile.json:2:13", "`srp-frame`", "`srp-profile`"],
    );
    refused(&folder, &["diff", "a.c", "old.json"], &["a.c: not JSON"]);
    write(
        &folder,
        "cut.json",
        "{\"format\": \"srp-frame\", \"version\": 2}",
    );
    refused(
        &folder,
        &["diff", "cut.json", "old.json"],
        &["cut.json: the account of a frame has a number at"],
    );
    write(
        &folder,
        "next.json",
        "{\"format\": \"srp-frame\", \"version\": 3}",
    );
    refused(
        &folder,
        &["diff", "next.json", "old.json"],
        &["next.json:1:36", "version 3", "version 2"],
    );
}
