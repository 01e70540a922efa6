//! `srp watertight`: the machine moves the figures, and other ray tracers can be held beside it.

use super::{folder, misused, refused, srp, write};
use serde_json::Value;
use std::path::Path;

fn document(folder: &Path, args: &[&str]) -> Value {
    let all = [&["watertight", "--rays", "60"], args, &["--json"]].concat();
    let output = srp(folder, &all);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "srp {all:?}: {said}");
    serde_json::from_slice(&output.stdout).expect("it is JSON")
}

/// Lost rays and false hits of a column, over all rows.
fn sums(document: &Value, column: usize) -> [u64; 2] {
    let rows = document["rows"].as_array().into_iter().flatten();
    rows.fold([0; 2], |[lost, hits], row| {
        let count = &row["counts"][column];
        let of = |name: &str| count[name].as_u64().expect("it is a count");
        [lost + of("lost"), hits + of("false_hits")]
    })
}

#[test]
fn the_machine_moves_what_is_lost() {
    let folder = folder("watertight-machine");
    let source = srp(&folder, &["machine", "source", "sgrt"]);
    let source = String::from_utf8(source.stdout).expect("it is text");
    let [own, wald] = [document(&folder, &[]), {
        let changed = source.replace(
            "intersection=\"anchor-wald-scaled\"",
            "intersection=\"wald\"",
        );
        assert_ne!(changed, source);
        write(&folder, "wald.xml", &changed);
        document(&folder, &["--machine", "wald.xml"])
    }];
    assert_eq!(own["tests"][0]["name"], "anchor-wald-scaled");
    assert_eq!(wald["tests"][0]["name"], "wald");
    assert_eq!(sums(&own, 0)[0], 0, "the default loses nothing");
    assert!(sums(&wald, 0)[0] > 50, "the paper's test does");
    // A coarser reciprocal takes a larger epsilon, which hits more that passes.
    let exact = "      <special function=\"rcp\" bits=\"exact\"/>";
    let coarse = source.replace(
        exact,
        "      <special function=\"rcp\" bits=\"12\" steps=\"0\"/>",
    );
    assert_ne!(coarse, source);
    write(&folder, "coarse.xml", &coarse);
    let coarse = document(&folder, &["--machine", "coarse.xml"]);
    assert!(sums(&coarse, 0)[1] > sums(&own, 0)[1]);
    let threads = document(&folder, &["--threads", "1"]);
    assert_eq!(threads["rows"], own["rows"], "threads change nothing");
}

#[test]
fn another_ray_tracer_is_held_beside() {
    let folder = folder("watertight-beside");
    let rays = ["watertight", "--rays", "40", "--mesh", "tube"];
    let written = srp(&folder, &[&rays[..], &["--export", "out"]].concat());
    assert!(written.status.success());
    let text = std::fs::read_to_string(folder.join("out/tube.rays")).expect("it was written");
    let rays_of: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    // One that answers rightly, and one that hits everything.
    let right = |line: &&str| {
        if line.ends_with("meets") {
            "1\n"
        } else {
            "0\n"
        }
    };
    for (name, answers) in [
        ("right", rays_of.iter().map(right).collect::<String>()),
        ("all", "1\n".repeat(rays_of.len())),
    ] {
        std::fs::create_dir(folder.join(name)).expect("it is new");
        write(&folder, &format!("{name}/tube.hits"), &answers);
    }
    let args = [
        &rays[..],
        &["--beside", "right", "--beside", "all", "--json"],
    ]
    .concat();
    let output = srp(&folder, &args);
    let document: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(document["others"], serde_json::json!(["right", "all"]));
    assert_eq!(sums(&document, 4), [0, 0]);
    let passes = rays_of.iter().filter(|line| line.ends_with("passes"));
    assert_eq!(sums(&document, 5), [0, passes.count() as u64]);
    // Its own T&I unit takes the exported scene and rays, too.
    let args = [
        "tni",
        "out/tube.obj",
        "--rays",
        "file",
        "--ray-file",
        "out/tube.rays",
        "--json",
    ];
    assert!(srp(&folder, &args).status.success());

    write(&folder, "all/tube.hits", "1\nmaybe\n");
    let args = [&rays[..], &["--beside", "all"]].concat();
    refused(&folder, &args, &["tube.hits:2:1: a line is 1 where"]);
    write(&folder, "all/tube.hits", "1\n");
    refused(&folder, &args, &["1 answers of the"]);
    let unknown = ["watertight", "--mesh", "teapot"];
    misused(
        &folder,
        &unknown,
        &["no mesh is named `teapot`; there are sphere,"],
    );
}
