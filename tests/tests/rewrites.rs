//! Rewritten expressions: equal in real arithmetic to what was written, found where they should be, and each with
//! what it gains. The table is `tests/precision/rewrites.txt`; `BLESS=1` writes it anew.
//!
//! Equality is tried where floats are exact: random expressions of small integers and powers of two.
//! `SRP_RANDOM_SEED` says where to begin, `SRP_RANDOM_REWRITES` how many programs there are.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};
use srp_archdesc::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::machines::SGRT;
use srp_ir::pass::{self, Rewrite, Rule};
use srp_studies::kernel::{Question, Study, Target, study};
use srp_tests::one_loop::printed;
use srp_tests::root;
use srp_toolchain::{Effort, Options, Session, front_end, optimise};
use std::collections::BTreeMap;
use std::fmt::Write as _;

fn machine() -> Arch {
    srp_archdesc::parse("sgrt.xml", SGRT.xml).expect("it is shipped")
}

/// Random expressions in C whose values are integers that a float holds.
struct Writer {
    random: Pcg64Mcg,
}

impl Writer {
    fn below(&mut self, n: u32) -> u32 {
        self.random.next_u32() % n
    }

    fn constant(&mut self) -> String {
        format!("{}.0f", self.below(9) as i32 - 4)
    }

    /// A polynomial of x, of about this degree, in one of many forms.
    fn polynomial(&mut self, degree: u32) -> String {
        if degree == 0 {
            return match self.below(4) {
                0 => "a".to_owned(),
                _ => self.constant(),
            };
        }
        let low = self.below(degree);
        let rest = self.polynomial(degree - 1);
        let sign = if self.below(3) == 0 { "-" } else { "+" };
        match self.below(5) {
            0 | 1 => format!("(({rest}) * x {sign} {})", self.polynomial(0)),
            2 => format!("({} {sign} x * ({rest}))", self.polynomial(0)),
            3 => {
                let power = vec!["x"; degree as usize].join(" * ");
                let factor = self.constant();
                format!("({} {sign} {factor} * {power})", self.polynomial(low))
            }
            _ => format!("(-({}) {sign} ({}))", rest, self.polynomial(low)),
        }
    }

    /// An expression that some rule fits, whose value is exact.
    fn expression(&mut self) -> String {
        let root = ["s", "t", "(s + t)"][self.below(3) as usize];
        let square = format!("srp_sqrt({root} * {root})");
        match self.below(8) {
            0 => format!("{square} - srp_sqrt(u * u)"),
            1 => "-s + srp_sqrt(s * s + (2.0f * s * t + t * t))".to_owned(),
            2 => "h / q - h / (4.0f * q)".to_owned(),
            3 => "1.0f / q - h / (q * 2.0f)".to_owned(),
            4 => "s * s - t * t".to_owned(),
            5 => "s * t - a * u".to_owned(),
            6 => format!("powf(t, {}.0f)", 1 + self.below(6)),
            _ => {
                let degree = 2 + self.below(5);
                self.polynomial(degree)
            }
        }
    }

    fn program(&mut self) -> String {
        let expression = self.expression();
        format!(
            "#include \"srp.h\"\n#include <math.h>\nfloat sum;\nstatic float f(float x, float a, float s, float t, float u, float h, float q) {{\n\
             return {expression};\n}}\n\
             static void put(float v) {{ unsigned bits = srp_bits(v); for (int i = 0; i < 4; i++) srp_out(SRP_PORT_PUTCHAR, \
             bits >> 8 * i & 255); }}\n\
             int main(void) {{ float s = 0.0f; for (int i = 0; i < 8; i++) {{\n\
             float v = f(i - 4, 3 - i, i + 1, 9 - i, 2 * i + 1, 1 << i, 1 << (7 - i)); put(v);\n\
             s += v;\n\
             if (i == 3) put(s); }} put(s); return 0; }}\n"
        )
    }
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    let words = bytes.chunks_exact(4);
    words
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// True if floats differ by a few units in the last place at most, or are no numbers where a logarithm is of what has
/// none.
fn near(found: &[f32], expected: &[f32]) -> bool {
    let mut pairs = found.iter().zip(expected);
    pairs.all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs() || !a.is_finite())
}

fn number(name: &str, default: u64) -> u64 {
    let set = std::env::var(name).ok().and_then(|text| text.parse().ok());
    set.unwrap_or(default)
}

#[test]
fn rewritten_expressions_are_equal_in_real_arithmetic() {
    let now = std::time::UNIX_EPOCH.elapsed().map_or(1, |d| d.as_secs());
    let seed = number("SRP_RANDOM_SEED", now);
    println!("SRP_RANDOM_SEED={seed}");
    let arch = machine();
    let mut found: BTreeMap<Rule, u32> = BTreeMap::new();
    for seed in seed..seed + number("SRP_RANDOM_REWRITES", 300) {
        let mut writer = Writer {
            random: Pcg64Mcg::seed_from_u64(seed),
        };
        let text = writer.program();
        let sources = [Source::new("f.c", text.clone())];
        let options = Options::default();
        let compiled = front_end(&sources, &arch, &options);
        let (program, _) = compiled.unwrap_or_else(|e| panic!("seed {seed}: {e}\n{text}"));
        let expected = floats(&printed(&program, &arch));
        for wish in pass::places(&program, &pass::Options::new(arch.precision)) {
            let mut rewritten = program.clone();
            let options = Options {
                rewrites: vec![wish.clone()],
                ..Options::default()
            };
            let remarks = optimise(&mut rewritten, &arch, &options);
            let told = remarks.iter().any(|r| r.rule() == Some(wish.rule));
            assert!(told, "seed {seed}: {wish} has no place after all\n{text}");
            *found.entry(wish.rule).or_default() += 1;
            let result = floats(&printed(&rewritten, &arch));
            // Zeros may differ in their signs.
            match wish.rule {
                // The other way of these is not exact.
                Rule::Products | Rule::Exp2Log2 => assert!(
                    near(&result, &expected),
                    "seed {seed}: {wish} changes more than rounding\n{text}"
                ),
                _ => assert!(
                    result == expected,
                    "seed {seed}: {wish} changes an exact result\n{text}"
                ),
            }
        }
    }
    println!("{found:?}");
    for rule in Rule::ALL {
        let is_exact = !matches!(rule, Rule::HalfAngle | Rule::Exp2Log2);
        assert!(!is_exact || found.contains_key(&rule), "{}", rule.name());
    }
}

#[test]
fn each_rewrite_has_both_numbers() {
    let path = root().join("tests/precision/rewrites.c");
    let text = std::fs::read_to_string(&path).expect("the kernels");
    let asked = Study {
        arch: machine(),
        options: Options {
            // What a rewrite does to an II shows with a quarter of the time.
            effort: Effort {
                percent: 25,
                ..Effort::default()
            },
            ..Options::default()
        },
        question: Question::default(),
        points: 256,
        budget: 1,
        grid: false,
        target: Target::parse("ulp=16").expect("a target"),
        threads: 2,
    };
    let studied = study(
        &Source::new("rewrites.c", text),
        &asked,
        &Session::default(),
    );
    let reports = studied.unwrap_or_else(|e| panic!("{e}")).reports;
    let mut table =
        String::from("bits lost, largest error in ulp, II; as it is, then each rewrite alone\n");
    let mut line =
        |name: &str, error: &srp_studies::kernel::Measure, ii: &[(String, u32)], gain: &str| {
            let ulps = error
                .ulps
                .map_or_else(|| "none".to_owned(), |u| format!("{u:.2}"));
            let ii: Vec<String> = ii.iter().map(|(_, ii)| ii.to_string()).collect();
            let _ = writeln!(
                table,
                "  {name:24} {:6.2} {ulps:>12} {:>4}  {gain}",
                error.bits,
                ii.join(",")
            );
        };
    for report in &reports {
        let base = &report.trials[0];
        line(&report.name, &base.error, &base.costs.ii, "");
        for found in &report.rewrites {
            assert_eq!(found.failed, None, "{}", found.name);
            line(
                &found.name,
                &found.error,
                &found.costs.ii,
                found.gain.words(),
            );
        }
    }
    let golden = root().join("tests/precision/rewrites.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&golden, &table).expect("the table is written");
    }
    let expected = std::fs::read_to_string(&golden).unwrap_or_default();
    assert_eq!(table, expected, "BLESS=1 writes it anew");
}

#[test]
fn wishes_are_read_as_they_are_written() {
    for text in ["estrin@12", "horner@poly.c:3", "compensated-sum@src/a.c:40"] {
        assert_eq!(
            Rewrite::parse(text).map(|wish| wish.to_string()),
            Ok(text.to_owned())
        );
    }
    for text in [
        "",
        "estrin",
        "estrin@",
        "estrin@0",
        "estrin@a.c",
        "fast@3",
        "estrin@a.c:-1",
    ] {
        assert!(Rewrite::parse(text).is_err(), "{text}");
    }
    let wish = Rewrite::parse("horner@b.c:3").expect("a wish");
    assert!(wish.is_at("b.c", 3) && wish.is_at("a/b.c", 3));
    assert!(!wish.is_at("ab.c", 3) && !wish.is_at("b.c", 4));
    let wish = Rewrite::parse("horner@3").expect("a wish");
    assert!(wish.is_at("b.c", 3) && !wish.is_at("kernels/libc/math.c", 3));
}
