//! Expressions that conditions and `evaluate` have: an operand, or two that are compared.

use std::fmt;

/// An operand.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Operand {
    /// A number that is written as an integer or by an address.
    Integer(u32),
    /// A number that is written with a point or an exponent.
    Real(f32),
    /// A variable, a global object, a register, or one of the names that stand for the place.
    Name(String),
    /// An element of an array, of a vector, or behind a pointer; a register of a file.
    Element(Box<Operand>, Box<Operand>),
    /// A member of a struct or union.
    Member(Box<Operand>, String),
    /// The target of a pointer; the word at an address.
    At(Box<Operand>),
    /// The address of something.
    Of(Box<Operand>),
}

impl Operand {
    /// A member of a name as one name with a dot, which objects of functions and registers have.
    pub(crate) fn dotted(&self) -> Option<String> {
        match self {
            Operand::Name(name) => Some(name.clone()),
            Operand::Member(inner, member) => Some(format!("{}.{member}", inner.dotted()?)),
            _ => None,
        }
    }
}

impl fmt::Display for Operand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Operand::Integer(bits) => write!(f, "{}", *bits as i32),
            Operand::Real(value) => write!(f, "{value:?}"),
            Operand::Name(name) => f.write_str(name),
            Operand::Element(of, index) => write!(f, "{of}[{index}]"),
            Operand::Member(of, name) => write!(f, "{of}.{name}"),
            Operand::At(pointer) => write!(f, "(*{pointer})"),
            Operand::Of(inner) => write!(f, "&{inner}"),
        }
    }
}

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Comparison {
    Equal,
    Unequal,
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    pub(crate) left: Operand,
    pub(crate) right: Option<(Comparison, Operand)>,
}

/// Why an expression is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoExpression(String);

impl fmt::Display for NoExpression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "`{}` is no expression: write a name with members and elements as C does (s.x, p->x, NAME[INDEX], *p, &x), \
             *ADDRESS or a number, or two of them with ==, !=, <, <=, > or >= between them",
            self.0
        )
    }
}

impl std::error::Error for NoExpression {}

const COMPARISONS: [(&str, Comparison); 6] = [
    ("==", Comparison::Equal),
    ("!=", Comparison::Unequal),
    ("<=", Comparison::AtMost),
    (">=", Comparison::AtLeast),
    ("<", Comparison::Less),
    (">", Comparison::Greater),
];

impl Expression {
    /// Reads an expression.
    ///
    /// # Errors
    ///
    /// It is none.
    pub fn parse(text: &str) -> Result<Expression, NoExpression> {
        let wrong = || NoExpression(text.to_owned());
        // The arrow of a member is no comparison.
        let without = text.replace("->", "--");
        let found = COMPARISONS.iter().find_map(|(sign, comparison)| {
            let at = without.find(sign)?;
            Some((&text[..at], *comparison, &text[at + sign.len()..]))
        });
        match found {
            None => Ok(Expression {
                left: operand(text).ok_or_else(wrong)?,
                right: None,
            }),
            Some((left, comparison, right)) => Ok(Expression {
                left: operand(left).ok_or_else(wrong)?,
                right: Some((comparison, operand(right).ok_or_else(wrong)?)),
            }),
        }
    }
}

/// Says of a name that it has a value at no place of the program.
pub(crate) fn never(name: &str) -> String {
    format!(
        "`{name}` has a value nowhere: no operation makes a variable of this name, and no object or register has it"
    )
}

/// A number of times; one where nothing is written.
///
/// # Errors
///
/// A sentence that says what is wrong.
pub(crate) fn count(text: &str) -> Result<u64, String> {
    match text.trim() {
        "" => Ok(1),
        text => (text.parse().ok().filter(|&n| n > 0))
            .ok_or_else(|| format!("`{text}` is no count: write a whole number from 1 on")),
    }
}

/// A number as C writes it.
fn number(text: &str) -> Option<Operand> {
    let whole = |text: &str| match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    };
    if let Some(n) = whole(text) {
        return Some(Operand::Integer(n as u32));
    }
    let digits = text.strip_suffix(['f', 'F']).unwrap_or(text);
    let is_number = digits.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let value = digits.parse().ok().filter(|_| is_number)?;
    Some(Operand::Real(value))
}

/// An address, as adapters and C write it.
pub(crate) fn address(text: &str) -> Option<u32> {
    match number(text)? {
        Operand::Integer(bits) => Some(bits),
        _ => None,
    }
}

/// How deep operands stand in each other.
const DEEPEST: u32 = 64;

fn operand(text: &str) -> Option<Operand> {
    operand_within(text, DEEPEST)
}

fn operand_within(text: &str, deep: u32) -> Option<Operand> {
    let text = text.trim();
    let deep = deep.checked_sub(1)?;
    let inner = |text| operand_within(text, deep).map(Box::new);
    if let Some(number) = number(text) {
        return Some(number);
    }
    if let Some(pointer) = text.strip_prefix('*') {
        return Some(Operand::At(inner(pointer)?));
    }
    if let Some(of) = text.strip_prefix('&') {
        return Some(Operand::Of(inner(of)?));
    }
    if text.ends_with(']') {
        let open = opening(text, '[', ']')?;
        let index = inner(&text[open + 1..text.len() - 1])?;
        return Some(Operand::Element(inner(&text[..open])?, index));
    }
    if text.ends_with(')') && opening(text, '(', ')') == Some(0) {
        return inner(&text[1..text.len() - 1]).map(|operand| *operand);
    }
    let start = text.rfind(|c: char| !(c.is_alphanumeric() || "_+".contains(c)));
    let Some(start) = start else {
        return is_name(text).then(|| Operand::Name(text.to_owned()));
    };
    let (before, member) = text.split_at(start + text[start..].chars().next()?.len_utf8());
    let is_member = is_name(member);
    if let Some(pointer) = before.strip_suffix("->").filter(|_| is_member) {
        let pointed = Box::new(Operand::At(inner(pointer)?));
        return Some(Operand::Member(pointed, member.to_owned()));
    }
    let of = before.strip_suffix('.').filter(|_| is_member)?;
    Some(Operand::Member(inner(of)?, member.to_owned()))
}

/// Where the last bracket of a text is opened.
fn opening(text: &str, open: char, close: char) -> Option<usize> {
    let mut deep = 0;
    for (at, c) in text.char_indices().rev() {
        if c == close {
            deep += 1;
        } else if c == open {
            deep -= 1;
            if deep == 0 {
                return Some(at);
            }
        }
    }
    None
}

fn is_name(text: &str) -> bool {
    let inner = |c: char| c.is_alphanumeric() || "_+".contains(c);
    let first = |c: char| c.is_alphabetic() || c == '_';
    text.starts_with(first) && text.chars().all(inner)
}

impl Comparison {
    pub(crate) fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Comparison::Equal => left == right,
            Comparison::Unequal => left != right,
            Comparison::Less => left < right,
            Comparison::AtMost => left <= right,
            Comparison::Greater => left > right,
            Comparison::AtLeast => left >= right,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_read_and_refused() {
        let parsed = Expression::parse("iteration == 17").expect("it is one");
        let name = Operand::Name("iteration".to_owned());
        let right = Some((Comparison::Equal, Operand::Integer(17)));
        assert_eq!(parsed, Expression { left: name, right });
        // A whole number with a point is a real one: the word beside it is a float.
        assert_eq!(number("36.0"), Some(Operand::Real(36.0)));
        assert_eq!(number("-1"), Some(Operand::Integer(u32::MAX)));
        for right in [
            "x",
            "b[3] <= -1.5f",
            "*0x80000010",
            "fu_0_0_r[2] != y",
            "p+4",
            "p->x.y[2] >= 3",
            "(*p).x",
            "&s.x == *q",
        ] {
            assert!(Expression::parse(right).is_ok(), "{right}");
        }
        for wrong in [
            "", "x ==", "f(x)", "a + b", "b[", "3x", "x.", ".x", "p->", "a[1", "&",
        ] {
            let error = Expression::parse(wrong).expect_err("it is none");
            assert!(error.to_string().contains("NAME[INDEX]"), "{wrong}");
        }
    }
}
