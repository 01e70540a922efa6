//! Banks of the SRAM: everything that counts the cycles of a program counts those that banks cost.

use super::{cache, folder, srp, write};
use serde_json::Value;
use std::fs::File;
use std::process::Command;

const PROGRAM: &str = "
static int a[256], b[256], c[256];
int main(void)
{
    int s = 0;
    for (int i = 0; i < 256; i++) { a[i] = i; b[i] = 3 * i; }
    for (int i = 0; i < 256; i++) c[i] = a[i] + b[i];
    for (int i = 0; i < 256; i++) s += c[i];
    return s != 4 * 255 * 128;
}
";

#[test]
fn conflicts_are_cycles_everywhere() {
    let folder = folder("banks");
    write(&folder, "main.c", PROGRAM);
    let sgrt = srp(&folder, &["machine", "source", "sgrt"]).stdout;
    let sgrt = String::from_utf8(sgrt).expect("it is text");
    let banked = sgrt.replace(
        "<sram size=\"240K\"",
        "<sram size=\"240K\" banks=\"4\" width=\"4\"",
    );
    assert_ne!(banked, sgrt);
    write(&folder, "banks.xml", &banked);
    let said = |line: &str| {
        let output = srp(&folder, &line.split(' ').collect::<Vec<_>>());
        let talk = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{line}: {talk}");
        (String::from_utf8(output.stdout).expect("it is text"), talk)
    };
    let cycles = |line: &str| -> Value {
        let document: Value = serde_json::from_str(&said(line).0).expect("it is JSON");
        document["cycles"].clone()
    };
    let number = |cycles: &Value, name: &str| cycles[name].as_u64().expect("a number");
    let plain = cycles("run main.c --json");
    let kept = cycles("run main.c --json --machine banks.xml --engine interp");
    assert_eq!(
        kept,
        cycles("run main.c --json --machine banks.xml --engine csim")
    );
    let (all, lost) = (number(&kept, "all"), number(&kept, "sram_stall"));
    // Each of 256 sums loads two words and stores one, 1,024 bytes apart from each other: all are in one bank.
    assert!(lost >= 2 * 256, "{kept}");
    assert_eq!(number(&plain, "sram_stall"), 0);
    assert_eq!(number(&plain, "all") + lost, all);
    said("run main.c --machine banks.xml --profile profile.json");
    let profile = std::fs::read(folder.join("profile.json")).expect("it was written");
    let profile: Value = serde_json::from_slice(&profile).expect("it is JSON");
    assert_eq!(profile["parts"]["sram_stall"].as_u64(), Some(lost));
    for page in ["page.html", "page.txt"] {
        said(&format!("run main.c --machine banks.xml --profile {page}"));
        let page = std::fs::read_to_string(folder.join(page)).expect("it was written");
        assert!(
            page.contains("the core stands still for banks of its SRAM"),
            "{page}"
        );
    }
    // The debugger goes through them one by one, and tells of those in which the core does something.
    let commands = "break cycle:1000\nrun\ncycle 7\ncontinue\nquit\n";
    write(&folder, "commands", commands);
    let debug = Command::new(env!("CARGO_BIN_EXE_srp"))
        .current_dir(&folder)
        .args(["debug", "main.c", "--machine", "banks.xml", "--terminal"])
        .env("SRP_CACHE", cache())
        .stdin(File::open(folder.join("commands")).expect("it was written"))
        .output()
        .expect("the command can be started");
    let debug = String::from_utf8_lossy(&debug.stdout);
    let end = format!("ended with status 0 after {all} cycles");
    assert!(
        debug.contains("cycle 1000:") && debug.contains(&end),
        "{all}: {debug}"
    );
    let (_, talk) =
        said("run main.c --machine banks.xml --trace 0..100000 --trace-output t.pftrace");
    assert!(talk.contains(&format!("cycles 0..{all} ")), "{all}: {talk}");
    let (_, talk) = said("tandem main.c --machine banks.xml");
    assert!(talk.contains("agreed"), "{talk}");
}
