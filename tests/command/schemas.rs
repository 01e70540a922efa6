//! Documents: the JSON of every command has the one envelope and fits its schema, the schemas are those of
//! `docs/schemas` (`BLESS=1` writes them), and a document that does not fit is refused with its place.

use super::{folder, refused, srp, write};
use jsonschema::Validator;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The members that every document has, each once.
#[derive(Deserialize)]
struct Envelope {
    format: String,
    version: u32,
    tool: BTreeMap<String, String>,
    command: String,
    machine: IgnoredAny,
    scene: IgnoredAny,
    options: BTreeMap<String, Value>,
}

fn schemas() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/schemas")
}

fn text(folder: &Path, args: &[&str]) -> String {
    let output = srp(folder, args);
    let said = String::from_utf8_lossy(&output.stderr);
    // 1 is the answer that something got worse, or is wrong.
    assert!(
        matches!(output.status.code(), Some(0 | 1)) && !output.stdout.is_empty(),
        "srp {args:?}: {said}"
    );
    String::from_utf8(output.stdout).expect("it is text")
}

/// The names of all formats.
fn formats(folder: &Path) -> BTreeSet<String> {
    text(folder, &["schema"])
        .lines()
        .map(str::to_owned)
        .collect()
}

#[test]
fn schemas_are_those_of_the_documentation() {
    let folder = folder("schemas-golden");
    let bless = std::env::var_os("BLESS").is_some();
    let mut known = BTreeSet::new();
    for name in formats(&folder) {
        let found = text(&folder, &["schema", &name]);
        let file = format!("{name}.json");
        let path = schemas().join(&file);
        if bless {
            std::fs::create_dir_all(schemas()).expect("the folder can be made");
            std::fs::write(&path, &found).expect("the golden can be written");
        }
        let golden = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == golden, "{file} differs; BLESS=1 takes it up");
        known.insert(file);
    }
    let files = std::fs::read_dir(schemas()).expect("the folder is there");
    let files = files.map(|f| {
        f.expect("a file")
            .file_name()
            .to_string_lossy()
            .into_owned()
    });
    assert_eq!(
        files.collect::<BTreeSet<_>>(),
        known,
        "a schema is of no format"
    );
    let misspelt = srp(&folder, &["schema", "srp-repor"]);
    assert_eq!(misspelt.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&misspelt.stderr).contains("srp-report"));
}

/// The schema of a format that takes no member that it does not know. Parts of a choice stay open, because their
/// members lie beside those around it.
fn closed(name: &str) -> Validator {
    fn close(schema: &mut Value) {
        let Some(object) = schema.as_object_mut() else {
            return;
        };
        if object.contains_key("properties") || object.contains_key("oneOf") {
            let is_object = object.get("type").is_some_and(|kind| kind == "object");
            if is_object && !object.contains_key("additionalProperties") {
                object.insert("unevaluatedProperties".to_owned(), false.into());
            }
        }
        for part in ["properties", "$defs"] {
            let parts = object.get_mut(part).and_then(Value::as_object_mut);
            parts
                .into_iter()
                .flatten()
                .for_each(|(_, part)| close(part));
        }
        if let Some(items) = object.get_mut("items") {
            close(items);
        }
    }
    let path = schemas().join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).expect("the schema is there");
    let mut schema = serde_json::from_str(&text).expect("a schema is JSON");
    close(&mut schema);
    jsonschema::validator_for(&schema).expect("the schema is one")
}

/// Checks a document; the name of its format.
fn checked(text: &str) -> String {
    let head: Envelope = serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"));
    let (IgnoredAny, IgnoredAny) = (head.machine, head.scene);
    assert!(head.version > 0 && !head.command.is_empty(), "{text}");
    assert_eq!(head.tool["version"], env!("CARGO_PKG_VERSION"));
    assert!(!head.tool["build"].is_empty());
    for name in ["json", "output", "threads"] {
        assert!(!head.options.contains_key(name), "{name}: {text}");
    }
    let document: Value = serde_json::from_str(text).expect("it was read before");
    let schema = closed(&head.format);
    let wrong: Vec<String> = (schema.iter_errors(&document))
        .map(|e| format!("{}: {e}", e.instance_path()))
        .take(5)
        .collect();
    assert!(wrong.is_empty(), "{}: {wrong:#?}", head.format);
    head.format
}

const LOOP: &str = "static int a[64];\nint main(void)\n{\n    for (int i = 0; i < 64; i++)\n        a[i] = i * 3;\n\
    return a[5];\n}\n";

/// Commands whose documents go to standard output.
const PRINTED: &[&str] = &[
    "report loop.c --machine tiny --what-if --times",
    "report --diff loops.json loops.json",
    "diff frame.json other.json",
    "compile loop.c",
    "run ok.c --engine interp",
    "run ok.c --engine ir",
    "render --size 16x8 --fidelity functional -o a.png",
    "render --size 16x8 --fidelity sampled",
    "effects --no-costs",
    "fidelity --size 16x8",
    "accuracy --size 8x8 --knob intersection -o accuracy",
    "accuracy --pixel 4,4 --size 16x8",
    "render --pixel 4,4 --size 16x8",
    "accuracy f.c --range x=1:2 --points 16 --trials 2",
    "map sum.dot --mesh 2x2 --what-if",
    "dram requests.trace",
    "tni --size 16x8 --memory both",
    "tni --size 16x8 --fidelity analytic",
    "tni --size 16x8 --ray 8,4",
    "paper table4 --size 16x8",
    "area",
    "units tiny",
    "watertight --rays 5 --mesh tube",
    "hard-cases --filter T1",
    "hard-cases --filter T1 --list",
    "sweep --set array.contexts=32,128 --program loop.c --measure ii,area",
    "sweep report sweep",
    "cache show",
];

/// Commands whose documents go to a file.
const WRITTEN: &[(&str, &str)] = &[
    ("run loop.c --profile profile.json", "profile.json"),
    ("run loop.c --loops loops.json", "loops.json"),
    ("run loop.c --registers registers.json", "registers.json"),
    (
        "render --size 16x8 --report frame.json -o a.png",
        "frame.json",
    ),
    (
        "render --size 16x8 --machine decoupled --report other.json -o a.png",
        "other.json",
    ),
];

#[test]
fn every_document_fits_its_schema() {
    let folder = folder("schemas");
    write(&folder, "loop.c", LOOP);
    write(&folder, "ok.c", &LOOP.replace("a[5]", "a[0]"));
    write(
        &folder,
        "f.c",
        "float f(float x)\n{\n    return 1.0f / (x - 0.5f);\n}\n",
    );
    write(
        &folder,
        "sum.dot",
        "digraph { a [op=load]; s [op=add]; a -> s; s -> s [distance=1]; }",
    );
    write(
        &folder,
        "requests.trace",
        "0 READ 0\n32 READ 0\n64 WRITE 100\n",
    );
    let mut met = BTreeSet::new();
    for (command, file) in WRITTEN {
        let args: Vec<&str> = command.split(' ').collect();
        let said = srp(&folder, &args).stderr;
        let text = std::fs::read_to_string(folder.join(file));
        let text = text.unwrap_or_else(|_| panic!("{command}: {}", String::from_utf8_lossy(&said)));
        met.insert(checked(&text));
    }
    for command in PRINTED {
        let args: Vec<&str> = command.split(' ').chain(["--json"]).collect();
        met.insert(checked(&text(&folder, &args)));
    }
    assert_eq!(
        met,
        formats(&folder),
        "a format that no command of this test writes"
    );
}

#[test]
fn documents_say_what_they_are_of() {
    let folder = folder("envelopes");
    write(&folder, "loop.c", LOOP);
    let report = |machine: &str, more: &[&str]| -> Value {
        let args = [&["report", "loop.c", "--json", "--machine", machine], more].concat();
        serde_json::from_str(&text(&folder, &args)).expect("it is JSON")
    };
    let tiny = report("tiny", &[]);
    assert_eq!(tiny["command"], "report");
    assert_eq!(tiny["machine"]["name"], "tiny");
    assert_eq!(tiny["scene"], Value::Null);
    assert_eq!(tiny["options"]["files"], json!(["loop.c"]));
    assert_eq!(tiny["options"]["what-if"], false);
    assert_eq!(tiny["options"]["effort"], "1");
    // A machine is the same whatever its file is called, and another if anything of it differs.
    let expanded = text(&folder, &["machine", "expand", "tiny"]);
    write(&folder, "same.xml", &expanded);
    let contexts = expanded.replacen("contexts=\"", "contexts=\"1", 1);
    assert_ne!(contexts, expanded);
    write(&folder, "other.xml", &contexts);
    assert_eq!(report("same.xml", &[])["machine"], tiny["machine"]);
    assert_ne!(
        report("other.xml", &[])["machine"]["hash"],
        tiny["machine"]["hash"]
    );
    let other = report("tiny", &["--what-if"]);
    assert_eq!(other["options"]["what-if"], true);
    assert_eq!(other["machine"], tiny["machine"]);
}

#[test]
fn documents_that_do_not_fit_are_refused_with_their_place() {
    let folder = folder("envelopes-at-fault");
    write(&folder, "loop.c", LOOP);
    srp(&folder, &["run", "loop.c", "--profile", "profile.json"]);
    let area = text(&folder, &["area", "--json"]);
    write(&folder, "area.json", &area);
    let profile = std::fs::read_to_string(folder.join("profile.json")).expect("it was written");
    let later = profile.replacen("\"version\": 2,", "\"version\": 99,", 1);
    assert_ne!(later, profile);
    write(&folder, "later.json", &later);
    write(&folder, "bare.json", "\n  { \"cycles\": 3 }");
    write(
        &folder,
        "text.json",
        "{ \"format\": \"srp-frame\",\n  oops }",
    );
    let cases: [(&str, &[&str]); 4] = [
        (
            "area.json",
            &[
                "area.json:2:13",
                "`srp-profile`",
                "`srp-frame`",
                "`srp-report`",
            ],
        ),
        (
            "later.json",
            &["later.json:3:14", "version 99", "version 2"],
        ),
        (
            "bare.json",
            &["bare.json:2:3", "`format`", "srp report --json"],
        ),
        ("text.json", &["text.json:2:3", "--profile FILE.json"]),
    ];
    for (file, says) in cases {
        refused(&folder, &["diff", "profile.json", file], says);
        refused(&folder, &["diff", file, "profile.json"], says);
    }
}
