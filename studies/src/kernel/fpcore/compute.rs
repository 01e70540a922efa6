//! FPCores computed in any [`Number`].

use super::{Binding, Core, Expr, Node};
use crate::kernel::decisions::Decisions;
use crate::real::{Number, Operation, Relation, Undefined};
use std::collections::BTreeMap;

/// Iterations of a loop that are followed.
const MOST_ITERATIONS: usize = 100_000;

/// The values of variables.
pub(in crate::kernel) type Values<N> = BTreeMap<String, N>;

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
pub(in crate::kernel) fn compute<N: Number>(
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

/// Decides a condition.
pub(in crate::kernel) fn holds<N: Number>(
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
pub(in crate::kernel) fn ranges(core: &Core) -> BTreeMap<String, (f64, f64)> {
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
