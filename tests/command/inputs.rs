//! Inputs that are no files of their kind, too large, or elsewhere: refused, not quoted, or told.

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
    refused(&folder, &["run", "/dev/fd/../zero"], &["/dev/fd/../zero"]);
    refused(&folder, &["run", "."], &["it is a folder"]);
    write(
        &folder,
        "include.c",
        "#include \"/dev/zero\"\nint main(void) { return 0; }\n",
    );
    refused(&folder, &["run", "include.c"], &["include.c:1:1", says[0]]);
    // What a scene lacks is told, and the rest of it is rendered.
    for (library, texture) in [
        ("/dev/zero", ""),
        ("pipe.c", ""),
        ("/dev/stdin", ""),
        ("m.mtl", "/dev/zero"),
        ("m.mtl", "pipe.c"),
    ] {
        let obj = format!("mtllib {library}\nusemtl m\n{TRIANGLE}");
        write(&folder, "library.obj", &obj);
        write(
            &folder,
            "m.mtl",
            &format!(
                "newmtl m\nKd 1 1 1\n{}",
                match texture {
                    "" => String::new(),
                    texture => format!("map_Kd {texture}\n"),
                }
            ),
        );
        let said = rendered(&folder, "library.obj");
        assert!(said.contains(says[0]), "{library} {texture}: {said}");
    }
}

/// What a small picture of a scene tells.
fn rendered(folder: &Path, scene: &str) -> String {
    let size = ["--size", "8x8", "--fidelity", "functional", "-o", "out.png"];
    let output = srp(folder, &[&["render", scene][..], &size[..]].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    said
}

/// The page says the limits that there are.
#[test]
fn limits_are_documented() {
    use srp_toolchain::files::Kind;
    let page = include_str!("../../docs/reliability.md");
    let rows: Vec<&str> = page
        .lines()
        .skip_while(|l| !l.contains("| most, MiB |"))
        .collect();
    let rows: Vec<&str> = rows[2..]
        .iter()
        .copied()
        .take_while(|l| l.starts_with('|'))
        .collect();
    let row = |kind: &Kind| format!("| {} | {} |", kind.what(), kind.limit() >> 20);
    assert_eq!(rows, Kind::ALL.iter().map(row).collect::<Vec<_>>());
}

/// The tests that the page names are there.
#[test]
fn claims_have_tests() {
    let page = include_str!("../../docs/reliability.md");
    let (_, tests) = page.split_once("| claim | test |").expect("the table");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = String::new();
    let mut count = 0;
    for name in tests.split('`').skip(1).step_by(2) {
        if name.ends_with(".rs") {
            text = fs::read_to_string(root.join(name)).expect(name);
            continue;
        }
        let function = format!("#[test]\nfn {name}()");
        let inner = format!("#[test]\n    fn {name}()");
        assert!(text.contains(&function) || text.contains(&inner), "{name}");
        count += 1;
    }
    assert!(count > 20, "{count} tests are named");
}

/// Files of more bytes than their kind may have are refused by their length, whatever is in them.
#[test]
fn files_have_a_largest_size() {
    let folder = folder("large_files");
    let made = |name: &str, mebibytes: u64| {
        let file = fs::File::create(folder.join(name)).expect("it can be made");
        // A file with a hole takes no room.
        file.set_len((mebibytes << 20) + 1).expect("it can be long");
    };
    for (name, mebibytes, command) in [
        ("machine.xml", 16, &["machine", "check"][..]),
        ("source.c", 64, &["run"]),
        ("program.ir", 64, &["run"]),
        ("program.dre.xml", 64, &["run"]),
        ("program.sched.xml", 64, &["run"]),
        ("graph.dot", 16, &["map", "--mesh", "2x2"]),
        ("scene.obj", 1024, &["render"]),
        ("requests.trace", 1024, &["dram"]),
        ("plan.toml", 1, &["sweep"]),
    ] {
        made(name, mebibytes);
        let output = srp(&folder, &[command, &[name]].concat());
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert_eq!(output.status.code(), Some(1), "{name}: {said}");
        let limit = format!("larger than {mebibytes} MiB");
        assert!(said.contains(&limit), "{name}: {said}");
    }
    made("m.mtl", 16);
    made("t.png", 256);
    write(&folder, "a.obj", &format!("mtllib m.mtl\n{TRIANGLE}"));
    assert!(rendered(&folder, "a.obj").contains("larger than 16 MiB"));
    write(&folder, "n.mtl", "newmtl n\nmap_Kd t.png\n");
    write(
        &folder,
        "b.obj",
        &format!("mtllib n.mtl\nusemtl n\n{TRIANGLE}"),
    );
    assert!(rendered(&folder, "b.obj").contains("larger than 256 MiB"));
}

/// Some bytes that say they are a picture of a billion texels.
#[test]
fn pictures_do_not_burst() {
    let folder = folder("bombs");
    let mut chunk = b"IHDR".to_vec();
    chunk.extend(16_384u32.to_be_bytes());
    chunk.extend(16_384u32.to_be_bytes());
    chunk.extend([8, 6, 0, 0, 0]);
    let mut sum = !0u32;
    for byte in &chunk {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 {
                (sum >> 1) ^ 0xedb8_8320
            } else {
                sum >> 1
            };
        }
    }
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
    png.extend(&chunk);
    png.extend((!sum).to_be_bytes());
    png.extend(b"\0\0\0\x02IDAT\x78\xda\0\0\0\0");
    fs::write(folder.join("bomb.png"), png).expect("it can be written");
    write(&folder, "m.mtl", "newmtl m\nmap_Kd bomb.png\n");
    write(
        &folder,
        "a.obj",
        &format!("mtllib m.mtl\nusemtl m\n{TRIANGLE}"),
    );
    let said = rendered(&folder, "a.obj");
    assert!(said.contains("texels"), "{said}");
}

/// A note tells of files elsewhere that a program or a scene names.
#[test]
fn files_outside_of_the_folder_are_told() {
    let folder = folder("outside");
    for part in ["program", "library", "scene"] {
        fs::create_dir(folder.join(part)).expect("it can be made");
    }
    write(&folder, "library/one.h", "#define ONE 1\n");
    write(&folder, "library/m.mtl", "newmtl m\nKd 1 0 0\n");
    write(
        &folder,
        "program/t.c",
        "#include \"../library/one.h\"\nint main(void) { return ONE; }\n",
    );
    let run = |args: &[&str]| {
        let run = ["run", "program/t.c", "--engine", "ir"];
        let output = srp(&folder, &[&run[..], args].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        said
    };
    let told = "outside the folders of the program";
    let said = run(&[]);
    assert!(
        said.contains("note[C0920]") && said.contains("t.c:1:1"),
        "{said}"
    );
    assert!(run(&["-W", "error"]).contains(told), "a note is no warning");
    for silent in [["-W", "no-outside-include"], ["-I", "library"]] {
        let said = run(&silent);
        assert!(!said.contains(told), "{silent:?}: {said}");
    }
    let obj = format!("mtllib ../library/m.mtl\nusemtl m\n{TRIANGLE}");
    write(&folder, "scene/a.obj", &obj);
    let said = rendered(&folder, "scene/a.obj");
    assert!(
        said.contains("m.mtl is outside the folder of the scene"),
        "{said}"
    );
    write(&folder, "b.obj", &obj.replace("../", ""));
    assert!(!rendered(&folder, "b.obj").contains("outside"));
}

/// Neither a program nor a scene of a stranger shows what stands in other files, nor does a file that is named by
/// mistake.
#[test]
fn files_of_other_kinds_are_not_quoted() {
    let folder = folder("foreign_files");
    let secrets = "root:x:0:0:root:/root:/bin/bash\nword = hunter2\n";
    let silent = |args: &[&str]| {
        let output = srp(&folder, args);
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).into_owned();
        for word in ["root", "bash", "hunter2", "word"] {
            assert!(!said.contains(word), "{args:?}: {said}");
        }
        said
    };
    write(&folder, "secrets", secrets);
    write(
        &folder,
        "thief.c",
        "#include \"secrets\"\nint main(void) { return 0; }\n",
    );
    write(&folder, "thief.obj", &format!("mtllib secrets\n{TRIANGLE}"));
    for command in [["run", "thief.c"], ["render", "thief.obj"]] {
        let said = silent(&command);
        assert!(said.contains("secrets"), "{said}");
    }
    for (name, command) in [
        ("s.obj", &["render"][..]),
        ("s.xml", &["machine", "check"]),
        ("s.dre.xml", &["run"]),
        ("s.sched.xml", &["run"]),
        ("s.json", &["report", "--diff", "s.json"]),
        ("s.trace", &["dram"]),
        ("s.rays", &["tni", "--rays", "file", "--ray-file"]),
    ] {
        write(&folder, name, secrets);
        let said = silent(&[command, &[name]].concat());
        assert!(said.contains("it is no "), "{name}: {said}");
    }
    silent(&["render", "--cameras", "s.json:a/0"]);
    // A program that says its lines are those of another file gets none of them into its profile.
    write(
        &folder,
        "line.c",
        "#line 1 \"secrets\"\nint main(void) { volatile int n = 0; for (int i = 0; i < 9; i++) n += i;\n\nreturn 0; }\n",
    );
    for profile in ["p.json", "p.html", "p.txt"] {
        let run = ["run", "line.c", "--profile", profile];
        let output = srp(&folder, &run);
        assert!(output.status.success(), "{output:?}");
        let text = fs::read_to_string(folder.join(profile)).expect("it was written");
        assert!(
            !text.contains("hunter2") && !text.contains("bash"),
            "{profile}"
        );
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
    for engine in ["interp", "auto", "ir"] {
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
