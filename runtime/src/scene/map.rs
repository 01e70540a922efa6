//! The texture statements of an MTL file: `map_Kd`, `map_Ks` and `map_d` with their options.

use std::rc::Rc;

use srp_archdesc::diagnostic::{Diagnostic, Span};

use super::lines::{Findings, Line, Word, join_continued, lines};

/// One texture of a material.
pub(super) struct Statement {
    /// The material's name.
    pub(super) material: Rc<str>,
    /// `map_Kd`, `map_Ks` or `map_d`.
    pub(super) keyword: String,
    /// The file, as it is written.
    pub(super) file: String,
    /// True if coordinates stop at the edges.
    pub(super) clamp: bool,
    /// Where the statement stands.
    pub(super) span: Span,
}

/// An option and its values.
struct Opt<'a> {
    name: Word<'a>,
    values: Vec<Word<'a>>,
}

impl Opt<'_> {
    /// True if it states the default.
    fn says_nothing(&self) -> bool {
        let all = |x: f32| self.values.iter().all(|w| w.text.parse() == Ok(x));
        match self.name.text {
            "-s" => all(1.0),
            "-o" | "-t" => all(0.0),
            "-blendu" | "-blendv" => self.values.iter().all(|w| w.text == "on"),
            "-cc" => self.values.iter().all(|w| w.text == "off"),
            "-mm" => {
                let values: Vec<_> = self.values.iter().map(|w| w.text.parse()).collect();
                values == [Ok(0.0f32), Ok(1.0)]
            }
            _ => false,
        }
    }
}

/// The options of a texture statement, and the name of the file behind them, blanks included.
fn parts<'a>(line: &Line<'a>) -> (Vec<Opt<'a>>, Option<&'a str>) {
    let mut options = Vec::new();
    let mut words = line.words.iter().copied().peekable();
    while let Some(name) = words.next_if(|w| w.text.starts_with('-')) {
        let numeric = matches!(name.text, "-o" | "-s" | "-t");
        let least = if name.text == "-mm" { 2 } else { 1 };
        let mut values = Vec::new();
        while let Some(word) = words.peek().copied() {
            let number = word.text.parse::<f32>().is_ok();
            if values.len() < least || (numeric && number && values.len() < 3) {
                words.next();
                values.push(word);
            } else {
                break;
            }
        }
        options.push(Opt { name, values });
    }
    let rest = line.rest;
    let file = words
        .peek()
        .map(|first| &rest.text[first.start - rest.start..]);
    (options, file)
}

/// The name of the file of a texture statement, if it has one.
pub(super) fn file<'a>(line: &Line<'a>) -> Option<&'a str> {
    parts(line).1
}

/// The texture statements of a material library that the line-level check has passed. Statements that are not
/// carried out as written go to `findings`.
pub(super) fn statements(library: &str, text: &str, findings: &mut Findings) -> Vec<Statement> {
    let joined = join_continued(text);
    let mut statements = Vec::new();
    let mut material: Rc<str> = Rc::from("");
    for line in lines(&joined) {
        let keyword = line.key.text;
        let warning = |message: String, span: Span, label: &str| {
            Diagnostic::warning("R0213", library, message).at(span, label)
        };
        match keyword {
            "newmtl" => material = Rc::from(line.rest.text),
            "map_Kd" | "map_Ks" | "map_d" => {
                let (options, file) = parts(&line);
                let mut clamp = false;
                for option in &options {
                    match (option.name.text, &option.values[..]) {
                        ("-clamp", [value]) if ["on", "off"].contains(&value.text) => {
                            clamp = value.text == "on";
                        }
                        _ if option.says_nothing() => {}
                        (name, _) => findings.push(warning(
                            format!("option `{name}` of `{keyword}` is ignored"),
                            option.name.span(),
                            "only `-clamp on` and `-clamp off` are done",
                        )),
                    }
                }
                if let Some(file) = file {
                    statements.push(Statement {
                        material: material.clone(),
                        keyword: keyword.to_owned(),
                        file: file.to_owned(),
                        clamp,
                        span: line.span(),
                    });
                }
            }
            _ => {}
        }
    }
    statements
}
