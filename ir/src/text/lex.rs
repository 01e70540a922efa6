//! Lines of a listing to tokens.

use super::TextError;

/// A token of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Token<'a> {
    /// Letters, digits, `_` and `.`: names, numbers, keywords.
    Atom(&'a str),
    /// A name in quotes.
    Quoted(String),
    /// `->`.
    Arrow,
    /// Any other sign.
    Sign(char),
}

impl std::fmt::Display for Token<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Token::Atom(text) => f.write_str(text),
            Token::Quoted(text) => write!(f, "{text:?}"),
            Token::Arrow => f.write_str("->"),
            Token::Sign(c) => write!(f, "{c}"),
        }
    }
}

/// A position after `;`, not yet looked up.
#[derive(Clone, Debug)]
pub(super) struct RawPos {
    pub(super) file: String,
    pub(super) line: u32,
    pub(super) column: u32,
    /// Column of the listing where it stands.
    pub(super) at: u32,
}

/// A line that has tokens, and how far they are read.
#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    /// Line number from 1.
    pub(super) number: u32,
    /// The position after `;`.
    pub(super) pos: Option<RawPos>,
    tokens: Vec<(Token<'a>, u32)>,
    next: usize,
    end: u32,
}

/// The lines of a listing that have tokens.
pub(super) fn lines(text: &str) -> Result<Vec<Line<'_>>, TextError> {
    let mut lines = Vec::new();
    for (number, text) in (1..).zip(text.lines()) {
        let line = Scanner::new(text, number).line()?;
        if !line.tokens.is_empty() {
            lines.push(line);
        } else if let Some(pos) = line.pos {
            return Err(TextError::new(number, pos.at, "a position without a line"));
        }
    }
    Ok(lines)
}

struct Scanner<'a> {
    rest: &'a str,
    number: u32,
    column: u32,
}

impl<'a> Scanner<'a> {
    fn new(text: &'a str, number: u32) -> Self {
        Scanner {
            rest: text,
            number,
            column: 1,
        }
    }

    /// Takes the next `bytes` bytes.
    fn take(&mut self, bytes: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(bytes);
        self.rest = rest;
        self.column += taken.chars().count() as u32;
        taken
    }

    fn error(&self, message: &str) -> TextError {
        TextError::new(self.number, self.column, message)
    }

    fn line(mut self) -> Result<Line<'a>, TextError> {
        let mut tokens = Vec::new();
        let mut pos = None;
        loop {
            let space = self.rest.len() - self.rest.trim_start().len();
            self.take(space);
            let Some(first) = self.rest.chars().next() else {
                break;
            };
            if self.rest.starts_with("//") {
                break;
            }
            let column = self.column;
            let token = if is_atom(first) {
                let end = self.rest.find(|c| !is_atom(c)).unwrap_or(self.rest.len());
                Token::Atom(self.take(end))
            } else if first == '"' {
                Token::Quoted(self.quoted()?)
            } else if self.rest.starts_with("->") {
                self.take(2);
                Token::Arrow
            } else if first == ';' {
                self.take(1);
                pos = Some(self.position()?);
                break;
            } else {
                self.take(first.len_utf8());
                Token::Sign(first)
            };
            tokens.push((token, column));
        }
        Ok(Line {
            number: self.number,
            pos,
            tokens,
            next: 0,
            end: self.column,
        })
    }

    fn quoted(&mut self) -> Result<String, TextError> {
        let start = self.column;
        self.take(1);
        let mut name = String::new();
        loop {
            let Some(c) = self.rest.chars().next() else {
                return Err(TextError::new(self.number, start, "a quote is not closed"));
            };
            self.take(c.len_utf8());
            match c {
                '"' => return Ok(name),
                '\\' => name.push(self.escape()?),
                c => name.push(c),
            }
        }
    }

    fn escape(&mut self) -> Result<char, TextError> {
        let bad = self.error(r#"after \ comes ", \ or u{hexadecimal}"#);
        if let Some(c @ ('"' | '\\')) = self.rest.chars().next() {
            self.take(1);
            return Ok(c);
        }
        let Some((digits, _)) = self
            .rest
            .strip_prefix("u{")
            .and_then(|rest| rest.split_once('}'))
        else {
            return Err(bad);
        };
        let code = u32::from_str_radix(digits, 16)
            .ok()
            .and_then(char::from_u32);
        let c = code.ok_or(bad)?;
        self.take("u{}".len() + digits.len());
        Ok(c)
    }

    /// `file:line:column` up to the end of the line.
    fn position(&mut self) -> Result<RawPos, TextError> {
        self.take(self.rest.len() - self.rest.trim_start().len());
        let bad = self.error("a position is file:line:column");
        let at = self.column;
        let (file, rest) = if self.rest.starts_with('"') {
            let file = self.quoted()?;
            (file, self.rest.strip_prefix(':').ok_or(bad.clone())?)
        } else {
            let (file, rest) = self.rest.split_once(':').ok_or(bad.clone())?;
            (file.to_owned(), rest)
        };
        let (line, column) = rest.trim_end().split_once(':').ok_or(bad.clone())?;
        let number = |text: &str| text.parse::<u32>().ok().filter(|&n| n > 0);
        Ok(RawPos {
            file,
            line: number(line).ok_or(bad.clone())?,
            column: number(column).ok_or(bad)?,
            at,
        })
    }
}

fn is_atom(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '.'
}

impl<'a> Line<'a> {
    /// The next token, without taking it.
    pub(super) fn peek(&self) -> Option<&Token<'a>> {
        self.tokens.get(self.next).map(|(token, _)| token)
    }

    /// Column of the next token, or of the end of the line.
    pub(super) fn column(&self) -> u32 {
        self.tokens.get(self.next).map_or(self.end, |&(_, c)| c)
    }

    /// An error at the next token.
    pub(super) fn error(&self, message: impl Into<String>) -> TextError {
        TextError::new(self.number, self.column(), message)
    }

    /// An error that names the token expected in place of the next one.
    pub(super) fn wanted(&self, what: &str) -> TextError {
        match self.peek() {
            Some(token) => self.error(format!("{what} expected, found {token}")),
            None => self.error(format!("{what} expected at the end of the line")),
        }
    }

    /// Takes the next token if it is this sign.
    pub(super) fn eat(&mut self, sign: char) -> bool {
        let found = self.peek() == Some(&Token::Sign(sign));
        self.next += usize::from(found);
        found
    }

    /// Takes the next token if it is this keyword.
    pub(super) fn eat_word(&mut self, word: &str) -> bool {
        let found = self.peek() == Some(&Token::Atom(word));
        self.next += usize::from(found);
        found
    }

    /// Takes `->` if it comes next.
    pub(super) fn eat_arrow(&mut self) -> bool {
        let found = self.peek() == Some(&Token::Arrow);
        self.next += usize::from(found);
        found
    }

    /// Takes this sign.
    pub(super) fn expect(&mut self, sign: char) -> Result<(), TextError> {
        match self.eat(sign) {
            true => Ok(()),
            false => Err(self.wanted(&sign.to_string())),
        }
    }

    /// Takes this keyword.
    pub(super) fn expect_word(&mut self, word: &str) -> Result<(), TextError> {
        match self.eat_word(word) {
            true => Ok(()),
            false => Err(self.wanted(word)),
        }
    }

    /// Takes an atom.
    pub(super) fn atom(&mut self, what: &str) -> Result<&'a str, TextError> {
        match self.peek() {
            Some(&Token::Atom(text)) => {
                self.next += 1;
                Ok(text)
            }
            _ => Err(self.wanted(what)),
        }
    }

    /// Takes a name, bare or in quotes.
    pub(super) fn name(&mut self) -> Result<String, TextError> {
        if let Some(Token::Quoted(name)) = self.peek() {
            let name = name.clone();
            self.next += 1;
            return Ok(name);
        }
        Ok(self.atom("a name")?.to_owned())
    }

    /// The number of the next token if it is `prefix` and a number.
    pub(super) fn peek_entity(&self, prefix: &str) -> Option<u32> {
        match self.peek()? {
            Token::Atom(text) => {
                let digits = text.strip_prefix(prefix)?;
                let plain = digits.bytes().all(|b| b.is_ascii_digit());
                plain.then(|| digits.parse().ok()).flatten()
            }
            _ => None,
        }
    }

    /// Takes `prefix` and a number.
    pub(super) fn entity(&mut self, prefix: &str) -> Result<u32, TextError> {
        let number = self
            .peek_entity(prefix)
            .ok_or_else(|| self.wanted(&format!("{prefix} and a number")))?;
        self.next += 1;
        Ok(number)
    }

    /// Takes an unsigned number, decimal or `0x`.
    pub(super) fn number(&mut self) -> Result<u32, TextError> {
        let parsed = match self.peek() {
            Some(Token::Atom(text)) => match text.strip_prefix("0x") {
                Some(digits) => u32::from_str_radix(digits, 16).ok(),
                None => text.parse().ok(),
            },
            _ => None,
        };
        let number = parsed.ok_or_else(|| self.wanted("a number below 2^32"))?;
        self.next += 1;
        Ok(number)
    }

    /// Takes `+n` or `-n`, or nothing for 0.
    pub(super) fn offset(&mut self) -> Result<i32, TextError> {
        let negative = self.peek() == Some(&Token::Sign('-'));
        if !negative && self.peek() != Some(&Token::Sign('+')) {
            return Ok(0);
        }
        let sign = self.clone();
        self.next += 1;
        let magnitude = i64::from(self.number()?);
        let value = if negative { -magnitude } else { magnitude };
        i32::try_from(value).map_err(|_| sign.error("the offset does not fit 32 bits"))
    }

    /// Makes sure that everything is taken.
    pub(super) fn done(&self) -> Result<(), TextError> {
        match self.peek() {
            None => Ok(()),
            Some(_) => Err(self.wanted("the end of the line")),
        }
    }
}
