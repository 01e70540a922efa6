//! Mistakes in files are told as the user's, with file, line, column and a caret.

use super::{TRIANGLE, folder, refused, srp, write};
use std::path::Path;

/// What the command says of a file that is wrong, with the line of the place and a caret under it.
fn told(folder: &Path, args: &[&str], says: &[&str]) {
    let output = srp(folder, args);
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    assert_eq!(output.status.code(), Some(1), "srp {args:?}: {said}");
    for part in says.iter().chain(&[" | ", "^"]) {
        assert!(
            said.contains(part),
            "srp {args:?} does not say {part:?}:\n{said}"
        );
    }
    for ours in ["mistake of the", "panicked", "internal"] {
        assert!(!said.contains(ours), "srp {args:?}: {said}");
    }
}

const LOOP: &str = "int a[8], b[8];\nint main(void)\n{\n    #pragma srp kernel\n    \
                    for (int i = 0; i < 8; i++)\n        b[i] = 2 * a[i];\n    return b[7];\n}\n";

/// Every form of a program that a user may edit.
#[test]
fn mistakes_in_later_forms_have_places() {
    let folder = folder("later_forms");
    write(&folder, "double.c", LOOP);
    let emit = ["--emit", "ir,dre,schedule", "--machine", "tiny", "-o", "."];
    assert!(
        srp(&folder, &[&["compile", "double.c"], &emit[..]].concat())
            .status
            .success()
    );
    let edited = |name: &str, from: &str, to: &str| {
        let form = name.split_once('.').expect("an ending").1;
        let path = folder.join(format!("double.{form}"));
        let right = std::fs::read_to_string(path).expect("it was written");
        let wrong = right.replacen(from, to, 1);
        assert_ne!(wrong, right, "there is {from} in\n{right}");
        write(&folder, name, &wrong);
        let line = 1 + right[..right.find(from).expect("found")]
            .matches('\n')
            .count();
        format!("{name}:{line}:")
    };
    let run = |name: &'static str| ["run", name, "--machine", "tiny"];
    let at = edited("a.ir", "= lw ", "= lww ");
    told(&folder, &run("a.ir"), &[&at, "lww"]);
    // A vector where the next line wants a word.
    edited("h.ir", "= lw ", "= lv ");
    told(&folder, &run("h.ir"), &["h.ir:17:", "= shl v"]);
    let at = edited("b.ir", "main fn", "main gn");
    told(&folder, &run("b.ir"), &[&at]);
    let at = edited("c.ir", "ret v", "ret w");
    told(&folder, &run("c.ir"), &[&at]);
    let at = edited("d.dre.xml", "op=\"lw\"", "op=\"lww\"");
    told(&folder, &run("d.dre.xml"), &[&at, "lww"]);
    let at = edited(
        "e.sched.xml",
        "<place node=\"n0\" fu=\"",
        "<place node=\"n0\" fu=\"x",
    );
    told(&folder, &run("e.sched.xml"), &[&at]);
    let rules = "this schedule breaks the machine's rules";
    let at = edited("f.sched.xml", "<schedule ii=\"", "<schedule ii=\"1000");
    told(&folder, &run("f.sched.xml"), &[&at, rules, "kernel `main`"]);
    let at = edited(
        "g.sched.xml",
        "<launch ",
        "<return link=\"word[0]\"/></bundle><bundle id=\"more\"><launch ",
    );
    told(&folder, &run("g.sched.xml"), &[rules, &at]);
}

/// Schedules of loops by themselves, which `srp map` writes.
#[test]
fn mistakes_in_schedules_of_loops_have_places() {
    let folder = folder("loop_schedules");
    write(
        &folder,
        "g.dot",
        "digraph g { a [op=load]; b [op=store]; a -> b; }\n",
    );
    let mesh = [
        "machine", "mesh", "--rows", "2", "--cols", "2", "-o", "mesh.xml",
    ];
    assert!(srp(&folder, &mesh).status.success());
    let map = ["map", "g.dot", "--machine", "mesh.xml", "-o", "g.sched.xml"];
    assert!(srp(&folder, &map).status.success());
    let right = std::fs::read_to_string(folder.join("g.sched.xml")).expect("it was written");
    let wrong = right.replacen(" ii=\"", " ii=\"100", 1);
    assert_ne!(right, wrong);
    write(&folder, "wrong.sched.xml", &wrong);
    let report = ["report", "wrong.sched.xml", "--machine", "mesh.xml"];
    told(&folder, &report, &["wrong.sched.xml:", "kernel `g`"]);
}

#[test]
fn mistakes_in_data_have_places() {
    let folder = folder("data");
    write(&folder, "tri.obj", TRIANGLE);
    let tni = |more: &[&'static str]| [&["tni", "tri.obj"][..], more].concat();
    let view = "{\"position\":[0,0,3],\"forward\":[0,0,0],\"fov_deg\":40}";
    let cameras = format!("{{\"tri\":{{\"up\":[0,1,0],\n \"views\":[\n  {view}]}}}}\n");
    write(&folder, "c.json", &cameras);
    told(
        &folder,
        &tni(&["--cameras", "c.json:tri"]),
        &["c.json:3:3", "direction"],
    );
    write(&folder, "d.json", &cameras.replace("40", "\"wide\""));
    told(&folder, &tni(&["--cameras", "d.json:tri"]), &["d.json:3:"]);
    write(&folder, "r.rays", "0 0 3 0 0 -1\n0 0 x 0 0 -1\n");
    told(
        &folder,
        &tni(&["--rays", "file", "--ray-file", "r.rays"]),
        &["r.rays:2:5"],
    );
    write(&folder, "p.json", "{\"format\": 1,\n  \"x\": tru}\n");
    told(&folder, &["diff", "p.json", "p.json"], &["p.json:2:"]);
    write(&folder, "t.trace", "0x40 READ 0\n0x40 TAKE 0\n");
    told(&folder, &["dram", "t.trace"], &["t.trace:2:6"]);
}

/// A format that does not fit is a warning, and one missing semicolon one error.
#[test]
fn formats_and_semicolons_are_told_of() {
    let folder = folder("c_words");
    let text =
        "#include <stdio.h>\nint main(void)\n{\n    printf(\"%s\\n\", 5);\n    return 0;\n}\n";
    write(&folder, "f.c", text);
    let compile = ["compile", "f.c", "--emit", "ir", "-o", "."];
    let said = String::from_utf8_lossy(&srp(&folder, &compile).stderr).into_owned();
    assert!(
        said.contains("f.c:4:13") && said.contains("warning[C0921]"),
        "{said}"
    );
    refused(
        &folder,
        &["run", "f.c", "-W", "error=format"],
        &["f.c:4:13"],
    );
    let silent = [
        "compile",
        "f.c",
        "--emit",
        "ir",
        "-W",
        "no-format",
        "-o",
        ".",
    ];
    assert!(!String::from_utf8_lossy(&srp(&folder, &silent).stderr).contains("C0921"));
    write(
        &folder,
        "s.c",
        "typedef int number\nnumber one = 1;\nint main(void)\n{\n    number n = one\n    return n;\n}\n",
    );
    refused(
        &folder,
        &["run", "s.c"],
        &["s.c:2:1", "s.c:6:5", "\n2 errors"],
    );
}

/// A machine whose contexts hold no constants runs no control code, and the program's first constant says so.
#[test]
fn a_machine_without_constants_is_refused_in_words() {
    let folder = folder("no_constants");
    write(&folder, "double.c", LOOP);
    let args = ["run", "double.c", "--set", "fu-type[*].constants=0"];
    let output = srp(&folder, &args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("room for constants"), "{said}");
}

/// Conditions that are the same in every iteration wait in registers of their own kind: the reason names those.
#[test]
fn what_finds_no_register_before_a_loop_is_named() {
    let folder = folder("conditions");
    let conditions: String = (1..=18)
        .map(|c| format!("if (n > {c}) s = s * {c} + 1;\n"))
        .collect();
    let text = format!(
        "int x[64];\nvoid f(int n) {{\nfor (int i = 0; i < 64; i++) {{ int s = x[i]; {conditions} x[i] = s; }}\n}}\n\
         int main(void) {{ f(x[3]); return 0; }}\n"
    );
    write(&folder, "many.c", &text);
    let said = |args: &[&str]| {
        let output = srp(&folder, args);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let few = said(&["run", "many.c", "-R", "pass"]);
    assert!(
        few.contains("18 conditions from before the loop wait"),
        "{few}"
    );
    assert!(few.contains("of which 16 hold such"), "{few}");
    let more = said(&[
        "run",
        "many.c",
        "-R",
        "pass",
        "--set",
        "file[name=pred].size=32",
    ]);
    assert!(more.contains("is on the array"), "{more}");
}

/// The copies of a loop that inlining has made have one reason: it is told once.
#[test]
fn copies_of_a_loop_are_told_once() {
    let folder = folder("copies");
    write(
        &folder,
        "gcd.c",
        "int x[8];\n\
         static int gcd(int a, int b) { while (b) { int t = a % b; a = b; b = t; } return a; }\n\
         int main(void) { x[0] = gcd(x[1], x[2]); x[3] = gcd(x[4], x[5]); x[6] = gcd(x[7], x[2]); return 0; }\n",
    );
    let output = srp(&folder, &["run", "gcd.c", "-R", "pass"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.matches("is not on the array").count(), 1, "{said}");
    assert!(
        said.contains("gcd (and gcd_2, gcd_3) is not on the array"),
        "{said}"
    );
}
