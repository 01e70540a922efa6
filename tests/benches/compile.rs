//! How long 10,000 lines of C take from text to the divided program, in many functions and in one,
//! the best of several runs: `cargo bench -p srp-tests --bench compile`. It fails where that is not
//! below a second.

use srp_archdesc::arch::Precision;
use srp_archdesc::diagnostic::Source;
use srp_frontend::{Options, compile};
use srp_ir::{pass, split};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// One function with a loop in every 13 lines.
fn one_function(loops: usize) -> String {
    let mut out = String::from(
        "struct point { int x; float y; unsigned bits : 5; };
static int table[16];
int main(int argc, char **argv)
{
    struct point p = { argc, 0.5f, 3 };
    int sum = 0;
",
    );
    for i in 0..loops {
        let _ = write!(
            out,
            "    for (int i = 0; i < 16; i++) {{
        table[i] = i * sum + p.bits;
        if (table[i] > {i}) {{
            sum += table[i];
        }} else {{
            p.y += 0.25f * i;
        }}
    }}
    switch (sum & 3) {{
    case 0: sum++; break;
    case 1: sum += (int)p.y;
    default: sum ^= p.x << 2;
    }}
"
        );
    }
    out + "    return sum & 1;\n}\n"
}

/// Functions of 20 lines each: loops, arrays, structs, conditions, floats, calls.
fn many_functions(functions: usize) -> String {
    let mut out = String::from("struct point { int x; float y; unsigned bits : 5; };\n");
    for i in 0..functions {
        let before = match i {
            0 => "x".to_owned(),
            i => format!("f{}(x & {})", i - 1, i % 7),
        };
        let _ = write!(
            out,
            "static int table{i}[16];
int f{i}(int x)
{{
    struct point p = {{ x, {i}.5f, {i} & 31 }};
    int sum = 0;
    for (int i = 0; i < 16; i++) {{
        table{i}[i] = i * x + p.bits;
        if (table{i}[i] > {i}) {{
            sum += table{i}[i];
        }} else {{
            p.y += 0.25f * i;
        }}
    }}
    switch (sum & 3) {{
    case 0: return sum;
    case 1: sum += (int)p.y;
    default: sum ^= p.x << 2;
    }}
    return sum + {before};
}}
"
        );
    }
    let _ = writeln!(
        out,
        "int main(void) {{ return f{}(3) & 1; }}",
        functions - 1
    );
    out
}

/// Runs, of which the best counts: others use the machine too.
const RUNS: usize = 7;

/// The times until the program is lowered, simplified and divided.
fn run(text: &str) -> [Duration; 3] {
    let start = Instant::now();
    let compiled = compile(&[Source::new("speed.c", text)], &Options::default());
    let (mut program, _) = compiled.unwrap_or_else(|messages| panic!("{messages:#?}"));
    let lowered = start.elapsed();
    let options = pass::Options::new(Precision::EXACT);
    pass::optimise(&mut program, &options);
    let simplified = start.elapsed();
    let divided = split::split(&program);
    let whole = start.elapsed();
    assert!(!divided.dre.kernels.is_empty(), "there are loops");
    [lowered, simplified, whole]
}

fn main() {
    let shapes = [
        ("many functions", many_functions(500)),
        ("one function", one_function(770)),
    ];
    for (shape, text) in shapes {
        let lines = text.lines().count();
        let runs = (0..RUNS).map(|_| run(&text));
        let best = runs.min_by_key(|&[.., whole]| whole);
        let [lowered, simplified, whole] = best.expect("there are runs");
        println!(
            "{lines} lines in {shape}: lowered after {lowered:.2?}, simplified after \
             {simplified:.2?}, divided after {whole:.2?}"
        );
        assert!(whole < Duration::from_secs(1), "more than a second");
    }
}
