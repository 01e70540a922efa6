//! `srp report`: text and JSON are those of the goldens, the page is well-formed, every member of
//! the JSON is in its reference, and of two reports it is said what got worse.

use super::{folder, refused, srp, stdout, write};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A loop that a recurrence bounds, and one that the memory's port does.
const LOOPS: &str = "\
int sum(const int *restrict p, int *restrict q, int n)
{
    int s = 0;
#pragma srp kernel
    for (int i = 0; i < n; i++) {
        s = (s ^ p[i]) * 5;
        q[i] = s;
    }
    return s;
}
void mix(const int *restrict p, const int *restrict q, int *restrict r, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        r[i] = p[i] + 3 * q[i];
}
void keep(const float *p, float *q, int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        q[i] = p[i] / 3.0f;
}
";

/// The program that runs them.
const MAIN: &str = "
static int a[64], b[64], c[64];
static float x[64], y[64];
int main(void)
{
    int s = sum(a, b, 64);
    mix(a, b, c, 64);
    keep(x, y, 64);
    return s + c[5];
}
";

/// A folder with the loops in it, their report in JSON and as a page.
fn reported(name: &str) -> (PathBuf, Value) {
    let folder = folder(name);
    write(&folder, "loops.c", LOOPS);
    let args = [
        "report",
        "loops.c",
        "--machine",
        "tiny",
        "--what-if",
        "--json",
        "--html",
        "loops.html",
    ];
    let json = stdout(&folder, &args, 0);
    write(&folder, "loops.json", &json);
    let value = serde_json::from_str(&json).expect("JSON is written");
    (folder, value)
}

/// Compares with a file of this folder; `BLESS=1` writes it.
fn golden(name: &str, found: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/command")
        .join(name);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, found).expect("the golden can be written");
    }
    let expected = std::fs::read_to_string(&path).expect("the golden can be read");
    assert_eq!(found, expected, "{name} differs; BLESS=1 takes it up");
}

#[test]
fn a_report_is_that_of_the_golden() {
    let (folder, json) = reported("report_golden");
    let args = ["report", "loops.c", "--machine", "tiny", "--what-if"];
    golden("report.txt", &stdout(&folder, &args, 0));
    let one = json["loops"][0].clone();
    golden(
        "report.json",
        &(serde_json::to_string_pretty(&one).expect("it is JSON") + "\n"),
    );
    let again = stdout(&folder, &[&args[..], &["--json"]].concat(), 0);
    let first = std::fs::read_to_string(folder.join("loops.json")).expect("it was written");
    assert_eq!(first, again, "two reports of one input differ");
}

/// The latencies of a recurrence by its distances are the bound; nothing is fuller than full.
#[test]
fn figures_of_a_report_agree() {
    let (_, json) = reported("report_figures");
    let loops = json["loops"].as_array().expect("a list");
    assert!(loops.len() >= 2, "{json}");
    let number = |v: &Value| v.as_u64().expect("a number");
    for l in loops {
        let ii = number(&l["ii"]);
        let steps = l["recurrence"].as_array().expect("a list");
        let sum = |what: &str| steps.iter().map(|s| number(&s[what])).sum::<u64>();
        if !steps.is_empty() {
            let bound = sum("latency").div_ceil(sum("distance"));
            assert_eq!(bound.max(1), number(&l["rec_mii"]), "{l}");
        }
        let scarcest = l["resources"].as_array().expect("a list").iter();
        let scarcest = scarcest.map(|r| number(&r["bound"])).max().unwrap_or(1);
        assert_eq!(scarcest, number(&l["res_mii"]), "{l}");
        assert_eq!(l["table"].as_array().expect("a list").len() as u64, ii);
        for f in l["files"].as_array().expect("a list") {
            assert!(number(&f["live"]) <= number(&f["capacity"]), "{f}");
            assert!(
                number(&f["read"]["most"]) <= number(&f["read"]["ports"]),
                "{f}"
            );
            assert!(
                number(&f["write"]["most"]) <= number(&f["write"]["ports"]),
                "{f}"
            );
        }
        for link in l["links"].as_array().expect("a list") {
            assert!(number(&link["slots"]) <= ii, "{link}");
        }
    }
}

/// Names of all members in a value.
fn members(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (name, value) in object {
                names.insert(name.clone());
                members(value, names);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| members(value, names)),
        _ => {}
    }
}

/// A document without what every document has, which is in the reference of all documents.
fn contents(mut document: Value) -> Value {
    let members = document.as_object_mut().expect("an object");
    for name in [
        "format", "version", "tool", "command", "options", "machine", "scene",
    ] {
        members.remove(name).unwrap_or_else(|| panic!("no {name}"));
    }
    document
}

#[test]
fn every_member_is_in_the_reference() {
    let (folder, mut json) = reported("report_members");
    let mut names = BTreeSet::new();
    members(&contents(json.clone()), &mut names);
    let timed = [
        "report",
        "loops.c",
        "--machine",
        "tiny",
        "--times",
        "--json",
    ];
    let timed = serde_json::from_str(&stdout(&folder, &timed, 0)).expect("JSON");
    members(&contents(timed), &mut names);
    json["loops"][0]["ii"] = 99.into();
    write(&folder, "worse.json", &json.to_string());
    let diff = ["report", "--diff", "loops.json", "worse.json", "--json"];
    let diff = serde_json::from_str(&stdout(&folder, &diff, 1)).expect("JSON");
    members(&contents(diff), &mut names);
    are_in_the_reference(&names);
    assert!(names.len() > 60, "{names:?}");
}

fn are_in_the_reference(names: &BTreeSet<String>) {
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/report.md");
    let reference = std::fs::read_to_string(reference).expect("the reference is there");
    let missing: Vec<&String> = names
        .iter()
        .filter(|name| !reference.contains(&format!("`{name}`")))
        .collect();
    assert!(
        missing.is_empty(),
        "docs/report.md does not name {missing:?}"
    );
}

#[test]
fn what_got_worse_is_named() {
    let (folder, json) = reported("report_diff");
    let same = stdout(
        &folder,
        &["report", "--diff", "loops.json", "loops.json"],
        0,
    );
    assert!(same.contains("0 worse, 0 better"), "{same}");
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut json = json.clone();
        change(&mut json);
        write(&folder, "new.json", &json.to_string());
    };
    let ii = json["loops"][0]["ii"].as_u64().expect("a number");
    changed(&|json| {
        json["loops"][0]["ii"] = (ii + 1).into();
        json["loops"][0]["status"] = "open".into();
        json["loops"][1]["files"][0]["live"] = 30.into();
    });
    let worse = stdout(&folder, &["report", "--diff", "loops.json", "new.json"], 1);
    let worse = worse.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "worse:",
        &format!("sum II {ii} → {}", ii + 1),
        "bound → open",
        "registers live",
    ] {
        assert!(worse.contains(part), "no {part:?} in\n{worse}");
    }
    let better = stdout(&folder, &["report", "--diff", "new.json", "loops.json"], 0);
    assert!(
        better.contains("0 worse") && better.contains("better:"),
        "{better}"
    );
    // With a lower II, its price is reported, and is not worse.
    changed(&|json| {
        json["loops"][0]["ii"] = (ii - 1).into();
        json["loops"][0]["stages"] = 40.into();
    });
    let price = stdout(&folder, &["report", "--diff", "loops.json", "new.json"], 0);
    assert!(
        price.contains("changed:") && price.contains("→ 40"),
        "{price}"
    );
    changed(&|json| {
        json["loops"].as_array_mut().expect("a list").remove(0);
    });
    let gone = stdout(&folder, &["report", "--diff", "loops.json", "new.json"], 1);
    assert!(gone.contains("→ not there"), "{gone}");
    let new = stdout(&folder, &["report", "--diff", "new.json", "loops.json"], 0);
    assert!(new.contains("not there → II = "), "{new}");
}

#[test]
fn what_is_no_report_is_refused() {
    let (folder, mut json) = reported("report_at_fault");
    write(&folder, "text.json", "{ \"loops\":\n  oops }");
    write(&folder, "frame.json", "{ \"cycles\": 5 }");
    json["version"] = 99.into();
    write(&folder, "later.json", &json.to_string());
    json["version"] = 2.into();
    json["loops"][0]["ii"] = "three".into();
    write(&folder, "members.json", &json.to_string());
    let cases: [(&str, &[&str]); 5] = [
        ("text.json", &["text.json:2:3", "srp report --json"]),
        (
            "frame.json",
            &["frame.json:1:1", "`format`", "srp report --json"],
        ),
        ("later.json", &["later.json:1:", "version 99", "version 2"]),
        ("members.json", &["members.json:1:", "three"]),
        ("none.json", &["none.json", "no such file"]),
    ];
    for (file, says) in cases {
        refused(&folder, &["report", "--diff", "loops.json", file], says);
    }
    let both = srp(
        &folder,
        &["report", "loops.c", "--diff", "loops.json", "loops.json"],
    );
    assert_eq!(both.status.code(), Some(2), "files and --diff");
}

/// One unit divides, four cycles at a time: what is in the way below the II is named, and where.
#[test]
fn what_is_in_the_way_has_a_place() {
    let folder = folder("report_obstacle");
    let text = "\
void divide(const int *x, int *y, int n, int d)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        y[i] = x[i] / d +
            x[i] % n;
}
";
    write(&folder, "divide.c", text);
    let json = stdout(&folder, &["report", "divide.c", "--json"], 0);
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let l = &json["loops"][0];
    assert_eq!(l["status"], "proved", "{l}");
    let operations = l["why_not_lower"]["operations"].as_array().expect("a list");
    assert!(!operations.is_empty(), "{}", l["why_not_lower"]);
    for operation in operations {
        let at = &operation["at"];
        assert_eq!(at["file"], "divide.c");
        assert!(
            (5..=6).contains(&at["line"].as_u64().expect("a number")),
            "{at}"
        );
        assert!(at["column"].as_u64() > Some(8), "{at}");
    }
    let text = stdout(&folder, &["report", "divide.c"], 0);
    assert!(
        text.contains("  not lower: ") && text.contains("divide.c:5:"),
        "{text}"
    );
}

/// The loops of the default frame take at most a quarter more cycles an iteration than their bounds say.
#[test]
fn kernels_of_a_frame_are_short() {
    let folder = folder("report_short");
    let text = stdout(&folder, &["report", "--frame", "--json"], 0);
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let loops = report["loops"].as_array().expect("a list");
    let cycles = |member: &str| {
        let cycles = loops.iter().map(|kernel| kernel[member].as_u64());
        cycles.map(|n| n.expect("cycles")).sum::<u64>()
    };
    let (length, least) = (cycles("length"), cycles("least_length"));
    assert!(length * 4 <= least * 5, "{length} cycles, at least {least}");
}

/// Schedules of bare graphs have a report as well.
#[test]
fn mapped_graphs_have_a_report() {
    let folder = folder("report_graphs");
    write(&folder, "accumulate.dot", super::graphs::GRAPH);
    let mesh = [
        "machine", "mesh", "--rows", "2", "--cols", "2", "-o", "mesh.xml",
    ];
    stdout(&folder, &mesh, 0);
    let map = [
        "map",
        "accumulate.dot",
        "--machine",
        "mesh.xml",
        "-o",
        "all.sched.xml",
    ];
    stdout(&folder, &map, 0);
    let report = ["report", "all.sched.xml", "--machine", "mesh.xml"];
    let text = stdout(&folder, &report, 0);
    assert!(text.contains("accumulate at II = 1, the bound"), "{text}");
    assert!(text.contains("accumulate.dot:"), "{text}");
    refused(
        &folder,
        &["report", "all.sched.xml", "--machine", "tiny"],
        &["all.sched.xml:", "tiny"],
    );
}

#[test]
fn wires_are_in_the_report() {
    let folder = folder("report_wires");
    write(&folder, "accumulate.dot", super::graphs::GRAPH);
    let mesh = "machine mesh --rows 1 --cols 4 --wires mesh --hops 3";
    let mesh: Vec<&str> = mesh.split(' ').collect();
    // A row whose units do one thing each, without links.
    let machine = stdout(&folder, &mesh, 0).replace("topology=\"mesh\"", "topology=\"none\"");
    write(&folder, "row.xml", &machine);
    let map = "map accumulate.dot --machine row.xml -o row.sched.xml";
    stdout(&folder, &map.split(' ').collect::<Vec<_>>(), 0);
    let report = ["report", "row.sched.xml", "--machine", "row.xml"];
    let text = stdout(&folder, &report, 0);
    assert!(text.contains(" of 6 used, "), "{text}");
    let arguments = [&report[..], &["--json", "--html", "row.html"]].concat();
    let json = stdout(&folder, &arguments, 0);
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let mut names = BTreeSet::new();
    members(&contents(json.clone()), &mut names);
    are_in_the_reference(&names);
    let wires = json["loops"][0]["wires"].as_array().expect("a list");
    assert_eq!(wires.len(), 6);
    let taken: usize = wires
        .iter()
        .map(|w| w["takes"].as_array().map_or(0, Vec::len))
        .sum();
    assert!(taken > 0, "{json}");
    let page = std::fs::read_to_string(folder.join("row.html")).expect("it was written");
    assert!(page.contains(" over mesh_0_"), "{page}");
}

/// Other commands write the same report.
#[test]
fn any_command_writes_the_report() {
    let folder = folder("report_from_commands");
    write(&folder, "loops.c", &format!("{LOOPS}{MAIN}"));
    let plain = stdout(
        &folder,
        &["report", "loops.c", "--machine", "tiny", "--json"],
        0,
    );
    let compile = [
        "compile",
        "loops.c",
        "--machine",
        "tiny",
        "--loops",
        "c.json",
        "--loops",
        "c.html",
    ];
    stdout(&folder, &compile, 0);
    let run = [
        "run",
        "loops.c",
        "--machine",
        "tiny",
        "--engine",
        "interp",
        "--loops",
        "r.json",
    ];
    stdout(&folder, &run, 0);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("it was written");
    // They differ in what was asked for alone.
    let report = |text: &str| {
        let mut report: Value = serde_json::from_str(text).expect("JSON");
        let members = report.as_object_mut().expect("an object");
        members.remove("command").expect("the command is told");
        members.remove("options").expect("its options are told");
        report
    };
    assert_eq!(report(&read("c.json")), report(&plain));
    assert_eq!(report(&read("r.json")), report(&plain));
    assert!(read("c.html").ends_with("</html>"));
    refused(
        &folder,
        &["run", "loops.c", "--loops", "no/such/r.json"],
        &["no/such/r.json"],
    );
}

/// Tags are closed in their order, every target of a reference is there once, and nothing comes from a
/// network.
#[test]
fn a_page_is_well_formed() {
    let (folder, _) = reported("report_page");
    let page = std::fs::read_to_string(folder.join("loops.html")).expect("it was written");
    let body = without(
        &without(&page, "<style>", "</style>"),
        "<script>",
        "</script>",
    );
    let mut open: Vec<&str> = Vec::new();
    let mut ids: BTreeMap<String, u32> = BTreeMap::new();
    let mut rest = body.strip_prefix("<!DOCTYPE html>").expect("it is HTML");
    while let Some(start) = rest.find('<') {
        assert!(
            !rest[..start].contains('>'),
            "a stray > in {:?}",
            &rest[..start]
        );
        let end = start + rest[start..].find('>').expect("tags end");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closed in the wrong order");
            continue;
        }
        let name = tag.split_whitespace().next().expect("tags have names");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        if let Some(id) = tag.split(" id=\"").nth(1) {
            *ids.entry(id[..id.find('"').expect("closed")].to_owned())
                .or_insert(0) += 1;
        }
        if !tag.ends_with('/') && name != "meta" {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "not closed: {open:?}");
    assert!(ids.values().all(|&n| n == 1), "{ids:?}");
    for reference in ["href=\"#", "url(#"] {
        for part in page.split(reference).skip(1) {
            let end = part.find(['"', ')']).expect("references end");
            assert!(
                ids.contains_key(&part[..end]),
                "nothing is called {}",
                &part[..end]
            );
        }
    }
    for outside in ["http:", "https:", "src=", "@import"] {
        assert!(!page.contains(outside), "{outside} in the page");
    }
    for drawn in [
        "class=\"panel\"",
        "class=\"recurrence\"",
        "class=\"whole\"",
        "class=\"slots\"",
    ] {
        assert!(body.contains(drawn), "no {drawn}");
    }
    let panels = body.matches("class=\"panel\"").count();
    let json = std::fs::read_to_string(folder.join("loops.json")).expect("it was written");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let loops = json["loops"].as_array().expect("a list").iter();
    let cycles: u64 = loops.map(|l| l["ii"].as_u64().expect("a number")).sum();
    assert_eq!(
        panels as u64, cycles,
        "a panel for every cycle of every loop"
    );
}

/// A text without what stands between two marks.
fn without(text: &str, from: &str, to: &str) -> String {
    let start = text.find(from).expect("it begins") + from.len();
    let end = start + text[start..].find(to).expect("it ends");
    text[..start].to_owned() + &text[end..]
}
