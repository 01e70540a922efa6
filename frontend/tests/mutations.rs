//! No input panics: programs with random changes of their tokens are refused or compiled, and what
//! compiles holds all rules of a program. `SRP_MUTATE_SECONDS` says for how long.

use srp_archdesc::diagnostic::Source;
use srp_frontend::{Include, Options, compile};
use srp_ir::verify;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % limit.max(1) as u64) as usize
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Programs to change.
fn programs() -> Vec<String> {
    let mut texts = Vec::new();
    for directory in [
        "tests/cases",
        "frontend/tests/errors",
        "frontend/tests/golden",
    ] {
        let mut paths: Vec<_> = std::fs::read_dir(root().join(directory))
            .expect("the programs are there")
            .map(|entry| entry.expect("the directory can be read").path())
            .filter(|path| path.extension().is_some_and(|e| e == "c"))
            .collect();
        paths.sort();
        texts.extend(
            paths
                .iter()
                .map(|p| std::fs::read_to_string(p).expect("readable")),
        );
    }
    // Texts that are large on purpose take too long to try often.
    texts.retain(|text| text.len() < 10_000 && !text.contains("T1000") && !text.contains("U V"));
    texts
}

/// A text in words, operators and white space.
fn pieces(text: &str) -> Vec<&str> {
    let kind = |c: char| match c {
        _ if c.is_alphanumeric() || c == '_' => 0,
        _ if c.is_whitespace() => 1,
        _ => 2,
    };
    let mut pieces = Vec::new();
    let mut start = 0;
    let mut before = None;
    for (at, c) in text.char_indices() {
        if before.is_some_and(|b| b != kind(c) || b == 2) {
            pieces.push(&text[start..at]);
            start = at;
        }
        before = Some(kind(c));
    }
    pieces.push(&text[start..]);
    pieces
}

/// Words that no program needs to have to get into trouble with.
const POOL: &[&str] = &[
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    ";",
    ",",
    "*",
    "&",
    "->",
    ".",
    "=",
    "?",
    ":",
    "#",
    "##",
    "\n#if ",
    "\n#endif\n",
    "\n#define X(a) a#a\n",
    "X(",
    "int ",
    "float4 ",
    "int4 ",
    "struct ",
    "union ",
    "typedef ",
    "static ",
    "const ",
    "void ",
    "unsigned ",
    "_Bool ",
    "char ",
    "__srp_global ",
    "sizeof ",
    "return ",
    "case 1:",
    "default:",
    "break;",
    "continue;",
    "switch",
    "while",
    "do ",
    "for(;;)",
    "if",
    "else ",
    "goto x;",
    "0",
    "1.5f",
    "0x7fffffff",
    "\"text\"",
    "'c'",
    "...",
    "++",
    "--",
    "!",
    "~",
    "%",
    "<<",
    "&&",
    "||",
    "\u{e4}",
    "\\\n",
    "/*",
    "//",
    "\"",
    "'",
    "(int)",
    "(float4){",
    "__srp_swz(",
    "__srp_float4",
    "enum ",
    "__attribute__((vector_size(16)))",
    "\n#pragma srp unroll 4\n",
    "\n#pragma srp kernel\n",
    "_Static_assert(",
    "__func__",
    "[1]=",
    "[0 ... 3]=",
    "double ",
    "long long ",
    "1e300",
    "0x123456789ULL",
    "x:",
    ": 3;",
    "({",
    "})",
    "typeof(",
    "_Generic(",
    "default:",
    "__builtin_va_arg(",
    "__builtin_va_list ",
    "__builtin_huge_val()",
    "__builtin_unreachable()",
    "?:",
    "case 2 ... 5:",
    "asm(\"\");",
    "L\"wide\"",
    "'abcd'",
    "(double)",
    "(long long)",
    "__VA_ARGS__",
    "\n_Pragma(\"once\")\n",
];

fn mutated(texts: &[String], random: &mut Random) -> String {
    let text = &texts[random.below(texts.len())];
    let other = &texts[random.below(texts.len())];
    let mut words = pieces(text);
    let donors = pieces(other);
    for _ in 0..1 + random.below(4) {
        let at = random.below(words.len());
        let end = (at + 1 + random.below(8)).min(words.len());
        match random.below(6) {
            0 => {
                words.drain(at..end);
            }
            1 => {
                let copy = words[at..end].to_vec();
                words.splice(at..at, copy);
            }
            2 => {
                let with = random.below(words.len());
                words.swap(at, with);
            }
            3 => words.insert(at, POOL[random.below(POOL.len())]),
            4 => words[at] = POOL[random.below(POOL.len())],
            _ => {
                let from = random.below(donors.len());
                let to = (from + 1 + random.below(12)).min(donors.len());
                words.splice(at..at, donors[from..to].iter().copied());
            }
        }
        if words.is_empty() {
            break;
        }
    }
    words.concat()
}

#[test]
fn changed_programs_do_not_panic() {
    let texts = programs();
    let header = |name: &str| std::fs::read_to_string(root().join("kernels").join(name)).ok();
    let resolve = |include: &Include<'_>| Some(Source::new(include.name, header(include.name)?));
    let options = Options {
        resolve: &|include| resolve(include).into(),
        ..Options::default()
    };
    let seconds = std::env::var("SRP_MUTATE_SECONDS").ok();
    let seconds = seconds.and_then(|s| s.parse().ok()).unwrap_or(1);
    let start = Instant::now();
    let (mut seed, mut compiled) = (0, 0);
    while start.elapsed() < Duration::from_secs(seconds) || compiled == 0 {
        let text = mutated(&texts, &mut Random(seed));
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            match compile(&[Source::new("m.c", &text)], &options) {
                Ok((program, _)) => Some(verify(&program)),
                Err(messages) => {
                    assert!(!messages.is_empty(), "refused without a word");
                    None
                }
            }
        }));
        match outcome {
            Ok(Some(Err(violations))) => panic!("seed {seed}: {violations:?}\n{text}"),
            Ok(Some(Ok(()))) => compiled += 1,
            Ok(None) => {}
            Err(_) => panic!("seed {seed} panics:\n{text}"),
        }
        seed += 1;
    }
}
