//! Inputs that are no files of their kind, and outputs that are inputs: refused, with nothing written.

use super::{TRIANGLE, folder, refused, srp, write};
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn inputs_that_never_end_are_refused() {
    let folder = folder("endless");
    let pipe = Command::new("mkfifo").arg(folder.join("pipe.c")).status();
    assert!(pipe.is_ok_and(|made| made.success()), "mkfifo is there");
    let says = ["no regular file"];
    refused(&folder, &["run", "pipe.c"], &says);
    refused(&folder, &["run", "/dev/zero"], &says);
    refused(
        &folder,
        &["map", "/dev/zero", "--mesh", "2x2"],
        &["/dev/zero"],
    );
    refused(&folder, &["machine", "check", "/dev/zero"], &says);
    refused(&folder, &["render", "/dev/zero"], &["/dev/zero"]);
    write(
        &folder,
        "include.c",
        "#include \"/dev/zero\"\nint main(void) { return 0; }\n",
    );
    refused(&folder, &["run", "include.c"], &["include.c:1:1"]);
    write(
        &folder,
        "library.obj",
        &format!("mtllib /dev/zero\n{TRIANGLE}"),
    );
    let rendered = srp(
        &folder,
        &[
            "render",
            "library.obj",
            "--size",
            "8x8",
            "--engine",
            "interp",
        ],
    );
    let said = String::from_utf8_lossy(&rendered.stderr);
    assert!(said.contains("/dev/zero"), "{said}");
}

#[test]
fn an_output_is_never_an_input_or_two_outputs() {
    let folder = folder("overwriting");
    let program = "int main(void) { return 0; }\n";
    write(&folder, "t.c", program);
    write(&folder, "tri.obj", TRIANGLE);
    let text = |name: &str| fs::read_to_string(folder.join(name)).expect("it is there");
    refused(
        &folder,
        &["report", "t.c", "--html", "t.c"],
        &["t.c", "of this command"],
    );
    refused(
        &folder,
        &["render", "tri.obj", "-o", "tri.obj"],
        &["tri.obj", "of this command"],
    );
    let linked = Path::new(&folder).join("link.obj");
    std::os::unix::fs::symlink("tri.obj", linked).expect("it can be made");
    refused(
        &folder,
        &["render", "tri.obj", "-o", "link.obj"],
        &["of this command"],
    );
    refused(
        &folder,
        &["render", "-o", "same.png", "--report", "./same.png"],
        &["another output"],
    );
    assert_eq!(text("t.c"), program);
    assert_eq!(text("tri.obj"), TRIANGLE);
}

#[test]
fn names_from_files_stay_inside_the_folder() {
    let folder = folder("names");
    let program = "int a[8]; int main(void) {\n#pragma srp kernel\n    \
                   for (int i = 0; i < 8; i++) a[i] = i;\n    return 0; }\n";
    write(&folder, "t.c", program);
    fs::create_dir(folder.join("out")).expect("it can be made");
    let emit = ["compile", "t.c", "--emit", "dre", "-o", "out"];
    assert!(srp(&folder, &emit).status.success());
    let dre = fs::read_to_string(folder.join("out/t.dre.xml")).expect("it was written");
    let escaping = dre.replace("\"main\"", "\"../../escaped\"");
    assert_ne!(escaping, dre);
    write(&folder, "escaping.dre.xml", &escaping);
    srp(
        &folder,
        &["compile", "escaping.dre.xml", "--emit", "dfg", "-o", "out"],
    );
    assert!(!folder.join("../escaped.dot").exists());
    assert!(!folder.join("escaped.dot").exists());
}

/// Neither a program nor a scene of a stranger shows what stands in other files.
#[test]
fn files_of_other_kinds_are_not_quoted() {
    let folder = folder("foreign_files");
    write(
        &folder,
        "secrets",
        "root:x:0:0:root:/root:/bin/bash\nword = hunter2\n",
    );
    write(
        &folder,
        "thief.c",
        "#include \"secrets\"\nint main(void) { return 0; }\n",
    );
    write(&folder, "thief.obj", &format!("mtllib secrets\n{TRIANGLE}"));
    for command in [["run", "thief.c"], ["render", "thief.obj"]] {
        let output = srp(&folder, &command);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("secrets"), "{said}");
        for word in ["root", "bash", "hunter2", "word"] {
            assert!(!said.contains(word), "{command:?}: {said}");
        }
    }
    // A header with a mistake is shown as ever.
    write(&folder, "common.h", "int f(void { return 1; }\n");
    write(
        &folder,
        "user.c",
        "#include \"common.h\"\nint main(void) { return f(); }\n",
    );
    let said = srp(&folder, &["run", "user.c"]);
    let said = String::from_utf8_lossy(&said.stderr);
    assert!(said.contains("int f(void {"), "{said}");
}

/// Text appears while the program that prints it runs, and a program whose reader goes away ends.
#[test]
fn a_program_that_prints_for_ever_is_read_as_it_runs() {
    let folder = folder("printing");
    let program =
        "#include <stdio.h>\nint main(void) { for (int i = 0;; i++) printf(\"line %d\\n\", i); }\n";
    write(&folder, "forever.c", program);
    for engine in ["interp", "auto"] {
        let mut running = Command::new(env!("CARGO_BIN_EXE_srp"))
            .current_dir(&folder)
            .args(["run", "forever.c", "--engine", engine])
            .env("SRP_CACHE", folder.with_extension("cache"))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command can be started");
        let text = running.stdout.take().expect("it is piped");
        let mut lines = BufReader::new(text).lines().map_while(Result::ok);
        let read: Vec<String> = lines.by_ref().take(3).collect();
        assert_eq!(read, ["line 0", "line 1", "line 2"], "{engine}");
        drop(lines);
        let ended = running.wait().expect("it ends");
        assert_eq!(ended.code(), Some(0), "{engine}");
    }
}
