//! A listing to its program.

use super::body::Body;
use super::lex::{Line, lines};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::diagnostic::{Diagnostic, Span, offset};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use std::fmt;

/// Where a listing cannot be read, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextError {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// The message.
    pub message: String,
}

impl TextError {
    /// As a message about a listing with this name, which can be rendered with a caret.
    pub fn diagnostic(&self, file: &str, text: &str) -> Diagnostic {
        let at = offset(text, self.line, self.column);
        Diagnostic::error("D0003", file, self.message.as_str()).at(Span::point(at), "")
    }

    pub(super) fn new(line: u32, column: u32, message: impl Into<String>) -> TextError {
        TextError {
            line,
            column,
            message: message.into(),
        }
    }
}

impl fmt::Display for TextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}

impl std::error::Error for TextError {}

/// Reads a listing. Checks its form and that blocks, values and slots are defined; whether the
/// program is valid is [`verify`](crate::verify())'s business.
pub fn read(text: &str) -> Result<Program, TextError> {
    let mut reader = Reader::default();
    let lines = lines(text)?;
    let mut rest = lines.into_iter();
    while let Some(line) = rest.next() {
        reader.item(line, &mut rest)?;
    }
    Ok(reader.program)
}

type Lines<'a> = std::vec::IntoIter<Line<'a>>;

#[derive(Default)]
struct Reader {
    program: Program,
    files: FxHashMap<String, SourceFile>,
}

impl Reader {
    fn item<'a>(&mut self, mut line: Line<'a>, rest: &mut Lines<'a>) -> Result<(), TextError> {
        if line.peek_entity("file").is_some() {
            in_order(&mut line, "file", self.program.files.len())?;
            let name = line.name()?;
            line.done()?;
            let file = self.program.files.push(name.clone());
            self.files.insert(name, file);
        } else if line.eat_word("main") {
            self.program.main = Some(Func::new(line.entity("fn")? as usize));
            line.done()?;
        } else if line.peek_entity("g").is_some() {
            self.global(line, rest)?;
        } else if line.peek_entity("fn").is_some() {
            self.function(line, rest)?;
        } else {
            return Err(line.wanted("file, main, a global or a function"));
        }
        Ok(())
    }

    fn pos(&self, line: &Line<'_>) -> Result<Pos, TextError> {
        let Some(raw) = &line.pos else {
            return Ok(Pos::nowhere());
        };
        let file = self.files.get(&raw.file).copied().ok_or_else(|| {
            let message = format!("no file is called {}", raw.file);
            TextError::new(line.number, raw.at, message)
        })?;
        Ok(Pos {
            file,
            line: raw.line,
            column: raw.column,
        })
    }

    fn global<'a>(&mut self, mut line: Line<'a>, rest: &mut Lines<'a>) -> Result<(), TextError> {
        in_order(&mut line, "g", self.program.globals.len())?;
        let (name, size, align) = object(&mut line)?;
        let mut data = GlobalData {
            name,
            size,
            align,
            init: Vec::new(),
            relocs: Vec::new(),
            pos: self.pos(&line)?,
        };
        if line.eat('{') {
            line.done()?;
            loop {
                let mut part = next(rest, &line)?;
                if part.eat('}') {
                    part.done()?;
                    break;
                } else if part.eat_word("hex") {
                    while part.peek().is_some() {
                        hex(&mut part, &mut data.init)?;
                    }
                } else {
                    part.expect_word("reloc")?;
                    data.relocs.push(Reloc {
                        offset: part.number()?,
                        symbol: symbol(&mut part)?,
                        addend: part.offset()?,
                    });
                    part.done()?;
                }
            }
        }
        line.done()?;
        self.program.globals.push(data);
        Ok(())
    }

    fn function<'a>(&mut self, mut line: Line<'a>, rest: &mut Lines<'a>) -> Result<(), TextError> {
        in_order(&mut line, "fn", self.program.funcs.len())?;
        let name = line.name()?;
        let params = params(&mut line)?;
        let mut results = Vec::new();
        if line.eat_arrow() {
            if line.eat('(') {
                results = comma_list(&mut line, ty)?;
                line.expect(')')?;
            } else {
                results.push(ty(&mut line)?);
            }
        }
        let noinline = line.eat_word("noinline");
        line.expect('{')?;
        line.done()?;
        let mut body = Body::new(Function::new(&name, &[], results, self.pos(&line)?));
        body.func.noinline = noinline;
        body.define_params(&line, body.func.entry(), params)?;
        loop {
            let part = next(rest, &line)?;
            let pos = self.pos(&part)?;
            if body.line(part, pos)? {
                break;
            }
        }
        let func = body.finish(&line)?;
        self.program.funcs.push(func);
        Ok(())
    }
}

/// Takes an entity that has to be the next of its kind.
fn in_order(line: &mut Line<'_>, prefix: &str, next: usize) -> Result<(), TextError> {
    match line.peek_entity(prefix) {
        Some(number) if number as usize == next => line.entity(prefix).map(drop),
        _ => Err(line.wanted(&format!("{prefix}{next}"))),
    }
}

fn next<'a>(rest: &mut Lines<'a>, start: &Line<'_>) -> Result<Line<'a>, TextError> {
    rest.next()
        .ok_or_else(|| TextError::new(start.number, 1, "} is missing"))
}

/// `name size n align n`.
pub(super) fn object(line: &mut Line<'_>) -> Result<(String, u32, u32), TextError> {
    let name = line.name()?;
    line.expect_word("size")?;
    let size = line.number()?;
    line.expect_word("align")?;
    Ok((name, size, line.number()?))
}

fn hex(line: &mut Line<'_>, bytes: &mut Vec<u8>) -> Result<(), TextError> {
    let at = line.clone();
    let digits = line.atom("hexadecimal bytes")?;
    let bad = || at.wanted("hexadecimal bytes");
    if digits.len() % 2 != 0 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(bad());
    }
    for i in (0..digits.len()).step_by(2) {
        bytes.push(u8::from_str_radix(&digits[i..i + 2], 16).map_err(|_| bad())?);
    }
    Ok(())
}

pub(super) fn symbol(line: &mut Line<'_>) -> Result<Symbol, TextError> {
    match line.peek_entity("g") {
        Some(_) => Ok(Symbol::Global(Global::new(line.entity("g")? as usize))),
        None => Ok(Symbol::Func(Func::new(line.entity("fn")? as usize))),
    }
}

pub(super) fn ty(line: &mut Line<'_>) -> Result<Ty, TextError> {
    let at = line.clone();
    Ty::parse(line.atom("a type")?).ok_or_else(|| at.wanted("a type (p, w, v)"))
}

pub(super) fn comma_list<'a, T>(
    line: &mut Line<'a>,
    mut item: impl FnMut(&mut Line<'a>) -> Result<T, TextError>,
) -> Result<Vec<T>, TextError> {
    let mut items = vec![item(line)?];
    while line.eat(',') {
        items.push(item(line)?);
    }
    Ok(items)
}

/// `(a, b)`, possibly empty.
pub(super) fn in_parens<'a, T>(
    line: &mut Line<'a>,
    item: impl FnMut(&mut Line<'a>) -> Result<T, TextError>,
) -> Result<Vec<T>, TextError> {
    line.expect('(')?;
    if line.eat(')') {
        return Ok(Vec::new());
    }
    let items = comma_list(line, item)?;
    line.expect(')')?;
    Ok(items)
}

pub(super) fn params(line: &mut Line<'_>) -> Result<Vec<(u32, Ty)>, TextError> {
    in_parens(line, |line| {
        let value = line.entity("v")?;
        line.expect(':')?;
        Ok((value, ty(line)?))
    })
}
