//! Kernels that are ready in the place of those that a scene calls for.

use super::{folder, srp_apart};
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};

/// A frame, whose kernels are scheduled soon.
const FRAME: [&str; 4] = ["--size", "16x12", "--effort", "0.02"];

/// Renders a frame of the default scene, with more arguments. Returns what was printed and said, and the picture.
fn render(folder: &Path, args: &[&str]) -> (Output, Vec<u8>) {
    let output = srp_apart(folder, &[&["render"], &FRAME[..], args].concat());
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let picture = std::fs::read(folder.join("out.png")).unwrap_or_default();
    (output, picture)
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The effects of the kernels that would be taken, and of those that the scene calls for.
fn ready(folder: &Path, args: &[&str]) -> (serde_json::Value, serde_json::Value) {
    let output = srp_apart(
        folder,
        &[&["effects", "--no-costs", "--json"], &FRAME[..], args].concat(),
    );
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    (json["ready"].clone(), json["built"].clone())
}

/// Waits until a process that goes on by itself has done its work.
fn wait(what: &str, done: impl Fn() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < Duration::from_secs(300), "{what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

#[test]
fn what_is_ready_is_taken_and_what_is_called_for_is_made_beside_it() {
    let folder = folder("ready");
    // Nothing is ready; more than the scene calls for is made so.
    assert!(ready(&folder, &[]).0.is_null());
    let (_, nothing) = render(&folder, &["--prepare", "--effects", "+emission"]);
    assert!(nothing.is_empty(), "kernels are only scheduled");

    let (taken, by_more) = render(&folder, &["--ready"]);
    let text = said(&taken);
    assert!(text.contains("calls for: emission\n"), "{text}");
    assert!(text.contains("for the next time"), "{text}");
    let (asked, _) = render(&folder, &["--effects", "+emission"]);
    assert_eq!(
        taken.stdout, asked.stdout,
        "its cycles are those of the kernels"
    );

    // What the process beside it made is taken the next time, and nothing is said or started.
    wait("the kernels are made", || {
        let (ready, built) = ready(&folder, &[]);
        ready == built
    });
    let (taken, by_own) = render(&folder, &["--ready"]);
    assert!(!said(&taken).contains("ready"), "{}", said(&taken));
    assert!(!said(&taken).contains("process"), "{}", said(&taken));
    assert!(by_more == by_own, "the picture is the same");
    assert_ne!(taken.stdout, asked.stdout, "the cycles are not");

    // Kernels of another machine, with other forms, or with less room do not serve.
    for other in [
        &["--set", "vliw.branch-delay=2"][..],
        &["--form", "colour=f16"],
        &["--bounces", "5"],
        &["--samples", "2"],
    ] {
        let (ready, _) = ready(&folder, other);
        assert!(ready.is_null(), "{other:?}: {ready}");
    }
    let (kept, _) = ready(&folder, &["--bounces", "0"]);
    assert!(kept.is_array(), "room for more bounces serves");
}
