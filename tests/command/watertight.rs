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

/// The number of columns of tests of the T&I unit, before those of other ray tracers.
fn tests_of(document: &Value) -> usize {
    document["tests"].as_array().map_or(0, Vec::len)
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
    assert_eq!(sums(&document, tests_of(&document)), [0, 0]);
    let passes = rays_of.iter().filter(|line| line.ends_with("passes"));
    let all = sums(&document, tests_of(&document) + 1);
    assert_eq!(all, [0, passes.count() as u64]);
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

/// The text of a mesh, a triangle a line.
fn obj(triangles: &[[[f32; 3]; 3]]) -> String {
    let mut text = String::new();
    for [x, y, z] in triangles.iter().flatten() {
        text += &format!("v {x:e} {y:e} {z:e}\n");
    }
    for i in 0..triangles.len() {
        text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    text
}

/// A square of so many squares a side, in the plane that a function bends.
fn square(n: usize, place: impl Fn(f32, f32) -> [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    let at = |i: usize, j: usize| place(i as f32 / n as f32, j as f32 / n as f32);
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    triangles
}

/// A closed box of bent sides, away from the origin.
fn closed() -> Vec<[[f32; 3]; 3]> {
    let bent = |u: f32, v: f32, w: f32| {
        let p = [2.0 * u - 1.0, 2.0 * v - 1.0, 2.0 * w - 1.0];
        let length = p.iter().map(|x| x * x).sum::<f32>().sqrt();
        [0, 1, 2].map(|k| 30.0 + 7.3 * p[k] / length)
    };
    let mut triangles = Vec::new();
    for end in [0.0, 1.0] {
        triangles.extend(square(5, |u, v| bent(u, v, end)));
        triangles.extend(square(5, |u, v| bent(end, u, v)));
        triangles.extend(square(5, |u, v| bent(v, end, u)));
    }
    triangles
}

/// Meshes of one's own: what has triangles on both sides is closed, and the default test loses nothing there; at
/// a border Woop's test does; triangles without area are met by nothing and hit by nothing.
#[test]
fn meshes_of_ones_own_are_shot_at() {
    let folder = folder("watertight-own");
    let open = square(6, |u, v| [u, v, 0.3 * u * v]);
    let point = [0.25; 3];
    let nothing = [[point; 3], [[0.0; 3], [1.0; 3], [2.0; 3]]];
    let with_nothing = [&closed()[..], &nothing].concat();
    let huge = [[[-9e17; 3], [9e17, -9e17, 0.0], [0.0, 9e17, 9e17]]];
    for (name, mesh) in [
        ("closed", &closed()[..]),
        ("open", &open),
        ("nothing", &nothing),
        ("with-nothing", &with_nothing),
        ("huge", &huge),
        ("point", &nothing[..1]),
    ] {
        write(&folder, &format!("{name}.obj"), &obj(mesh));
    }
    let files = ["closed", "open", "nothing", "with-nothing", "huge", "point"];
    let files = files.map(|name| format!("{name}.obj"));
    let mut args: Vec<&str> = files.iter().map(String::as_str).collect();
    args.extend(["--rays", "300"]);
    let output = srp(&folder, &[&["watertight"], &args[..], &["--json"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let document: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    let made: Vec<[u64; 3]> = (document["meshes"].as_array().into_iter().flatten())
        .map(|mesh| {
            ["triangles", "degenerate", "borders"].map(|k| mesh[k].as_u64().expect("so many"))
        })
        .collect();
    let expected = [
        [300, 0, 0],
        [72, 0, 24],
        [2, 2, 0],
        [302, 2, 0],
        [1, 0, 3],
        [1, 1, 0],
    ];
    assert_eq!(made, expected);

    // Rays, those that meet, and what is lost and hit falsely by the tests of these names.
    let sums = |mesh: &str, aims: &[&str], test: &str| {
        let tests = document["tests"].as_array().expect("there are tests");
        let column = tests
            .iter()
            .position(|t| t["name"] == test)
            .expect("the test is there");
        let rows = document["rows"].as_array().into_iter().flatten();
        let rows =
            rows.filter(|row| row["mesh"] == mesh && aims.iter().any(|aim| row["aim"] == *aim));
        rows.fold([0; 4], |sum, row| {
            let count = &row["counts"][column];
            let new = [
                &row["rays"],
                &row["meet"],
                &count["lost"],
                &count["false_hits"],
            ];
            [0, 1, 2, 3].map(|k| sum[k] + new[k].as_u64().expect("it is a count"))
        })
    };
    let (both_sides, one_side) = (["closed-edges", "closed-vertices"], ["edges", "vertices"]);
    let default = "anchor-wald-scaled";
    for mesh in ["closed", "open", "with-nothing"] {
        let [rays, meet, lost, _] = sums(mesh, &both_sides, default);
        assert_eq!([rays, lost], [600, 0], "{mesh}");
        assert!(meet > 590, "{mesh}: {meet}");
        for test in ["woop", "woop-wide"] {
            assert_eq!(sums(mesh, &both_sides, test)[2], 0, "{mesh}: {test}");
        }
        assert_eq!(sums(mesh, &one_side, default)[2], 0, "{mesh}");
    }
    assert!(sums("open", &both_sides, "wald")[2] > 0, "it has holes");
    let [_, meet, lost, _] = sums("open", &one_side, "woop");
    assert!(0 < lost && lost < meet, "{lost} of {meet}");
    assert_eq!(
        sums("huge", &both_sides, default)[0],
        0,
        "nothing is closed"
    );
    for mesh in ["nothing", "point"] {
        let all = [&both_sides[..], &one_side, &["grazing"]].concat();
        let [_, meet, lost, hits] = sums(mesh, &all, default);
        assert_eq!([meet, lost, hits], [0; 3], "{mesh}");
    }

    let text = srp(&folder, &[&["watertight"], &args[..], &["--all"]].concat());
    let text = String::from_utf8_lossy(&text.stdout);
    let told = "open: 72 triangles, 0 of them without area; 24 edges are a border, of one triangle";
    assert!(
        text.contains(told) && text.contains("  closed edges"),
        "{text}"
    );
}

#[test]
fn what_is_no_mesh_of_ones_own_is_refused() {
    let folder = folder("watertight-refused");
    write(&folder, "empty.obj", "v 0 0 0\n");
    write(&folder, "bad.obj", "v 0 0 0\nv 1 0 x\n");
    write(&folder, "one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    std::fs::create_dir(folder.join("other")).expect("it is new");
    write(
        &folder,
        "other/one.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    );
    refused(
        &folder,
        &["watertight", "empty.obj"],
        &["the file has no faces"],
    );
    refused(&folder, &["watertight", "bad.obj"], &["bad.obj:2:"]);
    refused(&folder, &["watertight", "absent.obj"], &["absent.obj"]);
    let twice = ["watertight", "one.obj", "other/one.obj"];
    misused(&folder, &twice, &["are both named `one`"]);
    let both = ["watertight", "one.obj", "--mesh", "tube"];
    misused(&folder, &both, &["--mesh"]);
    // The rays of one's own mesh go to other ray tracers, and their answers come back.
    let own = ["watertight", "one.obj", "--rays", "20"];
    assert!(
        srp(&folder, &[&own[..], &["--export", "out"]].concat())
            .status
            .success()
    );
    let rays = std::fs::read_to_string(folder.join("out/one.rays")).expect("it was written");
    let answer = |line: &str| {
        if line.ends_with("meets") {
            "1\n"
        } else {
            "0\n"
        }
    };
    let rays = rays.lines().filter(|line| !line.starts_with('#'));
    write(
        &folder,
        "out/one.hits",
        &rays.map(answer).collect::<String>(),
    );
    let beside = [&own[..], &["--beside", "out", "--json"]].concat();
    let document: Value = serde_json::from_slice(&srp(&folder, &beside).stdout).expect("JSON");
    assert_eq!(document["others"], serde_json::json!(["out"]));
    assert_eq!(sums(&document, tests_of(&document)), [0, 0]);
}
