//! FPCore, the form of FPBench (version 2.0, fpbench.org): reading it, and computing it in any [`Number`].

use super::decisions::Decisions;
use crate::real::{Number, Operation, Relation, Undefined};
use std::collections::BTreeMap;

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

/// An S-expression.
enum Term {
    Atom(At, String),
    Text(At, String),
    List(At, Vec<Term>),
}

impl Term {
    fn at(&self) -> At {
        match self {
            Term::Atom(at, _) | Term::Text(at, _) | Term::List(at, _) => *at,
        }
    }

    fn wrong(&self, why: impl Into<String>) -> Wrong {
        Wrong {
            at: self.at(),
            why: why.into(),
        }
    }
}

/// Lists in lists that are read.
const MOST_DEPTH: usize = 200;

/// The S-expressions of a text.
fn terms(text: &str) -> Result<Vec<Term>, Wrong> {
    let mut open: Vec<(At, Vec<Term>)> = Vec::new();
    let mut top = Vec::new();
    let (mut line, mut column) = (1, 0);
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        column += 1;
        let at = At { line, column };
        let term = match c {
            '\n' => {
                (line, column) = (line + 1, 0);
                continue;
            }
            c if c.is_whitespace() => continue,
            ';' => {
                while chars.next_if(|c| *c != '\n').is_some() {
                    column += 1;
                }
                continue;
            }
            '(' | '[' => {
                if open.len() == MOST_DEPTH {
                    let why = format!("lists are deeper than {MOST_DEPTH}");
                    return Err(Wrong { at, why });
                }
                open.push((at, Vec::new()));
                continue;
            }
            ')' | ']' => match open.pop() {
                Some((at, list)) => Term::List(at, list),
                None => {
                    let why = "a parenthesis that closes nothing".to_owned();
                    return Err(Wrong { at, why });
                }
            },
            '"' => {
                let mut text = String::new();
                let mut closed = false;
                while let Some(c) = chars.next() {
                    column += 1;
                    match c {
                        '"' => {
                            closed = true;
                            break;
                        }
                        '\n' => (line, column) = (line + 1, 0),
                        '\\' => {
                            column += 1;
                            text.extend(chars.next());
                            continue;
                        }
                        _ => {}
                    }
                    text.push(c);
                }
                if !closed {
                    let why = "a string that does not end".to_owned();
                    return Err(Wrong { at, why });
                }
                Term::Text(at, text)
            }
            c => {
                let mut atom = String::from(c);
                let is_part = |c: &char| !c.is_whitespace() && !"()[]\";".contains(*c);
                while let Some(c) = chars.next_if(is_part) {
                    column += 1;
                    atom.push(c);
                }
                Term::Atom(at, atom)
            }
        };
        match open.last_mut() {
            Some((_, list)) => list.push(term),
            None => top.push(term),
        }
    }
    match open.pop() {
        Some((at, _)) => Err(Wrong {
            at,
            why: "a parenthesis that is not closed".to_owned(),
        }),
        None => Ok(top),
    }
}

/// The benchmarks of a text, each of them or why it cannot be used.
pub(super) fn read(text: &str) -> Result<Vec<Result<Core, Wrong>>, Wrong> {
    let terms = terms(text)?;
    if terms.is_empty() {
        let at = At { line: 1, column: 1 };
        let why = "there is no FPCore in it".to_owned();
        return Err(Wrong { at, why });
    }
    let numbered = terms.iter().enumerate();
    Ok(numbered.map(|(i, term)| core(i, term)).collect())
}

fn core(number: usize, term: &Term) -> Result<Core, Wrong> {
    let Term::List(_, list) = term else {
        return Err(term.wrong("expected (FPCore …)"));
    };
    let mut rest = match list.split_first() {
        Some((Term::Atom(_, word), rest)) if word == "FPCore" => rest,
        _ => return Err(term.wrong("expected (FPCore …)")),
    };
    let mut name = format!("core{}", number + 1);
    if let Some((Term::Atom(_, symbol), after)) = rest.split_first() {
        name.clone_from(symbol);
        rest = after;
    }
    let Some((Term::List(_, params), mut rest)) = rest.split_first() else {
        return Err(term.wrong("the arguments are missing"));
    };
    let args: Vec<String> = params.iter().map(argument).collect::<Result<_, _>>()?;
    let mut pre = None;
    while let [Term::Atom(at, property), value, after @ ..] = rest
        && property.starts_with(':')
    {
        match (property.as_str(), value) {
            (":name", Term::Text(_, text)) => name.clone_from(text),
            (":pre", value) => pre = Some(node(value)?),
            (":precision", Term::Atom(_, p)) if p == "integer" => {
                return Err(Wrong {
                    at: *at,
                    why: "computes with integers".to_owned(),
                });
            }
            _ => {}
        }
        rest = after;
    }
    match rest {
        [body] => Ok(Core {
            name,
            args,
            pre,
            body: node(body)?,
        }),
        _ => Err(term.wrong("expected one expression after the properties")),
    }
}

fn argument(term: &Term) -> Result<String, Wrong> {
    match term {
        Term::Atom(_, name) => Ok(name.clone()),
        Term::List(_, list) => match list.as_slice() {
            [Term::Atom(_, mark), .., Term::Atom(_, name)] if mark == "!" => Ok(name.clone()),
            _ => Err(term.wrong("arguments that are arrays are not supported")),
        },
        Term::Text(..) => Err(term.wrong("expected the name of an argument")),
    }
}

/// Operators beside those of [`Operation::NAMED`].
fn arithmetic(word: &str, operands: usize) -> Option<Operation> {
    Some(match (word, operands) {
        ("+", 2) => Operation::Add,
        ("-", 2) => Operation::Sub,
        ("-", 1) => Operation::Neg,
        ("*", 2) => Operation::Mul,
        ("/", 2) => Operation::Div,
        _ => {
            let mut named = Operation::NAMED.iter();
            named
                .find(|(_, name, n, _)| *name == word && *n == operands)?
                .0
        }
    })
}

const COMPARISONS: [&str; 6] = ["<", ">", "<=", ">=", "==", "!="];

fn node(term: &Term) -> Result<Node, Wrong> {
    let at = term.at();
    let expr = match term {
        Term::Text(..) => return Err(term.wrong("a string is no expression")),
        Term::Atom(_, word) => atom(term, word)?,
        Term::List(_, list) => {
            let Some((Term::Atom(_, word), rest)) = list.split_first() else {
                return Err(term.wrong("expected an operator"));
            };
            form(term, word, rest)?
        }
    };
    Ok(Node { at, expr })
}

fn atom(term: &Term, word: &str) -> Result<Expr, Wrong> {
    if let Some(constant) = CONSTANTS.iter().find(|c| c.name == word) {
        return Ok(Expr::Constant(constant));
    }
    match word {
        "TRUE" => return Ok(Expr::Truth(true)),
        "FALSE" => return Ok(Expr::Truth(false)),
        "INFINITY" | "NAN" => return Err(term.wrong(format!("`{word}` is no real number"))),
        _ => {}
    }
    let starts = word.trim_start_matches(['+', '-']).chars().next();
    if !starts.is_some_and(|c| c.is_ascii_digit() || c == '.') {
        return Ok(Expr::Variable(word.to_owned()));
    }
    if let Some((above, below)) = word.split_once('/') {
        let part = |text: &str| {
            let expr = number(text).ok_or_else(|| term.wrong(format!("`{word}` is no number")))?;
            Ok(Box::new(Node {
                at: term.at(),
                expr,
            }))
        };
        return Ok(Expr::Rational(part(above)?, part(below)?));
    }
    number(word).ok_or_else(|| term.wrong(format!("`{word}` is no number")))
}

/// A decimal or hexadecimal number.
fn number(word: &str) -> Option<Expr> {
    let negative = word.starts_with('-');
    let text = word.trim_start_matches(['+', '-']);
    if let Some(hex) = text.strip_prefix("0x") {
        let value = u32::from_str_radix(hex, 16).ok()?;
        return Some(Expr::Number {
            digits: value.to_string(),
            exponent: 0,
            negative,
        });
    }
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = format!("{whole}{fraction}");
    let known =
        !digits.is_empty() && digits.len() < 400 && digits.chars().all(|c| c.is_ascii_digit());
    known.then(|| Expr::Number {
        digits,
        exponent: exponent.saturating_sub(fraction.len() as i32),
        negative,
    })
}

fn form(term: &Term, word: &str, rest: &[Term]) -> Result<Expr, Wrong> {
    let nodes = |terms: &[Term]| terms.iter().map(node).collect::<Result<Vec<_>, _>>();
    let boxed = |term: &Term| node(term).map(Box::new);
    if let Some(&comparison) = COMPARISONS.iter().find(|c| **c == word) {
        return Ok(Expr::Compare(comparison, nodes(rest)?));
    }
    Ok(match (word, rest) {
        ("and", _) => Expr::And(nodes(rest)?),
        ("or", _) => Expr::Or(nodes(rest)?),
        ("not", [of]) => Expr::Not(boxed(of)?),
        ("if", [a, b, c]) => Expr::If(Box::new([node(a)?, node(b)?, node(c)?])),
        ("let" | "let*", [Term::List(_, list), body]) => Expr::Let {
            sequential: word == "let*",
            bindings: list
                .iter()
                .map(|b| binding(b, false))
                .collect::<Result<_, _>>()?,
            body: boxed(body)?,
        },
        ("while" | "while*", [condition, Term::List(_, list), body]) => Expr::While {
            sequential: word == "while*",
            condition: boxed(condition)?,
            bindings: list
                .iter()
                .map(|b| binding(b, true))
                .collect::<Result<_, _>>()?,
            body: boxed(body)?,
        },
        // Annotations of precision: everything is binary32 here.
        ("!", [_, .., body]) => node(body)?.expr,
        ("cast", [body]) => node(body)?.expr,
        // More operands than two are not in the standard, but some files have them.
        ("+" | "*", [_, _, _, ..]) => {
            let op = if word == "+" {
                Operation::Add
            } else {
                Operation::Mul
            };
            let mut all = nodes(rest)?.into_iter();
            let first = all.next().ok_or_else(|| term.wrong("no operands"))?;
            let fold = |sum: Node, next| Node {
                at: term.at(),
                expr: Expr::Operation(op, vec![sum, next]),
            };
            all.fold(first, fold).expr
        }
        _ => match arithmetic(word, rest.len()) {
            Some(op) => Expr::Operation(op, nodes(rest)?),
            None => {
                let why = format!("`{word}` with {} operands is not supported", rest.len());
                return Err(term.wrong(why));
            }
        },
    })
}

fn binding(term: &Term, updated: bool) -> Result<Binding, Wrong> {
    match term {
        Term::List(_, parts) => {
            match (parts.as_slice(), updated) {
                ([Term::Atom(_, name), init], false) => Ok(Binding {
                    name: name.clone(),
                    init: node(init)?,
                    update: None,
                }),
                ([Term::Atom(_, name), init, update], true) => Ok(Binding {
                    name: name.clone(),
                    init: node(init)?,
                    update: Some(node(update)?),
                }),
                _ => Err(term
                    .wrong("a variable with its value, and in a loop its next value, is expected")),
            }
        }
        _ => Err(term.wrong("a variable with its value is expected")),
    }
}

/// Iterations of a loop that are followed.
const MOST_ITERATIONS: usize = 100_000;

/// The values of variables.
pub(super) type Values<N> = BTreeMap<String, N>;

/// The number that a comparison of two is about, by its relations.
fn relations(comparison: &str) -> &'static [Relation] {
    use Relation::*;
    match comparison {
        "<" => &[Less],
        ">" => &[Greater],
        "<=" => &[Less, Equal],
        ">=" => &[Greater, Equal],
        "==" => &[Equal],
        _ => &[Less, Greater, Unordered],
    }
}

/// Computes an expression.
pub(super) fn compute<N: Number>(
    node: &Node,
    values: &Values<N>,
    decisions: &mut Decisions,
    context: &N::Context,
) -> Result<N, Undefined> {
    match &node.expr {
        Expr::Number {
            digits,
            exponent,
            negative,
        } => {
            let number = N::of_decimal(digits, *exponent, context);
            match negative {
                true => N::apply(Operation::Neg, &[number], context),
                false => Ok(number),
            }
        }
        Expr::Rational(above, below) => {
            let above = compute(above, values, decisions, context)?;
            let below = compute(below, values, decisions, context)?;
            N::apply(Operation::Div, &[above, below], context)
        }
        Expr::Constant(c) => Ok(N::of_decimal(c.digits, c.exponent, context)),
        Expr::Variable(name) => (values.get(name).cloned())
            .ok_or_else(|| Undefined(format!("nothing is called `{name}`"))),
        Expr::Operation(op, args) => {
            let args = args.iter().map(|a| compute(a, values, decisions, context));
            N::apply(*op, &args.collect::<Result<Vec<_>, _>>()?, context)
        }
        Expr::If(parts) => {
            let [condition, then, other] = &**parts;
            match holds(condition, values, decisions, context)? {
                true => compute(then, values, decisions, context),
                false => compute(other, values, decisions, context),
            }
        }
        Expr::Let {
            sequential,
            bindings,
            body,
        } => {
            let inner = bound(*sequential, bindings, values, decisions, context)?;
            compute(body, &inner, decisions, context)
        }
        Expr::While {
            sequential,
            condition,
            bindings,
            body,
        } => {
            let mut inner = bound(*sequential, bindings, values, decisions, context)?;
            let mut iterations = 0;
            while holds(condition, &inner, decisions, context)? {
                iterations += 1;
                if iterations > MOST_ITERATIONS {
                    return Err(Undefined("a loop does not end".to_owned()));
                }
                let mut next = inner.clone();
                for binding in bindings {
                    let Some(update) = &binding.update else {
                        continue;
                    };
                    let from = if *sequential { &next } else { &inner };
                    let value = compute(update, from, decisions, context)?;
                    next.insert(binding.name.clone(), value);
                }
                inner = next;
            }
            compute(body, &inner, decisions, context)
        }
        _ => Err(Undefined(
            "a truth value stands where a number is expected".to_owned(),
        )),
    }
}

fn bound<N: Number>(
    sequential: bool,
    bindings: &[Binding],
    values: &Values<N>,
    decisions: &mut Decisions,
    context: &N::Context,
) -> Result<Values<N>, Undefined> {
    let mut inner = values.clone();
    for binding in bindings {
        let from = if sequential { &inner } else { values };
        let value = compute(&binding.init, from, decisions, context)?;
        inner.insert(binding.name.clone(), value);
    }
    Ok(inner)
}

/// Whether a condition holds.
pub(super) fn holds<N: Number>(
    node: &Node,
    values: &Values<N>,
    decisions: &mut Decisions,
    context: &N::Context,
) -> Result<bool, Undefined> {
    let mut all = |nodes: &[Node], until: bool| -> Result<bool, Undefined> {
        for node in nodes {
            if holds(node, values, decisions, context)? == until {
                return Ok(until);
            }
        }
        Ok(!until)
    };
    match &node.expr {
        Expr::Truth(truth) => Ok(*truth),
        Expr::And(nodes) => all(nodes, false),
        Expr::Or(nodes) => all(nodes, true),
        Expr::Not(of) => Ok(!holds(of, values, decisions, context)?),
        Expr::Compare(comparison, nodes) => {
            let numbers = nodes.iter().map(|n| compute(n, values, decisions, context));
            let numbers = numbers.collect::<Result<Vec<N>, _>>()?;
            for (i, a) in numbers.iter().enumerate() {
                // All of `!=` differ from one another.
                let others = match *comparison {
                    "!=" => &numbers[i + 1..],
                    _ => numbers.get(i + 1..i + 2).unwrap_or(&[]),
                };
                for b in others {
                    if !decisions.holds(a.relate(b), relations(comparison)) {
                        return Ok(false);
                    }
                }
            }
            Ok(true)
        }
        Expr::If(parts) => {
            let [condition, then, other] = &**parts;
            match holds(condition, values, decisions, context)? {
                true => holds(then, values, decisions, context),
                false => holds(other, values, decisions, context),
            }
        }
        _ => Err(Undefined(
            "a number stands where a condition is expected".to_owned(),
        )),
    }
}

/// The ranges that a precondition gives arguments: comparisons with constants, all of which hold.
pub(super) fn ranges(core: &Core) -> BTreeMap<String, (f64, f64)> {
    let mut ranges = BTreeMap::new();
    if let Some(pre) = &core.pre {
        narrow(pre, &mut ranges);
    }
    ranges.retain(|name, _| core.args.contains(name));
    ranges
}

fn narrow(node: &Node, ranges: &mut BTreeMap<String, (f64, f64)>) {
    let nodes = match &node.expr {
        Expr::And(nodes) => {
            nodes.iter().for_each(|node| narrow(node, ranges));
            return;
        }
        Expr::Compare("<" | "<=" | ">" | ">=" | "==", nodes) => nodes,
        _ => return,
    };
    let Expr::Compare(comparison, _) = &node.expr else {
        return;
    };
    let constant = |node: &Node| {
        let number: crate::real::Wide =
            compute(node, &Values::new(), &mut Decisions::default(), &()).ok()?;
        number.is_finite().then(|| number.value())
    };
    let rises = comparison.starts_with('<');
    for (i, of) in nodes.iter().enumerate() {
        // A chain's comparisons carry over: what is before a variable is below it.
        let before = nodes[..i].iter().rev().find_map(constant);
        let after = nodes[i + 1..].iter().find_map(constant);
        let (mut low, mut high) = if rises {
            (before, after)
        } else {
            (after, before)
        };
        if *comparison == "==" {
            (low, high) = (before.or(after), before.or(after));
        }
        let whole = (f64::from(f32::MIN), f64::from(f32::MAX));
        match &of.expr {
            Expr::Variable(name) => {
                let range = ranges.entry(name.clone()).or_insert(whole);
                range.0 = low.map_or(range.0, |low| range.0.max(low));
                range.1 = high.map_or(range.1, |high| range.1.min(high));
            }
            Expr::Operation(Operation::Abs, args) => {
                if let (Some(Expr::Variable(name)), Some(high)) =
                    (args.first().map(|a| &a.expr), high)
                {
                    let range = ranges.entry(name.clone()).or_insert(whole);
                    *range = (range.0.max(-high), range.1.min(high));
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
