//! The forms of `kernels/vector.h` at what breaks the obvious ones: vectors whose squares overflow or
//! vanish, products that nearly cancel, directions next to a pole, the critical angle, powers of 0.
//! The oracle is binary64, in which these inputs are harmless.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_ir::dre;
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_tests::{compiled, machine};
use std::fmt::Write;
use std::path::Path;

/// Evaluates `body`, which sets `out[i]` from `in[i]`, for rows of inputs.
fn evaluate<const IN: usize, const OUT: usize>(
    name: &str,
    body: &str,
    inputs: &[[f32; IN]],
) -> Vec<[f32; OUT]> {
    let mut text = format!(
        "#include \"vector.h\"\n#define N {}\nfloat out_all[N][{OUT}];\nstatic const unsigned given[N][{IN}] = {{\n",
        inputs.len()
    );
    for row in inputs {
        let words: Vec<String> = row.iter().map(|x| format!("{:#x}u", x.to_bits())).collect();
        writeln!(text, "{{ {} }},", words.join(", ")).expect("a String takes all");
    }
    write!(
        text,
        "}};\nint main(void)\n{{\nfor (int i = 0; i < N; i++) {{\nfloat *out = out_all[i];\n\
         float in[{IN}];\nfor (int k = 0; k < {IN}; k++) in[k] = srp_float(given[i][k]);\n{body}\n}}\nreturn 0;\n}}\n"
    )
    .expect("a String takes all");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("vectors-{name}.c"));
    std::fs::write(&path, text).expect("the folder is there");
    let arch = machine("sgrt");
    let program = compiled(&[path], &arch).unwrap_or_else(|messages| panic!("{messages}"));
    let layout = Layout::of(&program, arch.system.sram_bytes).expect("the arrays fit");
    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    let options = interp::Options {
        precision: arch.precision,
        ..interp::Options::new(&layout)
    };
    let main = program.main.expect("there is a main");
    let whole = dre::Dre {
        control: program.clone(),
        kernels: Default::default(),
    };
    dre::run(&whole, main, &[], &mut world, &options).unwrap_or_else(|t| panic!("{t:?}"));
    let symbols = layout.symbols(&program).into_iter();
    let out = symbols.into_iter().find(|s| s.name == "out_all");
    let out = out.expect("it is defined");
    let bytes = &world.sram[out.address as usize..(out.address + out.size) as usize];
    let word = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
    let words: Vec<f32> = bytes.chunks_exact(4).map(word).collect();
    let rows = words.chunks_exact(OUT);
    rows.map(|row| row.try_into().expect("a row")).collect()
}

fn random(from: &mut Pcg32) -> f32 {
    from.next_u32() as f32 / (1u32 << 31) as f32 - 1.0
}

fn directions(count: usize) -> Vec<[f32; 3]> {
    let mut from = Pcg32::new(7, 11);
    let unit = |_| {
        let v = [(); 3].map(|()| f64::from(random(&mut from)));
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
        v.map(|x| (x / length) as f32)
    };
    (0..count).map(unit).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[test]
fn unit_vectors_are_right_at_every_length() {
    let mut vectors = vec![
        [1e-30, 0.0, 0.0],
        [1e-23, 1e-23, 0.0],
        [3e-20, 4e-20, 0.0],
        [1e-45, 0.0, 0.0],
        [1e20, 0.0, 0.0],
        [f32::MAX, f32::MAX, -f32::MAX],
        [-0.0, f32::MIN_POSITIVE, 0.0],
    ];
    for (i, v) in directions(400).into_iter().enumerate() {
        vectors.push(v.map(|x| x * 2f32.powi(i as i32 / 2 - 100)));
    }
    let body = "float4 u = unit3(srp_float4(in[0], in[1], in[2], 0.0f), srp_splat(7.0f));
        out[0] = u[0]; out[1] = u[1]; out[2] = u[2];";
    let units: Vec<[f32; 3]> = evaluate("unit", body, &vectors);
    for (v, unit) in vectors.iter().zip(&units) {
        let exact = v.map(f64::from);
        let length = dot(exact, exact).sqrt();
        for (&x, e) in unit.iter().zip(exact) {
            assert!(
                (f64::from(x) - e / length).abs() < 1.8e-7,
                "{v:?}: {unit:?}"
            );
        }
    }
    let none: Vec<[f32; 3]> = evaluate("none", body, &[[0.0; 3], [-0.0, 0.0, 0.0]]);
    assert_eq!(none, [[7.0; 3]; 2]);
}

#[test]
fn products_that_nearly_cancel_keep_their_difference() {
    let mut cases = vec![
        [33962.035, -30438.8, 41563.4, -24871.969],
        [1.0, 1.0, 1.0, 1.0],
    ];
    let mut from = Pcg32::new(3, 5);
    for _ in 0..2000 {
        let [a, b] = [(); 2].map(|()| random(&mut from) + 2.0);
        let c = a * (1.0 + random(&mut from) * 1e-6);
        cases.push([a, b, c, (f64::from(a) * f64::from(b) / f64::from(c)) as f32]);
    }
    let body = "out[0] = difference_of_products(in[0], in[1], in[2], in[3]);";
    let found: Vec<[f32; 1]> = evaluate("difference", body, &cases);
    for (case, [found]) in cases.iter().zip(&found) {
        let [a, b, c, d] = case.map(f64::from);
        // Products of two floats are exact in binary64, and so is the difference of near ones.
        let exact = a * b - c * d;
        let ulp = exact.abs() * f64::from(f32::EPSILON);
        assert!(
            (f64::from(*found) - exact).abs() <= 1.5 * ulp,
            "{case:?}: {found} {exact}"
        );
    }
}

#[test]
fn bases_are_orthonormal_next_to_the_poles_too() {
    let mut normals = directions(300);
    normals.extend([
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [-0.0, 0.0, -1.0],
        [-3.9e-4, -3.8e-4, -0.999_999_9],
        [1e-20, -1e-20, -1.0],
        [1.0, 0.0, -0.0],
    ]);
    let body = "float4 n = srp_float4(in[0], in[1], in[2], 0.0f);
        for (int k = 0; k < 3; k++) {
            float4 axis = around3(n, k == 0 ? 1.0f : 0.0f, k == 1 ? 1.0f : 0.0f, k == 2 ? 1.0f : 0.0f);
            for (int l = 0; l < 3; l++) out[3 * k + l] = axis[l];
        }";
    let bases: Vec<[f32; 9]> = evaluate("bases", body, &normals);
    for (n, basis) in normals.iter().zip(&bases) {
        let axis = |k: usize| [0, 1, 2].map(|l| f64::from(basis[3 * k + l]));
        for k in 0..3 {
            for l in 0..3 {
                let expected = f64::from(u8::from(k == l));
                assert!(
                    (dot(axis(k), axis(l)) - expected).abs() < 6e-7,
                    "{n:?}: {basis:?}"
                );
            }
        }
        assert_eq!([basis[6], basis[7], basis[8]], *n, "the last is the normal");
    }
}

#[test]
fn the_critical_angle_is_decided_rightly() {
    // Light that leaves glass of the index eta: the square of the cosine behind the surface.
    let mut cases = Vec::new();
    for eta in [1.0001f32, 1.01, 1.33, 1.5, 2.42] {
        let critical = (1.0 - 1.0 / (f64::from(eta) * f64::from(eta))).sqrt() as f32;
        for step in -1000i32..1000 {
            let cosine = f32::from_bits(critical.to_bits().wrapping_add_signed(step));
            cases.push([eta, cosine]);
        }
    }
    let body = "float along = in[0] * in[1];
        out[0] = difference_of_products(along, along, in[0] - 1.0f, in[0] + 1.0f);";
    let found: Vec<[f32; 1]> = evaluate("critical", body, &cases);
    let mut wrong = 0;
    for ([eta, cosine], [square]) in cases.iter().zip(&found) {
        let (eta, cosine) = (f64::from(*eta), f64::from(*cosine));
        let exact = eta * eta * cosine * cosine - (eta - 1.0) * (eta + 1.0);
        wrong += u32::from((exact > 0.0) != (*square > 0.0));
        let off = (f64::from(*square) - exact).abs();
        assert!(
            off < 4e-7 * (eta - 1.0).max(1e-4),
            "{eta} {cosine}: {square} {exact}"
        );
    }
    // Rounding the index plus 1 and the product leaves a unit or two of the cosine undecided.
    assert!(wrong <= 25, "{wrong} of {}", cases.len());
}

#[test]
fn powers_have_no_holes() {
    let cases = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 1e6],
        [0.0, 1.0],
        [0.5, 1000.0],
        [0.999, 300.0],
        [0.25, 0.5],
    ];
    let body = "out[0] = power(in[0], in[1]);";
    let found: Vec<[f32; 1]> = evaluate("powers", body, &cases);
    for ([x, n], [power]) in cases.iter().zip(&found) {
        let exact = f64::from(*x).powf(f64::from(*n));
        assert!(
            (f64::from(*power) - exact).abs() <= 1e-4 * exact.max(1e-20),
            "{x}^{n}: {power}"
        );
    }
}
