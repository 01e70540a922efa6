//! Graphs from elsewhere: all forms read to the same, and each mistake is shown as expected.
//! `UPDATE_GOLDEN=1` writes the expectations of mistakes anew.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::diagnostic::{Source, render_all};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Class, Opcode};
use srp_ir::dfg::{Initial, Node, Operand, Order};
use srp_ir::graph::{Graph, Mistakes, Options, read_dot, read_edges, read_json};
use std::fmt::Write;
use std::path::Path;

fn dot(text: &str) -> Result<Graph, Mistakes> {
    read_dot(&Source::new("graph.dot", text), &Options::default())
}

fn json(text: &str) -> Result<Graph, Mistakes> {
    read_json(&Source::new("graph.json", text), &Options::default())
}

fn edges(edges: &str, ops: &str) -> Result<Graph, Mistakes> {
    let (edges, ops) = (
        Source::new("graph.edges", edges),
        Source::new("graph.ops", ops),
    );
    read_edges(&edges, &ops, &Options::default())
}

/// The graph without what depends on the form: its name, positions and files.
fn essence(graph: Result<Graph, Mistakes>) -> String {
    let graph = graph.unwrap_or_else(|mistakes| panic!("{}", render_all(&mistakes, "", false)));
    assert_eq!(graph.dfg.verify(), Ok(()));
    assert!(graph.dfg.is_bare());
    let mut text = String::new();
    for (node, data) in graph.dfg.nodes.iter() {
        let (name, op, operands) = (&graph.names[node], data.op, &data.operands);
        writeln!(text, "{name} {op} {operands:?}").expect("strings can be written");
    }
    let (order, latencies) = (&graph.dfg.order, &graph.latencies);
    writeln!(text, "{order:?} {latencies:?}").expect("strings can be written");
    text
}

/// The example of the reference in one form: what stands between two lines of its text.
fn example(from: &str) -> &'static str {
    let text = include_str!("../../../docs/graphs.md");
    let (_, rest) = text
        .split_once(from)
        .expect("the reference has the example");
    rest.split_once("```").expect("it ends").0
}

#[test]
fn the_forms_of_the_reference_are_one_graph() {
    let as_json = essence(json(example("```json\n")));
    let drawn = example("```\ndigraph");
    assert_eq!(essence(dot(&format!("digraph{drawn}"))), as_json);
    // Lists of edges have no orders, and latencies.
    let list = essence(edges(
        &format!("# fir.edges{}", example("# fir.edges")),
        "x load\nm mul\nsum add\ny store\n",
    ));
    let graph = json(example("```json\n")).expect("it was read");
    assert_eq!(
        graph.dfg.order,
        [Order {
            from: Node::new(3),
            to: Node::new(0),
            distance: 1
        }]
    );
    let values = as_json.lines().take(4).collect::<Vec<_>>();
    assert_eq!(list.lines().take(4).collect::<Vec<_>>(), values);
    let carried = Operand::Node {
        node: Node::new(2),
        init: vec![Initial::Any],
    };
    assert_eq!(graph.dfg.nodes[Node::new(2)].operands[1], carried);
}

#[test]
fn an_edge_to_itself_is_carried() {
    let graph = edges("a a\na b\nb b 2\n", "a add\nb add\n").expect("it was read");
    assert_eq!(graph.carried, [Node::new(0)]);
    let distances = graph.dfg.nodes.values().flat_map(|n| &n.operands);
    let distances = distances.map(|o| match o {
        Operand::Node { init, .. } => init.len(),
        _ => 0,
    });
    assert_eq!(distances.collect::<Vec<_>>(), [1, 0, 2]);
}

/// A random graph in all three forms.
fn forms(random: &mut Pcg32) -> [String; 4] {
    let mut below = |n: u32| random.next_u32() % n;
    let nodes = 1 + below(12);
    let ops = [
        "add",
        "MUL",
        "Load",
        "cmp",
        "select",
        "getelementptr",
        "fmul",
        "store",
    ];
    let [mut dot, mut json, mut list, mut names] = [(); 4].map(|()| String::new());
    let put = |text: &mut String, line: String| {
        text.push_str(&line);
        text.push('\n');
    };
    put(&mut dot, "strict digraph {".to_owned());
    put(&mut json, "{\"nodes\": [".to_owned());
    for n in 0..nodes {
        let (op, comma) = (ops[below(8) as usize], if n == 0 { "" } else { "," });
        put(&mut dot, format!("  \"v {n}\" [opcode={op}]"));
        put(
            &mut json,
            format!("{comma}{{\"op\": \"{op}\", \"id\": \"v {n}\"}}"),
        );
        put(&mut names, format!("v_{n} {op}"));
    }
    put(&mut json, "], \"edges\": [".to_owned());
    for e in 0..below(20) {
        let (from, to) = (below(nodes), below(nodes));
        let distance = u32::from(from >= to) + below(4) / 3;
        let comma = if e == 0 { "" } else { "," };
        put(
            &mut dot,
            format!("  \"v {from}\" -> \"v {to}\" [distance={distance}, latency=1];"),
        );
        let ends = format!("\"from\": \"v {from}\", \"to\": \"v {to}\"");
        put(
            &mut json,
            format!("{comma}{{{ends}, \"distance\": {distance}, \"latency\": 1}}"),
        );
        put(&mut list, format!("v_{from} v_{to} {distance} 1"));
    }
    put(&mut dot, "}".to_owned());
    put(&mut json, "]}".to_owned());
    [dot, json, list, names]
}

#[test]
fn random_graphs_are_the_same_in_all_forms() {
    let mut random = Pcg32::seed_from_u64(1);
    for _ in 0..300 {
        let [as_dot, as_json, list, names] = forms(&mut random);
        let drawn = essence(dot(&as_dot));
        assert_eq!(drawn, essence(json(&as_json)), "{as_dot}{as_json}");
        assert_eq!(
            drawn.replace("v ", "v_"),
            essence(edges(&list, &names)),
            "{as_dot}{list}"
        );
    }
}

#[test]
fn operands_stand_where_edges_say() {
    let text = "digraph { node [op=add]; a; b; c; d; t [op=mac];
        a -> t; b -> t [operand=0]; c -> t [operand=RHS]; d -> t [operand=any]; a -> t [operand=9] }";
    let graph = dot(text).expect("it is one");
    let target = graph
        .names
        .iter()
        .find(|(_, name)| *name == "t")
        .expect("t")
        .0;
    let names: Vec<&str> = (graph.dfg.nodes[target].producers())
        .map(|(from, _)| graph.names[from].as_str())
        .collect();
    assert_eq!(names, ["b", "c", "a", "d", "a"]);
}

#[test]
fn labels_and_classes_say_what_nodes_do() {
    let op = |attributes: &str, any_op| {
        let source = Source::new("g.dot", format!("digraph {{ n [{attributes}] }}"));
        let graph = read_dot(&source, &Options { any_op });
        graph.map(|g| g.dfg.nodes[Node::new(0)].op).ok()
    };
    assert_eq!(op("label=\"%7 = mul i32\\n%5\"", None), Some(Opcode::Mul));
    assert_eq!(op("label=\"ADD_12\"", None), Some(Opcode::Add));
    assert_eq!(op("label=\"load3\", op=fmul", None), Some(Opcode::Fmul));
    assert_eq!(op("op=\"add.i32\"", None), Some(Opcode::Add));
    assert_eq!(op("op=vfma", None), Some(Opcode::Vfma));
    // Predicates are words.
    assert_eq!(op("op=lt", None), Some(Opcode::Sub));
    assert_eq!(op("op=frobnicate", None), None);
    let alu = op("op=frobnicate", Some(Class::Imul)).expect("any will do");
    assert_eq!(alu.class(), Class::Imul);
}

#[test]
fn stores_that_pass_a_value_on_are_loads() {
    let graph = dot(
        "digraph { a [op=add]; s [op=store]; t [op=storeb]; a -> s; a -> t; t -> a [distance=1] }",
    );
    let graph = graph.expect("it is one");
    assert_eq!(graph.dfg.verify(), Ok(()));
    let ops: Vec<Opcode> = graph.dfg.nodes.values().map(|n| n.op).collect();
    assert_eq!(ops, [Opcode::Add, Opcode::Sw, Opcode::Lw]);
}

/// A graph as its file's name says, with the operations behind a line `# ops` of lists of edges: at
/// the same place in a text of their own, so that what is shown of the file is right.
fn read_case(name: &str, text: &str) -> Result<Graph, Mistakes> {
    let source = |name: &str, text: &str| Source::new(name, text);
    if name.ends_with(".dot") {
        read_dot(&source(name, text), &Options::default())
    } else if name.ends_with(".json") {
        read_json(&source(name, text), &Options::default())
    } else {
        let (list, ops) = text.split_once("# ops\n").expect("both files in one");
        let before = " ".repeat(text.len() - ops.len());
        let ops = source(name, &format!("{before}{ops}"));
        read_edges(&source(name, list), &ops, &Options::default())
    }
}

#[test]
fn every_mistake_is_shown_as_expected() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/graphs/errors");
    let mut wrong = Vec::new();
    let mut cases: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder of cases")
        .map(|entry| entry.expect("a case").path())
        .filter(|path| path.extension().is_some_and(|e| e != "stderr"))
        .collect();
    cases.sort();
    for path in cases {
        let text = std::fs::read_to_string(&path).expect("a readable case");
        let name = path.file_name().and_then(|n| n.to_str()).expect("a name");
        let shown = match read_case(name, &text) {
            Ok(_) => "nothing is wrong\n".to_owned(),
            Err(mistakes) => render_all(&mistakes, &text, false),
        };
        let expected = folder.join(format!("{name}.stderr"));
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(&expected, shown).expect("a writable expectation");
        } else if std::fs::read_to_string(&expected).ok().as_ref() != Some(&shown) {
            wrong.push(format!("{name} shows\n{shown}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Files with a few bytes changed are read or refused, always with a place, never with a panic.
#[test]
fn damaged_files_are_refused_or_read() {
    let mut random = Pcg32::seed_from_u64(2);
    let pieces = [
        "{", "}", "[", "]", "\"", "->", "<", ">", "\\", ":", "=", ",", "é", "#", "/*", "-1", "9",
    ];
    for round in 0..600 {
        let [as_dot, as_json, list, names] = forms(&mut random);
        let mut texts = [as_dot, as_json, list];
        let text = &mut texts[round % 3];
        for _ in 0..1 + random.next_u32() % 3 {
            let at = text.floor_char_boundary(random.next_u32() as usize % (text.len() + 1));
            let piece = pieces[random.next_u32() as usize % pieces.len()];
            if random.next_u32() % 2 == 0 {
                text.insert_str(at, piece);
            } else {
                let end = text.ceil_char_boundary((at + 1).min(text.len()));
                text.replace_range(at..end, piece);
            }
        }
        let result = match round % 3 {
            0 => dot(text),
            1 => json(text),
            _ => edges(text, &names),
        };
        match result {
            Ok(graph) => assert_eq!(graph.dfg.verify(), Ok(()), "{text}"),
            Err(mistakes) => assert!(mistakes.iter().all(|m| m.primary.is_some()), "{text}"),
        }
    }
}
