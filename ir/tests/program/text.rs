//! `read` and `write` are each other's inverses; mistakes are reported where they are.

use crate::generate;
use srp_ir::pass::compact_program;
use srp_ir::text::{read, write};
use srp_ir::verify;

#[test]
fn random_programs_are_valid_and_read_back() {
    for seed in 0..200 {
        let mut program = generate::program(seed);
        if let Err(violations) = verify(&program) {
            let list: Vec<String> = violations.iter().map(|v| v.to_string()).collect();
            panic!("seed {seed}:\n{}\n{}", list.join("\n"), write(&program));
        }
        let loose = read(&write(&program)).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        compact_program(&mut program);
        let text = write(&program);
        let back = read(&text).unwrap_or_else(|e| panic!("seed {seed}: {e}\n{text}"));
        assert_eq!(back, program, "seed {seed}\n{text}");
        let mut loose = loose;
        compact_program(&mut loose);
        assert_eq!(loose, program, "seed {seed}\n{text}");
        assert_eq!(write(&back), text);
    }
}

/// A listing written by hand comes back, except for comments and numbering.
#[test]
fn listing_comes_back() {
    let text = include_str!("cases/listing.ir");
    let program = read(text).expect("the case is a listing");
    verify(&program).expect("the case is valid");
    assert_eq!(write(&program), text);
}

#[test]
fn mistakes_have_their_place() {
    let in_body = |line: &str| format!("fn0 f(v0: w) {{\nbb0:\n  {line}\n  ret\n}}\n");
    let cases = [
        ("file1 \"a.c\"", "1:1: file0 expected, found file1"),
        ("file0 \"a.c", "1:7: a quote is not closed"),
        (
            "file0 \"a\\q\"",
            "1:10: after \\ comes \", \\ or u{hexadecimal}",
        ),
        (
            "g0 x size 4294967296 align 4",
            "1:11: a number below 2^32 expected, found 4294967296",
        ),
        (
            "g0 x size 4 align 4 {\n  hex 0g\n}",
            "2:7: hexadecimal bytes expected, found 0g",
        ),
        ("g0 x size 4 align 4 {", "1:1: } is missing"),
        (
            "fn0 f(v0: q) {\n}",
            "1:11: a type (p, w, v) expected, found q",
        ),
        ("fn0 f() {\n}", "1:10: a function has at least one block"),
        ("fn0 f() {\nbb0:\n}", "1:10: its last block has no end"),
        (
            &in_body("v1 = frob v0"),
            "3:8: an instruction expected, found frob",
        ),
        (&in_body("v1 = add v0, v7"), "3:16: v7 is not defined"),
        (&in_body("v0 = const 1"), "3:3: v0 is defined twice"),
        (
            &in_body("v1 = const 1, 2"),
            "3:15: the end of the line expected, found ,",
        ),
        (
            &in_body("v1 = call fn0(v0)"),
            "3:3: the results of a call need types",
        ),
        (
            &in_body("sw v0, v0, v0 +99999999999"),
            "3:18: a number below 2^32 expected, found 99999999999",
        ),
        (
            &in_body("v1, v2 = add v0, v0"),
            "3:3: 2 results given, 1 expected",
        ),
        (&in_body("v1 = slot ss0"), "3:13: ss0 is not defined"),
        (&in_body("jump bb9"), "4:3: the block has already ended"),
        (
            &in_body("v1 = const 1 ; x.c:1:2"),
            "3:18: no file is called x.c",
        ),
        (
            &in_body("v1 = const 1 ; 1:2"),
            "3:18: a position is file:line:column",
        ),
    ];
    for (text, expected) in cases {
        let error = read(text).expect_err(text);
        assert_eq!(error.to_string(), expected, "{text}");
    }
}
