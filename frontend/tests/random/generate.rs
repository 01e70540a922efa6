//! Random C without undefined or unspecified behaviour: shifts are by masked counts, divisors and
//! conversions from floating types are checked, indices masked, calls stand alone in a statement,
//! and loops count.

use super::tree::{Expr, Function, Piece, Stmt, Tree};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

const INTS: [&str; 10] = [
    "char",
    "signed char",
    "unsigned char",
    "short",
    "unsigned short",
    "int",
    "unsigned",
    "long long",
    "unsigned long long",
    "_Bool",
];

const CONSTANTS: [&str; 18] = [
    "0",
    "1",
    "-1",
    "2",
    "7",
    "-13",
    "100",
    "127",
    "128",
    "-128",
    "255",
    "32767",
    "65535",
    "2147483647",
    "(-2147483647 - 1)",
    "4294967295u",
    "123456789012345LL",
    "0x8000000000000000ULL",
];

const FLOATS: [&str; 9] = [
    "0.0f", "1.0f", "-0.5f", "3.25f", "1e10f", "0.1", "-2.75", "1e-3", "65536.5",
];

/// The start of every program: the functions that keep it defined, and the variables.
pub(crate) const COMMON: &str = "\
#include \"srp.h\"
static int div_i(int a, int b) { return b == 0 || b == -1 ? a : a / b; }
static int rem_i(int a, int b) { return b == 0 || b == -1 ? a : a % b; }
static unsigned div_u(unsigned a, unsigned b) { return b ? a / b : a; }
static long long div_l(long long a, long long b) { return b == 0 || b == -1 ? a : a / b; }
static unsigned long long rem_l(unsigned long long a, unsigned long long b) { return b ? a % b : a; }
static int to_i(double x) { return x > -2e9 && x < 2e9 ? (int)x : 3; }
static long long to_l(double x) { return x > -9e18 && x < 9e18 ? (long long)x : 5; }
static unsigned long long mix(unsigned long long h, unsigned long long v) { return (h ^ v) * 0x100000001b3ULL; }
static unsigned long long mix_f(unsigned long long h, float f) { return mix(h, f != f ? 1 : srp_bits(f)); }
static unsigned long long mix_d(unsigned long long h, double d) { union { double d; unsigned long long u; } x = { d }; return mix(h, d != d ? 1 : x.u); }
";

pub(crate) struct Maker {
    rng: Pcg32,
    /// The prefix of every name of the program.
    prefix: String,
    /// Loops around the current statement.
    loops: usize,
    /// Functions that may be called: those made already.
    callable: usize,
    blocks: usize,
}

fn text(text: impl Into<String>) -> Piece {
    Piece::Text(text.into())
}

fn int_expr(pieces: Vec<Piece>) -> Expr {
    Expr {
        pieces,
        simplest: "1",
    }
}

fn float_expr(pieces: Vec<Piece>) -> Expr {
    Expr {
        pieces,
        simplest: "1.0f",
    }
}

/// The program of a seed, its names beginning with `prefix`; its function `PREFIXmain` returns a
/// checksum.
pub(crate) fn program(seed: u64, prefix: &str) -> Tree {
    let mut maker = Maker {
        rng: Pcg32::new(seed, 1442),
        prefix: prefix.to_owned(),
        loops: 0,
        callable: 0,
        blocks: 0,
    };
    let globals = maker.globals();
    let count = 1 + maker.below(3);
    let mut functions = Vec::new();
    for _ in 0..count {
        functions.push(maker.function());
        maker.callable += 1;
    }
    functions.push(maker.main());
    Tree {
        globals,
        functions,
        last: String::new(),
    }
}

impl Maker {
    fn below(&mut self, n: usize) -> usize {
        self.rng.next_u32() as usize % n
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }

    fn globals(&mut self) -> String {
        let p = self.prefix.clone();
        let mut out = String::new();
        let widths = [3, 7, 12, 20, 1].map(|w| 1 + (w + self.below(5)) % 24);
        let [a, b, c, d, e] = widths;
        out += &format!(
            "struct {p}s {{ unsigned a : {a}; int b : {b}; char c; long long d : {}; unsigned short e : {}; \
             float f; unsigned g : {d}; int h[3]; }};\n",
            c + 20,
            e.min(16)
        );
        for (i, ty) in INTS.iter().enumerate() {
            let value = self.pick(&CONSTANTS);
            out += &format!("static {ty} {p}g{i} = ({ty}){value};\n");
            let values: Vec<_> = (0..3)
                .map(|_| format!("({ty}){}", self.pick(&CONSTANTS)))
                .collect();
            out += &format!("static {ty} {p}a{i}[8] = {{ {} }};\n", values.join(", "));
        }
        let (x, y) = (self.pick(&FLOATS), self.pick(&FLOATS));
        out += &format!(
            "static float {p}f0 = {x}, {p}f1; static double {p}d0 = {y}, {p}d1;\n\
             static float {p}fa[4] = {{ 1, {x} }}; static float4 {p}v0 = {{ 1, 2, 3, 4 }}, {p}v1;\n\
             static int4 {p}w0 = {{ 5, -6, 7, -8 }};\n\
             static struct {p}s {p}s0 = {{ 1, -1, 2, -3, 4, 0.5f, 6, {{ 7, 8 }} }}, {p}s1;\n\
             static struct {p}s *{p}sp = &{p}s0; static int *{p}ip = &{p}a5[3];\n\
             static struct {p}s {p}turn(struct {p}s s, int by) {{ s.b += by; s.h[by & 1] -= s.g; return s; }}\n"
        );
        out
    }

    /// Something of an integer type that can be assigned to.
    fn int_place(&mut self) -> Vec<Piece> {
        let p = self.prefix.clone();
        let kind = self.below(INTS.len());
        match self.below(9) {
            0 | 1 => vec![text(format!("{p}g{kind}"))],
            2 => {
                let index = self.int(1);
                vec![
                    text(format!("{p}a{kind}[(")),
                    Piece::Expr(index),
                    text(") & 7]"),
                ]
            }
            3 => vec![text(format!("(*{p}ip)"))],
            4 => {
                let field = self.pick(&["a", "b", "c", "d", "e", "g", "h[1]", "h[2]"]);
                let of = self.pick(&["s0.", "s1.", "sp->"]);
                vec![text(format!("{p}{of}{field}"))]
            }
            _ => vec![text(format!("l{}", self.below(6)))],
        }
    }

    /// An integer expression.
    fn int(&mut self, depth: usize) -> Expr {
        if depth == 0 || self.one_in(5) {
            let pieces = match self.below(8) {
                0..3 => vec![text(self.pick(&CONSTANTS))],
                3 if self.loops > 0 => vec![text(format!("i{}", self.below(self.loops)))],
                _ => self.int_place(),
            };
            return int_expr(pieces);
        }
        let (a, b) = (self.int(depth - 1), self.int(depth - 1));
        let (a, b) = (Piece::Expr(a), Piece::Expr(b));
        int_expr(match self.below(19) {
            0..5 => {
                let op = self.pick(&["+", "-", "*", "&", "|", "^"]);
                vec![text("("), a, text(format!(" {op} ")), b, text(")")]
            }
            5..7 => {
                let op = self.pick(&["<", "<=", ">", ">=", "==", "!=", "&&", "||"]);
                vec![text("("), a, text(format!(" {op} ")), b, text(")")]
            }
            7 => {
                let op = self.pick(&["<<", ">>"]);
                vec![
                    text("((int)"),
                    a,
                    text(format!(" {op} (")),
                    b,
                    text(" & 31))"),
                ]
            }
            8 => {
                let op = self.pick(&["<<", ">>"]);
                let ty = self.pick(&["unsigned long long", "long long"]);
                vec![
                    text(format!("(({ty})")),
                    a,
                    text(format!(" {op} (")),
                    b,
                    text(" & 63))"),
                ]
            }
            9..11 => {
                let call = self.pick(&["div_i", "rem_i", "div_u", "div_l", "rem_l"]);
                vec![text(format!("{call}(")), a, text(", "), b, text(")")]
            }
            11 => {
                let c = self.int(depth - 1);
                vec![
                    text("("),
                    Piece::Expr(c),
                    text(" ? "),
                    a,
                    text(" : "),
                    b,
                    text(")"),
                ]
            }
            12 => {
                let op = self.pick(&["-", "~", "!", "+"]);
                vec![text(format!("({op} ")), a, text(")")]
            }
            13 | 14 => {
                let ty = self.pick(&INTS);
                vec![text(format!("(({ty})")), a, text(")")]
            }
            15 => {
                let (x, y) = (self.float(depth - 1), self.float(depth - 1));
                let op = self.pick(&["<", "<=", ">", ">=", "==", "!="]);
                vec![
                    text("("),
                    Piece::Expr(x),
                    text(format!(" {op} ")),
                    Piece::Expr(y),
                    text(")"),
                ]
            }
            16 => {
                let x = self.float(depth - 1);
                let call = self.pick(&["to_i", "to_l"]);
                vec![text(format!("{call}(")), Piece::Expr(x), text(")")]
            }
            17 => {
                let lane = self.below(4);
                vec![text(format!("{}w0[{lane}]", self.prefix))]
            }
            _ => vec![text("(("), a, text(") ?: "), b, text(")")],
        })
    }

    /// A floating expression.
    fn float(&mut self, depth: usize) -> Expr {
        let p = self.prefix.clone();
        if depth == 0 || self.one_in(4) {
            let pieces = match self.below(7) {
                0 | 1 => vec![text(self.pick(&FLOATS))],
                2 => vec![text(format!("{p}fa[{}]", self.below(4)))],
                3 => vec![text(format!("{p}v0[{}]", self.below(4)))],
                4 => vec![text(format!("{p}s0.f"))],
                _ => {
                    let name = self.pick(&["f0", "f1", "d0", "d1"]);
                    vec![text(format!("{p}{name}"))]
                }
            };
            return float_expr(pieces);
        }
        let (a, b) = (self.float(depth - 1), self.float(depth - 1));
        let (a, b) = (Piece::Expr(a), Piece::Expr(b));
        float_expr(match self.below(8) {
            0..4 => {
                let op = self.pick(&["+", "-", "*", "/"]);
                vec![text("("), a, text(format!(" {op} ")), b, text(")")]
            }
            4 => {
                let c = self.int(depth - 1);
                vec![
                    text("("),
                    Piece::Expr(c),
                    text(" ? "),
                    a,
                    text(" : "),
                    b,
                    text(")"),
                ]
            }
            5 => {
                let ty = self.pick(&["float", "double"]);
                vec![text(format!("(({ty})")), a, text(")")]
            }
            6 => {
                let ty = self.pick(&["float", "double"]);
                let c = self.int(depth - 1);
                vec![text(format!("(({ty})")), Piece::Expr(c), text(")")]
            }
            _ => vec![text("(- "), a, text(")")],
        })
    }

    fn stmts(&mut self, depth: usize) -> Vec<Stmt> {
        let count = 1 + self.below(4);
        (0..count).map(|_| self.stmt(depth)).collect()
    }

    fn assign(&mut self) -> Stmt {
        let mut pieces = self.int_place();
        let value = Piece::Expr(self.int(3));
        match self.below(5) {
            0..2 => pieces.extend([text(" = "), value, text(";")]),
            2 => {
                let op = self.pick(&["+=", "-=", "*=", "&=", "|=", "^="]);
                pieces.extend([text(format!(" {op} ")), value, text(";")]);
            }
            3 => {
                let op = self.pick(&["<<=", ">>="]);
                pieces.extend([text(format!(" {op} (")), value, text(") & 7;")]);
            }
            _ => {
                let op = self.pick(&["++", "--"]);
                match self.one_in(2) {
                    true => pieces.insert(0, text(op)),
                    false => pieces.push(text(op)),
                }
                pieces.push(text(";"));
            }
        }
        Stmt::Plain(pieces)
    }

    fn float_assign(&mut self) -> Stmt {
        let p = self.prefix.clone();
        let place = match self.below(4) {
            0 => format!("{p}fa[{}]", self.below(4)),
            1 => format!("{p}s0.f"),
            2 => format!("{p}v0[{}]", self.below(4)),
            _ => {
                let name = self.pick(&["f0", "f1", "d0", "d1"]);
                format!("{p}{name}")
            }
        };
        let op = self.pick(&["=", "=", "+=", "-=", "*="]);
        let value = Piece::Expr(self.float(3));
        Stmt::Plain(vec![text(format!("{place} {op} ")), value, text(";")])
    }

    /// Vectors, structs, pointers.
    fn other_assign(&mut self) -> Stmt {
        let p = self.prefix.clone();
        let index = Piece::Expr(self.int(2));
        Stmt::Plain(match self.below(7) {
            0 => {
                let op = self.pick(&["+", "-", "*"]);
                vec![text(format!("{p}v1 = {p}v0 {op} {p}v1;"))]
            }
            1 => {
                let op = self.pick(&["+", "-", "*", "&", "^"]);
                vec![
                    text(format!("{p}w0 = {p}w0 {op} srp_splati((int)")),
                    index,
                    text(");"),
                ]
            }
            2 => vec![text(format!("{p}v0 = {p}v1;"))],
            3 => vec![
                text(format!("{p}s1 = {p}turn({p}s0, (int)")),
                index,
                text(");"),
            ],
            4 => vec![text(format!("*{p}sp = {p}s1;"))],
            5 => vec![text(format!("{p}ip = &{p}a5[(")), index, text(") & 7];")],
            _ => {
                let target = self.pick(&["s0", "s1"]);
                vec![text(format!("{p}sp = &{p}{target};"))]
            }
        })
    }

    fn block(&mut self, open: Vec<Piece>, depth: usize, close: &str) -> Stmt {
        Stmt::Block {
            open,
            body: self.stmts(depth - 1),
            close: close.to_owned(),
        }
    }

    fn stmt(&mut self, depth: usize) -> Stmt {
        if depth == 0 {
            return match self.below(5) {
                0 => self.float_assign(),
                1 => self.other_assign(),
                _ => self.assign(),
            };
        }
        match self.below(15) {
            0 | 1 => self.float_assign(),
            2 => self.other_assign(),
            3 | 4 => {
                let c = Piece::Expr(self.int(3));
                self.block(vec![text("if ("), c, text(") {")], depth, "}")
            }
            5 if self.loops < 3 => {
                let (n, count) = (self.loops, 1 + self.below(5));
                self.loops += 1;
                let open = match self.below(3) {
                    0 => format!("for (int i{n} = 0; i{n} < {count}; i{n}++) {{"),
                    1 => format!("for (int i{n} = {count}; i{n} > 0; i{n} -= 2) {{"),
                    _ => format!("for (unsigned i{n} = 0; i{n} != {count}; ++i{n}) {{"),
                };
                let stmt = self.block(vec![text(open)], depth, "}");
                self.loops -= 1;
                stmt
            }
            6 if self.loops > 0 => {
                let c = Piece::Expr(self.int(2));
                let leave = self.pick(&["break", "continue"]);
                Stmt::Plain(vec![text("if ("), c, text(format!(") {leave};"))])
            }
            7 => self.switch(depth),
            8 if self.callable > 0 && self.loops < 2 => {
                let (a, b) = (self.int(2), self.float(2));
                let callee = self.below(self.callable);
                let place = format!("l{}", self.below(6));
                Stmt::Plain(vec![
                    text(format!("{place} = {}fn{callee}(", self.prefix)),
                    Piece::Expr(a),
                    text(", "),
                    Piece::Expr(b),
                    text(");"),
                ])
            }
            9 => {
                let c = Piece::Expr(self.int(2));
                Stmt::Plain(vec![text("if ("), c, text(") goto out;")])
            }
            10 => {
                let n = self.blocks;
                self.blocks += 1;
                let open = format!("{{ int n{n} = {}; again{n}:", 1 + self.below(3));
                let close = format!("if (--n{n} > 0) goto again{n}; }}");
                self.block(vec![text(open)], depth, &close)
            }
            _ => self.assign(),
        }
    }

    fn switch(&mut self, depth: usize) -> Stmt {
        let value = Piece::Expr(self.int(2));
        let mut body = Vec::new();
        for i in 0..1 + self.below(4) {
            let label = match self.below(4) {
                0 if i == 0 => "default:".to_owned(),
                1 => format!("case {} ... {}:", 3 * i, 3 * i + 1),
                _ => format!("case {}:", 3 * i),
            };
            let close = if self.one_in(3) { "" } else { "break;" };
            body.push(self.block(vec![text(label)], depth, close));
        }
        // A label needs a statement after it.
        body.push(Stmt::Plain(vec![text("case 100:;")]));
        Stmt::Block {
            open: vec![text("switch (("), value, text(") & 15) {")],
            body,
            close: "}".to_owned(),
        }
    }

    fn locals(&mut self) -> String {
        let mut out = String::new();
        for i in 0..6 {
            let (ty, value) = (self.pick(&INTS), self.pick(&CONSTANTS));
            let storage = if self.one_in(8) { "static " } else { "" };
            out += &format!("    {storage}{ty} l{i} = ({ty}){value};\n");
        }
        if self.one_in(2) {
            out += &format!(
                "    {}ip = &(int){{ 4 }};\n    {}ip = &{}a5[1];\n",
                self.prefix, self.prefix, self.prefix
            );
        }
        out
    }

    fn function(&mut self) -> Function {
        let (result, a) = (self.pick(&INTS), self.pick(&INTS));
        let b = self.pick(&["float", "double"]);
        let head = format!(
            "static {result} {}fn{}({a} a, {b} b)",
            self.prefix, self.callable
        );
        let mut first = self.locals();
        first += "    l0 += a; l1 ^= b > 0;\n";
        Function {
            head,
            first,
            body: self.stmts(3),
            last: format!("out:;\n    return l{};\n", self.below(6)),
        }
    }

    fn main(&mut self) -> Function {
        let p = self.prefix.clone();
        let first = self.locals();
        let mut body = self.stmts(3);
        body.extend(self.stmts(3));
        let mut last = String::from("out:;\n    unsigned long long h = 1;\n");
        for i in 0..INTS.len() {
            last += &format!(
                "    h = mix(h, {p}g{i}); for (int i = 0; i < 8; i++) h = mix(h, {p}a{i}[i]);\n"
            );
        }
        for name in ["f0", "f1", "s0.f", "s1.f"] {
            last += &format!("    h = mix_f(h, {p}{name});\n");
        }
        last += &format!(
            "    h = mix_d(h, {p}d0); h = mix_d(h, {p}d1);\n    for (int i = 0; i < 4; i++) {{ \
             h = mix_f(h, {p}fa[i]); h = mix_f(h, {p}v0[i]); h = mix_f(h, {p}v1[i]); h = mix(h, {p}w0[i]); }}\n"
        );
        for field in ["a", "b", "c", "d", "e", "g", "h[0]", "h[1]", "h[2]"] {
            last += &format!("    h = mix(h, {p}s0.{field}); h = mix(h, {p}s1.{field});\n");
        }
        for i in 0..6 {
            last += &format!("    h = mix(h, l{i});\n");
        }
        last += "    return h;\n";
        Function {
            head: format!("unsigned long long {p}main(void)"),
            first,
            body,
            last,
        }
    }
}
