//! JSON (RFC 8259) as values that know where they stand.

use srp_archdesc::diagnostic::Span;

/// How deep lists and objects may stand in each other.
const MAX_DEPTH: u32 = 64;
/// Most members of one object.
const MAX_MEMBERS: usize = 64;

/// A value and its place.
#[derive(Debug)]
pub(super) struct Json<'t> {
    pub(super) value: Value<'t>,
    pub(super) span: Span,
}

#[derive(Debug)]
pub(super) enum Value<'t> {
    /// `true`, `false` or `null`.
    Word,
    /// A number as it is written.
    Number(&'t str),
    Text(String),
    Array(Vec<Json<'t>>),
    Object(Vec<Member<'t>>),
}

/// The name of a member, where it stands, and the value.
pub(super) type Member<'t> = (String, Span, Json<'t>);

type Read<T> = Result<T, (Span, String)>;

/// The value that a text is.
pub(super) fn parse(text: &str) -> Read<Json<'_>> {
    let mut parser = Parser { text, at: 0 };
    let json = parser.value(0)?;
    parser.skip();
    match parser.peek() {
        None => Ok(json),
        Some(_) => parser.fault("text after the end of the graph"),
    }
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn skip(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r' | b'\n')) {
            self.at += 1;
        }
    }

    fn span(&self, start: usize) -> Span {
        Span::new(start as u32, self.at as u32)
    }

    /// A mistake at the next character.
    fn fault<T>(&self, message: impl Into<String>) -> Read<T> {
        let length = self.text[self.at..]
            .chars()
            .next()
            .map_or(0, char::len_utf8);
        let span = Span::new(self.at as u32, (self.at + length) as u32);
        let message = match self.text[self.at..].chars().next() {
            Some(c) if c.is_control() => format!("{}, not {c:?}", message.into()),
            Some(c) => format!("{}, not `{c}`", message.into()),
            None => format!("{}, not the end of the file", message.into()),
        };
        Err((span, message))
    }

    /// Takes `byte`, if it comes next.
    fn takes(&mut self, byte: u8) -> bool {
        self.skip();
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    fn value(&mut self, depth: u32) -> Read<Json<'t>> {
        self.skip();
        let start = self.at;
        if depth > MAX_DEPTH {
            return self.fault(format!("at most {MAX_DEPTH} levels are expected"));
        }
        let value = match self.peek() {
            Some(b'{') => self.object(depth)?,
            Some(b'[') => self.array(depth)?,
            Some(b'"') => Value::Text(self.string()?),
            Some(b'-' | b'0'..=b'9') => self.number()?,
            _ => self.word()?,
        };
        Ok(Json {
            value,
            span: self.span(start),
        })
    }

    fn word(&mut self) -> Read<Value<'t>> {
        for word in ["true", "false", "null"] {
            if self.text[self.at..].starts_with(word) {
                self.at += word.len();
                return Ok(Value::Word);
            }
        }
        self.fault("a value is expected")
    }

    fn number(&mut self) -> Read<Value<'t>> {
        let start = self.at;
        while matches!(
            self.peek(),
            Some(b'0'..=b'9' | b'-' | b'+' | b'.' | b'e' | b'E')
        ) {
            self.at += 1;
        }
        let text = &self.text[start..self.at];
        match text.parse::<f64>() {
            Ok(_) => Ok(Value::Number(text)),
            Err(_) => Err((self.span(start), format!("`{text}` is not a number"))),
        }
    }

    fn array(&mut self, depth: u32) -> Read<Value<'t>> {
        self.at += 1;
        let mut items = Vec::new();
        if self.takes(b']') {
            return Ok(Value::Array(items));
        }
        loop {
            items.push(self.value(depth + 1)?);
            if self.takes(b']') {
                return Ok(Value::Array(items));
            }
            if !self.takes(b',') {
                return self.fault("`,` or `]` is expected");
            }
        }
    }

    fn object(&mut self, depth: u32) -> Read<Value<'t>> {
        self.at += 1;
        let mut members: Vec<Member<'t>> = Vec::new();
        if self.takes(b'}') {
            return Ok(Value::Object(members));
        }
        loop {
            self.skip();
            let start = self.at;
            if self.peek() != Some(b'"') {
                return self.fault("a member's name in quotes is expected");
            }
            let name = self.string()?;
            let span = self.span(start);
            if members.len() == MAX_MEMBERS {
                return Err((span, format!("more than {MAX_MEMBERS} members")));
            }
            if !self.takes(b':') {
                return self.fault("`:` is expected");
            }
            members.push((name, span, self.value(depth + 1)?));
            if self.takes(b'}') {
                return Ok(Value::Object(members));
            }
            if !self.takes(b',') {
                return self.fault("`,` or `}` is expected");
            }
        }
    }

    fn string(&mut self) -> Read<String> {
        let start = self.at;
        self.at += 1;
        let mut text = String::new();
        loop {
            let rest = &self.text[self.at..];
            let Some(c) = rest.chars().next() else {
                return Err((self.span(start), "text without its closing `\"`".to_owned()));
            };
            match c {
                '"' => {
                    self.at += 1;
                    return Ok(text);
                }
                '\\' => text.push(self.escape()?),
                c if u32::from(c) < 32 => {
                    return self.fault("characters of text are expected");
                }
                c => {
                    self.at += c.len_utf8();
                    text.push(c);
                }
            }
        }
    }

    fn escape(&mut self) -> Read<char> {
        let start = self.at;
        self.at += 1;
        let c = match self.peek() {
            Some(c @ (b'"' | b'\\' | b'/')) => char::from(c),
            Some(b'b') => '\u{8}',
            Some(b'f') => '\u{c}',
            Some(b'n') => '\n',
            Some(b'r') => '\r',
            Some(b't') => '\t',
            Some(b'u') => return self.code_point(start),
            _ => return self.fault("an escape of JSON is expected"),
        };
        self.at += 1;
        Ok(c)
    }

    /// A character by its number, or two that are one beyond the first plane.
    fn code_point(&mut self, start: usize) -> Read<char> {
        let high = self.unit()?;
        let code = if (0xd800..0xdc00).contains(&high) && self.text[self.at..].starts_with("\\u") {
            self.at += 1;
            let low = self.unit()?;
            0x1_0000 + ((high - 0xd800) << 10) + (low.wrapping_sub(0xdc00) & 0x3ff)
        } else {
            high
        };
        let wrong = || (self.span(start), "this is no character".to_owned());
        char::from_u32(code).ok_or_else(wrong)
    }

    /// `u` and four hexadecimal digits.
    fn unit(&mut self) -> Read<u32> {
        self.at += 1;
        let digits = self.text.get(self.at..self.at + 4);
        let digits = digits.filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()));
        match digits.and_then(|d| u32::from_str_radix(d, 16).ok()) {
            Some(unit) => {
                self.at += 4;
                Ok(unit)
            }
            None => self.fault("four hexadecimal digits are expected"),
        }
    }
}
