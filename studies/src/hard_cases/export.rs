//! Cases for other ray tracers and other tools: as C, and in the form of the catalogue.

use super::catalogue::{VERSION, number};
use super::{Case, Level};
use std::fmt::Write;

const HEAD: &str = "\
#include <stddef.h>
#include <stdint.h>

/* An argument: the bits of its floats. */
struct srp_argument {
    const char *name;
    size_t words;
    const uint32_t *bits;
};

/* An answer in words, the numbers among these, and their bits. */
struct srp_answer {
    const char *words;
    size_t numbers;
    const uint32_t *number;
};

/* An approximate unit and how often its error may go into the answer, or a triangle test and the share of rays
   that it may lose. */
struct srp_named {
    const char *name;
    double number;
};

/* A case: a call with its arguments, and the answer that it has to give. */
struct srp_case {
    const char *id, *title, *call;
    size_t arguments;
    const struct srp_argument *argument;
    const char *gives;    /* the answer in words */
    size_t numbers;       /* the numbers among these, and their bits */
    const uint32_t *number;
    double within;        /* units of the last place that a number may be off */
    const char *oracle, *source;
    size_t mays;          /* other answers that are allowed */
    const struct srp_answer *may;
    struct srp_answer flushed; /* the answer where subnormals are flushed; no words where it is the same */
    size_t costs, losses; /* units, and triangle tests */
    const struct srp_named *cost, *loss;
};
";

/// Cases as C that stands alone: an array `srp_cases` of `srp_case_count`.
pub fn c(cases: &[Case]) -> String {
    let mut text = String::from("/* Hard cases of float arithmetic in ray tracing. */\n");
    text += HEAD;
    for (i, case) in cases.iter().enumerate() {
        arrays(&mut text, i, case);
    }
    text += "\nstatic const struct srp_case srp_cases[] = {\n";
    for (i, case) in cases.iter().enumerate() {
        let [id, title, call] = [&case.id, &case.title, &case.call].map(|s| quoted(s));
        let source = quoted(&case.source);
        let arguments = counted(format!("srp_{i}"), case.arguments.len());
        let gives = answer(&format!("srp_{i}_gives"), &case.gives);
        let (within, oracle) = (case.within, quoted(case.oracle.name()));
        let mays = counted(format!("srp_{i}_mays"), case.may.len());
        let flushed = match case.flushed.is_empty() {
            true => "NULL, 0, NULL".to_owned(),
            false => answer(&format!("srp_{i}_flushed"), &case.flushed),
        };
        let (costs, losses) = (case.costs.len(), case.loses.len());
        let [cost, loss] = [("costs", costs), ("loses", losses)]
            .map(|(what, count)| of(format!("srp_{i}_{what}"), count));
        let _ = writeln!(
            text,
            "    {{{id}, {title}, {call}, {arguments}, {gives}, {within:?}, {oracle}, {source}, {mays}, {{{flushed}}}, \
             {costs}, {losses}, {cost}, {loss}}},"
        );
    }
    let _ = writeln!(
        text,
        "}};\nstatic const size_t srp_case_count = {};",
        cases.len()
    );
    text
}

/// The arrays that a case points to: those of numbers, and those of arguments, answers, units and tests.
fn arrays(text: &mut String, i: usize, case: &Case) {
    for (k, (_, words)) in case.arguments.iter().enumerate() {
        bits(text, &format!("srp_{i}_{k}"), words);
    }
    bits(text, &format!("srp_{i}_gives"), &numbers(&case.gives));
    bits(text, &format!("srp_{i}_flushed"), &numbers(&case.flushed));
    for (k, words) in case.may.iter().enumerate() {
        bits(text, &format!("srp_{i}_may_{k}"), &numbers(words));
    }
    let arguments = case.arguments.iter().enumerate();
    let arguments = arguments.map(|(k, (name, words))| {
        let words = counted(format!("srp_{i}_{k}"), words.len());
        format!("{}, {words}", quoted(name))
    });
    array(text, "argument", &format!("srp_{i}"), arguments);
    let may = case.may.iter().enumerate();
    let may = may.map(|(k, words)| answer(&format!("srp_{i}_may_{k}"), words));
    array(text, "answer", &format!("srp_{i}_mays"), may);
    for (what, pairs) in [("costs", &case.costs), ("loses", &case.loses)] {
        let pairs = pairs.iter();
        let pairs = pairs.map(|(name, number)| format!("{}, {number:?}", quoted(name)));
        array(text, "named", &format!("srp_{i}_{what}"), pairs);
    }
}

/// The numbers of an answer.
fn numbers(answer: &[String]) -> Vec<u32> {
    answer.iter().filter_map(|word| number(word)).collect()
}

/// An answer whose numbers are in the array of a name.
fn answer(name: &str, words: &[String]) -> String {
    let numbers = counted(name.to_owned(), numbers(words).len());
    format!("{}, {numbers}", quoted(&words.join(" ")))
}

/// How many elements an array has, and the array.
fn counted(name: String, count: usize) -> String {
    format!("{count}, {}", of(name, count))
}

/// Writes an array of structures; none where it would be empty.
fn array(text: &mut String, kind: &str, name: &str, elements: impl Iterator<Item = String>) {
    let elements: Vec<String> = elements.map(|element| format!("{{{element}}}, ")).collect();
    if !elements.is_empty() {
        let elements = elements.concat();
        let _ = writeln!(
            text,
            "static const struct srp_{kind} {name}[] = {{{elements}}};"
        );
    }
}

/// An array, or the pointer that stands for none.
fn of(name: String, count: usize) -> String {
    match count {
        0 => "NULL".to_owned(),
        _ => name,
    }
}

fn bits(text: &mut String, name: &str, words: &[u32]) {
    if words.is_empty() {
        return;
    }
    let _ = write!(text, "static const uint32_t {name}[] = {{");
    for word in words {
        let _ = write!(text, "0x{word:08x}, ");
    }
    text.push_str("};\n");
}

/// A string of C. Bytes beyond ASCII are octal, as are question marks, which could begin trigraphs.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' => quoted.extend(['\\', char::from(byte)]),
            b' '..=b'~' if byte != b'?' => quoted.push(char::from(byte)),
            byte => {
                let _ = write!(quoted, "\\{byte:03o}");
            }
        }
    }
    quoted.push('"');
    quoted
}

/// Cases in the form of the catalogue, in which they can be read again.
pub fn text(cases: &[Case]) -> String {
    let mut text = format!("version {VERSION}\n");
    for case in cases {
        let _ = write!(
            text,
            "\ncase {} {}\n  call {}",
            case.id, case.title, case.call
        );
        for (name, words) in &case.arguments {
            let _ = write!(text, " {name}");
            for word in words {
                let _ = write!(text, " {}", shown(*word));
            }
        }
        let _ = writeln!(text, "\n  gives {}", case.gives.join(" "));
        let mut line = |keyword: &str, rest: String| {
            if !rest.is_empty() {
                let _ = writeln!(text, "  {keyword} {rest}");
            }
        };
        for answer in &case.may {
            line("may", answer.join(" "));
        }
        line("flushed", case.flushed.join(" "));
        line("by", case.oracle.name().to_owned());
        line("source", case.source.clone());
        let levels: Vec<&str> = case.levels.iter().map(|&l: &Level| l.name()).collect();
        line("on", levels.join(" "));
        if case.within > 0.0 {
            line("within", case.within.to_string());
        }
        line("costs", pairs(&case.costs));
        line("loses", pairs(&case.loses));
    }
    text
}

fn pairs(pairs: &[(String, f64)]) -> String {
    let pairs = pairs
        .iter()
        .map(|(name, number)| format!("{name} {number}"));
    pairs.collect::<Vec<_>>().join(" ")
}

/// A number as the catalogue writes it: the shortest decimal one that is this float, where one is.
fn shown(bits: u32) -> String {
    let value = f32::from_bits(bits);
    let decimal = match value.abs() {
        0.0 | 1e-4..1e7 => format!("{value}"),
        _ => format!("{value:e}").to_lowercase(),
    };
    match number(&decimal) {
        Some(same) if same == bits => decimal,
        _ => format!("x{bits:08x}"),
    }
}
