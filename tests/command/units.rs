//! T&I units and memories alone: `srp tni`, `srp paper`, `srp area`, `srp dram`.

use crate::{TRIANGLE, folder, misused, refused, srp, write};
use std::path::Path;

/// Returns the output of the command, which must succeed.
fn printed(folder: &Path, args: &[&str]) -> String {
    let output = srp(folder, args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "srp {args:?}: {message}");
    String::from_utf8(output.stdout).expect("output is text")
}

fn json(folder: &Path, args: &[&str]) -> serde_json::Value {
    let text = printed(folder, &[args, &["--json"]].concat());
    serde_json::from_str(&text).expect("it is JSON")
}

/// A machine whose reciprocal has a step that is not fused, in code.
#[test]
fn units_of_a_machine_have_certificates() {
    let folder = folder("certificates");
    let (_, tiny) = printed(&folder, &["machine", "expand", "tiny"])
        .split_once('\n')
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .expect("it has lines");
    let exact = "  <special function=\"rcp\" bits=\"exact\"/>\n";
    let step =
        "  <special function=\"rcp\" bits=\"12\" steps=\"1\" fused=\"false\" refine=\"code\"/>\n";
    assert!(tiny.contains(exact), "{tiny}");
    let changed = format!("<machine name=\"t\">\n{}", tiny.replacen(exact, step, 1));
    write(&folder, "t.xml", &changed);
    let found = json(&folder, &["units", "t.xml"]);
    let rcp = &found["srp"][0];
    assert_eq!(rcp["function"], "rcp");
    let worst = rcp["worst_ulp"].as_f64().expect("a number");
    assert!((2.2..2.3).contains(&worst), "{worst}");
    assert_eq!(rcp["monotone"], false);
    assert_eq!(found["tni"]["rounded"], 1.0);
    let text = printed(&folder, &["units", "t.xml"]);
    assert!(text.contains("12 bits + 1 step not fused"), "{text}");
}

#[test]
fn units_alone_give_the_same_figures_on_any_number_of_threads() {
    let folder = folder("tni");
    let json = |more: &[&str]| {
        let mut args = vec!["tni", "--size", "40x30", "--spp", "4", "--json"];
        args.extend(more);
        let output = srp(&folder, &args);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "srp {args:?}: {message}");
        String::from_utf8(output.stdout).expect("JSON is text")
    };
    for rays in ["primary", "ao", "diffuse"] {
        for memory in ["shared", "private"] {
            let one = json(&["--rays", rays, "--memory", memory, "--threads", "1"]);
            let two = json(&["--rays", rays, "--memory", memory, "--threads", "2"]);
            assert_eq!(one, two, "{rays}, {memory}");
        }
    }
    write(&folder, "rays.txt", "0 1 9 0 0 -1\n0 1 9 0 0 -1 0 1 any\n");
    let given = json(&["--rays", "file", "--ray-file", "rays.txt"]);
    assert!(given.contains("\"rays\": 2"), "{given}");
    let told = srp(&folder, &["tni", "--size", "40x30", "--ray", "20,15"]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(
        told.contains("RD     to TRV 0") && told.contains("result "),
        "{told}"
    );
    let told = json(&["--ray", "20,15"]);
    let told: serde_json::Value = serde_json::from_str(&told).expect("it is JSON");
    let events = told["events"].as_array().expect("there are events");
    assert_eq!(events[0]["what"], "dispatch");
    assert_eq!(events[events.len() - 1]["what"], "result");
    for (args, says) in [
        (
            &["--fidelity", "analytic", "--heat", "heat.png"],
            "leave one out",
        ),
        (
            &["--fidelity", "sampled", "--heat", "heat.png"],
            "leave one out",
        ),
        (
            &["--fidelity", "sampled", "--sample", "1/4"],
            "leave out --sample",
        ),
        (
            &["--fidelity", "functional", "--memory", "both"],
            "leave out --memory",
        ),
        (&["--heat-of", "visits", "--views", "0"], "give a file"),
        (&["--ray-file", "rays.txt", "--views", "0"], "--rays file"),
    ] {
        misused(&folder, &[&["tni"], &args[..]].concat(), &[says]);
    }
    misused(
        &folder,
        &["paper", "table4", "--sample", "1/4"],
        &["leave out --sample"],
    );
    write(&folder, "bad.txt", "0 1 9 0 0 -1\n0 1 nine 0 0 -1\n");
    refused(
        &folder,
        &["tni", "--rays", "file", "--ray-file", "bad.txt"],
        &["bad.txt:2:5", "this is not a number"],
    );
    refused(&folder, &["tni", "--views", "3"], &["there is no view 3"]);
}

#[test]
fn areas_are_those_of_the_machine() {
    let folder = folder("area");
    let of = |machine: &str| {
        let output = srp(&folder, &["area", machine]);
        assert!(output.status.success());
        String::from_utf8(output.stdout).expect("a report is text")
    };
    let sgrt = of("sgrt");
    assert!(
        sgrt.contains("TRV × 4       24    24     0    44"),
        "{sgrt}"
    );
    assert!(sgrt.contains("wald"), "{sgrt}");
    let numbers = json(&folder, &["area", "sgrt"]);
    assert_eq!(numbers["tni"]["trv"]["operations"]["add"], 24);
    assert_eq!(numbers["tni"]["total"], numbers["parallel_mm2"]);
    let mm2 = |name: &str| numbers[name].as_f64().expect("a number");
    assert!(mm2("single_mm2") < mm2("parallel_mm2"));
    assert_ne!(sgrt, of("tiny"));
}

#[test]
fn odd_scenes_are_measured_or_refused() {
    let folder = folder("odd scenes");
    write(&folder, "one.obj", TRIANGLE);
    let one = json(&folder, &["tni", "one.obj", "--size", "20x15"]);
    let counted = &one["all"]["counters"];
    assert_eq!(counted["unit"]["rays"], 300);
    assert_eq!(counted["triangle_tests"], 300);
    assert_eq!(counted["box_tests"], 0);
    let hits = counted["unit"]["hits"].as_u64().expect("a number");
    assert!((1..300).contains(&hits), "{hits}");

    let flat = "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 1 1 2\n";
    write(&folder, "flat.obj", flat);
    let flat = json(&folder, &["tni", "flat.obj", "--size", "20x15"]);
    assert_eq!(flat["all"]["counters"]["unit"]["hits"], 0);
    let nothing = ["start from"];
    for level in ["functional", "analytic", "cycle+dram"] {
        let ao = ["tni", "flat.obj", "--rays", "ao", "--fidelity", level];
        refused(&folder, &ao, &nothing);
    }
    let paper = ["paper", "table4", "flat.obj", "--size", "20x15"];
    refused(&folder, &paper, &nothing);
    write(&folder, "none.obj", "v 0 0 0\n");
    refused(&folder, &["tni", "none.obj"], &["no faces"]);
    let far = TRIANGLE.replace("v 1 0 0", "v 1e30 0 0");
    write(&folder, "far.obj", &far);
    refused(&folder, &["tni", "far.obj"], &["far.obj:2:3"]);
    write(&folder, "none.txt", "# no rays\n");
    let none = ["tni", "--rays", "file", "--ray-file", "none.txt"];
    refused(&folder, &none, &["the file has none"]);
}

#[test]
fn the_papers_tables_are_data_too() {
    let folder = folder("paper");
    let of = ["paper", "table5", "--size", "40x30"];
    let report = json(&folder, &of);
    let groups = &report["scenes"][0]["groups"];
    let kinds: Vec<_> = (0..3).map(|i| &groups[i]["rays"]).collect();
    assert_eq!(kinds, ["primary", "AO", "diffuse"]);
    let rate = &groups[0]["figures"][0];
    assert!(
        rate["ours"].as_f64() > Some(1.0) && rate["paper"].is_null(),
        "{rate}"
    );
    let text = printed(&folder, &of);
    let line = text.lines().find(|l| l.contains("Mrays/s, a memory each"));
    let shown = format!("{:.2}", rate["ours"].as_f64().unwrap_or(0.0));
    assert!(line.is_some_and(|l| l.contains(&shown)), "{shown}: {text}");
}

/// A sample states its size, with intervals; too few rays for a sample are all run, and the report says so.
#[test]
fn rays_are_sampled_or_all_run() {
    let folder = folder("sampled rays");
    let of = |size: &str| {
        let rays = [
            "tni", "--rays", "ao", "--spp", "4", "--units", "1", "--size", size,
        ];
        let more = ["--fidelity", "sampled", "--error", "10%"];
        let numbers = json(&folder, &[&rays[..], &more].concat());
        let said = srp(&folder, &[&rays[..], &more].concat()).stderr;
        (numbers, String::from_utf8_lossy(&said).into_owned())
    };
    let (some, said) = of("320x240");
    let number = |v: &serde_json::Value| v.as_f64().unwrap_or(f64::NAN);
    let blocks = &some["blocks"];
    assert!(
        number(&blocks["run"]) < number(&blocks["all"]) / 2.0,
        "{blocks}"
    );
    assert!(!said.contains("all are run"), "{said}");
    let rate = &some["intervals"][0];
    assert_eq!(
        (&rate["name"], &rate["value"]),
        (&"rate".into(), &some["all"]["mrays_per_second"])
    );
    assert!(number(&rate["half_width"]) > 0.0);
    let (all, said) = of("40x30");
    assert!(all["blocks"].is_null() && all["intervals"] == serde_json::json!([]));
    assert!(said.contains("all are run"), "{said}");
}

/// The machine says who shares a memory, the command line may say otherwise, and both can be had.
#[test]
fn memories_are_shared_or_not() {
    let folder = folder("memories");
    let machine = include_str!("../../archdesc/machines/sgrt.xml");
    let own = machine.replacen("shared=\"true\"", "shared=\"false\"", 1);
    assert_ne!(own, machine);
    write(&folder, "own.xml", &own);
    let of = |more: &[&str]| {
        let args = ["tni", "--size", "64x48", "--machine"];
        json(&folder, &[&args, more].concat())
    };
    let memories = |report: &serde_json::Value| report["memory"]["memories"].clone();
    let (shared, private) = (of(&["sgrt"]), of(&["own.xml"]));
    assert_eq!(memories(&shared["all"]), 1);
    assert_eq!(memories(&private["all"]), 4);
    assert_eq!(of(&["sgrt", "--memory", "private"])["all"], private["all"]);
    let both = of(&["own.xml", "--memory", "both"]);
    assert_eq!(both["all"], shared["all"]);
    assert_eq!(both["all_with_private_memories"], private["all"]);
    // The memories deliver the bytes that the units ask for.
    for report in [&shared["all"], &private["all"]] {
        let read = &report["memory"]["counters"]["bytes_read"];
        assert_eq!(*read, report["counters"]["bytes_read"]);
        assert_ne!(*read, 0);
    }
}

#[test]
fn traces_of_requests_run_through_memories() {
    let folder = folder("dram");
    // Two bursts of one row, then one of another row of the same bank.
    let trace = "0 READ 0\n32 READ 0 # the next burst\n0x2000000 READ 100\n";
    write(&folder, "three.trace", trace);
    let fast = ["dram", "three.trace", "--preset", "lpddr3-1600"];
    let report = json(&folder, &fast);
    for (name, expected) in [
        ("reads", 3),
        ("activates", 2),
        ("precharges", 1),
        ("read_row_hits", 1),
    ] {
        assert_eq!(report[name], expected, "{name}");
    }
    // The last has to close the row (15), open another (15) and read it (12 + 4).
    let most = report["max_read_cycles"].as_u64().expect("a number");
    assert!((46..60).contains(&most), "{most}");
    let text = printed(&folder, &fast);
    assert!(text.contains("3 of 3 requests taken"), "{text}");
    let early = json(&folder, &[&fast[..], &["--cycles", "50"]].concat());
    assert_eq!((&early["taken"], &early["reads"]), (&2.into(), &2.into()));
    let known = printed(&folder, &["dram", "--presets"]);
    for name in ["paper-gddr3-1GHz", "lpddr3-1600", "lpddr3-1866", "fixed"] {
        assert!(known.contains(name), "{known}");
        json(&folder, &["dram", "three.trace", "--preset", name]);
    }
    write(&folder, "bad.trace", "0 READ 0\n64 ERASE 4\n");
    refused(&folder, &["dram", "bad.trace"], &["bad.trace:2:4", "ERASE"]);
    let unknown = srp(&folder, &["dram", "three.trace", "--preset", "ddr9"]);
    assert_eq!(unknown.status.code(), Some(2));
}

/// Packets of any size make the same picture, but for what rounding does at edges.
#[test]
fn packets_of_any_size_make_the_same_picture() {
    let folder = folder("packets");
    let machine = include_str!("../../archdesc/machines/sgrt.xml");
    let picture = |rays: &str| {
        let xml = machine.replacen(
            "<buffers rays=\"64\"",
            &format!("<buffers rays=\"{rays}\""),
            1,
        );
        write(&folder, "machine.xml", &xml);
        let args = [
            "render",
            "--size",
            "64x48",
            "--engine",
            "interp",
            "--machine",
            "machine.xml",
        ];
        printed(&folder, &args);
        let png = std::fs::read(folder.join("out.png")).expect("it was written");
        image::load_from_memory(&png)
            .expect("it is a PNG")
            .into_rgb8()
    };
    let expected = picture("64");
    for rays in ["63", "20"] {
        let got = picture(rays);
        let differ = |(a, b): &(&u8, &u8)| a.abs_diff(**b) > 2;
        let others = expected.iter().zip(got.iter()).filter(differ).count();
        assert!(others < expected.len() / 200, "{rays}: {others} values");
    }
}
