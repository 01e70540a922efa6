//! Every rule of the verifier has a program that breaks it.

use srp_ir::text::read;
use srp_ir::verify;

fn violations(text: &str) -> Vec<String> {
    let program = read(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    match verify(&program) {
        Ok(()) => Vec::new(),
        Err(found) => found.iter().map(|v| v.to_string()).collect(),
    }
}

/// The violations of a function `f(v0: w, v1: p, v2: v)` with this body.
fn in_function(body: &str) -> Vec<String> {
    violations(&format!(
        "fn0 f(v0: w, v1: p, v2: v) -> w {{\nbb0:\n{body}\n}}\n"
    ))
}

#[test]
fn operands_and_results() {
    let cases = [
        (
            "v3 = add v0, v1\nret v3",
            "fn0: bb0: i0: v1 has type p, where w is expected",
        ),
        (
            "v3 = add v0\nret v3",
            "fn0: bb0: i0: add: 1 values where 2 are expected",
        ),
        (
            "v3 = vext v2 +4\nret v3",
            "fn0: bb0: i0: vext has the immediate 4",
        ),
        (
            "v3 = swz v2 -1\nret v0",
            "fn0: bb0: i0: swz has the immediate -1",
        ),
        (
            "v3 = in -1\nret v3",
            "fn0: bb0: i0: in has the immediate -1",
        ),
        (
            "v3 = add v0, v0 +1\nret v3",
            "fn0: bb0: i0: add has the immediate 1",
        ),
        ("ret v1", "fn0: bb0: v1 has type p, where w is expected"),
        ("ret", "fn0: bb0: return: 0 values where 1 are expected"),
        (
            "br v0, bb1, bb1\nbb1:\nret v0",
            "fn0: bb0: v0 has type w, where p is expected",
        ),
        (
            "v3 = symbol g7\nret v3",
            "fn0: bb0: i0: address of g7, which does not exist",
        ),
        (
            "v3: w = call fn3(v0)\nret v3",
            "fn0: bb0: i0: calls fn3, which does not exist",
        ),
        (
            "v3: w = call fn0(v0)\nret v3",
            "fn0: bb0: i0: arguments: 1 values where 3 are expected",
        ),
        (
            "v3: p = call fn0(v0, v1, v2)\nret v0",
            "fn0: bb0: i0: v3 has type p, where w is expected",
        ),
        (
            "v3: p = call v1()\nret v0",
            "fn0: bb0: i0: v1 has type p, where w is expected",
        ),
    ];
    for (body, expected) in cases {
        assert_eq!(in_function(body), [expected], "{body}");
    }
}

#[test]
fn flow() {
    let cases = [
        ("jump bb0", "fn0: bb0: jumps to the entry"),
        (
            "jump bb1\nbb1(v3: w):\nret v3",
            "fn0: bb0: jump to bb1: 0 values where 1 are expected",
        ),
        (
            "jump bb1(v1)\nbb1(v3: w):\nret v3",
            "fn0: bb0: v1 has type p, where w is expected",
        ),
        (
            "v3 = mov v4\nv4 = mov v0\nret v4",
            "fn0: bb0: i0: uses v4 before its definition",
        ),
        (
            "br v1, bb1, bb2\nbb1:\nv3 = mov v0\njump bb2\nbb2:\nret v3",
            "fn0: bb2: uses v3 before its definition",
        ),
    ];
    for (body, expected) in cases {
        let found = in_function(body);
        assert!(found.contains(&expected.to_owned()), "{body}: {found:?}");
    }
    let loops = "jump bb1(v0)\nbb1(v3: w):\nv4 = add v3, v0\nbr v1, bb1(v4), bb2\nbb2:\nret v4";
    assert_eq!(in_function(loops), [""; 0]);
    let unreached = "ret v0\nbb1:\nv3 = mov v4\nv4 = mov v3\njump bb1";
    assert_eq!(in_function(unreached), [""; 0]);
}

#[test]
fn names_and_globals() {
    let cases = [
        ("file0 \"a\"\nfile1 \"a\"", "two files are called a"),
        ("file0 \"\"", "a file has no name"),
        ("main fn0", "main is fn0, which does not exist"),
        ("g0 x size 4 align 3", "g0: alignment 3 is no power of two"),
        (
            "g0 x size 1 align 1 {\nhex 0000\n}",
            "g0: 2 initial bytes in a size of 1",
        ),
        (
            "g0 x size 4 align 4 {\nreloc 1 g0\n}",
            "g0: relocation at 1 lies outside",
        ),
        (
            "g0 x size 4 align 4 {\nreloc 0 fn0\n}",
            "g0: relocation of fn0, which does not exist",
        ),
        (
            "g0 x size 8 align 4 {\nreloc 0 g0\nreloc 2 g0\n}",
            "g0: relocations overlap",
        ),
        (
            "g0 x size 4 align 4\ng1 x size 4 align 4",
            "two globals are called x",
        ),
        (
            "fn0 f() {\nbb0:\njump bb1\nbb1: kernel k\njump bb2\nbb2: kernel k\njump bb1\n}",
            "two kernels are called k",
        ),
        (
            "fn0 f() {\nss0 x size 4 align 32\nbb0:\nret\n}",
            "fn0: ss0 has alignment 32",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(violations(text), [expected], "{text}");
    }
}
