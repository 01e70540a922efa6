//! Flags that are alike everywhere: colours, quiet, standard output, and status 2 for what is wrong with arguments.

use super::{folder, misused, srp, write};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs the command with only these of the variables about colours.
fn with(folder: &Path, variables: &[(&str, &str)], args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.current_dir(folder).args(args);
    command.env("SRP_CACHE", folder.with_extension("cache"));
    for name in ["NO_COLOR", "CLICOLOR_FORCE"] {
        command.env_remove(name);
    }
    command.envs(variables.iter().copied());
    command.output().expect("the command can be started")
}

#[test]
fn colours_are_as_asked_for() {
    let folder = folder("flags-colours");
    write(&folder, "wrong.c", "int main(void) { return x; }\n");
    let force = ("CLICOLOR_FORCE", "1");
    type Case<'a> = (&'a [(&'a str, &'a str)], &'a [&'a str], bool);
    let cases: [Case<'_>; 7] = [
        (&[], &[], false),
        (&[], &["--color", "always"], true),
        (&[force], &[], true),
        (&[("CLICOLOR_FORCE", "0")], &[], false),
        (&[force, ("NO_COLOR", "1")], &[], false),
        (&[force], &["--color", "never"], false),
        (&[("NO_COLOR", "1")], &["--color=always"], true),
    ];
    for (variables, flags, coloured) in cases {
        for args in [
            [flags, &["run", "wrong.c"]].concat(),
            [&["run", "wrong.c"], flags].concat(),
        ] {
            let output = with(&folder, variables, &args);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(said.contains("wrong.c"), "{said}");
            assert_eq!(
                said.contains('\u{1b}'),
                coloured,
                "{variables:?} {args:?}: {said}"
            );
        }
    }
}

#[test]
fn quiet_says_nothing_but_errors() {
    let folder = folder("flags-quiet");
    write(&folder, "f.c", "int main(void) { return 0; }\n");
    write(&folder, "wrong.c", "int main(void) { return x; }\n");
    for args in [
        &["-q", "run", "f.c"][..],
        &["compile", "f.c", "--quiet"],
        &["machine", "check", "-q"],
    ] {
        let output = srp(&folder, args);
        assert_eq!(output.status.code(), Some(0));
        assert!(
            output.stderr.is_empty(),
            "{args:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let output = srp(&folder, &["-q", "run", "wrong.c"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("wrong.c:1:25"));
}

/// Runs the command with a text on its standard input.
fn given(folder: &Path, text: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_srp"));
    command.current_dir(folder).args(args);
    command.env("SRP_CACHE", folder.with_extension("cache"));
    command.stdin(Stdio::piped());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command can be started");
    let mut input = child.stdin.take().expect("it has one");
    // A command that refuses its arguments reads nothing.
    let _ = input.write_all(text.as_bytes());
    drop(input);
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_hyphen_is_standard_input() {
    let folder = folder("flags-input");
    let program = "int main(void) { return 3; }\n";
    let run = given(&folder, program, &["run", "-"]);
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(3), "{said}");
    let confined = given(&folder, program, &["run", "-", "--untrusted"]);
    assert_eq!(confined.status.code(), Some(3));
    let both = given(
        &folder,
        program,
        &["compile", "-", "--emit", "ir", "-o", "-"],
    );
    write(&folder, "f.c", program);
    let file = srp(&folder, &["compile", "f.c", "--emit", "ir", "-o", "-"]);
    assert_eq!(both.status.code(), Some(0));
    let named = String::from_utf8_lossy(&file.stdout).replace("f.c", "-");
    assert_eq!(String::from_utf8_lossy(&both.stdout), named);
    let machine = srp(&folder, &["machine", "source", "tiny"]).stdout;
    let machine = String::from_utf8(machine).expect("it is text");
    // A graph's form is seen from its first letter.
    for graph in [
        "digraph g { x [op=add]; x -> x [distance=1]; }",
        " {\"nodes\": [{\"id\": \"x\", \"op\": \"add\"}], \"edges\": []}",
    ] {
        for args in [
            &["map", "-", "--mesh", "2x2"][..],
            &["map", "-", "--mesh", "2x2", "--untrusted"],
        ] {
            let mapped = given(&folder, graph, args);
            let table = String::from_utf8_lossy(&mapped.stdout);
            assert_eq!(mapped.status.code(), Some(0), "{graph} {args:?}: {table}");
            assert!(table.contains("1 of 1 graphs mapped"), "{table}");
        }
    }
    let area = given(&folder, &machine, &["area", "--machine", "-", "--json"]);
    assert_eq!(area.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&area.stdout).contains("\"tiny\""));
    let wrong = given(&folder, "int main(void) { return x; }\n", &["run", "-"]);
    let said = String::from_utf8_lossy(&wrong.stderr);
    assert_eq!(wrong.status.code(), Some(1));
    assert!(
        said.contains("-:1:25") && said.contains("return x;"),
        "{said}"
    );
}

#[test]
fn verbose_tells_how_long_stages_took() {
    let folder = folder("flags-verbose");
    write(&folder, "f.c", "int main(void) { return 0; }\n");
    let render = ["render", "--size", "8x6", "--fidelity", "functional"];
    let usual = srp(&folder, &render);
    let verbose = srp(&folder, &[&render[..], &["-v"]].concat());
    let said = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let is_time = |line: &str| line.contains(": ") && line.ends_with(" s");
    assert!(!said(&usual).lines().any(is_time), "{}", said(&usual));
    assert!(said(&verbose).lines().any(is_time), "{}", said(&verbose));
    assert_eq!(usual.stdout, verbose.stdout);
    misused(&folder, &["run", "f.c", "-q", "-v"], &["--quiet"]);
}

#[test]
fn names_that_mean_nothing_are_arguments_at_fault() {
    let folder = folder("flags-names");
    write(&folder, "f.c", "int main(void) { return N; }\n");
    assert_eq!(
        srp(&folder, &["run", "f.c", "-D", "N=7"]).status.code(),
        Some(7)
    );
    assert_eq!(srp(&folder, &["run", "f.c", "-DN"]).status.code(), Some(1));
    for define in ["3x", "A B=3", "=3", "", "A-b=3", "A(x)=x"] {
        misused(&folder, &["run", "f.c", "-D", define], &["NAME=VALUE"]);
    }
    let glow = ["render", "--size", "8x6", "--effects", "+glow"];
    misused(&folder, &glow, &["glow", "shadow"]);
}

#[test]
fn one_form_goes_to_standard_output() {
    let folder = folder("flags-output");
    let text = "int a[8];\nint main(void)\n{\n    for (int i = 0; i < 8; i++)\n        a[i] = i;\n    return a[0];\n}\n";
    write(&folder, "f.c", text);
    for (form, ending) in [
        ("ast", "ast"),
        ("ir", "ir"),
        ("dfg", "main.dot"),
        ("dre", "dre.xml"),
        ("schedule", "sched.xml"),
    ] {
        let printed = srp(&folder, &["compile", "f.c", "--emit", form, "-o", "-"]);
        assert_eq!(
            printed.status.code(),
            Some(0),
            "{form}: {}",
            String::from_utf8_lossy(&printed.stderr)
        );
        srp(&folder, &["compile", "f.c", "--emit", form, "-o", "out"]);
        let written =
            std::fs::read(folder.join(format!("out/f.{ending}"))).expect("it was written");
        assert!(printed.stdout == written, "{form}");
    }
    misused(
        &folder,
        &["compile", "f.c", "--emit", "ir,dre", "-o", "-"],
        &["several forms"],
    );
    misused(
        &folder,
        &["compile", "f.c", "--emit", "rust", "-o", "-"],
        &["folder"],
    );
    misused(
        &folder,
        &["compile", "f.c", "--json", "-o", "-"],
        &["--json"],
    );
    misused(
        &folder,
        &["sweep", "--set", "array.rows=4", "-o", "-"],
        &["name a folder"],
    );
    assert!(!folder.join("-").exists());
}

#[test]
fn wrong_arguments_end_with_status_2() {
    let folder = folder("flags-status");
    write(&folder, "g.dot", "digraph { a [op=add]; }");
    write(&folder, "f.c", "int main(void) { return 0; }\n");
    let cases: &[(&[&str], &str)] = &[
        (&["--explain", "X9999"], "X9999"),
        (&["--explain", "C0502", "area"], "--explain"),
        (&["-q"], "command"),
        (&["area", "--color", "blue"], "blue"),
        (&["run", "f.c", "-W", "no-such-warning"], "no-such-warning"),
        (
            &["run", "f.c", "--engine", "ir", "--loops", "l.txt"],
            "--loops",
        ),
        (&["render", "--camera", "1,2"], "1,2"),
        (&["render", "--cameras", "views.json"], "NAME/N"),
        (&["render", "-W", "no-such-warning"], "no-such-warning"),
        (&["render", "--form", "no-such=1"], "no-such"),
        (
            &["map", "g.dot", "--mesh", "2x2", "--any-op", "branch"],
            "branch",
        ),
        (
            &["map", "g.dot", "--mesh", "2x2", "--ops", "x.ops"],
            "--ops",
        ),
        (
            &[
                "machine", "mesh", "--rows", "2", "--cols", "2", "--ops", "no-such", "-o", "m.xml",
            ],
            "no-such",
        ),
        (&["hard-cases", "--filter", "no-such"], "identifier"),
        (&["accuracy", "--knob", "no-such"], "no-such"),
        (&["schema", "no-such"], "srp-report"),
        (&["dram"], "TRACE"),
    ];
    for (args, says) in cases {
        misused(&folder, args, &[says]);
    }
}
