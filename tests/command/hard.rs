//! `srp hard-cases`: the whole matrix.

use super::{folder, srp};

#[test]
fn hard_cases_are_right_or_within_the_bounds_stated() {
    let folder = folder("hard");
    let output = srp(&folder, &["hard-cases", "--html", "cases.html"]);
    let text = String::from_utf8_lossy(&output.stdout);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}{message}");
    assert!(text.contains(", 0 wrong"), "{text}");
    // A unit or a kernel that is a few times worse is noticed.
    let room = text
        .split_once("its bound is ")
        .and_then(|(_, text)| text.split_once(' '));
    let room: Option<f64> = room.and_then(|(room, _)| room.parse().ok());
    assert!(room.is_some_and(|room| room <= 4.0), "{text}");
    let page = std::fs::read_to_string(folder.join("cases.html")).expect("it was written");
    assert!(page.contains("Hard cases on sgrt") && !page.contains("http://"));

    // A test that loses rays is no excuse for one that must not.
    let json = srp(&folder, &["hard-cases", "--filter", "L1", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).expect("it is JSON");
    let results = json["cases"].as_array().into_iter().flatten();
    let results = results.flat_map(|case| case["results"].as_array().into_iter().flatten());
    let (mut lost, mut all) = (0, 0);
    for result in results {
        let setting = result["setting"].as_str().unwrap_or_default();
        let right = result["verdict"] == "right";
        let leaky = setting.starts_with("wald") || setting.starts_with("anchor-wald");
        let leaky = leaky && !setting.contains("scaled");
        assert!(right || leaky, "{result}");
        (lost, all) = (lost + u32::from(!right), all + 1);
    }
    assert!(lost > 10 && all > 100, "{lost} of {all}");
    // What a machine has no room for is left out, and told.
    let small = srp(
        &folder,
        &["hard-cases", "--machine", "tiny", "--filter", "P11"],
    );
    let text = String::from_utf8_lossy(&small.stdout);
    assert_eq!(small.status.code(), Some(0), "{text}");
    assert!(text.contains("skipped: frame: P11.2: "), "{text}");
    let unknown = srp(&folder, &["hard-cases", "--filter", "nonsense"]);
    assert_eq!(unknown.status.code(), Some(2));
}

const OWN: &str = "\
version 1
on srp
by rule
source this test
case Y1 the sine of one is none
  call sinf of 1
  gives 0.9
case Y2 the sine of one is allowed
  call sinf of 1
  gives 0.9
  may 0.84147096
  within 2
case Y3 a box is met
  call box low 0 0 0 high 1 1 1 from -1 .5 .5 along 1 0 0
  on tni
  gives hit
";

#[test]
fn cases_of_ones_own_are_tried() {
    let folder = folder("hard-own");
    super::write(&folder, "my.cases", OWN);
    let args = ["hard-cases", "--cases", "my.cases", "--html", "own.html"];
    let output = srp(&folder, &args);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("srp hard-cases --cases my.cases --filter Y1\n"));
    let row = |id: &str| {
        let found = text.lines().find(|line| line.starts_with(id));
        found.expect("the case has a row")[9..19].to_owned()
    };
    assert!(row("Y1").contains('X') && !row("Y1").contains('.'));
    assert!(row("Y2").contains('o') && !row("Y2").contains('X'));
    let page = std::fs::read_to_string(folder.join("own.html")).expect("it was written");
    let place = |what: &str| page.find(what).expect("the page has it");
    assert!(place(">Y1<") < place(">Y2<") && place(">Y2<") < place(">Y3<"));
    let right = srp(&folder, &["hard-cases", "--cases", ".", "--filter", "Y3"]);
    assert_eq!(right.status.code(), Some(0));
    // What is no view is told with its place.
    let blind =
        "on frame\ncase Y1 no view\ncall picture size 4 4 eye 1 2 3 at 1 2 3 grid 1\ngives off 0\n";
    super::write(&folder, "blind.cases", blind);
    let output = srp(&folder, &["hard-cases", "--cases", "blind.cases"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("blind.cases:2: Y1: the camera's direction"),
        "{said}"
    );
}

#[test]
fn mistakes_in_cases_are_shown() {
    let folder = folder("hard-mistakes");
    for (wrong, told) in [
        ("version 2", "1:1: this tool reads version 1"),
        ("call frob of 1", "6:1: nothing is called `frob`"),
        ("call sinf 1", "6:1: `1` has no name before it"),
        ("call sinf on 1", "6:1: `sinf` has no argument `on`"),
        ("call sinf of 1 2 3 4 5", "6:1: `of` has 5 numbers"),
        (
            "call leaks sphere 9 9 1 0 0 0 seed 1\non tni",
            "6:1: `leaks` needs `rays`",
        ),
        (
            "call ray grid 1e9 from 0 0 0 along 1 0 0\non tni",
            "6:1: 1000000000 is no size",
        ),
        (
            "call picture size 8 6 eye 0 0 4 at 0 0 0 diffuse 2 0 0\non frame\ngives off 0",
            "6:1: 2 is no size of `diffuse`",
        ),
        (
            "call picture size 200 200 eye 0 0 4 at 0 0 0 samples 64\non frame\ngives off 0",
            "6:1: 2560000 rays from the eye are more than 1000000",
        ),
        ("gives hit", "6:1: `hit` is no number"),
        ("gives 1 2", "6:1: the answer has 1 number, not 2"),
        ("on tni", "6:1: `sinf` does not run at the level tni"),
        ("costs frob 1", "6:1: no unit is called `frob`"),
        ("loses frob 1", "6:1: no triangle test is called `frob`"),
        ("within -1", "6:1: `-1` is not a number from 0 on"),
        ("gifs 1", "6:1: `gifs` is no keyword"),
        ("case Y1 again", "6:1: a case `Y1` stands at"),
    ] {
        let (version, line) = match wrong.starts_with("version") {
            true => (wrong, "within 1"),
            false => ("version 1", wrong),
        };
        let text =
            format!("{version}\non srp\ncase Y1 one\ncall sinf of 1\ngives 0.84147096\n{line}\n");
        super::write(&folder, "my.cases", &text);
        let output = srp(&folder, &["hard-cases", "--cases", "my.cases", "--list"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{wrong}: {said}");
        let (place, what) = told.split_once(": ").expect("a place");
        assert!(
            said.contains(&format!("my.cases:{place}\n")),
            "{wrong}: {said}"
        );
        assert!(said.contains(what), "{wrong}: {said}");
    }
}

/// A program in C that tells what an answer may be besides, and tries the square roots among the exported cases.
const OTHER: &str = r#"
#include "cases.c"
#include <math.h>
#include <stdio.h>
#include <string.h>

static void named(const char *keyword, size_t count, const struct srp_named *pairs)
{
    for (size_t k = 0; k < count; k++)
        printf("%s%s %s %.17g%s", k == 0 ? "  " : "", k == 0 ? keyword : "", pairs[k].name, pairs[k].number,
               k + 1 == count ? "\n" : "");
}

int main(void)
{
    int tried = 0;
    for (size_t i = 0; i < srp_case_count; i++) {
        const struct srp_case *c = &srp_cases[i];
        printf("case %s\n", c->id);
        for (size_t k = 0; k < c->mays; k++)
            printf("  may %s\n", c->may[k].words);
        if (c->flushed.words != NULL)
            printf("  flushed %s\n", c->flushed.words);
        named("costs", c->costs, c->cost);
        named("loses", c->losses, c->loss);
        if (strcmp(c->call, "sqrt") != 0)
            continue;
        float of, gives, found;
        memcpy(&of, c->argument[0].bits, 4);
        memcpy(&gives, c->number, 4);
        found = sqrtf(of);
        if (!(found == gives || (isnan(found) && isnan(gives)))) {
            printf("%s: %a, not %a\n", c->id, found, gives);
            return 1;
        }
        tried++;
    }
    return tried > 5 ? 0 : 2;
}
"#;

#[test]
fn cases_go_to_other_programs() {
    let folder = folder("hard-export");
    let all = srp(&folder, &["hard-cases", "--export", "all.cases"]);
    assert_eq!(all.status.code(), Some(0));
    let more = OWN.split_once("case Y2").expect("it has another answer").1;
    let more = more.split_once("case Y3").map_or(more, |(case, _)| case);
    super::write(&folder, "more.cases", &format!("on srp\ncase Y2{more}"));
    for file in ["cases.c", "both.cases", "cases.json"] {
        let both = [
            "hard-cases",
            "--cases",
            "all.cases",
            "--cases",
            "more.cases",
        ];
        let output = srp(&folder, &[&both[..], &["--export", file]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{file}: {said}");
    }
    // What is written in the own form is read as the same.
    let again = [
        "hard-cases",
        "--cases",
        "all.cases",
        "--export",
        "again.cases",
    ];
    assert_eq!(srp(&folder, &again).status.code(), Some(0));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("it was written");
    assert_eq!(read("all.cases"), read("again.cases"));
    let json: serde_json::Value = serde_json::from_str(&read("cases.json")).expect("it is JSON");
    let besides = besides(&read("both.cases"));
    for keyword in ["may", "flushed", "costs", "loses"] {
        assert!(besides.contains(&format!("\n  {keyword} ")), "{keyword}");
    }
    assert_eq!(besides_in(&json), besides);
    let count = json["cases"].as_array().map_or(0, Vec::len);
    let list = srp(&folder, &["hard-cases", "--list"]);
    let list = String::from_utf8_lossy(&list.stdout).lines().count();
    assert!(count == list + 1 && count > 600, "{count} {list}");

    super::write(&folder, "other.c", OTHER);
    let cc = |args: &[&str]| {
        let mut cc = std::process::Command::new("cc");
        cc.current_dir(&folder).args(args).output()
    };
    if cc(&["--version"]).is_err() {
        println!("skipped: there is no cc");
        return;
    }
    let built = cc(&[
        "-Wall", "-Werror", "-std=c99", "other.c", "-lm", "-o", "other",
    ]);
    let built = built.expect("cc can be started");
    assert!(
        built.status.success(),
        "{}",
        String::from_utf8_lossy(&built.stderr)
    );
    let run = std::process::Command::new(folder.join("other")).output();
    let run = run.expect("it can be started");
    let told = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success(), "{told}");
    // C has its own way to write a number.
    let shortest = |word: &str| word.parse().map_or(word.to_owned(), |n: f64| n.to_string());
    let lines = told
        .split('\n')
        .map(|line| match line.trim_start().split_once(' ') {
            Some(("costs" | "loses", _)) => {
                let words: Vec<String> = line.split(' ').map(shortest).collect();
                words.join(" ")
            }
            _ => line.to_owned(),
        });
    assert_eq!(lines.collect::<Vec<_>>().join("\n"), besides);
}

/// Answers that are allowed besides, of cases in their own form.
fn besides(text: &str) -> String {
    let mut told = String::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("case") => told += &format!("case {}\n", words.next().expect("an identifier")),
            Some("may" | "flushed" | "costs" | "loses") => told += &format!("{line}\n"),
            _ => {}
        }
    }
    told
}

/// The same of cases as JSON.
fn besides_in(json: &serde_json::Value) -> String {
    let list = |value: &serde_json::Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &serde_json::Value| value.as_str().expect("it is text").to_owned();
    let words = |value: &serde_json::Value| list(value).iter().map(text).collect::<Vec<_>>();
    let named = |value: &serde_json::Value| {
        let number = |pair: &serde_json::Value| pair["number"].as_f64().expect("it is a number");
        let pair = |pair: &serde_json::Value| format!("{} {}", text(&pair["name"]), number(pair));
        list(value).iter().map(pair).collect::<Vec<_>>()
    };
    let mut told = String::new();
    for case in list(&json["cases"]) {
        told += &format!("case {}\n", text(&case["id"]));
        let may = list(&case["may"]);
        let lines = may.iter().map(|answer| ("may", words(answer)));
        for (keyword, words) in lines.chain([
            ("flushed", words(&case["flushed"])),
            ("costs", named(&case["costs"])),
            ("loses", named(&case["loses"])),
        ]) {
            if !words.is_empty() {
                told += &format!("  {keyword} {}\n", words.join(" "));
            }
        }
    }
    told
}

/// Kernels that mirror along the wrong side of a normal, or leave out what a box is widened by, are found out: a
/// header and a C file take the place of those that come along.
#[test]
fn kernels_of_ones_own_are_tried() {
    let folder = folder("hard-kernels");
    let made = srp(&folder, &["new", "kernels", "mine"]);
    assert_eq!(made.status.code(), Some(0));
    let tried = |filter| {
        let args = ["hard-cases", "--kernels", "mine", "--filter", filter];
        let output = srp(&folder, &args);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), text)
    };
    let (status, text) = tried("V9");
    assert_eq!(status, Some(0), "{text}");
    for (file, filter, right, wrong) in [
        ("vector.h", "V9", "direction - normal", "direction + normal"),
        ("rgs.h", "S5", "reciprocal * widening", "reciprocal"),
    ] {
        let path = format!("mine/{file}");
        let whole = std::fs::read_to_string(folder.join(&path)).expect("it was made");
        assert!(whole.contains(right), "{file}");
        super::write(&folder, &path, &whole.replace(right, wrong));
        let (status, text) = tried(filter);
        assert_eq!(status, Some(1), "{file}: {text}");
        let again = format!("srp hard-cases --kernels mine --filter {filter}");
        assert!(text.contains(&again), "{text}");
    }
}

/// On a machine of narrow formats bounds follow from these: answers keep them, or have none and say why. A kernel that
/// is wrong stays so.
#[test]
fn narrow_formats_are_in_the_bounds() {
    let folder = folder("hard-narrow");
    let source = srp(&folder, &["machine", "source", "sgrt"]);
    let source = String::from_utf8(source.stdout).expect("it is text");
    let float = "  <float add=\"tf32\" multiply=\"tf32\" fused=\"bfloat16\"/>\n  <fu-type ";
    super::write(
        &folder,
        "narrow.xml",
        &source.replacen("  <fu-type ", float, 1),
    );
    assert_eq!(
        srp(&folder, &["new", "kernels", "mine"]).status.code(),
        Some(0)
    );
    let tried = |filter: &str| {
        let args = [
            "hard-cases",
            "--kernels",
            "mine",
            "--machine",
            "narrow.xml",
            "--filter",
            filter,
            "--json",
        ];
        let output = srp(&folder, &args);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
        let results = json["cases"].as_array().into_iter().flatten();
        let results =
            results.flat_map(|case| case["results"].as_array().cloned().unwrap_or_default());
        let on_srp = results.filter(|result| result["level"] == "srp");
        let told = on_srp.map(|r| {
            [&r["verdict"], &r["what"]].map(|v| v.as_str().unwrap_or_default().to_owned())
        });
        (output.status.code(), told.collect::<Vec<_>>())
    };
    let (status, told) = tried("V");
    let count =
        |told: &[[String; 2]], verdict: &str| told.iter().filter(|[v, _]| v == verdict).count();
    assert_eq!((status, count(&told, "wrong")), (Some(0), 0), "{told:?}");
    assert!(count(&told, "bounded") > 20, "{told:?}");
    let reason = |what: &str| what.contains("bfloat16, tf32") || what.contains("narrow formats");
    let mut unbounded = told.iter().filter(|[verdict, _]| verdict == "unbounded");
    assert!(unbounded.all(|[_, what]| reason(what)), "{told:?}");

    let path = folder.join("mine/vector.h");
    let whole = std::fs::read_to_string(&path).expect("it was made");
    let wrong = whole.replace("direction - normal", "direction + normal");
    assert_ne!(wrong, whole);
    super::write(&folder, "mine/vector.h", &wrong);
    let (status, told) = tried("V9");
    assert_eq!(status, Some(1));
    assert!(count(&told, "wrong") > 0, "{told:?}");
}
