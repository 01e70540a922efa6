//! Certificates of impossible initiation intervals. The refutation is held against a checker of its own ([`rup`])
//! and against `drat-trim` where that is installed, the folded formula against a program that makes it from the
//! machine and the graph alone (`tests/certificate/fold.py`), and what is called impossible against searches for
//! schedules ([`search`]).

mod rup;
mod search;

use rup::Clauses;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::xml::{StandardArray, standard};
use srp_archdesc::{Unwatched, xml};
use srp_ir::dfg::Dfg;
use srp_ir::graph::{self, Graph, read_edges};
use srp_ir::split;
use srp_scheduler::modulo::{self, Fold, Impossible, Scope};
use srp_studies::certificate::certify;
use srp_tests::{compiled, machine, root};
use srp_toolchain::Session;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A machine from its file.
fn parsed(text: &str) -> Arch {
    srp_archdesc::parse("array.xml", text).unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn mesh(rows: u32, cols: u32) -> Arch {
    parsed(&standard(&StandardArray::mesh(rows, cols)).expect("a mesh there is"))
}

/// A graph from its lists; every operation is an `add`.
fn listed(edges: &str) -> (Graph, String) {
    let mut nodes: Vec<&str> = Vec::new();
    let ends = edges.lines().flat_map(|line| line.split(' ').take(2));
    for node in ends {
        if !nodes.contains(&node) {
            nodes.push(node);
        }
    }
    let ops: String = nodes.iter().map(|node| format!("{node} add\n")).collect();
    let sources = [("g.edges", edges), ("g.ops", &ops)].map(|(name, text)| Source::new(name, text));
    let read = read_edges(&sources[0], &sources[1], &graph::Options::default());
    (read.unwrap_or_else(|mistakes| panic!("{mistakes:?}")), ops)
}

/// The formula of a claim, and its refutation; `None` where there is none.
fn certificate(dfg: &Dfg, arch: &Arch, ii: u32, scope: Scope) -> Option<(String, String)> {
    let claim = Impossible {
        ii,
        scope,
        outright: matches!(scope, Scope::Folded(_)),
    };
    let certificate = certify(dfg, None, arch, claim, &Session::default()).ok()?;
    let text = |bytes| String::from_utf8(bytes).expect("text");
    Some((text(certificate.formula), text(certificate.steps)))
}

fn folded(laps: u32, depth: u32) -> Scope {
    Scope::Folded(Fold { laps, depth })
}

/// Holds a refutation against the checkers.
fn check(formula: &str, steps: &str) {
    let mut clauses = Clauses::read(formula);
    assert!(clauses.refuted_by(steps), "the proof does not hold");
    let clauses = Clauses::read(formula);
    assert!(
        !clauses.implies(&[]),
        "the formula refutes itself, so that any proof holds"
    );
    let folder = folder("drat");
    let (cnf, drat) = (folder.join("f.cnf"), folder.join("f.drat"));
    std::fs::write(&cnf, formula).expect("written");
    std::fs::write(&drat, steps).expect("written");
    let Ok(output) = Command::new("drat-trim").arg(&cnf).arg(&drat).output() else {
        println!("skipped: there is no drat-trim");
        return;
    };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("s VERIFIED"), "{said}");
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("certificate-{name}"));
    std::fs::create_dir_all(&folder).expect("a folder for tests");
    folder
}

#[test]
fn certificates_hold() {
    let arch = machine("tiny");
    let sources = [root().join("tests/certificate/rays.c")];
    let program = compiled(&sources, &arch).unwrap_or_else(|e| panic!("{e}"));
    let dfg = &split::split(&program)
        .dre
        .kernels
        .into_values()
        .next()
        .expect("a loop");
    let scheduled = modulo::schedule(dfg, &arch.srp, &modulo::Options::default(), &Unwatched);
    let scheduled = scheduled.expect("it has a schedule");
    let bound = scheduled.bounds.min_ii();
    assert!(
        bound < scheduled.schedule.ii,
        "a loop that has nothing to prove proves nothing"
    );
    let timed = certificate(dfg, &arch, bound, Scope::Timed { slack: 0 });
    let (formula, steps) = timed.expect("it is impossible");
    check(&formula, &steps);
}

/// A star: the value of `a` has so many consumers, which a sum takes together again.
fn star(consumers: usize) -> String {
    let mut edges = String::new();
    for k in 0..consumers {
        edges += &format!("a c{k} 0\n");
        let sum = if k == 0 {
            "c0".to_owned()
        } else {
            format!("s{k}")
        };
        let next = k + 1;
        if next < consumers {
            edges += &format!("{sum} s{next} 0\nc{next} s{next} 0\n");
        }
    }
    edges
}

#[test]
fn what_is_refuted_at_any_length_has_a_certificate() {
    let arch = mesh(3, 3);
    let (graph, _) = listed(&star(4));
    assert_eq!(modulo::bounds(&graph.dfg, &arch.srp).min_ii(), 1);
    let found = certificate(&graph.dfg, &arch, 1, folded(1, 2));
    let (formula, steps) =
        found.expect("only the centre reaches four others, and they do not meet");
    check(&formula, &steps);
    for line in [
        "c graph: g\n",
        "c machine: mesh_3x3_r8\n",
        "c ii: 1\n",
        "c claim: II = 1 is impossible\n",
    ] {
        assert!(formula.contains(line), "{line}");
    }
}

/// An array with all that the formula has clauses for: latencies, a slow unit, a resource that is shared, links with
/// delays, and files that are written over links.
const UNEVEN: &str = r#"<machine name="uneven">
  <resource name="port" count="1"/>
  <array rows="2" cols="2" topology="mesh">
    <fu row="0" col="0" name="a" pred-out="false"><op class="alu" latency="1" interval="1" uses="port"/>
      <file name="r" kind="static" size="2" from-links="true" write-ports="1"/></fu>
    <fu row="0" col="1" name="b" pred-out="false"><op class="alu" latency="2" interval="2"/></fu>
    <fu row="1" col="0" name="c" pred-out="false"><op class="alu" latency="2" interval="1" uses="port"/>
      <file name="r" kind="rotating" size="1"/></fu>
    <fu row="1" col="1" name="d" pred-out="false"><op class="alu" latency="1" interval="1"/></fu>
    <link from="a" to="d" delay="1"/>
    <link from="d" to="a" delay="2"/>
  </array>
  <vliw slots="0"/>
</machine>"#;

#[test]
fn another_program_makes_the_same_formula() {
    let python = Command::new("python3").arg("--version").output();
    if !python.is_ok_and(|output| output.status.success()) {
        println!("skipped: there is no python3");
        return;
    }
    let folder = folder("fold");
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let recurrence = "x a 0\na b 0\nb c 0\nc a 1\na a 2\nc d 1\nb d 0\nd e 0\nx e 0";
    let cases = [
        (mesh(2, 2), star(3), 2, (1, 2)),
        (mesh(2, 2), star(3), 2, (3, 0)),
        (mesh(2, 3), recurrence.to_owned(), 3, (1, 1)),
        (mesh(2, 3), recurrence.to_owned(), 4, (2, 3)),
        (mesh(3, 3), star(5), 1, (2, 4)),
        (parsed(UNEVEN), recurrence.to_owned(), 4, (1, 2)),
        (parsed(UNEVEN), star(3), 3, (2, 1)),
    ];
    for (arch, edges, ii, (laps, depth)) in cases {
        let (graph, ops) = listed(&edges);
        // Formulas that are satisfiable are compared too.
        let mut formula =
            format!("c ii: {ii}\nc formula: folded, laps {laps}, depth {depth}\n").into_bytes();
        let claim = Impossible {
            ii,
            scope: folded(laps, depth),
            outright: true,
        };
        let certificate = modulo::Certificate {
            formula: &mut formula,
            steps: &mut Vec::new(),
        };
        modulo::certify(&graph.dfg, &arch.srp, claim, &Unwatched, certificate);
        let formula = String::from_utf8(formula).expect("text");
        let files = [
            write("machine.xml", &xml::write(&arch)),
            write("g.edges", &edges),
            write("g.ops", &ops),
            write("g.cnf", &formula),
            root().join("docs/graphs.md"),
        ];
        let program = root().join("tests/certificate/fold.py");
        let output = Command::new("python3").arg(program).args(files).output();
        let output = output.expect("python3 runs");
        let said = String::from_utf8_lossy(&output.stdout);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success(),
            "{}, II {ii}, {laps} laps: {said}{error}",
            arch.name
        );
    }
}
