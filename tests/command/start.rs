//! `srp new`: every starting point does what its first comment says.

use super::{folder, srp};

#[test]
fn starting_points_do_what_they_say() {
    let folder = folder("start");
    for (kind, path, commands) in [
        ("program", "fog.c", 5),
        ("machine", "mine.xml", 4),
        ("sweep", "plan.toml", 3),
        ("cases", "my.cases", 2),
    ] {
        let made = srp(&folder, &["new", kind, path]);
        assert_eq!(made.status.code(), Some(0), "{kind}");
        let text = std::fs::read_to_string(folder.join(path)).expect("it was written");
        assert!(!text.contains('@'), "{text}");
        // The lines of the first comment that are commands.
        let words = |line: &str| {
            let line = line.trim_start_matches(['#', '*', ' ']);
            let words = line.strip_prefix("srp ")?;
            Some(words.split(' ').map(str::to_owned).collect::<Vec<_>>())
        };
        let lines = text
            .lines()
            .take_while(|line| !line.contains("loop goes to the array"));
        let tried: Vec<Vec<String>> = lines.take(10).filter_map(words).collect();
        assert_eq!(tried.len(), commands, "{kind}: {tried:?}");
        for args in tried {
            let args: Vec<&str> = args.iter().map(String::as_str).collect();
            let output = srp(&folder, &args);
            let said = String::from_utf8_lossy(&output.stderr);
            if said.contains("there is no simulator") {
                println!("skipped: there is no rustc");
                continue;
            }
            assert_eq!(output.status.code(), Some(0), "{args:?}: {said}");
        }
        let again = srp(&folder, &["new", kind, path]);
        assert_eq!(again.status.code(), Some(1), "{kind} is written over");
    }
}

/// Kernels of two effects are scheduled sooner than those of all that the default scene calls for.
const LIT: [&str; 2] = ["--effects", "-all,+light,+shadow"];

#[test]
fn kernels_of_ones_own_begin_as_ours() {
    let folder = folder("start-kernels");
    assert_eq!(
        srp(&folder, &["new", "kernels", "mine"]).status.code(),
        Some(0)
    );
    let picture = |name: &str, args: &[&str]| {
        let size = ["--size", "32x24", "--effort", "0.05"];
        let args = [&["render", "-o", name], &size[..], &LIT, args].concat();
        assert_eq!(srp(&folder, &args).status.code(), Some(0), "{args:?}");
        std::fs::read(folder.join(name)).expect("it was written")
    };
    let mine = ["--kernels", "mine"];
    let ours = picture("ours.png", &[]);
    assert!(ours == picture("mine.png", &mine));
    // What is changed shows.
    let shade = folder.join("mine/shade.c");
    let text = std::fs::read_to_string(&shade).expect("it was written");
    let changed = text.replacen(
        "float4 diffuse = kd;",
        "float4 diffuse = srp_splat(1.0f) - kd;",
        1,
    );
    assert!(text != changed);
    std::fs::write(&shade, changed).expect("it can be written");
    assert!(ours != picture("changed.png", &mine));

    // Every command about frames has them, and no command takes what it knows of others for theirs.
    let measured = |args: &[&str]| -> [String; 2] {
        [&[][..], &mine].map(|kernels| {
            let output = srp(&folder, &[args, &LIT, kernels].concat());
            assert_eq!(output.status.code(), Some(0), "{args:?} {kernels:?}");
            String::from_utf8_lossy(&output.stdout).into_owned()
        })
    };
    let psnr = |report: &str| {
        let report: serde_json::Value = serde_json::from_str(report).expect("it is JSON");
        report["trials"][0]["all"]["psnr"].as_f64()
    };
    let one_knob = ["--knob", "T&I reciprocal", "--trials", "1", "--json"];
    let accuracy = [&["accuracy", "--size", "16x12"], &one_knob[..]].concat();
    let [own, changed] = measured(&accuracy).map(|report| psnr(&report));
    assert!(own > changed && changed.is_some(), "{own:?} {changed:?}");
    for args in [
        &["effects", "--no-costs"][..],
        &["fidelity", "--size", "8x6", "--json"],
        &["paper", "table6", "--size", "16x12", "--fidelity", "cycle"],
    ] {
        let [own, changed] = measured(args);
        assert!(own != changed, "{args:?}");
    }
}
