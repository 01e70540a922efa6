//! Formats of `printf` and its like, held against the arguments that they take.

use super::Checker;
use crate::ast;
use crate::ctype::{Int, Type, TypeId};
use crate::library;
use crate::message::FORMAT;
use crate::typed::{Callee, ExprId};
use srp_archdesc::diagnostic::Span;

/// Functions with a format: its argument, and the first that it takes.
const FORMATTED: [(&str, usize, usize); 4] = [
    ("printf", 0, 1),
    ("fprintf", 1, 2),
    ("sprintf", 1, 2),
    ("snprintf", 2, 3),
];

/// An argument that a conversion takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Int,
    Long,
    LongLong,
    /// Of `z` and `t`: 32 bits, whatever they are called.
    Size,
    Double,
    Text,
    WideText,
    Pointer,
    /// Of `%n`: where the number of characters goes.
    Count,
}

impl Wanted {
    /// It in words.
    fn what(self) -> &'static str {
        match self {
            Wanted::Int => "an `int`",
            Wanted::Long => "a `long`",
            Wanted::LongLong => "a `long long`",
            Wanted::Size => "a number of 32 bits",
            Wanted::Double => "a `double`",
            Wanted::Text => "a `char *`",
            Wanted::WideText => "a `wchar_t *`",
            Wanted::Pointer => "a pointer",
            Wanted::Count => "an `int *`",
        }
    }
}

/// A conversion of a format.
#[derive(Debug, PartialEq, Eq)]
struct Conversion {
    /// Its spelling, from `%` to its letter.
    text: String,
    /// How many `%` stand before it.
    sign: usize,
    /// The arguments that it takes, in order; `None` where its letter means nothing.
    wanted: Option<Vec<Wanted>>,
}

/// The conversions of a format, `%%` among them.
fn conversions(format: &[u8]) -> Vec<Conversion> {
    let mut all = Vec::new();
    let (mut rest, mut sign) = (format, 0);
    while let Some(start) = rest.iter().position(|&b| b == b'%') {
        rest = &rest[start..];
        let (length, wanted) = conversion(&rest[1..]);
        let (text, after) = rest.split_at(1 + length);
        let signs = text.iter().filter(|&&b| b == b'%').count();
        let text = String::from_utf8_lossy(text).into_owned();
        all.push(Conversion { text, sign, wanted });
        (rest, sign) = (after, sign + signs);
    }
    all
}

/// The bytes of a conversion after its `%`, and what it takes.
fn conversion(text: &[u8]) -> (usize, Option<Vec<Wanted>>) {
    let mut wanted = Vec::new();
    let mut at = 0;
    let skip = |at: &mut usize, set: &[u8]| {
        let count = text[*at..].iter().take_while(|b| set.contains(b)).count();
        *at += count;
        count
    };
    skip(&mut at, b"-+ #0");
    for part in 0..2 {
        if part == 1 && skip(&mut at, b".") == 0 {
            break;
        }
        match text.get(at) {
            Some(b'*') => {
                at += 1;
                wanted.push(Wanted::Int);
            }
            _ => drop(skip(&mut at, b"0123456789")),
        }
    }
    let sizes = at;
    skip(&mut at, b"hljqztL");
    let integer = match &text[sizes..at] {
        b"" | b"h" | b"hh" => Some(Wanted::Int),
        b"l" => Some(Wanted::Long),
        b"ll" | b"j" | b"q" => Some(Wanted::LongLong),
        b"z" | b"t" => Some(Wanted::Size),
        _ => None,
    };
    let is_wide = &text[sizes..at] == b"l";
    let is_plain = sizes == at;
    let Some(letter) = text.get(at) else {
        return (at, None);
    };
    let taken = match letter {
        b'd' | b'i' | b'u' | b'o' | b'x' | b'X' => integer,
        b'c' if is_plain || is_wide => Some(Wanted::Int),
        b's' if is_wide => Some(Wanted::WideText),
        b's' if is_plain => Some(Wanted::Text),
        b'p' if is_plain => Some(Wanted::Pointer),
        b'n' if is_plain => Some(Wanted::Count),
        b'e' | b'E' | b'f' | b'F' | b'g' | b'G' | b'a' | b'A' => {
            (is_plain || is_wide || &text[sizes..at] == b"L").then_some(Wanted::Double)
        }
        b'%' => return (at + 1, Some(wanted)),
        _ => None,
    };
    wanted.extend(taken);
    let length = match letter.is_ascii_graphic() {
        true => at + 1,
        false => at,
    };
    (length, taken.map(|_| wanted))
}

impl Checker<'_> {
    /// Warns of arguments that a format does not take, and of those that it lacks.
    pub(super) fn check_format(
        &mut self,
        callee: &Callee,
        args: &[ast::ExprId],
        values: &[ExprId],
    ) {
        let Callee::Function(function) = callee else {
            return;
        };
        let name = library::plain(&self.functions[*function].name);
        let known = FORMATTED.iter().find(|(known, ..)| *known == name);
        let Some(&(_, format, first)) = known else {
            return;
        };
        let Some(expr) = args.get(format).map(|&e| &self.unit.exprs[e]) else {
            return;
        };
        let ast::ExprKind::Str(bytes) = &expr.kind else {
            return;
        };
        let (bytes, literal) = (bytes.clone(), expr.span);
        let conversions = conversions(&bytes);
        let mut next = first;
        for conversion in &conversions {
            let place = self.place_of(conversion, &bytes, literal);
            let text = &conversion.text;
            let Some(wanted) = &conversion.wanted else {
                let what = format!("`{text}` is no conversion of a format");
                // What it takes is not known, so the others cannot be told.
                return self.warning(FORMAT, place, what);
            };
            for &wanted in wanted {
                let Some(&value) = values.get(next) else {
                    let what = format!(
                        "`{text}` takes {}, and there is no argument for it",
                        wanted.what()
                    );
                    return self.warning(FORMAT, place, what);
                };
                next += 1;
                if !self.fits(wanted, self.ty(value)) {
                    self.wrong_argument(text, wanted, value, place);
                }
            }
        }
        if let Some(&value) = values.get(next) {
            let at = self.span(value);
            self.warning(FORMAT, at, "the format has no conversion for this argument");
        }
    }

    fn wrong_argument(&mut self, text: &str, wanted: Wanted, value: ExprId, place: Span) {
        if self.is_library(place) {
            return;
        }
        let is = self.show(self.ty(value));
        let what = format!("`{text}` takes {}, and the argument is {is}", wanted.what());
        let label = format!("this is {is}");
        let message = self.sources.warning(FORMAT, place, what, "");
        let message = self.sources.also(message, self.span(value), &label);
        self.messages.push(message);
    }

    /// True if an argument of this type is what a conversion takes. Signs are not told apart.
    fn fits(&self, wanted: Wanted, ty: TypeId) -> bool {
        let is_long = |int: &Int| matches!(int, Int::Long | Int::ULong);
        let target = || self.types.pointee(ty).map(|to| self.types.get(to.ty));
        match (wanted, self.types.get(ty)) {
            (_, Type::Error) => true,
            (Wanted::Int, Type::Bool) => true,
            (Wanted::Int, Type::Int(int)) => int.size() <= 4 && !is_long(int),
            (Wanted::Long, Type::Int(int)) => is_long(int),
            (Wanted::LongLong, Type::Int(int)) => int.size() == 8,
            (Wanted::Size, Type::Int(int)) => int.size() == 4,
            (Wanted::Double, Type::Float | Type::Double) => true,
            (Wanted::Pointer, Type::Pointer(_)) => true,
            (Wanted::Text, Type::Pointer(_)) => match target() {
                Some(Type::Int(int)) => int.size() == 1,
                other => matches!(other, Some(Type::Void)),
            },
            (Wanted::WideText | Wanted::Count, Type::Pointer(_)) => match target() {
                Some(Type::Int(int)) => int.size() == 4,
                other => matches!(other, Some(Type::Void)),
            },
            _ => false,
        }
    }

    /// Where a conversion stands in its literal; the whole literal where its spelling hides that.
    fn place_of(&self, conversion: &Conversion, format: &[u8], literal: Span) -> Span {
        let spelled = self.sources.spelled(literal);
        let signs = |text: &[u8]| text.iter().filter(|&&b| b == b'%').count();
        if signs(spelled.as_bytes()) != signs(format) {
            return literal;
        }
        let mut places = spelled.match_indices('%').map(|(at, _)| at);
        match places.nth(conversion.sign) {
            Some(at) if spelled[at..].starts_with(&conversion.text) => {
                let start = literal.start + at as u32;
                Span::new(start, start + conversion.text.len() as u32)
            }
            _ => literal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_are_taken_apart() {
        use Wanted::*;
        let taken = |format: &str| -> Vec<Option<Vec<Wanted>>> {
            let all = conversions(format.as_bytes());
            all.into_iter().map(|c| c.wanted).collect()
        };
        assert_eq!(
            taken("a %d, %-08.3lf%% %*.*s %llx"),
            [
                Some(vec![Int]),
                Some(vec![Double]),
                Some(vec![]),
                Some(vec![Int, Int, Text]),
                Some(vec![LongLong])
            ]
        );
        assert_eq!(
            taken("%zu %p %ls %n %hhd %Lg"),
            [Size, Pointer, WideText, Count, Int, Double].map(|w| Some(vec![w]))
        );
        for wrong in [
            "%", "%5", "%y", "%lld%", "%hs", "%zf", "% ", "%\u{e9}", "%\n",
        ] {
            assert_eq!(taken(wrong).last(), Some(&None), "{wrong}");
        }
        let spelled: Vec<(usize, String)> = (conversions(b"%% %d%5.2f").into_iter())
            .map(|c| (c.sign, c.text))
            .collect();
        let expected = [(0, "%%"), (2, "%d"), (3, "%5.2f")].map(|(n, t)| (n, t.to_owned()));
        assert_eq!(spelled, expected);
    }
}
