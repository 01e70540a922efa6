//! How soon an edit is answered: `cargo build --release && cargo bench -p srp-tests --bench edit` prints a
//! table of what a user does, with the seconds that it takes and those that are wanted. It runs the
//! command of the release build (or `SRP`), each row in a cache of its own, the best of a few tries.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Tries of each row; the machine may be busy with something else.
const TRIES: u32 = 3;

/// A folder to work in, with a cache and kernels to edit.
struct Desk {
    folder: PathBuf,
    command: PathBuf,
}

impl Desk {
    fn new() -> Desk {
        let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
        let root = tests.parent().expect("tests are in the project");
        let built = root.join("target/release/srp");
        let command = std::env::var_os("SRP").map_or(built, PathBuf::from);
        assert!(
            command.exists(),
            "{} is not there: build it with `cargo build --release`",
            command.display()
        );
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("edit");
        let _ = fs::remove_dir_all(&folder);
        for name in ["kernels", "elsewhere/kernels"] {
            let copy = folder.join(name);
            fs::create_dir_all(&copy).expect("the target folder can be written");
            for file in srp_kernels::SOURCES.iter().chain(srp_kernels::HEADERS) {
                let name = Path::new(file.path).file_name().expect("it is a file");
                fs::write(copy.join(name), file.text).expect("it can be written");
            }
        }
        Desk { folder, command }
    }

    fn forget(&self) {
        let _ = fs::remove_dir_all(self.folder.join("cache"));
    }

    /// The time that a command takes.
    fn run(&self, args: &[&str]) -> Duration {
        let mut command = Command::new(&self.command);
        command.current_dir(&self.folder).args(args);
        command.env("SRP_CACHE", self.folder.join("cache"));
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let start = Instant::now();
        let output = command.output().expect("the command can be started");
        let took = start.elapsed();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "srp {args:?}: {said}");
        took
    }

    /// Changes a file; the new text stands for each try.
    fn edit(&self, name: &str, from: &str, to: &str) {
        let path = self.folder.join(name);
        let text = fs::read_to_string(&path).expect("it can be read");
        assert!(text.contains(from), "{name} has no {from:?}");
        fs::write(path, text.replacen(from, to, 1)).expect("it can be written");
    }
}

/// Prints a row: the best of the tries, each of which `set_up` prepares.
fn row(what: &str, wanted: f64, set_up: &dyn Fn(u32), run: &dyn Fn() -> Duration) {
    let tries = (0..TRIES).map(|number| {
        set_up(number);
        run()
    });
    let best = tries.min().unwrap_or_default().as_secs_f64();
    let verdict = if best <= wanted { "" } else { "  missed" };
    println!("| {what:62} | {best:7.2} | {wanted:6.1} |{verdict}");
}

fn main() {
    let desk = Desk::new();
    let nothing = |_: u32| {};
    let forget = |_: u32| desk.forget();
    let render = ["render", "-o", "out.png"];
    let render_from = |folder: &'static str| ["render", "--kernels", folder, "-o", "out.png"];
    println!(
        "| {:62} | {:>7} | {:>6} |",
        "what a user does", "seconds", "wanted"
    );
    println!("|{}|--------:|-------:|", "-".repeat(64));

    row("first render", 6.0, &forget, &|| desk.run(&render));
    row("render again", 1.5, &nothing, &|| desk.run(&render));
    desk.run(&render_from("kernels"));
    row(
        "render --kernels DIR, nothing edited",
        1.5,
        &nothing,
        &|| desk.run(&render_from("kernels")),
    );
    row("the same kernels in another folder", 1.5, &nothing, &|| {
        desk.run(&render_from("elsewhere/kernels"))
    });
    let brighter = |number: u32| match number {
        0 => desk.edit(
            "kernels/light.c",
            "specular, colour)",
            "specular, colour * 1.01f)",
        ),
        n => {
            let factor = |n: u32| format!("colour * 1.0{n}f)");
            desk.edit("kernels/light.c", &factor(n), &factor(n + 1));
        }
    };
    row(
        "one line of light.c edited, render",
        3.0,
        &brighter,
        &|| desk.run(&render_from("kernels")),
    );
    let machine = Command::new(&desk.command)
        .args(["machine", "expand", "sgrt"])
        .output();
    let machine = machine.expect("the command can be started").stdout;
    fs::write(desk.folder.join("machine.xml"), machine).expect("it can be written");
    let slower = |number: u32| {
        let (from, to) = (number, number + 1);
        let latency = |ns: u32| format!("latency-ns=\"{ns}\"");
        desk.edit("machine.xml", &latency(from), &latency(to));
    };
    row(
        "latency-ns of the DRAM edited, render",
        1.8,
        &slower,
        &|| desk.run(&["render", "--machine", "machine.xml", "-o", "out.png"]),
    );
    let functional = ["render", "--fidelity", "functional", "-o", "out.png"];
    row(
        "render --fidelity functional, nothing kept",
        0.5,
        &forget,
        &|| desk.run(&functional),
    );

    let reports: [(&str, &[&str]); 4] = [
        ("report of the kernels that come along", &["report"]),
        ("report --frame", &["report", "--frame"]),
        ("report light.c", &["report", "kernels/light.c"]),
        (
            "report --kernel shade_miss",
            &["report", "--kernel", "shade_miss"],
        ),
    ];
    for (what, args) in reports {
        row(&format!("{what}, nothing kept"), 2.0, &forget, &|| {
            desk.run(args)
        });
        row(&format!("{what}, again"), 0.3, &nothing, &|| desk.run(args));
    }
}
