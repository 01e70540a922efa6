//! Random loops in C as people write them: pointers that may alias, strides of either sign, counts of
//! nothing, one and many, or known only at the end, narrow arrays, conditional stores, early exits, short loops
//! inside, two deep, of several forms and with several ways back and out. Each
//! program means the same to the host's compiler, to the intermediate form after the passes, and
//! divided; some are scheduled and simulated too.
//!
//! `SRP_RANDOM_LOOPS=100000` tries as many programs, `SRP_RANDOM_SEED` says where to begin,
//! `SRP_RANDOM_SIMULATED` how many of them are simulated.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::Arch;
use srp_ir::dre::Dre;
use srp_ir::split::split;
use srp_tests::{
    Ended, LITTLE, c_files, compiled_as_written, has_host_compiler, interpreted, machine, on_host,
    simulated,
};
use srp_toolchain::{Effort, Session, schedule};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Programs in one file: the host's compiler takes longer to start than to compile one.
const BATCH: u64 = 10;

const HEAD: &str = "\
#include <math.h>
#include <stdio.h>
typedef struct { int x; float y; short z; unsigned char w; } item;
static int a[64], b[64], total;
static short h[64];
static unsigned char c[64];
static float f[64], g[64];
static item items[32];
static const int table[8] = {3, -5, 7, 11, -13, 17, 19, -23};
static int after[64];
static int *p, *q;
static volatile int some;
static unsigned sum;
static void reset(void)
{
    total = 0;
    for (int i = 0; i < 64; i++) {
        a[i] = i * 37 % 101 - 50;
        b[i] = i * 53 % 97 - 40;
        h[i] = (short)(i * 29 % 83 - 30);
        c[i] = (unsigned char)(i * 71);
        after[i] = i % 13 == 5 ? -1 : (i + 1) % 64;
        f[i] = (i * 13 % 31) * 0.25f;
        g[i] = (i * 17 % 37) * 0.5f - 4.0f;
        items[i & 31].x = i;
        items[i & 31].y = i * 0.125f;
        items[i & 31].z = (short)(i * 5);
        items[i & 31].w = (unsigned char)(i * 3);
    }
}
static void add(unsigned x) { sum = (sum ^ x) * 16777619u; }
static void check(void)
{
    add((unsigned)total);
    for (int i = 0; i < 64; i++) {
        add((unsigned)a[i]);
        add((unsigned)b[i]);
        add((unsigned)h[i]);
        add(c[i]);
        add((unsigned)(int)(fmaxf(fminf(f[i], 1e6f), -1e6f) * 16.0f));
        add((unsigned)(int)(fmaxf(fminf(g[i], 1e6f), -1e6f) * 16.0f));
        add((unsigned)items[i & 31].x + (unsigned)items[i & 31].z + items[i & 31].w);
    }
    printf(\"%08x\\n\", sum);
}
";

struct Maker {
    random: Pcg32,
    text: String,
    /// Loops around a statement beside that of `i`.
    deep: usize,
    /// True when `continue` goes on to what counts.
    continues: bool,
}

impl Maker {
    fn below(&mut self, n: u32) -> u32 {
        (self.random.next_u32() >> 8) % n
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len() as u32) as usize]
    }

    fn index(&mut self, size: u32) -> String {
        let mask = size - 1;
        match self.below(8) {
            0..=2 if size == 64 => "i".into(),
            3 => format!("({} - i) & {mask}", self.below(64)),
            4 => format!("(i * {} + {}) & {mask}", self.below(5) + 1, self.below(9)),
            5 if self.deep == 1 => format!("(i + j) & {mask}"),
            5 if self.deep == 2 => format!("(i + j * 4 + k) & {mask}"),
            _ => format!("(i + {}) & {mask}", self.below(6)),
        }
    }

    fn place(&mut self) -> String {
        let name = self.one(&["a", "a", "b", "h", "c", "p", "q"]);
        let index = self.index(if "pq".contains(name) { 32 } else { 64 });
        format!("{name}[{index}]")
    }

    fn integer(&mut self, depth: u32) -> String {
        if depth == 0 {
            return match self.below(10) {
                0 => "i".into(),
                1 => format!("{}", self.below(200) as i32 - 100),
                2 => "s".into(),
                3 => {
                    let index = self.index(32);
                    let member = self.one(&["x", "z", "w"]);
                    format!("items[{index}].{member}")
                }
                4 => format!("table[{}]", self.below(8)),
                5 if self.deep > 0 => self.one(&["j", "k"][..self.deep]).into(),
                _ => self.place(),
            };
        }
        let (x, y) = (self.integer(depth - 1), self.integer(depth - 1));
        match self.below(10) {
            0 => format!("({x} / {})", self.below(30) as i32 + 2),
            1 => format!("({x} % {})", self.below(30) as i32 + 2),
            2 => format!("((unsigned)({x}) / {}u)", self.below(1000) + 2),
            3 => format!("({x} < {y} ? {x} : {y})"),
            4 => format!("({x} & {y})"),
            5 => format!("({x} * 3 - {y})"),
            6 => format!("({x} >> {})", self.below(8)),
            _ => format!("({x} + {y})"),
        }
    }

    fn float(&mut self) -> String {
        let (i, j) = (self.index(64), self.index(64));
        match self.below(6) {
            0 => format!("sqrtf(fabsf(g[{i}]))"),
            1 => format!("fminf(f[{i}], g[{j}]) * 0.5f"),
            2 => format!("floorf(g[{i}] * 0.75f)"),
            3 => format!("(f[{i}] > 3.0f ? f[{i}] - 1.0f : g[{j}] * 0.25f)"),
            4 => format!("items[{i} & 31].y / 4.0f"),
            _ => format!("f[{i}] * 0.5f + g[{j}]"),
        }
    }

    fn condition(&mut self) -> String {
        let (x, y) = (self.integer(0), self.integer(0));
        match self.below(5) {
            0 => format!("{x} > {y} && s < 5000"),
            1 => format!("({x} ^ {y}) % 5 == 0"),
            2 => format!("{x} < {}", self.below(120) as i32 - 60),
            3 => {
                let index = self.index(64);
                format!("f[{index}] > {}.0f", self.below(9))
            }
            _ => format!("{x} == {}", self.below(60) as i32 - 30),
        }
    }

    fn statement(&mut self, indent: &str) {
        let line = match self.below(12) {
            0..=2 => {
                let (place, value) = (self.place(), self.integer(2));
                format!("{place} = {value};")
            }
            3 => {
                let (condition, place, value) = (self.condition(), self.place(), self.integer(1));
                format!("if ({condition}) {place} = {value};")
            }
            4 => format!("s += {};", self.integer(1)),
            5 => format!("total += {};", self.integer(1)),
            6 | 7 => {
                let (index, value) = (self.index(64), self.float());
                let name = self.one(&["f", "g"]);
                format!("{name}[{index}] = {value};")
            }
            8 => {
                let (index, value) = (self.index(32), self.integer(1));
                let member = self.one(&["x", "z", "w"]);
                format!("items[{index}].{member} = {value};")
            }
            9 => {
                let (condition, one, other) = (self.condition(), self.integer(1), self.integer(1));
                match self.below(3) {
                    0 => format!("if ({condition}) total = {one};"),
                    _ => format!("if ({condition}) s -= {one}; else s ^= {other};"),
                }
            }
            10 if self.deep < 2 => return self.short_loop(indent),
            _ => {
                let condition = self.condition();
                let ways = ["break", "return s", "continue"];
                let what = self.one(&ways[..2 + usize::from(self.continues)]);
                format!("if ({condition}) {what};")
            }
        };
        writeln!(self.text, "{indent}{line}").expect("strings take text");
    }

    fn line(&mut self, indent: &str, line: &str) {
        writeln!(self.text, "{indent}{line}").expect("strings take text");
    }

    fn statements(&mut self, indent: &str, most: u32) {
        for _ in 0..=self.below(most) {
            self.statement(indent);
        }
    }

    /// A loop of few iterations inside another.
    fn short_loop(&mut self, indent: &str) {
        let inside = format!("{indent}    ");
        let j = ["j", "k"][self.deep];
        let (count, condition) = (self.below(7) + 1, self.condition());
        let also = match self.below(4) {
            0 => format!(" && {condition}"),
            _ => String::new(),
        };
        let form = self.below(8);
        let continues = std::mem::replace(&mut self.continues, form < 6);
        match form {
            0..=2 => {
                self.line(
                    indent,
                    &format!("for (int {j} = 0; {j} < {count}{also}; {j}++) {{"),
                );
                self.deep += 1;
                self.statements(&inside, 3);
                self.line(indent, "}");
            }
            // Whether it is left is known behind the first iteration.
            3 => {
                let (x, first) = (format!("x{j}"), self.integer(1));
                let (left, then) = (self.below(3), self.below(3));
                self.line(
                    indent,
                    &format!("for (int {j} = 0, {x} = ({first}) & 3; {j} < {count}; {j}++) {{"),
                );
                self.deep += 1;
                self.statements(&inside, 1);
                self.line(&inside, &format!("if ({x} == {left}) break;"));
                self.statements(&inside, 2);
                self.line(&inside, &format!("{x} = {then};"));
                self.line(indent, "}");
            }
            4 | 5 => {
                let step = match form {
                    4 => "1".to_owned(),
                    _ => format!("{condition} ? 2 : 1"),
                };
                self.line(indent, &format!("{{ int {j}_ = 0;"));
                self.line(indent, "do {");
                self.deep += 1;
                self.line(&inside, &format!("int {j} = {j}_;"));
                self.line(&inside, &format!("{j}_ += {step};"));
                self.statements(&inside, 2);
                self.line(indent, &format!("}} while ({j}_ < {count}{also}); }}"));
            }
            // Two ways back, each with its step.
            6 => {
                self.line(indent, &format!("{{ int {j} = 0;"));
                self.line(indent, "do {");
                self.deep += 1;
                self.statements(&inside, 2);
                let again = self.condition();
                self.line(&inside, &format!("if ({again}) {{ {j} += 2; continue; }}"));
                self.statements(&inside, 2);
                self.line(&inside, &format!("{j}++;"));
                self.line(indent, &format!("}} while ({j} < {count}); }}"));
            }
            _ => {
                self.line(indent, &format!("{{ int {j} = 0;"));
                self.line(indent, "for (;;) {");
                self.deep += 1;
                self.statements(&inside, 2);
                self.line(&inside, &format!("if ({j}++ == {count}) break;"));
                self.statements(&inside, 2);
                self.line(indent, "} }");
            }
        }
        self.deep -= 1;
        self.continues = continues;
    }

    fn program(&mut self, number: u64) {
        let n = self.one(&["0", "1", "2", "17", "63", "64", "some + 33"]);
        let (away, behind) = (self.below(4), self.below(32));
        let both = self.one(&["a", "b", "a"]);
        let start = self.below(9);
        writeln!(
            self.text,
            "static int t{number}(void)\n{{\n    int s = {start}, n = {n};\n    p = a + {away};\n    q = {both} + {behind};",
        )
        .expect("text");
        for _ in 0..=self.below(2) {
            let step = self.below(3) + 1;
            let form = self.below(11);
            if form >= 8 {
                self.uncounted(form);
                continue;
            }
            if form >= 6 {
                let last = match form {
                    6 => self.below(40).to_string(),
                    _ => "n".into(),
                };
                self.repeat(&last);
                continue;
            }
            let head = match form {
                0 => format!("for (int i = n - 1; i >= 0; i -= {step})"),
                1 => format!("for (int i = 0; i < {}; i += {step})", self.below(64) + 1),
                2 => format!("for (int i = {}; i != 64; i++)", self.below(64)),
                3 => format!("for (unsigned i = 0; i < (unsigned)n; i += {step})"),
                _ => format!("for (int i = 0; i < n; i += {step})"),
            };
            writeln!(self.text, "    {head} {{").expect("text");
            self.statements("        ", 5);
            self.text.push_str("    }\n");
        }
        self.text.push_str("    return s;\n}\n");
    }

    /// A loop that only running it ends, on the array even where the other engine is faster.
    fn uncounted(&mut self, form: u32) {
        if self.below(2) == 0 {
            self.line("", "#pragma srp kernel");
        }
        let first = self.below(64);
        let head = match form {
            8 => format!("for (int i = {first}; i >= 0; i = after[i])"),
            9 => format!("for (int i = {}; after[i] > 0; i++)", first % 50),
            _ => {
                let next = self.one(&["i & (i - 1)", "i >> 1", "i / 3"]);
                format!("for (unsigned i = {first}; i; i = {next})")
            }
        };
        self.line("    ", &format!("{head} {{"));
        self.statements("        ", 4);
        self.line("    ", "}");
    }

    /// A loop with two ways back, each with its step.
    fn repeat(&mut self, last: &str) {
        let again = self.below(3) + 1;
        self.line("    ", "{ int i = 0; do {");
        self.continues = false;
        self.statements("        ", 3);
        let condition = self.condition();
        self.line(
            "        ",
            &format!("if ({condition}) {{ i += {again}; continue; }}"),
        );
        self.statements("        ", 3);
        self.continues = true;
        self.line("        ", "i++;");
        self.line("    ", &format!("}} while (i < {last}); }}"));
    }
}

/// The programs of some seeds, in one file.
fn text(seeds: std::ops::Range<u64>) -> String {
    let mut all = HEAD.to_owned();
    let mut main = String::from("int main(void)\n{\n");
    for seed in seeds {
        let mut maker = Maker {
            random: Pcg32::new(seed, 77),
            text: String::new(),
            deep: 0,
            continues: true,
        };
        maker.program(seed);
        all += &maker.text;
        main += &format!("    reset();\n    add((unsigned)t{seed}());\n    check();\n");
    }
    all + &main + "    return 0;\n}\n"
}

fn number(variable: &str, default: u64) -> u64 {
    let value = std::env::var(variable).ok();
    value.and_then(|v| v.parse().ok()).unwrap_or(default)
}

/// Returns what is wrong with a file whose output is known.
fn difference(file: &Path, expected: &Ended, arch: &Arch, simulate: bool) -> Result<(), String> {
    let same = |what: &str, found: Ended| match found == *expected {
        true => Ok(()),
        false => Err(format!("{what}: {found:?}, not {expected:?}")),
    };
    let control = compiled_as_written(&[file.to_owned()], arch)?;
    let whole = Dre {
        control: control.clone(),
        kernels: Default::default(),
    };
    same("after the passes", interpreted(&whole, arch)?)?;
    same("divided", interpreted(&split(&control).dre, arch)?)?;
    if simulate {
        let compiled = schedule(control, arch, LITTLE, &Session::default());
        let compiled = compiled.map_err(|e| e.to_string())?;
        same("simulated", simulated(&compiled.schedule.program)?)?;
    }
    Ok(())
}

#[test]
fn random_loops_mean_the_same_to_the_host() {
    if !has_host_compiler() {
        eprintln!("skipped: there is no C compiler `cc`");
        return;
    }
    let arch = machine("sgrt");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let (file, binary) = (folder.join("loops.c"), folder.join("loops"));
    let now = std::time::UNIX_EPOCH.elapsed().map_or(1, |d| d.as_secs());
    let first = number("SRP_RANDOM_SEED", now);
    println!("SRP_RANDOM_SEED={first}");
    let count = number("SRP_RANDOM_LOOPS", 250);
    let simulated = number("SRP_RANDOM_SIMULATED", 10);
    for start in (first..first + count).step_by(BATCH as usize) {
        let seeds = start..(start + BATCH).min(first + count);
        let all = text(seeds.clone());
        std::fs::write(&file, &all).expect("the folder can be written");
        let expected = on_host(std::slice::from_ref(&file), &binary).expect("the programs are C");
        let simulate = start - first < simulated;
        let Err(together) = difference(&file, &expected, &arch, simulate) else {
            continue;
        };
        for seed in seeds {
            let one = text(seed..seed + 1);
            std::fs::write(&file, &one).expect("the folder can be written");
            let expected =
                on_host(std::slice::from_ref(&file), &binary).expect("the programs are C");
            if let Err(what) = difference(&file, &expected, &arch, simulate) {
                panic!("seed {seed}: {what}\n{one}");
            }
        }
        panic!("only together, from seed {start}: {together}\n{all}");
    }
}

/// Programs whose loops had wrong schedules, with so little effort that they have them again where the mistake is.
#[test]
fn loops_that_were_found_are_right() {
    let arch = machine("sgrt");
    let effort = Effort {
        percent: 1,
        ..LITTLE
    };
    for path in c_files("tests/found") {
        let control = compiled_as_written(std::slice::from_ref(&path), &arch);
        let control = control.unwrap_or_else(|messages| panic!("{messages}"));
        let meant = interpreted(&split(&control).dre, &arch);
        let compiled = schedule(control, &arch, effort, &Session::default());
        let compiled = compiled.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let found = simulated(&compiled.schedule.program);
        assert_eq!(found, meant, "{}", path.display());
    }
}
