//! Outputs: never where an input or another output is, and never outside their folder.

use super::{TRIANGLE, folder, refused, srp, write};
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// The names and texts of all files of a folder and of those in it.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("it is a folder") {
        let path = entry.expect("it can be read").path();
        match path.is_dir() {
            true => all.extend(contents(&path)),
            false => {
                let text = fs::read(&path).expect("it can be read");
                all.insert(path.display().to_string(), text);
            }
        }
    }
    all
}

/// Every option that names an output, with an input of its command, and with another output.
#[test]
fn every_output_is_its_own_file() {
    let folder = folder("own_file");
    write(&folder, "t.c", "int main(void) { return 0; }\n");
    write(&folder, "tri.obj", TRIANGLE);
    write(&folder, "g.dot", "digraph g { a [op=add]; }\n");
    write(
        &folder,
        "m.xml",
        include_str!("../../archdesc/machines/tiny.xml"),
    );
    let before = contents(&folder);
    let render = "render tri.obj --size 8x8 --fidelity functional";
    let tni = "tni tri.obj --size 8x8";
    let map = "map g.dot --mesh 2x2";
    let alone = [
        format!("{render} -o tri.obj"),
        format!("{render} -o out.png --report tri.obj"),
        "render tri.obj --size 8x8 -o out.png --profile tri.obj".to_owned(),
        format!("{render} -o m.xml --machine m.xml"),
        format!("{tni} --heat tri.obj"),
        format!("{tni} --hits tri.obj"),
        "effects tri.obj --no-costs --html tri.obj".to_owned(),
        "hard-cases tri.obj --html tri.obj".to_owned(),
        "run t.c --profile t.c".to_owned(),
        "run t.c --trace 0..9 --trace-format fst --trace-output t.c".to_owned(),
        "render tri.obj --size 8x8 -o out.png --trace 0..9 --trace-format fst --trace-output tri.obj"
            .to_owned(),
        "report t.c --html t.c".to_owned(),
        "report t.c --proof t.c".to_owned(),
        format!("{map} -o g.dot"),
        format!("{map} --proof g.dot"),
    ];
    let twice = [
        format!("{render} -o two --report two"),
        "render tri.obj --size 8x8 -o two --profile two".to_owned(),
        "render tri.obj --size 8x8 -o t.fst --trace 0..9 --trace-output t.fst".to_owned(),
        format!("{tni} --heat two --hits two"),
        "report t.c --html two --proof two".to_owned(),
        "report t.c --html two.cnf --proof two".to_owned(),
        format!("{map} -o two --proof two"),
        format!("{map} -o two.cnf --proof two"),
    ];
    let alone = alone.iter().map(|line| (line, "of this command"));
    let twice = twice
        .iter()
        .map(|line| (line, "another output of this command"));
    for (line, says) in alone.chain(twice) {
        let words: Vec<&str> = line.split(' ').collect();
        let output = srp(&folder, &words);
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert_eq!(output.status.code(), Some(1), "srp {line}: {said}");
        assert!(said.contains(says), "srp {line}: {said}");
        assert!(contents(&folder) == before, "srp {line} wrote: {said}");
    }
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
    fs::hard_link(folder.join("tri.obj"), folder.join("hard.obj")).expect("it can be made");
    refused(
        &folder,
        &["render", "tri.obj", "-o", "hard.obj"],
        &["of this command"],
    );
    refused(
        &folder,
        &["render", "-o", "same.png", "--report", "./same.png"],
        &["another output"],
    );
    // Files that others name are inputs, too.
    write(&folder, "one.h", "#define ONE 1\n");
    write(
        &folder,
        "u.c",
        "#include \"one.h\"\nint main(void) { return ONE; }\n",
    );
    refused(&folder, &["report", "u.c", "--html", "one.h"], &["one.h"]);
    write(&folder, "g.dot", "digraph g { a [op=add]; }\n");
    let mesh = ["map", "g.dot", "--mesh", "2x2"];
    for option in ["-o", "--proof"] {
        let onto = [&mesh[..], &[option, "g.dot"]].concat();
        let output = srp(&folder, &onto);
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("of this command"), "{said}");
    }
    assert!(
        srp(&folder, &["compile", "t.c", "--emit", "ir"])
            .status
            .success()
    );
    let ir = text("t.ir");
    let again = ["compile", "t.ir", "--emit", "ir", "-o", "."];
    refused(&folder, &again, &["t.ir", "input of this command"]);
    fs::create_dir(folder.join("more")).expect("it can be made");
    write(&folder, "more/t.c", program);
    refused(
        &folder,
        &["compile", "t.c", "more/t.c", "--emit", "ast"],
        &["another output"],
    );
    assert_eq!(text("t.ir"), ir);
    assert_eq!(text("one.h"), "#define ONE 1\n");
    assert!(text("g.dot").starts_with("digraph"));
    assert_eq!(text("t.c"), program);
    assert_eq!(text("tri.obj"), TRIANGLE);
}

/// Where the work would take long, it is not begun.
#[test]
fn what_cannot_be_written_is_told_first() {
    let folder = folder("unwritable");
    fs::create_dir(folder.join("full")).expect("it can be made");
    let render = ["render", "--size", "4096x4096", "--engine", "interp"];
    for output in ["none/out.png", "full", "."] {
        let line = [&render[..], &["-o", output]].concat();
        refused(&folder, &line, &["cannot write", output]);
        let line = [&render[..], &["-o", "out.png", "--report", output]].concat();
        refused(&folder, &line, &["cannot write", output]);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_part_of_a_file() {
    let folder = folder("interrupted");
    write(&folder, "tri.obj", TRIANGLE);
    write(&folder, "out.png", "old");
    let before = contents(&folder);
    let mut render = Command::new(env!("CARGO_BIN_EXE_srp"));
    render
        .current_dir(&folder)
        .env("SRP_CACHE", folder.with_extension("cache"))
        .args([
            "render",
            "tri.obj",
            "--size",
            "4096x4096",
            "--engine",
            "interp",
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let mut render = render.spawn().expect("the command can be started");
    // It says what it builds as soon as it answers interrupts.
    let mut lines = BufReader::new(render.stderr.take().expect("it is piped")).lines();
    let first = lines.next().expect("a line").expect("text");
    assert!(first.contains("BVH"), "{first}");
    let id = render.id().to_string();
    let kill = Command::new("kill").args(["-INT", &id]).status();
    assert!(kill.is_ok_and(|sent| sent.success()), "kill is there");
    let said: Vec<String> = lines.map_while(Result::ok).collect();
    let status = render.wait().expect("it ends");
    assert_eq!(status.code(), Some(130), "{said:?}");
    assert!(contents(&folder) == before, "{said:?}");
}

#[test]
fn names_from_files_stay_inside_the_folder() {
    let folder = folder("names");
    let long = "f".repeat(100_000);
    let program = format!(
        "int a[8];\nvoid {long}(void) {{\n#pragma srp kernel\n    \
         for (int i = 0; i < 8; i++) a[i] = i;\n}}\nint main(void) {{ {long}(); return 0; }}\n"
    );
    write(&folder, "t.c", &program);
    fs::create_dir(folder.join("out")).expect("it can be made");
    let emit = |input: &str, forms: &str| {
        let output = srp(&folder, &["compile", input, "--emit", forms, "-o", "out"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{input}: {said}");
    };
    emit("t.c", "dre,dfg,schedule,rust");
    let dre = fs::read_to_string(folder.join("out/t.dre.xml")).expect("it was written");
    for (number, name) in [
        "../../escaped",
        "csim/../../../x",
        "/tmp/x",
        "..",
        "a\\b",
        "-",
    ]
    .into_iter()
    .enumerate()
    {
        let escaping = dre.replace(&format!("\"{long}\""), &format!("\"{name}\""));
        assert_ne!(escaping, dre);
        let input = format!("{number}.dre.xml");
        write(&folder, &input, &escaping);
        let before = fs::read_dir(folder.join("out"))
            .expect("it is there")
            .count();
        emit(&input, "dfg,rust,schedule");
        let after = fs::read_dir(folder.join("out"))
            .expect("it is there")
            .count();
        assert_eq!(
            after,
            before + 3,
            "{name}: a graph, a folder and a schedule"
        );
    }
    // All that was written is in `out`, under names that any system takes.
    let beside = contents(&folder);
    for path in beside.keys() {
        let inside = Path::new(path).strip_prefix(&folder).expect("it is inside");
        let words: Vec<_> = inside.iter().map(|word| word.to_string_lossy()).collect();
        assert!(words.len() == 1 || words[0] == "out", "{path}");
        assert!(words.iter().all(|word| word.len() <= 120), "{path}");
    }
    assert_eq!(
        beside.keys().filter(|path| !path.contains("/out/")).count(),
        7
    );
    let parent = folder.parent().expect("it has one");
    assert!(!parent.join("escaped.dot").exists() && !parent.join("x.dot").exists());
}

/// A trace says beforehand how large it can be, and why there is none.
#[test]
fn traces_are_told_and_refused() {
    let folder = folder("traces");
    let text =
        "float a[32];\nint main(void) { for (int i = 0; i < 32; i++) a[i] += 1.0f; return 0; }\n";
    write(&folder, "t.c", text);
    let run = |more: &[&str]| {
        let output = srp(&folder, &[&["run", "t.c"], more].concat());
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    for (window, name) in [("10..30", "t.fst"), ("kernel:main", "t.kanata")] {
        let (status, said) = run(&["--trace", window, "--trace-output", name]);
        assert_eq!(status, Some(0), "{said}");
        let told = said
            .find("at most")
            .expect("it is told how large the file can be");
        let done = said.find("VLIW").expect("there is an account");
        assert!(told < done, "{said}");
        assert!(folder.join(name).is_file(), "{said}");
    }
    let (status, said) = run(&["--trace", "1000000..1000001", "--trace-output", "no.fst"]);
    assert_eq!(status, Some(1));
    assert!(
        said.contains("were not reached") && !folder.join("no.fst").exists(),
        "{said}"
    );
    let (status, said) = run(&["--trace", "kernel:no", "--trace-output", "no.fst"]);
    assert_eq!(status, Some(1));
    assert!(
        said.contains("no kernel `no`") && said.contains("main"),
        "{said}"
    );
    for misuse in [
        ["--trace", "5..5", "--trace-output", "no.fst"],
        ["--trace", "0..9", "--trace-output", "no.txt"],
        ["--trace", "tile:1", "--trace-output", "no.fst"],
        ["--trace", "pixel:1,1", "--trace-output", "no.fst"],
        ["--trace", "0..9", "--engine", "ir"],
    ] {
        let (status, said) = run(&misuse);
        assert_eq!(status, Some(2), "{misuse:?}: {said}");
    }
    // A trace beside a profile is that without one, and so is the profile.
    for args in [
        [
            "--trace",
            "10..30",
            "--trace-output",
            "both.fst",
            "--profile",
            "both.txt",
        ]
        .as_slice(),
        &["--profile", "one.txt"],
    ] {
        let (status, said) = run(args);
        assert_eq!(status, Some(0), "{said}");
    }
    let read = |name: &str| std::fs::read(folder.join(name)).expect("it was written");
    assert!(read("both.fst") == read("t.fst") && read("both.txt") == read("one.txt"));
    write(&folder, "tri.obj", TRIANGLE);
    for (window, says) in [("tile:9", "1 tile, from 0"), ("pixel:9,1", "8x8 pixels")] {
        let render = ["render", "tri.obj", "--size", "8x8", "--trace", window];
        refused(&folder, &render, &[says]);
    }
}

/// The history of a pixel has the picture's colour, and its ray.
#[test]
fn a_pixel_tells_what_it_was_made_of() {
    let folder = folder("pixel");
    write(&folder, "tri.obj", TRIANGLE);
    let told = |pixel: &str| {
        let args = ["render", "tri.obj", "--size", "16x8", "--pixel", pixel];
        let output = srp(&folder, &args);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        String::from_utf8(output.stdout).expect("it is text")
    };
    let (hit, missed) = (told("7,4"), told("0,0"));
    let picture = image::open(folder.join("out.png")).expect("it is a picture");
    for (text, at, what) in [
        (&hit, (7, 4), "hits triangle 0"),
        (&missed, (0, 0), "hits nothing"),
    ] {
        let [red, green, blue] = picture.to_rgb8().get_pixel(at.0, at.1).0;
        let head = format!("pixel {},{} is {red} {green} {blue} ", at.0, at.1);
        assert!(text.starts_with(&head) && text.contains(what), "{text}");
    }
    assert!(hit.contains("shade_hit, launch") && !missed.contains("shade_hit, launch"));
    // Whether something was traced or counted beside it, it is the same.
    let args = "render tri.obj --size 16x8 --pixel 7,4 --profile p.txt --trace tile:0";
    let output = srp(&folder, &args.split(' ').collect::<Vec<_>>());
    assert!(String::from_utf8_lossy(&output.stdout) == hit);
    let far = ["render", "tri.obj", "--size", "16x8", "--pixel", "16,0"];
    refused(&folder, &far, &["16x8 pixels"]);
}
