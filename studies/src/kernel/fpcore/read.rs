//! FPCores of S-expressions.

use super::term::{Term, terms};
use super::{At, Binding, CONSTANTS, Core, Expr, Node, Wrong};
use crate::real::Operation;

/// The benchmarks of a text, each of them or why it cannot be used.
pub(in crate::kernel) fn read(text: &str) -> Result<Vec<Result<Core, Wrong>>, Wrong> {
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
