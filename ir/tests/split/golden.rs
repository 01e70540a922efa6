//! Cases with their results: the file of the divided program, and the remarks about it.
//! `UPDATE_GOLDEN=1` writes the expectations anew.

use srp_ir::program::{Pos, Program};
use srp_ir::split::{Split, split};
use srp_ir::{dre, text, verify};
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/split/cases")
        .join(name)
}

fn check(name: &str) {
    let listing = std::fs::read_to_string(case(&format!("{name}.ir"))).expect("the case");
    let program = text::read(&listing).unwrap_or_else(|e| panic!("{name}: {e}"));
    verify(&program).unwrap_or_else(|v| panic!("{name}: {v:?}"));
    let result = split(&program);
    result
        .dre
        .verify()
        .unwrap_or_else(|v| panic!("{name}: {v:?}"));
    let file = dre::write(&result.dre);
    assert_eq!(dre::read(&file).expect("is read back"), result.dre);
    compare_case(&format!("{name}.dre.xml"), &file);
    compare_case(&format!("{name}.said"), &said(&program, &result));
}

/// Compares with the expectation of this name.
pub(crate) fn compare_case(name: &str, found: &str) {
    let path = case(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, found).expect("can be written");
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        expected == found,
        "{} differs; found\n{found}",
        path.display()
    );
}

fn said(program: &Program, result: &Split) -> String {
    let show = |pos: Pos| program.show_pos(pos);
    let mut out = String::new();
    for n in &result.not_pipelined {
        let (pos, at) = (show(n.pos), show(n.at));
        let asked = if n.required { "required" } else { "tried" };
        writeln!(out, "{pos}: `{}` ({asked}): {at}: {}", n.name, n.reason).expect("a string");
    }
    for r in &result.remarks {
        let (first, second) = (show(r.first), show(r.second));
        writeln!(out, "`{}`: {first}, {second}: {}", r.kernel, r.doubt).expect("a string");
    }
    for dfg in result.dre.kernels.values() {
        let (mii, cycle) = dfg.rec_mii(|_| 1);
        writeln!(
            out,
            "`{}`: recurrences of unit latency: {mii} {cycle:?}",
            dfg.name
        )
        .expect("a string");
    }
    out
}

#[test]
fn saxpy() {
    check("saxpy");
}

#[test]
fn recurrence() {
    check("recurrence");
}

#[test]
fn parameters() {
    check("parameters");
}

#[test]
fn pointers() {
    check("pointers");
}

#[test]
fn independent() {
    check("independent");
}

#[test]
fn countdown() {
    check("countdown");
}

#[test]
fn refused() {
    check("refused");
}

#[test]
fn calls() {
    check("calls");
}

#[test]
fn exchange() {
    check("exchange");
}
