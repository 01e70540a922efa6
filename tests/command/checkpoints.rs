//! Checkpoints: who goes on from one ends as who never stopped, and what does not fit is refused.

use super::{TRIANGLE, folder, misused, refused, srp, write};
use std::path::Path;

fn done(folder: &Path, line: &str) -> String {
    let output = srp(folder, &line.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{line}: {said}");
    said
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).expect("it was written")
}

#[test]
fn a_frame_goes_on_as_if_it_had_not_stopped() {
    let folder = folder("checkpoint-frame");
    let frame = "render --size 48x32 --engine interp";
    done(
        &folder,
        &format!("{frame} -o whole.png --report whole.json"),
    );
    let account = |name: &str| {
        let text = String::from_utf8(read(&folder, name)).expect("it is text");
        let mut account: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
        // What was asked for differs.
        account
            .as_object_mut()
            .expect("it is an object")
            .remove("options");
        account
    };
    let whole = account("whole.json");
    let cycles = whole["cycles"].as_u64().expect("a number of cycles");
    let window = format!("{}..{}", cycles / 2, cycles / 2 + 300);
    done(
        &folder,
        &format!("{frame} -o whole.png --trace {window} --trace-output whole.fst"),
    );
    // At the start, in the middle of everything, and near the end; by engines that differ.
    for (i, at) in [0, cycles / 5, cycles / 3, cycles - 500]
        .into_iter()
        .enumerate()
    {
        let keep = format!("--checkpoint-at {at} --checkpoint {i}.checkpoint");
        let said = done(
            &folder,
            &format!("{frame} {keep} -o kept.png --report kept.json"),
        );
        assert!(said.contains(&format!("to {i}.checkpoint")), "{said}");
        assert!(account("kept.json") == whole, "keeping changes nothing");
        let rest = format!("render --size 48x32 --restore {i}.checkpoint -o rest.png");
        let engine = ["interp", "auto"][i % 2];
        let trace = format!("--trace {window} --trace-output rest.fst");
        let traced = match at < cycles / 2 {
            true => trace.as_str(),
            false => "--json",
        };
        let said = done(
            &folder,
            &format!("{rest} --engine {engine} --report rest.json {traced}"),
        );
        assert!(said.contains("goes on from cycle"), "{said}");
        assert!(account("rest.json") == whole, "from cycle {at}");
        assert!(
            read(&folder, "rest.png") == read(&folder, "whole.png"),
            "{at}"
        );
        if at < cycles / 2 {
            assert!(
                read(&folder, "rest.fst") == read(&folder, "whole.fst"),
                "{at}"
            );
        }
    }
    // What does not fit.
    let other = |args: &str, says: &str| {
        let line = format!("render --restore 1.checkpoint {args}");
        refused(&folder, &line.split(' ').collect::<Vec<_>>(), &[says]);
    };
    other("--size 48x40", "another scene, camera, or size");
    other(
        "--size 48x32 --machine decoupled",
        "another program, machine",
    );
    write(&folder, "tri.obj", TRIANGLE);
    refused(
        &folder,
        &["render", "tri.obj", "--restore", "tri.obj"],
        &["is no checkpoint"],
    );
    let mut bytes = read(&folder, "1.checkpoint");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(folder.join("1.checkpoint"), &bytes).expect("it can be written");
    other("--size 48x32", "damaged checkpoint");
    std::fs::write(folder.join("1.checkpoint"), &bytes[..20]).expect("it can be written");
    other("--size 48x32", "damaged checkpoint");
    let late = format!("{frame} --checkpoint-at {}", cycles + 9);
    refused(
        &folder,
        &late.split(' ').collect::<Vec<_>>(),
        &["it was over after"],
    );
    misused(
        &folder,
        &["render", "--checkpoint", "a"],
        &["--checkpoint-at"],
    );
}

#[test]
fn a_program_goes_on_as_if_it_had_not_stopped() {
    let folder = folder("checkpoint-program");
    let text = "#include <stdio.h>\nfloat a[64];\nint main(void) {\n    float sum = 0;\n\
        for (int times = 0; times < 4; times++) {\n        for (int i = 0; i < 64; i++) a[i] += (float)i;\n\
        for (int i = 0; i < 64; i++) sum += a[i];\n        printf(\"%d %g\\n\", times, sum);\n    }\n    return 3;\n}\n";
    write(&folder, "p.c", text);
    let run = |args: &str| {
        let line = format!("run p.c --registers end.json --report end.account.json {args}");
        let output = srp(&folder, &line.trim().split(' ').collect::<Vec<_>>());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{said}");
        let ends = [read(&folder, "end.json"), read(&folder, "end.account.json")];
        (
            String::from_utf8(output.stdout).expect("it is text"),
            ends,
            said,
        )
    };
    let (printed, ends, _) = run("");
    let account: serde_json::Value = serde_json::from_slice(&ends[1]).expect("it is JSON");
    let cycles = account["cycles"]["all"]
        .as_u64()
        .expect("a number of cycles");
    for at in [1, cycles / 3, cycles / 2, cycles - 1] {
        let (kept, same, _) = run(&format!("--checkpoint-at {at}"));
        assert!(kept == printed && same == ends, "{at}");
        let (rest, same, said) = run("--restore srp.checkpoint");
        assert!(printed.ends_with(&rest) && same == ends, "{at}: {rest}");
        assert!(said.contains("goes on from cycle"), "{said}");
    }
    write(&folder, "q.c", &text.replace("times < 4", "times < 5"));
    let other = ["run", "q.c", "--restore", "srp.checkpoint"];
    refused(&folder, &other, &["another program"]);
    misused(
        &folder,
        &["run", "p.c", "--engine", "ir", "--checkpoint-at", "9"],
        &["no cycles"],
    );
}
