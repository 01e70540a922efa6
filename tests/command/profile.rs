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
