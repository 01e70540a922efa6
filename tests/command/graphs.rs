//! Bare graphs: those that are mapped, and those that are refused with their places.

use super::{folder, srp, write};

pub(super) const GRAPH: &str = "digraph accumulate {
  x [op=load]; m [op=mul]; sum [op=add]; y [op=store];
  x -> m -> sum -> y; sum -> sum [distance=1];
}
";

#[test]
fn graphs_are_mapped() {
    let folder = folder("graphs");
    write(&folder, "accumulate.dot", GRAPH);
    write(&folder, "pair.edges", "a b 0 1\nb a 2 1\n");
    write(&folder, "pair.ops", "a ADD\nb LOAD\n");
    let mesh = [
        "machine", "mesh", "--rows", "2", "--cols", "2", "-o", "mesh.xml",
    ];
    assert!(srp(&folder, &mesh).status.success());
    let stdout = |args: &[&str]| {
        let output = srp(&folder, args);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "srp {args:?}: {message}");
        String::from_utf8(output.stdout).expect("text is written")
    };
    let args = ["map", ".", "--machine", "mesh.xml", "-o", "all.sched.xml"];
    let text = stdout(&args);
    assert!(
        text.contains("2 of 2 graphs mapped onto `mesh_2x2_r8`, 2 at their bound"),
        "{text}"
    );
    let schedules = std::fs::read_to_string(folder.join("all.sched.xml")).expect("it was written");
    assert!(
        schedules.contains("<kernel name=\"accumulate\""),
        "{schedules}"
    );
    let json = stdout(&["map", "accumulate.dot", "--mesh", "2x2", "--json"]);
    assert!(
        json.contains("\"rec_mii\": 1") && json.contains("\"ii\": 1"),
        "{json}"
    );
    // Obstacles have the names of the file.
    write(
        &folder,
        "clique.dot",
        "digraph { a [op=add]; b [op=add]; c [op=add]; d [op=add];
         a -> b; a -> c; a -> d; b -> c; b -> d; c -> d; }",
    );
    let text = stdout(&["map", "clique.dot", "--mesh", "1x4", "--effort", "0.05"]);
    let named = |from: char| text.contains(&format!("at II = 2, no route from `{from}` to `"));
    assert!(
        "abc".chars().any(named) && !text.contains("of line"),
        "{text}"
    );
    // Four loads on one unit that loads; what a graph without a schedule leaves to the others.
    write(
        &folder,
        "loads.dot",
        "digraph { a [op=load]; b [op=load]; s [op=add]; a -> s; b -> s; c [op=load]; d [op=load]; }",
    );
    let one = [
        "machine",
        "mesh",
        "--rows",
        "1",
        "--cols",
        "2",
        "--memory-columns",
        "1",
        "-o",
        "one.xml",
    ];
    assert!(srp(&folder, &one).status.success());
    let alone = ["--machine", "one.xml", "--no-expansion", "--what-if"];
    let text = stdout(&[&["map", "loads.dot"][..], &alone[..]].concat());
    assert!(text.contains("expanded II  contexts"), "{text}");
    assert!(text.contains(" too: II = 3, +"), "{text}");
    let impossible = GRAPH.replace("distance=1", "distance=1000");
    write(&folder, "impossible.dot", &impossible);
    let some = [
        "map",
        "impossible.dot",
        "loads.dot",
        "--machine",
        "one.xml",
        "-o",
        "some.sched.xml",
    ];
    let output = srp(&folder, &some);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("some.sched.xml: schedules of 1 of 2 graphs"),
        "{said}"
    );
    assert!(folder.join("some.sched.xml").exists());
}

#[test]
fn graphs_at_fault_are_refused() {
    let folder = folder("graphs_at_fault");
    write(&folder, "op.dot", &GRAPH.replace("op=mul", "op=mull"));
    write(
        &folder,
        "cycle.dot",
        &GRAPH.replace("sum -> sum [", "sum -> m ["),
    );
    let cycle = std::fs::read_to_string(folder.join("cycle.dot")).expect("it was written");
    write(&folder, "cycle.dot", &cycle.replace(" [distance=1]", ""));
    write(&folder, "text.json", "{\"nodes\": 1}");
    write(&folder, "alone.edges", "a b\n");
    write(&folder, "fine.dot", GRAPH);
    let refuses = |args: &[&str], says: &[&str]| {
        let output = srp(&folder, args);
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert_eq!(output.status.code(), Some(1), "srp {args:?}: {said}");
        for part in says {
            assert!(
                said.contains(part),
                "srp {args:?} does not say {part:?}:\n{said}"
            );
        }
    };
    let mesh = ["--mesh", "2x2"];
    let map = |file: &'static str| [&["map", file][..], &mesh[..]].concat();
    refuses(
        &map("op.dot"),
        &["op.dot:2:22", "did you mean `mul`?", "^^^^"],
    );
    refuses(&map("cycle.dot"), &["cycle.dot:3:", "sum → m"]);
    refuses(&map("text.json"), &["text.json:1:11", "a list of nodes"]);
    refuses(&map("alone.edges"), &["alone.ops", "no such file"]);
    refuses(&map("missing.dot"), &["missing.dot"]);
    let no_load = ["--mesh", "2x2", "--set", "fu-type[*].classes=alu"];
    refuses(
        &[&["map", "fine.dot"][..], &no_load].concat(),
        &["fine.dot:2: node `x`: no unit of the array runs"],
    );
    refuses(&map("."), &["1 of 5 graphs mapped", "cycle.dot:3:"]);
    let any = ["map", "op.dot", "--mesh", "2x2", "--any-op", "imul"];
    assert!(srp(&folder, &any).status.success());
    // What runs no program says so.
    write(&folder, "main.c", "int main(void)\n{\n    return 0;\n}\n");
    let mesh = [
        "machine", "mesh", "--rows", "2", "--cols", "2", "-o", "mesh.xml",
    ];
    assert!(srp(&folder, &mesh).status.success());
    refuses(&["run", "main.c", "--machine", "mesh.xml"], &["VLIW slot"]);
    let unknown = ["map", "fine.dot", "--mesh", "2x2", "--any-op", "alou"];
    assert_eq!(srp(&folder, &unknown).status.code(), Some(2));
    assert_eq!(srp(&folder, &["map", "fine.dot"]).status.code(), Some(2));
}

/// Units without links, and one file with one port to write: all values but those that a unit keeps go through it.
const ONE_PORT: &str = "<machine name=\"one_port\">
  <vliw slots=\"0\"/>
  <op class=\"alu\"/>
  <fu-type name=\"f\" width=\"32\" classes=\"alu\"/>
  <array rows=\"2\" cols=\"4\" topology=\"none\">
    <row units=\"f f f f\"/>
    <file name=\"g\" kind=\"rotating\" width=\"32\" size=\"64\" read-ports=\"8\" readers=\"all\" writers=\"all\"/>
  </array>
</machine>
";

#[test]
fn what_there_is_no_more_of_is_told() {
    let folder = folder("graphs-full");
    write(&folder, "one_port.xml", ONE_PORT);
    write(
        &folder,
        "tree.dot",
        "digraph { a [op=add]; b [op=add]; c [op=add]; d [op=add]; e [op=add]; f [op=add]; g [op=add];
         a -> e; b -> e; c -> f; d -> f; e -> g; f -> g; }",
    );
    let map = |more: &[&str]| {
        let args = ["map", "tree.dot", "--machine", "one_port.xml"];
        let output = srp(&folder, &[&args[..], more].concat());
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stderr.is_empty());
        String::from_utf8(output.stdout).expect("text is written")
    };
    let text = map(&[]);
    let told = |what: &str| text.lines().any(|line| line.contains(what));
    assert!(told("all taken at II = "), "{text}");
    assert!(told("ports to write of g ("), "{text}");
    // More of it lowers the II, and then it is not what is full.
    let interval = |text: &str| -> serde_json::Value {
        let table: serde_json::Value = serde_json::from_str(text).expect("it is JSON");
        table["graphs"][0]["mapping"].clone()
    };
    let (one, four) = (
        interval(&map(&["--json"])),
        interval(&map(&[
            "--json",
            "--set",
            "array/file[name=g].write-ports=8",
        ])),
    );
    assert!(one["ii"].as_u64() > four["ii"].as_u64(), "{one} {four}");
    let parts = |mapping: &serde_json::Value| mapping["fullest"].to_string();
    assert!(parts(&one).contains("ports to write of g"), "{one}");
    assert!(!parts(&four).contains("ports to write of g"), "{four}");
    // The mesh of `--mesh` is as studies have it: what is told of its clock would be no news.
    let mesh = srp(&folder, &["map", "tree.dot", "--mesh", "2x2"]);
    assert!(mesh.status.success() && mesh.stderr.is_empty());
}
