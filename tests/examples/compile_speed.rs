//! How long 10,000 lines of C take from text to the divided program:
//! `cargo run --release -p srp-tests --example compile_speed`.

use srp_archdesc::arch::Precision;
use srp_archdesc::diagnostic::Source;
use srp_frontend::{Options, compile};
use srp_ir::{pass, split};
use std::fmt::Write;
use std::time::Instant;

/// Functions of 20 lines each: loops, arrays, structs, conditions, floats, calls.
fn text(functions: usize) -> String {
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

fn main() {
    let text = text(500);
    let lines = text.lines().count();
    let start = Instant::now();
    let compiled = compile(&[Source::new("speed.c", text)], &Options::default());
    let (mut program, _) = compiled.unwrap_or_else(|messages| panic!("{messages:#?}"));
    let lowered = start.elapsed();
    let options = pass::Options {
        precision: Precision::EXACT,
    };
    pass::optimise(&mut program, &options);
    let optimised = start.elapsed();
    let divided = split::split(&program);
    println!(
        "{lines} lines: lowered after {lowered:.2?}, simplified after {optimised:.2?}, divided after {:.2?}; {} kernels",
        start.elapsed(),
        divided.dre.kernels.len()
    );
}
