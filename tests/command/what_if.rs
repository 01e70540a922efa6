//! `--what-if`: what is said to lower an II lowers it to what is said.

use super::{folder, stdout, write};
use serde_json::Value;
use std::path::Path;

/// The changed machine gives the II that trying the change promised.
#[test]
fn what_to_do_holds_on_the_changed_machine() {
    let folder = folder("report_what_if");
    let text = "\
static int a[64], b[64], c[64], d[64];
static float x[64], y[64];
void add(int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        d[i] = a[i] + b[i] + c[i];
}
void mix(int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        d[i] = (a[i] + b[i]) * (c[i] ^ (b[i] << 3)) + (a[i] >> 2) * (c[i] & 15);
}
void invert(int n)
{
#pragma srp kernel
    for (int i = 0; i < n; i++)
        y[i] = 1.0f / x[i];
}
";
    write(&folder, "loops.c", text);
    let machines = Path::new(env!("CARGO_MANIFEST_DIR")).join("archdesc/machines/sgrt.xml");
    let sgrt = std::fs::read_to_string(machines).expect("the machine is there");
    let edited = |name: &str, from: &str, to: &str| {
        assert!(sgrt.contains(from), "{from}");
        write(&folder, name, &sgrt.replace(from, to));
    };
    let port = |n: u32| format!("name=\"sram_port\" count=\"{n}\"");
    edited("one.xml", &port(4), &port(1));
    edited("two.xml", &port(4), &port(2));
    let division = "<op class=\"fdiv\"";
    let every = |cycles: u32| format!("{division} latency=\"12\" interval=\"{cycles}\"");
    edited("slow.xml", division, &every(8));
    edited("quick.xml", division, &every(1));
    let cases = [
        ("one.xml", "two.xml", "add", "one more sram_port"),
        ("slow.xml", "quick.xml", "invert", "fdiv issued every cycle"),
    ];
    for (before, after, kernel, what) in cases {
        let of = |machine: &str| {
            let args = [
                "report",
                "loops.c",
                "--kernel",
                kernel,
                "--what-if",
                "--json",
                "--machine",
            ];
            let json = stdout(&folder, &[&args[..], &[machine]].concat(), 0);
            let json: Value = serde_json::from_str(&json).expect("JSON");
            json["loops"][0].clone()
        };
        let (now, then) = (of(before), of(after));
        let changes = now["what_if"]["changes"].as_array().expect("a list");
        let promised = changes.iter().find(|c| c["what"] == what);
        let promised = promised.unwrap_or_else(|| panic!("no {what:?} in {changes:?}"));
        assert_eq!(promised["ii"], then["ii"], "{what}");
        assert!(now["ii"].as_u64() > then["ii"].as_u64(), "{what}");
        let hint = now["hint"].as_str().expect("text");
        assert!(hint.contains("would give II = "), "{hint}");
    }
}

/// Iterations that may meet in an element are not told to be apart by names or by `restrict`, which would change nothing.
#[test]
fn what_may_meet_in_an_element_is_not_told_to_be_apart() {
    let folder = folder("report_histogram");
    let text = "\
int bins[16];
void count(const int *restrict a, int n)
{
    for (int i = 0; i < n; i++)
        bins[a[i] & 15]++;
}
void apart(const int *a, int *b, int n)
{
    for (int i = 0; i < n; i++)
        b[i] = b[i] * 3 + a[i];
}
";
    write(&folder, "count.c", text);
    let report = |file: &str| {
        let json = stdout(&folder, &["report", file, "--what-if", "--json"], 0);
        let json: Value = serde_json::from_str(&json).expect("JSON");
        let of = |kernel: &str| {
            let mut loops = json["loops"].as_array().into_iter().flatten();
            loops
                .find(|l| l["kernel"] == kernel)
                .expect("it is on the array")
                .clone()
        };
        [of("count"), of("apart")]
    };
    let remedies = |l: &Value| {
        let changes = l["what_if"]["changes"].as_array().into_iter().flatten();
        let told = |change: &Value| {
            let words = ["restrict", "independent"];
            let word = words
                .into_iter()
                .find(|w| change["what"].to_string().contains(w))?;
            Some((word, change["ii"].clone()))
        };
        changes.filter_map(told).collect::<Vec<_>>()
    };
    let [count, apart] = report("count.c");
    let [(word, ii)] = &remedies(&count)[..] else {
        panic!("{count}");
    };
    assert_eq!(*word, "independent");
    let pragma = "#pragma srp independent(bins)\n    for (int i = 0; i < n; i++)\n        bins";
    let said = text.replace("for (int i = 0; i < n; i++)\n        bins", pragma);
    assert_ne!(said, text);
    write(&folder, "said.c", &said);
    assert_eq!(report("said.c")[0]["ii"], *ii);
    let [(word, ii)] = &remedies(&apart)[..] else {
        panic!("{apart}");
    };
    assert_eq!(*word, "restrict");
    let said = text.replace(
        "const int *a, int *b",
        "const int *restrict a, int *restrict b",
    );
    write(&folder, "said.c", &said);
    assert_eq!(report("said.c")[1]["ii"], *ii);
}

/// Larger arrays are tried too, and the setting makes what is promised.
#[test]
fn a_row_or_a_column_more_is_tried() {
    let folder = folder("what_if_larger");
    let nodes = (0..6).map(|i| format!("n{i} [op=add];"));
    let nodes: String = nodes.collect();
    write(&folder, "six.dot", &format!("digraph {{ {nodes} }}"));
    let mesh = ["map", "six.dot", "--mesh", "2x2", "--json"];
    let map = |more: &[&str]| -> Value {
        let text = stdout(&folder, &[&mesh[..], more].concat(), 0);
        serde_json::from_str(&text).expect("JSON")
    };
    let report = map(&["--what-if"]);
    assert_eq!(report["graphs"][0]["mapping"]["ii"], 2);
    let changes = report["graphs"][0]["what_if"]["changes"]
        .as_array()
        .expect("changes");
    for (what, setting) in [
        ("one more row of units", "array.rows=3"),
        ("one more column of units", "array.cols=3"),
    ] {
        let change = changes.iter().find(|change| change["what"] == what);
        let change = change.expect(what);
        assert_eq!(
            (&change["ii"], &change["set"][0]),
            (&1.into(), &setting.into())
        );
        assert_eq!(map(&["--set", setting])["graphs"][0]["mapping"]["ii"], 1);
    }
}

/// Where several bounds are equal, all of them are named, what lowers them together is tried, and it gives what is promised.
#[test]
fn changes_that_help_only_together_are_found() {
    let folder = folder("what_if_together");
    let text = |resources: &str, classes: &str| {
        format!(
            r#"<machine name="small">{resources}
<fu-type name="pe" pred-out="false" constants="2" classes="alu load {classes}">
  <file name="r" kind="rotating" size="4"/>
</fu-type>
<array rows="2" cols="3" topology="mesh"><row units="pe"/></array>
<vliw slots="0"/>
</machine>"#
        )
    };
    let port = r#"<resource name="port" count="2"/><op class="load" uses="port"/>"#;
    let product = r#"<resource name="product" count="1"/><op class="imul" uses="product"/>"#;
    write(&folder, "two.xml", &text(port, ""));
    write(
        &folder,
        "three.xml",
        &text(&[port, product].concat(), "imul"),
    );
    let edges = "a -> d; b -> d; c -> e; d -> e; e -> f; f -> g;";
    let graph = |what: &str| {
        let ops = [("abc", "load"), ("de", what), ("fg", "add")];
        let nodes = ops
            .iter()
            .flat_map(|(nodes, op)| nodes.chars().map(move |n| (n, op)));
        let nodes: String = nodes.map(|(n, op)| format!("{n} [op={op}];")).collect();
        format!("digraph {{ {nodes} {edges} }}")
    };
    write(&folder, "two.dot", &graph("add"));
    write(&folder, "three.dot", &graph("mul"));
    let ports = "resource[name=port].count=3";
    let products = "resource[name=product].count=2";
    for (name, why, settings) in [
        (
            "two",
            "7 operations of alu, load on 6 units; 3 uses of port, 2 a cycle",
            &[ports][..],
        ),
        (
            "three",
            "7 operations of alu, imul, load on 6 units; 3 uses of port, 2 a cycle; 2 uses of product, 1 a cycle",
            &[ports, products],
        ),
    ] {
        let map = |more: &[&str]| -> Value {
            let (graph, machine) = (format!("{name}.dot"), format!("{name}.xml"));
            let args = ["map", &graph, "--machine", &machine, "--json"];
            let text = stdout(&folder, &[&args[..], more].concat(), 0);
            let json: Value = serde_json::from_str(&text).expect("JSON");
            json["graphs"][0].clone()
        };
        let report = map(&["--what-if"]);
        assert_eq!(report["mapping"]["ii"], 2);
        assert_eq!(report["mapping"]["res_mii_why"], why);
        let changes = report["what_if"]["changes"].as_array().expect("changes");
        for larger in ["array.rows=3", "array.cols=4"] {
            let settings = [&[larger][..], settings].concat();
            let is_it = |change: &&Value| {
                let set = change["set"].as_array().expect("settings");
                set.iter().all(|set| settings.iter().any(|s| set == s))
                    && set.len() == settings.len()
            };
            let change = changes
                .iter()
                .find(is_it)
                .unwrap_or_else(|| panic!("{settings:?}: {changes:?}"));
            let set: Vec<&str> = settings.iter().flat_map(|s| ["--set", s]).collect();
            assert_eq!(change["ii"], map(&set)["mapping"]["ii"]);
        }
    }
}

/// Links that lead into the units' own files are tried where they do not, and take area.
#[test]
fn links_into_files_are_tried() {
    let folder = folder("what_if_from_links");
    let nodes = "abcdef".chars().map(|n| format!("{n} [op=add];"));
    let nodes: String = nodes.collect();
    let edges = "a -> b; b -> c; c -> d; d -> e; a -> f; e -> f; b -> f;";
    write(
        &folder,
        "late.dot",
        &format!("digraph {{ {nodes} {edges} }}"),
    );
    let machine = r#"<machine name="chain">
<fu-type name="pe" pred-out="false" classes="alu"><file name="r" kind="rotating" size="4"/></fu-type>
<array rows="2" cols="4" topology="mesh"><row units="pe"/></array>
<vliw slots="0"/>
</machine>"#;
    write(&folder, "chain.xml", machine);
    let map = |more: &[&str]| -> Value {
        let args = ["map", "late.dot", "--machine", "chain.xml", "--json"];
        let text = stdout(&folder, &[&args[..], more].concat(), 0);
        let json: Value = serde_json::from_str(&text).expect("JSON");
        json["graphs"][0].clone()
    };
    let report = map(&["--what-if"]);
    let setting = "fu-type[*]/file[*].from-links=true";
    let mut changes = report["what_if"]["changes"]
        .as_array()
        .into_iter()
        .flatten();
    let change = changes.find(|change| change["set"][0] == setting);
    let change = change.unwrap_or_else(|| panic!("{report}"));
    assert!(change["mm2"].as_f64() > Some(0.0), "{change}");
    assert_eq!(change["ii"], map(&["--set", setting])["mapping"]["ii"]);
}

/// A large loop, on an array with too few contexts for it: the II with more of them is that of the machine that has them.
#[test]
fn a_large_loop_has_the_ii_that_was_told() {
    let folder = folder("report_what_if_large");
    write(&folder, "software.xml", SOFTWARE);
    let kernel = Path::new(env!("CARGO_MANIFEST_DIR")).join("kernels/micro/saxpy.c");
    let kernel = kernel.to_str().expect("the path is text");
    let report = |more: &[&str]| -> Value {
        let args = ["report", kernel, "--kernel", "main", "--json"];
        let machine = ["--machine", "software.xml"];
        let text = stdout(&folder, &[&args, &machine[..], more].concat(), 0);
        serde_json::from_str(&text).expect("the report is JSON")
    };
    let told = report(&["--what-if"]);
    let changes = &told["not_pipelined"][0]["what_if"]["changes"];
    let mut changes = changes.as_array().into_iter().flatten();
    let setting = "array.contexts=80";
    let more = changes.find(|change| change["set"][0] == setting);
    let more = more.expect("more contexts bring it onto the array");
    assert_eq!(more["ii"], report(&["--set", setting])["loops"][0]["ii"]);
}

/// A machine that computes some operations in software, with few contexts.
const SOFTWARE: &str = r#"<machine name="software">
<resource name="sram_port" count="2"/>
<resource name="mulport" count="1"/>
<op class="load" latency="4" uses="sram_port"/>
<op class="store" uses="sram_port"/>
<op class="imul" latency="4" interval="3" uses="mulport"/>
<op class="fmul" latency="5" interval="2" uses="mulport"/>
<op class="fadd" latency="4" interval="2"/>
<fu-type name="ctl" width="128" constants="1" classes="alu imul idiv pred cvt lane load store cload cstore tex io branch fmul fadd fma">
  <file name="r" kind="rotating" size="4" read-ports="1" from-links="true"/>
  <file name="s" kind="static" size="2"/>
</fu-type>
<fu-type name="int" width="32" pred-out="false" classes="alu pred">
  <file name="r" kind="rotating" size="4" read-ports="2"/>
</fu-type>
<fu-type name="fp" width="32" classes="alu fadd fmul pred cvt">
  <file name="r" kind="rotating" size="4" read-ports="2" from-links="true"/>
</fu-type>
<array rows="3" cols="5" topology="mesh" link-delay="1" contexts="40">
  <row units="ctl int ctl int fp"/>
  <row units="int fp int fp int"/>
  <row units="fp int fp int ctl"/>
  <file name="word" kind="central" width="32" size="24" read-ports="3"/>
  <file name="vec" kind="central" width="128" size="16"/>
  <file name="pred" kind="central" width="1" size="8"/>
</array>
<vliw slots="2" branch-delay="3" mode-switch="10" preload-width="1"/>
<system cores="1" srp-mhz="800" tni-mhz="800">
  <sram size="64K" banks="2" width="4"/>
  <tni trvs="1" ists="2" pipeline="single" stacks="4"/>
</system>
</machine>
"#;
