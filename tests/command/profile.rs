//! Profiles of frames: what they advise makes the frame faster.

use super::{folder, srp};
use serde_json::Value;

#[test]
fn what_a_profile_advises_makes_the_frame_faster() {
    let folder = folder("advice");
    let run = |line: &str| {
        let output = srp(&folder, &line.split(' ').collect::<Vec<_>>());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
        String::from_utf8(output.stdout).expect("it is text")
    };
    run("render --size 96x64 --effort 0.05 --profile profile.json --report frame.json -o a.png");
    for page in ["page.html", "page.txt"] {
        run(&format!(
            "render --size 96x64 --effort 0.05 --profile {page} -o a.png"
        ));
        let page = std::fs::read_to_string(folder.join(page)).expect("it was written");
        assert!(page.contains("the core waits for a port"), "{page}");
    }
    let read = |name: &str| -> Value {
        let text = std::fs::read(folder.join(name)).expect("it was written");
        serde_json::from_slice(&text).expect("it is JSON")
    };
    let cycles = read("frame.json")["cycles"].as_u64().expect("a number");
    let profile = read("profile.json");
    let advice = profile["advice"].as_array().expect("a list");
    assert!(advice.len() > 2, "{advice:?}");
    let share = |advice: &Value| advice["share"].as_f64().expect("a number");
    assert!(
        advice
            .windows(2)
            .all(|two| share(&two[0]) >= share(&two[1]))
    );
    let mut tried = 0;
    for (number, advice) in advice.iter().enumerate() {
        let set = advice["set"].as_array().expect("a list");
        let set: Vec<String> = (set.iter())
            .map(|pair| {
                let word = |i: usize| pair[i].as_str().expect("a word");
                format!("--set {}={}", word(0), word(1))
            })
            .collect();
        if set.is_empty() {
            continue;
        }
        let set = set.join(" ");
        let told = run(&format!(
            "sweep {set} --size 96x64 --effort 0.05 --measure cycles -o {number} --json"
        ));
        let table: Value = serde_json::from_str(&told).expect("it is JSON");
        let row = &table["rows"][0];
        let after = row["outcome"]["figures"]["cycles"]
            .as_f64()
            .expect("a number");
        // No more than the share of the cost is to be had, and some of it is.
        let least = (1.0 - share(advice)) * cycles as f64;
        assert!(after < cycles as f64, "{set}: {cycles} to {after}");
        assert!(
            after > 0.9 * least,
            "{set}: {after} of {cycles}, at least {least}"
        );
        tried += 1;
    }
    assert!(tried > 1, "{advice:?}");
}

/// Where one part is made the narrowest by far, the profile says so, and what it advises is worth a good part of what it
/// claims.
#[test]
fn the_narrowest_part_is_named() {
    let folder = folder("narrowest");
    let frame = |set: &[String], name: &str| -> (f64, Value) {
        let sizes = ["render", "--size", "96x64", "--effort", "0.05"];
        let [report, profile] = ["report", "profile"].map(|of| format!("{name}.{of}.json"));
        let files = ["-o", "a.png", "--report", &report, "--profile", &profile];
        let set = set.iter().map(String::as_str);
        let args: Vec<&str> = sizes.into_iter().chain(files).chain(set).collect();
        let output = srp(&folder, &args);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {said}");
        let read = |file: &str| -> Value {
            let text = std::fs::read(folder.join(file)).expect("it was written");
            serde_json::from_slice(&text).expect("it is JSON")
        };
        let cycles = read(&report)["cycles"].as_f64().expect("a number");
        (cycles, read(&profile))
    };
    let set = |attribute: &str, value: &str| ["--set".to_owned(), format!("{attribute}={value}")];
    let cases: [(&[(&str, &str)], &str); 4] = [
        (&[("bus.width", "1")], "bus.width"),
        (
            &[("dram.bits", "8"), ("dram.channels", "1")],
            "dram.channels",
        ),
        (
            &[
                ("tni.trvs", "1"),
                ("tni.stacks", "4"),
                ("buffers.hit-buffers", "4"),
                ("buffers.ray-buffers", "5"),
            ],
            "tni.stacks",
        ),
        (
            &[
                ("tni.rau-rows", "0"),
                ("tni/trv-l2.latency", "60"),
                ("buffers.hit-buffers", "8"),
                ("buffers.ray-buffers", "9"),
            ],
            "tni.rau-rows",
        ),
    ];
    for (machine, part) in cases {
        let machine: Vec<String> = (machine.iter())
            .flat_map(|(attribute, value)| set(attribute, value))
            .collect();
        let (before, profile) = frame(&machine, "before");
        let advice = &profile["advice"][0];
        let share = advice["share"].as_f64().expect("a number");
        let changes: Vec<String> = (advice["set"].as_array().expect("a list").iter())
            .flat_map(|pair| {
                let word = |i: usize| pair[i].as_str().expect("a word");
                assert_eq!(word(0), part, "{advice}");
                set(word(0), word(1))
            })
            .collect();
        let (after, _) = frame(&[machine, changes].concat(), "after");
        let saved = (before - after) / before;
        assert!(saved > 0.25 * share, "{part}: {saved} of {share}");
    }
}
