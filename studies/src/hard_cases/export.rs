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
};
";

/// Cases as C that stands alone: an array `srp_cases` of `srp_case_count`.
pub fn c(cases: &[Case]) -> String {
    let mut text = String::from("/* Hard cases of float arithmetic in ray tracing. */\n");
    text += HEAD;
    for (i, case) in cases.iter().enumerate() {
        for (k, (_, words)) in case.arguments.iter().enumerate() {
            bits(&mut text, &format!("srp_{i}_{k}"), words);
        }
        bits(&mut text, &format!("srp_{i}_gives"), &of_answer(case));
        if !case.arguments.is_empty() {
            let _ = write!(text, "static const struct srp_argument srp_{i}[] = {{");
            for (k, (name, words)) in case.arguments.iter().enumerate() {
                let (name, count) = (quoted(name), words.len());
                let _ = write!(
                    text,
                    "{{{name}, {count}, {}}}, ",
                    of(format!("srp_{i}_{k}"), count)
                );
            }
            text += "};\n";
        }
    }
    text += "\nstatic const struct srp_case srp_cases[] = {\n";
    for (i, case) in cases.iter().enumerate() {
        let [id, title, call] = [&case.id, &case.title, &case.call].map(|s| quoted(s));
        let [gives, source] = [&case.gives.join(" "), &case.source].map(|s| quoted(s));
        let (arguments, numbers) = (case.arguments.len(), of_answer(case).len());
        let argument = of(format!("srp_{i}"), arguments);
        let number = of(format!("srp_{i}_gives"), numbers);
        let (within, oracle) = (case.within, quoted(case.oracle.name()));
        let _ = writeln!(
            text,
            "    {{{id}, {title}, {call}, {arguments}, {argument}, {gives}, {numbers}, {number}, {within:?}, \
             {oracle}, {source}}},"
        );
    }
    let _ = writeln!(
        text,
        "}};\nstatic const size_t srp_case_count = {};",
        cases.len()
    );
    text
}

fn of_answer(case: &Case) -> Vec<u32> {
    case.gives.iter().filter_map(|word| number(word)).collect()
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
