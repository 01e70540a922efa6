//! The words of the Graphviz language.

use srp_archdesc::diagnostic::Span;

/// A word and its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) kind: Kind,
    /// Where it stands, without its quotes.
    pub(super) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// A name, number or quoted text; whether quotes were round it.
    Id(String, bool),
    /// One of `{}[];,=:`.
    Mark(char),
    /// `->`
    Arrow,
    /// `--`
    Line,
    End,
}

/// The words of a text, [`Kind::End`] last.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, (Span, String)> {
    let mut lexer = Lexer { text, at: 0 };
    let mut tokens = Vec::new();
    loop {
        lexer.skip()?;
        let token = lexer.token()?;
        let end = token.kind == Kind::End;
        tokens.push(token);
        if end {
            return Ok(tokens);
        }
    }
}

struct Lexer<'t> {
    text: &'t str,
    at: usize,
}

fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

impl Lexer<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn span(&self, start: usize) -> Span {
        Span::new(start as u32, self.at as u32)
    }

    /// Skips blanks and comments. A line that begins with `#` is one.
    fn skip(&mut self) -> Result<(), (Span, String)> {
        loop {
            let rest = self.rest();
            let line_starts = self.at == 0 || self.text[..self.at].ends_with('\n');
            if rest.starts_with("/*") {
                let Some(end) = rest.find("*/") else {
                    let span = Span::new(self.at as u32, self.at as u32 + 2);
                    return Err((span, "a comment without its end `*/`".to_owned()));
                };
                self.at += end + 2;
            } else if rest.starts_with("//") || (line_starts && rest.starts_with('#')) {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else {
                match rest.chars().next() {
                    Some(c) if c.is_whitespace() || c == '\u{feff}' => self.at += c.len_utf8(),
                    _ => return Ok(()),
                }
            }
        }
    }

    fn token(&mut self) -> Result<Token, (Span, String)> {
        let start = self.at;
        let Some(c) = self.rest().chars().next() else {
            return Ok(Token {
                kind: Kind::End,
                span: self.span(start),
            });
        };
        let kind = match c {
            '"' => return self.quoted(),
            '<' => return self.markup(),
            '{' | '}' | '[' | ']' | ';' | ',' | '=' | ':' => {
                self.at += 1;
                Kind::Mark(c)
            }
            '-' if self.rest().starts_with("->") => {
                self.at += 2;
                Kind::Arrow
            }
            '-' if self.rest().starts_with("--") => {
                self.at += 2;
                Kind::Line
            }
            '-' | '.' => {
                let number = |c: char| c.is_ascii_digit() || matches!(c, '-' | '.');
                self.word(number)
            }
            c if c.is_ascii_digit() => self.word(|c| is_letter(c) || c == '.'),
            c if is_letter(c) => self.word(is_letter),
            c => {
                self.at += c.len_utf8();
                let message = format!("`{}` is not expected here", c.escape_debug());
                return Err((self.span(start), message));
            }
        };
        Ok(Token {
            kind,
            span: self.span(start),
        })
    }

    fn word(&mut self, belongs: impl Fn(char) -> bool) -> Kind {
        let start = self.at;
        let rest = self.rest();
        let length = rest.find(|c| !belongs(c)).unwrap_or(rest.len());
        self.at += length;
        Kind::Id(self.text[start..self.at].to_owned(), false)
    }

    /// Text in quotes, in which a backslash stays what it is: only `\"` and a backslash at a line's end mean something else.
    fn quoted(&mut self) -> Result<Token, (Span, String)> {
        let start = self.at + 1;
        let mut text = String::new();
        let mut chars = self.text[start..].char_indices().peekable();
        while let Some((i, c)) = chars.next() {
            match c {
                '"' => {
                    self.at = start + i;
                    let span = self.span(start);
                    self.at += 1;
                    let kind = Kind::Id(text, true);
                    return Ok(Token { kind, span });
                }
                '\\' => match chars.peek().map(|(_, c)| *c) {
                    Some('"') => {
                        text.push('"');
                        chars.next();
                    }
                    Some('\\') => {
                        text.push_str("\\\\");
                        chars.next();
                    }
                    Some('\n') => drop(chars.next()),
                    _ => text.push('\\'),
                },
                c => text.push(c),
            }
        }
        let span = Span::new(start as u32 - 1, start as u32);
        Err((span, "text without its closing `\"`".to_owned()))
    }

    /// Markup between `<` and `>`, which may be nested.
    fn markup(&mut self) -> Result<Token, (Span, String)> {
        let start = self.at + 1;
        let mut open = 0u32;
        for (i, c) in self.text[self.at..].char_indices() {
            match c {
                '<' => open += 1,
                '>' => open -= 1,
                _ => {}
            }
            if open == 0 {
                self.at += i;
                let span = self.span(start);
                let text = self.text[start..self.at].to_owned();
                self.at += 1;
                let kind = Kind::Id(text, true);
                return Ok(Token { kind, span });
            }
        }
        let span = Span::new(start as u32 - 1, start as u32);
        Err((span, "`<` without its `>`".to_owned()))
    }
}
