//! FPCore, the form of FPBench (version 2.0, fpbench.org): reading it, and computing it in any [`Number`].

mod compute;
mod read;
mod term;

use crate::real::Operation;
pub(super) use compute::{Values, compute, holds, ranges};
pub(super) use read::read;

/// A place in a file: line and column from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct At {
    pub(super) line: u32,
    pub(super) column: u32,
}

/// Why a text is no FPCore that can be used.
#[derive(Debug)]
pub(super) struct Wrong {
    pub(super) at: At,
    pub(super) why: String,
}

/// A benchmark.
#[derive(Clone, Debug)]
pub(super) struct Core {
    pub(super) name: String,
    pub(super) args: Vec<String>,
    pub(super) pre: Option<Node>,
    pub(super) body: Node,
}

/// An expression with its place.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) at: At,
    pub(super) expr: Expr,
}

/// A variable of a loop or a `let`: its name, its value, and in a loop its next value.
#[derive(Clone, Debug)]
pub(super) struct Binding {
    pub(super) name: String,
    pub(super) init: Node,
    pub(super) update: Option<Node>,
}

#[derive(Clone, Debug)]
pub(super) enum Expr {
    /// A decimal number: its digits, the power of ten that they are times, and a sign.
    Number {
        digits: String,
        exponent: i32,
        negative: bool,
    },
    /// A quotient of two whole numbers.
    Rational(Box<Node>, Box<Node>),
    Constant(&'static Constant),
    Truth(bool),
    Variable(String),
    Operation(Operation, Vec<Node>),
    /// A chain of comparisons, each of which holds of these relations.
    Compare(&'static str, Vec<Node>),
    And(Vec<Node>),
    Or(Vec<Node>),
    Not(Box<Node>),
    If(Box<[Node; 3]>),
    Let {
        sequential: bool,
        bindings: Vec<Binding>,
        body: Box<Node>,
    },
    While {
        sequential: bool,
        condition: Box<Node>,
        bindings: Vec<Binding>,
        body: Box<Node>,
    },
}

/// A mathematical constant: FPCore's name, and as decimal digits behind the first one.
#[derive(Debug)]
pub(super) struct Constant {
    pub(super) name: &'static str,
    pub(super) digits: &'static str,
    pub(super) exponent: i32,
}

/// Digits as in Abramowitz and Stegun, chapter 1, and the OEIS.
const CONSTANTS: &[Constant] = &[
    constant("E", "2718281828459045235360287471352662497757247", -42),
    constant("LOG2E", "1442695040888963407359924681001892137426646", -42),
    constant("LOG10E", "4342944819032518276511289189166050822943970", -43),
    constant("LN2", "6931471805599453094172321214581765680755001", -43),
    constant("LN10", "2302585092994045684017991454684364207601101", -42),
    constant("PI", "3141592653589793238462643383279502884197169", -42),
    constant("PI_2", "1570796326794896619231321691639751442098585", -42),
    constant("PI_4", "7853981633974483096156608458198757210492923", -43),
    constant("M_1_PI", "3183098861837906715377675267450287240689193", -43),
    constant("M_2_PI", "6366197723675813430755350534900574481378386", -43),
    constant(
        "M_2_SQRTPI",
        "1128379167095512573896158903121545171688101",
        -42,
    ),
    constant("SQRT2", "1414213562373095048801688724209698078569672", -42),
    constant(
        "SQRT1_2",
        "7071067811865475244008443621048490392848360",
        -43,
    ),
];

const fn constant(name: &'static str, digits: &'static str, exponent: i32) -> Constant {
    Constant {
        name,
        digits,
        exponent,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::decisions::Decisions;
    use crate::real::Wide;

    fn value(text: &str, args: &[(&str, f64)]) -> f64 {
        let cores =
            read(text).unwrap_or_else(|w| panic!("{}:{}: {}", w.at.line, w.at.column, w.why));
        let core = cores[0].as_ref().unwrap_or_else(|w| panic!("{}", w.why));
        let values: Values<Wide> = args
            .iter()
            .map(|(n, x)| ((*n).to_owned(), Wide::of(*x)))
            .collect();
        let found = compute(&core.body, &values, &mut Decisions::default(), &());
        found.expect("a number").value()
    }

    #[test]
    fn forms_mean_what_the_standard_says() {
        assert_eq!(
            value("(FPCore (x) (let ([x 1] [y x]) (+ x y)))", &[("x", 5.0)]),
            6.0
        );
        assert_eq!(
            value("(FPCore (x) (let* ([x 1] [y x]) (+ x y)))", &[("x", 5.0)]),
            2.0
        );
        let fibonacci = "(FPCore (n) (while (> n 0) ([n n (- n 1)] [a 0 b] [b 1 (+ a b)]) a))";
        assert_eq!(value(fibonacci, &[("n", 10.0)]), 55.0);
        assert_eq!(
            value(
                "(FPCore (x) (if (< 0 x 1) (if (and (!= x 2) TRUE) 7 8) 9))",
                &[("x", 0.5)]
            ),
            7.0
        );
        assert_eq!(
            value("(FPCore () (! :precision binary64 (- 3/4 1e-1)))", &[]),
            0.65
        );
        assert_eq!(value("(FPCore () (* PI 2))", &[]), std::f64::consts::TAU);
    }

    #[test]
    fn preconditions_give_ranges() {
        let text =
            "(FPCore f (x y z) :pre (and (<= -1 x 2.5) (> 10 y 3) (< (fabs z) 4) (< x y)) x)";
        let cores = read(text).expect("a core");
        let core = cores[0].as_ref().expect("a core");
        let ranges = ranges(core);
        assert_eq!(ranges["x"], (-1.0, 2.5));
        assert_eq!(ranges["y"], (3.0, 10.0));
        assert_eq!(ranges["z"], (-4.0, 4.0));
    }

    #[test]
    fn mistakes_have_a_place() {
        for (text, line, column) in [
            ("(FPCore (x)\n  (+ x (foo x)))", 2, 8),
            ("(FPCore (x)", 1, 1),
            ("(FPCore (x) x))", 1, 15),
            ("(FPCore (x) (let ([y]) y))", 1, 19),
            ("", 1, 1),
            ("(FPCore (x) 1.2.3)", 1, 13),
        ] {
            let first = read(text).and_then(|mut cores| cores.remove(0));
            let wrong = first.map(|_| ()).expect_err(text);
            assert_eq!(
                (wrong.at.line, wrong.at.column),
                (line, column),
                "{text}: {}",
                wrong.why
            );
        }
    }
}
