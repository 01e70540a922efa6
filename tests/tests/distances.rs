//! How many iterations apart the memory accesses and the values of C loops have to stay: what the
//! array may overlap, and what not.

use srp_archdesc::arch::Precision;
use srp_archdesc::diagnostic::Source;
use srp_frontend::message::render_all;
use srp_frontend::{Options, compile};
use srp_ir::pass;
use srp_ir::split::{Doubt, Remark, Split, split};

fn divided(text: &str) -> Split {
    let source = Source::new("loop.c", text);
    let texts = |name: &str| (name == "loop.c").then(|| text.to_owned());
    let (mut program, _) = compile(&[source], &Options::default())
        .unwrap_or_else(|messages| panic!("{}", render_all(&messages, &texts, false)));
    let options = pass::Options::new(Precision::EXACT);
    pass::optimise(&mut program, &options);
    split(&program)
}

/// The memory orders of the only loop, as `from -> to + distance` in opcodes.
fn orders(text: &str) -> Vec<String> {
    let split = divided(text);
    let kernels: Vec<_> = split.dre.kernels.values().collect();
    let [dfg] = kernels[..] else {
        panic!("{text}: {} loops, {:?}", kernels.len(), split.not_pipelined);
    };
    let op = |node| dfg.nodes[node].op;
    let show = |o: &srp_ir::dfg::Order| format!("{} -> {} + {}", op(o.from), op(o.to), o.distance);
    dfg.order.iter().map(show).collect()
}

/// The distances over 0 at which the loops of a program take values of operations.
fn carried(text: &str) -> Vec<u32> {
    let split = divided(text);
    let nodes = split.dre.kernels.values().flat_map(|k| k.nodes.values());
    let distances = nodes.flat_map(|data| data.producers().map(|(_, distance)| distance));
    let mut distances: Vec<u32> = distances.filter(|&d| d > 0).collect();
    distances.sort_unstable();
    distances.dedup();
    distances
}

const NONE: [&str; 0] = [];

#[test]
fn affine_subscripts_of_one_array_have_their_distance() {
    let case = |body: &str| {
        orders(&format!(
            "int a[256]; int m[16][8], w[16][64]; struct {{ int x, y; }} s[64]; short h[128];
             void f(int n) {{ {body} }}"
        ))
    };
    let back = case("for (int i = 3; i < n; i++) a[i] = a[i - 3] + 1;");
    assert_eq!(back, ["sw -> lw + 3"]);
    let every_other = case("for (int i = 5; i < n; i++) a[2 * i] = a[2 * i - 10] + 1;");
    assert_eq!(every_other, ["sw -> lw + 5"]);
    // What is read before it is overwritten is in order already: the value is stored later.
    assert_eq!(
        case("for (int i = 0; i < n; i++) a[i] = a[i + 2] + 1;"),
        NONE
    );
    assert_eq!(
        case("for (int i = 0; i < n; i++) a[2 * i] = a[2 * i + 1];"),
        NONE
    );
    let downwards = case("for (int i = n; i > 0; i--) a[i] = a[i + 4] + 1;");
    assert_eq!(downwards, ["sw -> lw + 4"]);
    let rows =
        case("for (int i = 1; i < n; i++) for (int j = 0; j < n; j++) m[i][j] = m[i - 1][j] + 1;");
    assert_eq!(rows, ["sw -> lw + 8"]);
    let known = case(
        "for (int i = 1; i < 16; i++) for (int j = 0; j < 64; j++) w[i][j] = w[i - 1][j] + 1;",
    );
    assert_eq!(known, NONE, "no row is longer than its 64 elements");
    assert_eq!(
        case("for (int i = 1; i < n; i++) s[i].x = s[i - 1].y;"),
        NONE
    );
    let member = case("for (int i = 2; i < n; i++) s[i].x = s[i - 2].x + 1;");
    assert_eq!(member, ["sw -> lw + 2"]);
    assert_eq!(
        case("for (int i = 1; i < n; i++) a[i] = a[i - 1] + 1;"),
        NONE,
        "what was stored is kept in a register for the next iteration"
    );
    let halves = case("for (int i = 2; i < n; i++) h[i] = h[i - 2] + 1;");
    assert_eq!(halves, ["sh -> lh + 2"]);
    let at_one = case("for (int i = 0; i < n; i++) a[7] += i;");
    assert_eq!(
        at_one, NONE,
        "the word stays in a register while the loop runs"
    );
    let unknown = case("for (int i = 0; i < n; i++) a[s[i].x] += 1;");
    assert_eq!(unknown, ["sw -> lw + 1"]);
}

#[test]
fn different_arrays_never_meet() {
    let case = |body: &str| orders(&format!("int a[64], b[64]; {body}"));
    assert_eq!(
        case("void f(int n) { for (int i = 1; i < n; i++) a[i] = b[i - 1]; }"),
        NONE
    );
    assert_eq!(
        case("void f(int n) { for (int i = 1; i < n; i++) a[i] = b[a[i + 1]]; }"),
        NONE
    );
    let either = case(
        "void f(int n, int c) { int *p = c ? a : b; for (int i = 1; i < n; i++) p[i] = b[i - 1]; }",
    );
    assert_eq!(either, ["sw -> lw + 1"]);
}

#[test]
fn pointers_may_meet_unless_one_is_restrict() {
    let case = |parameters: &str, body: &str| {
        orders(&format!(
            "int a[64]; void f({parameters}, int n) {{ {body} }}"
        ))
    };
    let copy = "for (int i = 1; i < n; i++) p[i] = q[i - 1] + 1;";
    assert_eq!(case("int *p, int *q", copy), ["sw -> lw + 1"]);
    // One is enough: q is not based on p.
    assert_eq!(case("int *restrict p, int *q", copy), NONE);
    assert_eq!(case("int *p, int *restrict q", copy), NONE);
    assert_eq!(case("int *restrict p, int *restrict q", copy), NONE);
    // Nor is what is loaded, unless p was stored.
    let loaded = "for (int i = 1; i < n; i++) p[i] = t[0][i - 1] + 1;";
    assert_eq!(case("int *restrict p, int **t", loaded), NONE);
    let given_away = format!("t[n] = p; {loaded}");
    assert_eq!(
        case("int *restrict p, int **t", &given_away),
        ["sw -> lw + 1"]
    );
    assert_eq!(
        case("int p[restrict], int q[restrict static 4]", copy),
        NONE
    );
    // One of them is known to be another object.
    let global = "for (int i = 1; i < n; i++) p[i] = a[i - 1] + 1;";
    assert_eq!(case("int *p", global), ["sw -> lw + 1"]);
    assert_eq!(case("int *restrict p", global), NONE);
    // The same pointer keeps its distance.
    let own = "for (int i = 3; i < n; i++) p[i] = p[i - 3] + 1;";
    assert_eq!(case("int *restrict p", own), ["sw -> lw + 3"]);
    let derived = "int *r = p + 2; for (int i = 1; i < n; i++) r[i] = p[i] + 1;";
    assert_eq!(case("int *restrict p", derived), ["sw -> lw + 2"]);
    let stepping = "while (n--) *p++ = *q++ + 1;";
    assert_eq!(case("int *restrict p, int *restrict q", stepping), NONE);
}

#[test]
fn restrict_holds_in_its_scope() {
    let locals = "int *restrict x = p, *restrict y = q;
                  for (int i = 1; i < n; i++) x[i] = y[i - 1] + 1;";
    let case = |body: &str| orders(&format!("void f(int *p, int *q, int n) {{ {body} }}"));
    assert_eq!(case(locals), NONE);
    let ended = "int *v, *w; { int *restrict x = p, *restrict y = q; v = x; w = y; }
                 for (int i = 1; i < n; i++) v[i] = w[i - 1] + 1;";
    assert_eq!(case(ended), ["sw -> lw + 1"]);
    let each = "for (int i = 1; i < n; i++) {
                    int *restrict x = p + i, *restrict y = q + i; x[0] = y[-1] + 1; }";
    assert_eq!(
        case(each),
        ["sw -> lw + 1"],
        "it is another scope in each iteration"
    );
    // A function that is inlined into the loop begins its scope in each iteration, one with the loop
    // in it once.
    let copy = "static inline void copy(int *restrict x, int *restrict y, int m)
                { for (int i = 1; i < m; i++) x[i] = y[i - 1] + 1; }
                static inline int *same(int *restrict x) { for (int i = 0; i < 0; i++); return x; }
                static inline void one(int *restrict x, int *restrict y) { x[0] = y[-1] + 1; }";
    let case = |body: &str| {
        orders(&format!(
            "{copy} void f(int *p, int *q, int n) {{ {body} }} int main(void) {{ return 0; }} void (*used)(int *, int *, int) = f;"
        ))
    };
    assert_eq!(case("copy(p, q, n);"), NONE);
    assert_eq!(
        case("for (int i = 1; i < n; i++) one(p + i, q + i);"),
        ["sw -> lw + 1"]
    );
    assert_eq!(
        case("int *x = same(p), *y = same(q); for (int i = 1; i < n; i++) x[i] = y[i - 1] + 1;"),
        ["sw -> lw + 1"]
    );
}

#[test]
fn what_restrict_would_buy_is_told() {
    let copy = "for (int i = 1; i < n; i++) p[i] = q[i - 1] + 1;";
    let of = |parameters: &str, body: &str| {
        divided(&format!("void f({parameters}, int n)\n{{\n{body} }}"))
    };
    let split = of("int *p, int *q", copy);
    let relaxed: Vec<_> = split.relaxed.values().collect();
    assert_eq!(relaxed, [&Vec::new()]);
    let [remark] = &split.remarks[..] else {
        panic!("{:?}", split.remarks);
    };
    assert_eq!(remark.doubt, Doubt::AliasUnlessRestrict);
    assert_eq!((remark.first.line, remark.second.line), (3, 3));
    // It would not help where both go through one pointer.
    let split = of(
        "int *p, int *q",
        "for (int i = 1; i < n; i++) p[q[0]] = p[q[1]] + 1;",
    );
    let helped = |r: &Remark| r.doubt == Doubt::AliasUnlessRestrict;
    assert!(!split.remarks.iter().all(helped), "{:?}", split.remarks);
    assert!(
        of("int *restrict p, int *restrict q", copy)
            .remarks
            .is_empty()
    );
}

#[test]
fn reductions_and_scalars_are_carried() {
    let sum =
        "int a[64]; int f(int n) { int s = 0; for (int i = 0; i < n; i++) s += a[i]; return s; }";
    assert_eq!(carried(sum), [1]);
    let third = "int a[64]; int f(int n, int x, int y, int z)
                 { int s = 0; for (int i = 0; i < n; i++) { s ^= z; z = y; y = x; x = a[i]; } return s; }";
    assert_eq!(carried(third), [1, 3]);
    let maximum = "float a[64]; float f(int n)
                   { float m = 0; for (int i = 0; i < n; i++) m = a[i] > m ? a[i] : m; return m; }";
    assert_eq!(carried(maximum), [1]);
}
