//! Inputs that are at fault end with status 1 and a message that says where; nothing is left behind.

use super::{TRIANGLE, folder, refused, srp, stdout, write};
use std::process::Command;

#[test]
fn scenes_at_fault_are_refused() {
    let folder = folder("scenes");
    write(&folder, "truncated.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2");
    write(&folder, "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write(
        &folder,
        "nan.obj",
        &TRIANGLE.replace("v 1 0 0", "v 1 nan 0"),
    );
    refused(&folder, &["render", "missing.obj"], &["missing.obj"]);
    refused(&folder, &["render", "truncated.obj"], &["truncated.obj:4:"]);
    refused(&folder, &["render", "range.obj"], &["range.obj:4:7"]);
    refused(&folder, &["render", "nan.obj"], &["nan.obj:2:5"]);
}

#[test]
fn machines_at_fault_are_refused() {
    let folder = folder("machines");
    let machine = include_str!("../../archdesc/machines/tiny.xml");
    let copy = srp(&folder, &["machine", "source", "tiny"]).stdout;
    assert_eq!(String::from_utf8_lossy(&copy), machine, "a copy to edit");
    refused(
        &folder,
        &["machine", "show", "tinny"],
        &["sgrt, decoupled, fpga, tiny, wide"],
    );
    let sgrt = include_str!("../../archdesc/machines/sgrt.xml");
    let long = "<trv-l1 size=\"16K\" ways=\"2\" line=\"128\"";
    let lines = sgrt.replacen("<trv-l1 size=\"16K\" ways=\"2\" line=\"64\"", long, 1);
    assert_ne!(lines, sgrt);
    write(&folder, "lines.xml", &lines);
    let wrong = [
        "lines.xml",
        "cannot be simulated",
        "of 128: make it a multiple",
    ];
    refused(&folder, &["machine", "check", "lines.xml"], &wrong);
    let unknown = machine.replacen("<array rows=", "<array colour=\"blue\" rows=", 1);
    assert_ne!(unknown, machine);
    write(&folder, "unknown.xml", &unknown);
    let dangling = machine.replacen(
        "</array>",
        "<link from=\"fu_9_9\" to=\"fu_0_0\"/></array>",
        1,
    );
    assert_ne!(dangling, machine);
    write(&folder, "dangling.xml", &dangling);
    refused(
        &folder,
        &["machine", "check", "unknown.xml"],
        &["unknown.xml:", "colour"],
    );
    refused(
        &folder,
        &["render", "--machine", "dangling.xml"],
        &["dangling.xml:", "fu_9_9"],
    );
}

#[test]
fn programs_at_fault_are_refused() {
    let folder = folder("programs");
    write(
        &folder,
        "syntax.c",
        "int main(void)\n{\n    return 1 +;\n}\n",
    );
    write(
        &folder,
        "type.c",
        "int main(void)\n{\n    int *p = 1.5f;\n    return *p;\n}\n",
    );
    write(
        &folder,
        "unsupported.c",
        "int main(void)\n{\n    _Complex float z;\n    return 0;\n}\n",
    );
    refused(&folder, &["run", "syntax.c"], &["syntax.c:3:15"]);
    refused(&folder, &["run", "type.c"], &["type.c:3:14"]);
    refused(
        &folder,
        &["compile", "unsupported.c"],
        &["unsupported.c:3:5"],
    );
}

/// An error that no unit of the machine keeps to is an error with its place; one that a unit keeps to is none.
#[test]
fn an_error_that_no_unit_keeps_to_is_refused() {
    let folder = folder("max_ulp");
    let sgrt = include_str!("../../archdesc/machines/sgrt.xml");
    let coarse = sgrt.replace(
        "<array rows",
        "<special function=\"rcp\" bits=\"8\"/>\n  <array rows",
    );
    write(&folder, "coarse.xml", &coarse);
    let text =
        "#include <srp.h>\nvolatile float x = 3;\nint main(void) { return (int)srp_rcp(x); }\n";
    write(&folder, "one.c", text);
    let run = |ulp| ["run", "one.c", "--machine", "coarse.xml", "--max-ulp", ulp];
    refused(
        &folder,
        &run("100"),
        &["C0602", "one.c:3:30", "`rcp` to 100 units", "to 65537"],
    );
    stdout(&folder, &run("65537"), 0);
}

/// Traps: what is wrong, and the lines of the calls that are open.
const TRAPS: [(&str, &str, &[u32]); 3] = [
    ("10 / zero", "integer division by zero", &[3, 3, 4]),
    (
        "*(int *)(zero + 0x7fffff0)",
        "access of 4 bytes",
        &[3, 3, 4],
    ),
    ("down(n)", "stack overflow", &[3; 16]),
];

#[test]
fn traps_tell_their_place_and_the_open_calls() {
    let folder = folder("traps");
    for (trapping, what, lines) in TRAPS {
        let text = format!(
            "int zero, made[400];\nint down(int n)\n{{ int own[99]; own[n & 1] = n; int r = n ? down(n - 1) + 1 : {trapping}; return own[0] + r; }}\n\
             int main(void) {{ return down(2); }}\n"
        );
        write(&folder, "trap.c", &text);
        for engine in ["ir", "interp", "csim"] {
            let output = srp(&folder, &["run", "trap.c", "--engine", engine]);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_ne!(output.status.code(), Some(0), "{engine}: {message}");
            let head = message.lines().find(|line| line.contains(what));
            let head = head.unwrap_or_else(|| panic!("{engine} does not say {what:?}: {message}"));
            assert!(head.contains("trap.c:"), "{engine}: {message}");
            let calls = message.lines().filter_map(|line| {
                let place = line.trim().strip_prefix("called at trap.c:")?;
                place.split(':').next()?.parse::<u32>().ok()
            });
            // The call of `main` by the start code has the place of `main` or none.
            let calls: Vec<u32> = calls.take(lines.len()).collect();
            assert_eq!(calls, lines, "{engine}: {message}");
        }
    }
}

#[test]
fn what_is_no_text_is_refused() {
    let folder = folder("text");
    std::fs::write(folder.join("latin.ir"), b"int x;\n// na\xefve\n").expect("it can be written");
    refused(&folder, &["run", "latin.ir"], &["latin.ir", "0xef at 2:6"]);
    std::fs::create_dir(folder.join("folder.c")).expect("it can be made");
    refused(&folder, &["run", "folder.c"], &["folder.c"]);
}

/// Comments may hold any bytes, and strings keep theirs.
#[test]
fn sources_need_not_be_utf_8() {
    let folder = folder("latin");
    let text = b"/* na\xefve */\nint main(void)\n{\n    const char *s = \"\xe9t\xc3\xa9\\xe9\";\n    \
                 const unsigned char wanted[] = {0xe9, 't', 0xc3, 0xa9, 0xe9, 0};\n    \
                 for (int i = 0; i < 6; i++)\n        if ((unsigned char)s[i] != wanted[i]) return 1;\n    \
                 return '\xe9' != -23;\n}\n";
    std::fs::write(folder.join("latin.c"), text).expect("it can be written");
    let run = srp(&folder, &["run", "latin.c", "--engine", "ir"]);
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(0), "{said}");
}

#[test]
fn a_stack_that_does_not_fit_is_refused() {
    let folder = folder("stack");
    let text = "int a[64];\nint main(void)\n{\n    volatile int big[200000];\n    \
                for (int i = 0; i < 64; i++) big[i * 3000] = a[i];\n    return big[0];\n}\n";
    write(&folder, "deep.c", text);
    let says = [
        "deep.c:2:5: ",
        "variables of main need 800000 bytes of stack",
        "<sram size",
    ];
    refused(&folder, &["run", "deep.c"], &says);
    refused(&folder, &["compile", "deep.c"], &says);
}

/// Kernels by themselves have reports, schedules and simulators; only to run they need a `main`.
#[test]
fn kernels_need_no_main() {
    let folder = folder("kernels");
    let text = "void fill(int *p, int *q, int n)\n{\n#pragma srp kernel\n    for (int i = 0; i < n; i++)\n        \
                p[i] = q[i];\n}\n";
    write(&folder, "fill.c", text);
    refused(
        &folder,
        &["run", "fill.c", "--machine", "tiny"],
        &["no function `main`"],
    );
    let html = "fill.html";
    let report = srp(
        &folder,
        &["report", "fill.c", "--machine", "tiny", "--html", html],
    );
    assert!(report.status.success());
    let text = String::from_utf8_lossy(&report.stdout);
    assert!(text.contains("fill.c:4:5: fill at II = "), "{text}");
    assert!(text.contains("these two accesses may alias"), "{text}");
    let page = std::fs::read_to_string(folder.join(html)).expect("it was written");
    assert!(page.contains("fill.c:4:5") && page.ends_with("</html>"));

    let emit = ["--emit", "schedule,rust", "--machine", "tiny", "-o", "out"];
    let compiled = srp(&folder, &[&["compile", "fill.c"], &emit[..]].concat());
    let message = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{message}");
    assert!(folder.join("out/fill.sched.xml").is_file());
    // The simulator is a crate of its own, which rustc takes as it is.
    let rustc = Command::new("rustc")
        .args([
            "--edition=2024",
            "--crate-type=cdylib",
            "--emit=metadata",
            "lib.rs",
        ])
        .current_dir(folder.join("out/fill.csim"))
        .output();
    match rustc {
        Ok(output) => assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(e) => eprintln!("not compiled, for there is no rustc: {e}"),
    }
}

#[test]
fn schedules_that_break_rules_are_refused() {
    let folder = folder("schedules");
    let text = "int a[8], b[8];\nint main(void)\n{\n    #pragma srp kernel\n    \
                for (int i = 0; i < 8; i++)\n        b[i] = 2 * a[i];\n    return b[7];\n}\n";
    write(&folder, "double.c", text);
    let emit = ["--emit", "schedule", "--machine", "tiny", "-o", "."];
    let compiled = srp(&folder, &[&["compile", "double.c"], &emit[..]].concat());
    let message = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{message}");
    let path = folder.join("double.sched.xml");
    let right = std::fs::read_to_string(path).expect("it was written");
    let run = ["run", "wrong.sched.xml", "--machine", "tiny"];
    let broken = |from: &str, to: &str| {
        let wrong = right.replacen(from, to, 1);
        assert_ne!(wrong, right, "there is {from} in\n{right}");
        write(&folder, "wrong.sched.xml", &wrong);
    };
    let rules = "this schedule breaks the machine's rules: ";
    broken(" ii=\"", " ii=\"1000");
    let kernel = "double.c:5:5: kernel `main`: ";
    refused(
        &folder,
        &run,
        &[rules, kernel, "wrong.sched.xml:", "^^^^^^^^"],
    );
    broken(" length=\"", " length=\"1000");
    refused(&folder, &run, &["double.c:5:5: ", "overlap"]);
    broken(
        "<launch ",
        "<jump to=\"b0\"/></bundle><bundle id=\"more\"><launch ",
    );
    refused(&folder, &run, &[rules, "bundle b", "(ControlFlow)"]);
    write(&folder, "wrong.sched.xml", &right);
    let status = srp(&folder, &run).status.code();
    assert_eq!(status, Some(0), "nothing was wrong with it");
}

#[test]
fn an_output_that_cannot_be_written_is_refused() {
    let folder = folder("output");
    write(&folder, "kept.html", "kept");
    let kept = folder.join("kept.html");
    let mut permissions = std::fs::metadata(&kept).expect("it is there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&kept, permissions).expect("it is ours");
    refused(&folder, &["report", "--html", "kept.html"], &["kept.html"]);
    refused(&folder, &["render", "-o", "."], &["it is a folder"]);
    if let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") {
        let status = Command::new(env!("CARGO_BIN_EXE_srp"))
            .args(["machine", "expand"])
            .stdout(full)
            .status();
        assert_eq!(status.expect("it can be started").code(), Some(1));
    }
    refused(
        &folder,
        &["render", "-o", "no/such/folder/out.png"],
        &["no/such/folder/out.png"],
    );
    for args in [
        ["render", "--size", "0x4"],
        ["accuracy", "--threads", "1000000"],
    ] {
        let output = srp(&folder, &args);
        assert_eq!(output.status.code(), Some(2), "srp {args:?}");
    }
}
