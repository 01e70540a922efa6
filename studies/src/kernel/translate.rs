//! FPCore to C: a statement for each operation, on a line of its own, so that what is known of a line is
//! known of the operation that stands there.

use super::decisions::Decisions;
use super::fpcore::{At, Binding, Core, Expr, Node, Values, Wrong, compute};
use crate::real::{Operation, Wide};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A function in C, and where each of its lines comes from.
pub(super) struct Translated {
    /// The text.
    pub(super) text: String,
    /// The function's name in C.
    pub(super) function: String,
    /// For lines that compute something: the place of the operation.
    pub(super) lines: BTreeMap<u32, At>,
}

/// A name of C for a name of FPCore.
pub(super) fn identifier(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(letter).collect();
    format!("fp_{name}")
}

/// Makes C of a benchmark.
pub(super) fn translate(core: &Core) -> Result<Translated, Wrong> {
    let mut writer = Writer {
        text: String::new(),
        line: 1,
        lines: BTreeMap::new(),
        names: 0,
    };
    let function = identifier(&core.name);
    let mut scope = Scope::new();
    let mut params = Vec::new();
    for name in &core.args {
        let param = writer.name();
        params.push(format!("float {param}"));
        scope.insert(name.clone(), param);
    }
    let params = match params.is_empty() {
        true => "void".to_owned(),
        false => params.join(", "),
    };
    let nowhere = core.body.at;
    writer.plain("#include <math.h>");
    writer.plain(&format!("float {function}({params})"));
    writer.plain("{");
    let result = writer.number(&core.body, &scope)?;
    writer.at(nowhere, &format!("return {result};"));
    writer.plain("}");
    Ok(Translated {
        text: writer.text,
        function,
        lines: writer.lines,
    })
}

/// The names of C that variables have.
type Scope = BTreeMap<String, String>;

struct Writer {
    text: String,
    line: u32,
    lines: BTreeMap<u32, At>,
    names: u32,
}

impl Writer {
    fn plain(&mut self, line: &str) {
        let _ = writeln!(self.text, "{line}");
        self.line += 1;
    }

    fn at(&mut self, at: At, line: &str) {
        self.lines.insert(self.line, at);
        self.plain(line);
    }

    fn name(&mut self) -> String {
        self.names += 1;
        format!("v{}", self.names)
    }

    /// A statement that gives a new variable a value; its name.
    fn set(&mut self, at: At, ty: &str, value: &str) -> String {
        let name = self.name();
        self.at(at, &format!("{ty} {name} = {value};"));
        name
    }

    fn number(&mut self, node: &Node, scope: &Scope) -> Result<String, Wrong> {
        let at = node.at;
        let wrong = |why: String| Wrong { at, why };
        match &node.expr {
            Expr::Number { .. } | Expr::Rational(..) | Expr::Constant(_) => {
                let value: Result<Wide, _> =
                    compute(node, &Values::new(), &mut Decisions::default(), &());
                let value = value.map_err(|undefined| wrong(undefined.0))?.to_float();
                match value.is_finite() {
                    // A negative literal is a term of its own.
                    true => Ok(format!("({value:e}f)")),
                    false => Err(wrong("is too large for binary32".to_owned())),
                }
            }
            Expr::Variable(name) => (scope.get(name).cloned())
                .ok_or_else(|| wrong(format!("nothing is called `{name}`"))),
            Expr::Operation(op, args) => {
                let args = args.iter().map(|a| self.number(a, scope));
                let args = args.collect::<Result<Vec<_>, _>>()?;
                let value = written(*op, &args)
                    .ok_or_else(|| wrong(format!("the library has no function for {op:?}")))?;
                Ok(self.set(at, "float", &value))
            }
            Expr::If(parts) => {
                let [condition, then, other] = &**parts;
                let condition = self.truth(condition, scope)?;
                let name = self.name();
                self.plain(&format!("float {name};"));
                self.at(at, &format!("if ({condition}) {{"));
                let value = self.number(then, scope)?;
                self.plain(&format!("{name} = {value}; }} else {{"));
                let value = self.number(other, scope)?;
                self.plain(&format!("{name} = {value}; }}"));
                Ok(name)
            }
            Expr::Let {
                sequential,
                bindings,
                body,
            } => {
                let mut inner = scope.clone();
                for binding in bindings {
                    let from = if *sequential {
                        inner.clone()
                    } else {
                        scope.clone()
                    };
                    let value = self.number(&binding.init, &from)?;
                    inner.insert(binding.name.clone(), value);
                }
                self.number(body, &inner)
            }
            Expr::While {
                sequential,
                condition,
                bindings,
                body,
            } => {
                let inner = self.variables(*sequential, bindings, scope)?;
                self.plain("for (;;) {");
                let holds = self.truth(condition, &inner)?;
                self.at(condition.at, &format!("if (!{holds}) break;"));
                let mut next = inner.clone();
                let mut sets = Vec::new();
                for binding in bindings {
                    let Some(update) = &binding.update else {
                        continue;
                    };
                    let from = if *sequential {
                        next.clone()
                    } else {
                        inner.clone()
                    };
                    let value = self.number(update, &from)?;
                    let copy = self.set(update.at, "float", &value);
                    sets.push(format!("{} = {copy};", inner[&binding.name]));
                    next.insert(binding.name.clone(), copy);
                }
                self.plain(&sets.join(" "));
                self.plain("}");
                self.number(body, &inner)
            }
            _ => Err(wrong(
                "a truth value stands where a number is expected".to_owned(),
            )),
        }
    }

    /// Variables of a loop, each with its first value.
    fn variables(
        &mut self,
        sequential: bool,
        bindings: &[Binding],
        scope: &Scope,
    ) -> Result<Scope, Wrong> {
        let mut inner = scope.clone();
        for binding in bindings {
            let from = if sequential {
                inner.clone()
            } else {
                scope.clone()
            };
            let value = self.number(&binding.init, &from)?;
            let name = self.set(binding.init.at, "float", &value);
            inner.insert(binding.name.clone(), name);
        }
        Ok(inner)
    }

    fn truth(&mut self, node: &Node, scope: &Scope) -> Result<String, Wrong> {
        let at = node.at;
        match &node.expr {
            Expr::Truth(truth) => Ok(i32::from(*truth).to_string()),
            Expr::And(nodes) | Expr::Or(nodes) => {
                let is_and = matches!(node.expr, Expr::And(_));
                let parts = nodes.iter().map(|n| self.truth(n, scope));
                let parts = parts.collect::<Result<Vec<_>, _>>()?;
                let value = match (parts.is_empty(), is_and) {
                    (true, _) => i32::from(is_and).to_string(),
                    (_, true) => parts.join(" & "),
                    (_, false) => parts.join(" | "),
                };
                Ok(self.set(at, "int", &value))
            }
            Expr::Not(of) => {
                let of = self.truth(of, scope)?;
                Ok(self.set(at, "int", &format!("!{of}")))
            }
            Expr::Compare(comparison, nodes) => {
                let numbers = nodes.iter().map(|n| self.number(n, scope));
                let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
                let pair = |a: &String, b: &String| format!("({a} {comparison} {b})");
                let mut pairs = Vec::new();
                for (i, a) in numbers.iter().enumerate() {
                    let others = match *comparison {
                        "!=" => &numbers[i + 1..],
                        _ => numbers.get(i + 1..i + 2).unwrap_or(&[]),
                    };
                    pairs.extend(others.iter().map(|b| pair(a, b)));
                }
                match pairs.is_empty() {
                    true => Ok("1".to_owned()),
                    false => Ok(self.set(at, "int", &pairs.join(" & "))),
                }
            }
            Expr::If(parts) => {
                let [condition, then, other] = &**parts;
                let condition = self.truth(condition, scope)?;
                let (then, other) = (self.truth(then, scope)?, self.truth(other, scope)?);
                Ok(self.set(at, "int", &format!("{condition} ? {then} : {other}")))
            }
            _ => Err(Wrong {
                at,
                why: "a number stands where a condition is expected".to_owned(),
            }),
        }
    }
}

/// An operation in C, where there is one.
fn written(op: Operation, args: &[String]) -> Option<String> {
    let infix = |sign: &str| Some(format!("{} {sign} {}", args[0], args[1]));
    match op {
        Operation::Add => infix("+"),
        Operation::Sub => infix("-"),
        Operation::Mul => infix("*"),
        Operation::Div => infix("/"),
        Operation::Neg => Some(format!("-{}", args[0])),
        // The library has no inverse hyperbolic functions.
        Operation::Asinh => {
            let x = &args[0];
            Some(format!(
                "copysignf(logf(fabsf({x}) + sqrtf({x} * {x} + 1.0f)), {x})"
            ))
        }
        Operation::Acosh => {
            let x = &args[0];
            Some(format!("logf({x} + sqrtf({x} * {x} - 1.0f))"))
        }
        Operation::Atanh => {
            let x = &args[0];
            Some(format!("0.5f * logf((1.0f + {x}) / (1.0f - {x}))"))
        }
        _ => {
            let (_, _, _, function) = Operation::NAMED.iter().find(|(known, ..)| *known == op)?;
            Some(format!("{function}({})", args.join(", ")))
        }
    }
}
