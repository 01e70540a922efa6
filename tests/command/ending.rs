//! Where a program stands when its run is over, and its registers then, by every engine.

use super::{folder, srp, write};

const PROGRAM: &str = "\
float a[64];
static float sum(float by) {
    float s = 0;
    for (int i = 0; i < 64; i++)
        s += a[i] * by;
    return s;
}
int main(void) {
    for (int i = 0; i < 64; i++)
        a[i] = i * 0.5f;
    return (int)sum(0.25f) & 127;
}
";

/// Engines that have registers; the generated one if there is rustc.
const ENGINES: [&str; 3] = ["interp", "auto", "csim"];

#[test]
fn engines_end_with_the_same_registers() {
    let folder = folder("ending-registers");
    write(&folder, "main.c", PROGRAM);
    let dumped = |engine: &str, file: &str| {
        let args = ["run", "main.c", "--engine", engine, "--registers", file];
        let output = srp(&folder, &args);
        let said = String::from_utf8_lossy(&output.stderr);
        if said.contains("there is no simulator") {
            println!("skipped: there is no rustc");
            return None;
        }
        std::fs::read_to_string(folder.join(file)).ok()
    };
    let first = dumped("interp", "first.txt").expect("it was written");
    assert!(first.lines().count() > 10, "{first}");
    for engine in ENGINES {
        let file = format!("{engine}.txt");
        if let Some(text) = dumped(engine, &file) {
            assert_eq!(text, first, "{engine}");
        }
    }
    let json = dumped("interp", "first.json").expect("it was written");
    let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    assert_eq!(json["format"], "srp-registers");
    let stores = json["stores"].as_array().into_iter().flatten();
    let count = |store: &serde_json::Value| store["registers"].as_array().map_or(0, Vec::len);
    assert_eq!(stores.map(count).sum::<usize>(), first.lines().count());
    write(&folder, "main.c", &PROGRAM.replace("0.25f)", "0.75f)"));
    assert_ne!(
        dumped("interp", "second.txt").expect("it was written"),
        first
    );
    let refused = srp(
        &folder,
        &["run", "main.c", "--engine", "ir", "--registers", "-"],
    );
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn a_run_that_is_cut_off_tells_where_it_stands() {
    let folder = folder("ending-stands");
    write(&folder, "main.c", PROGRAM);
    for engine in ENGINES {
        // The first loop takes its cycles, and the second one is under way.
        let mut told = Vec::new();
        for limit in ["20", "120"] {
            let args = ["run", "main.c", "--engine", engine, "--limit", limit];
            let output = srp(&folder, &args);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{said}");
            told.push(said);
        }
        assert!(
            told[0].contains("of the loop `main` at main.c:9:5, on the array"),
            "{}",
            told[0]
        );
        assert!(
            told[1].contains("of the loop `sum` at main.c:4:5, on the array"),
            "{}",
            told[1]
        );
    }
    let waits = "#include \"srp.h\"\nint main(void) {\n    return srp_in(77);\n}\n";
    write(&folder, "waits.c", waits);
    let output = srp(&folder, &["run", "waits.c"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("waits for port 77"), "{said}");
    assert!(
        said.contains("note: it stands in `main` at waits.c:3:12"),
        "{said}"
    );
}
