//! Flags that are alike everywhere: colours, quiet, standard output, and status 2 for what is wrong with arguments.

use super::{folder, misused, srp, write};
use std::path::Path;
use std::process::{Command, Output};

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
