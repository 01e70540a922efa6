//! `--set PATH=VALUE`: a machine is changed on the command line as its file would be.

use super::{folder, misused, refused, srp, stdout, write};
use serde_json::Value;
use std::path::Path;

const PROGRAM: &str = "\
float xs[64], ys[64];
int main(void) {
    #pragma srp kernel
    for (int i = 0; i < 64; i++) ys[i] = __builtin_sqrtf(xs[i] + 1.0f);
    return 0;
}
";

const CHANGES: [&str; 6] = [
    "--set",
    "op[class=sfu].interval=3",
    "--set",
    "tni.trvs=8",
    "--set",
    "sram.banks=2",
];

fn document(folder: &Path, args: &[&str], more: &[&str]) -> Value {
    let args = [args, more, &["--json"]].concat();
    let mut document: Value = serde_json::from_str(&stdout(folder, &args, 0)).expect("it is JSON");
    let is_set = !document["options"]["set"].is_null();
    assert_eq!(is_set, more.contains(&"--set"));
    document["options"] = Value::Null;
    document
}

#[test]
fn a_change_is_that_of_the_file() {
    let folder = folder("set-file");
    write(&folder, "p.c", PROGRAM);
    let source = stdout(&folder, &["machine", "source", "sgrt"], 0);
    let args = [&["machine", "source", "sgrt"][..], &CHANGES].concat();
    let changed = stdout(&folder, &args, 0);
    assert_eq!(
        source.lines().count(),
        changed.lines().count(),
        "comments stay"
    );
    write(&folder, "mine.xml", &changed);
    let commands: [&[&str]; 4] = [
        &["report", "p.c"],
        &["run", "p.c"],
        &["area"],
        &[
            "render", "--size", "16x12", "--effort", "0.05", "-o", "a.png",
        ],
    ];
    for command in commands {
        let plain = document(&folder, command, &[]);
        let set = document(&folder, command, &CHANGES);
        let file = document(&folder, command, &["--machine", "mine.xml"]);
        assert_eq!(set, file, "srp {command:?}");
        assert_ne!(set, plain, "srp {command:?}");
    }
    let ii = |more: &[&str]| {
        let report = document(&folder, &["report", "p.c"], more);
        report["loops"][0]["ii"].as_u64().expect("it has an II")
    };
    assert_eq!([ii(&[]), ii(&CHANGES)], [2, 3]);
    // What is said to help helps as it is said.
    let tried = document(&folder, &["report", "p.c", "--what-if"], &[]);
    let helps = &tried["loops"][0]["what_if"]["changes"][0];
    let set = helps["set"][0].as_str().expect("it has a setting");
    assert_eq!(set, "op[class=sfu].interval=1");
    assert_eq!(
        ii(&["--set", set]),
        helps["ii"].as_u64().expect("it has an II")
    );
    let written = [&["machine", "expand"][..], &CHANGES].concat();
    assert_eq!(
        stdout(&folder, &written, 0),
        stdout(&folder, &["machine", "expand", "mine.xml"], 0)
    );
}

#[test]
fn a_mesh_is_changed_too() {
    let folder = folder("set-mesh");
    write(&folder, "sum.edges", "0 1\n0 2\n1 3\n2 3\n");
    write(&folder, "sum.ops", "0 add\n1 mul\n2 mul\n3 add\n");
    let ii = |more: &[&str]| {
        let mapped = document(&folder, &["map", "sum.edges", "--mesh", "1x4"], more);
        let ii = &mapped["graphs"][0]["mapping"]["ii"];
        ii.as_u64().expect("it has an II")
    };
    let alone = ii(&["--set", "array.cols=1"]);
    assert_eq!(alone, 4, "one unit issues the four operations");
    assert!(ii(&[]) < alone);
}

/// Links that take time are gone round by way of the central registers: no bound may say that this is too short.
#[test]
fn slow_links_are_gone_round() {
    let folder = folder("set-links");
    let text = "#include <srp.h>\nfloat a[64];\nint main(void) {\n    for (int i = 3; i < 64; i++)\n        \
                a[i] = srp_sqrt(a[i - 3]) * 0.5f;\n    return (int)a[9];\n}\n";
    write(&folder, "p.c", text);
    for machine in ["sgrt", "tiny", "wide"] {
        for delay in ["array.link-delay=1", "array.link-delay=2"] {
            let set = ["--machine", machine, "--set", delay];
            let report = document(&folder, &["report", "p.c"], &set);
            let ii = report["loops"][0]["ii"].as_u64().expect("it has an II");
            if machine == "sgrt" {
                // Three cycles of a load, eight of a root, three of a product and one of a store, in three iterations.
                assert_eq!(ii, 5, "{report}");
            }
        }
    }
}

/// A loop or a graph without a schedule is refused, not looked for without end.
#[test]
fn what_has_no_schedule_is_refused() {
    let folder = folder("set-hopeless");
    let text = "float a[64];\nint main(void) {\n    float s = 0;\n    for (int i = 0; i < 64; i++) s += a[i];\n    \
                return (int)s;\n}\n";
    write(&folder, "s.c", text);
    let slotless = ["--set", "vliw.slots=0"];
    refused(
        &folder,
        &[&["run", "s.c"][..], &slotless].concat(),
        &["VLIW slot"],
    );
    write(&folder, "odd.edges", "0 1\n1 2\n");
    write(&folder, "odd.ops", "0 add\n1 sqrt\n2 add\n");
    let asked = ["map", "odd.edges", "--mesh", "4x4", "--what-if"];
    let output = srp(
        &folder,
        &[&asked[..], &["--set", "fu-type[*].classes=alu"]].concat(),
    );
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("sqrt"), "{said}");
}

#[test]
fn what_cannot_be_set_is_told() {
    let folder = folder("set-wrong");
    misused(&folder, &["area", "--set", "array.rows"], &["array.rows=5"]);
    misused(
        &folder,
        &["area", "--set", "rows=5"],
        &["ELEMENT.ATTRIBUTE"],
    );
    refused(
        &folder,
        &["area", "--set", "arrray.rows=5"],
        &["sgrt: `arrray.rows`", "`array`"],
    );
    refused(
        &folder,
        &["area", "--set", "array.rowz=5"],
        &["sgrt with array.rowz=5:", "rowz=\"5\"", "^"],
    );
    refused(
        &folder,
        &["render", "--set", "tni.trvs=0"],
        &["trvs=\"0\"", "^"],
    );
    let unnamed = ["area", "--set", "resource[name=sram_ports].count=1"];
    refused(&folder, &unnamed, &["`<resource>`"]);
    let preset = [
        "dram",
        "t.trace",
        "--preset",
        "fixed",
        "--set",
        "dram.mhz=500",
    ];
    misused(&folder, &preset, &["--preset"]);
    write(&folder, "broken.xml", "<machine name=\"m\">\n  <array\n");
    let set = ["--machine", "broken.xml", "--set", "array.rows=5"];
    refused(
        &folder,
        &[&["run", "p.c"][..], &set].concat(),
        &["broken.xml:"],
    );
}
