//! S-expressions.

use super::{At, Wrong};

/// An S-expression.
pub(super) enum Term {
    Atom(At, String),
    Text(At, String),
    List(At, Vec<Term>),
}

impl Term {
    pub(super) fn at(&self) -> At {
        match self {
            Term::Atom(at, _) | Term::Text(at, _) | Term::List(at, _) => *at,
        }
    }

    pub(super) fn wrong(&self, why: impl Into<String>) -> Wrong {
        Wrong {
            at: self.at(),
            why: why.into(),
        }
    }
}

/// Lists in lists that are read.
const MOST_DEPTH: usize = 200;

/// The S-expressions of a text.
pub(super) fn terms(text: &str) -> Result<Vec<Term>, Wrong> {
    let mut open: Vec<(At, Vec<Term>)> = Vec::new();
    let mut top = Vec::new();
    let (mut line, mut column) = (1, 0);
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        column += 1;
        let at = At { line, column };
        let term = match c {
            '\n' => {
                (line, column) = (line + 1, 0);
                continue;
            }
            c if c.is_whitespace() => continue,
            ';' => {
                while chars.next_if(|c| *c != '\n').is_some() {
                    column += 1;
                }
                continue;
            }
            '(' | '[' => {
                if open.len() == MOST_DEPTH {
                    let why = format!("lists are deeper than {MOST_DEPTH}");
                    return Err(Wrong { at, why });
                }
                open.push((at, Vec::new()));
                continue;
            }
            ')' | ']' => match open.pop() {
                Some((at, list)) => Term::List(at, list),
                None => {
                    let why = "a parenthesis that closes nothing".to_owned();
                    return Err(Wrong { at, why });
                }
            },
            '"' => {
                let mut text = String::new();
                let mut closed = false;
                while let Some(c) = chars.next() {
                    column += 1;
                    match c {
                        '"' => {
                            closed = true;
                            break;
                        }
                        '\n' => (line, column) = (line + 1, 0),
                        '\\' => {
                            column += 1;
                            text.extend(chars.next());
                            continue;
                        }
                        _ => {}
                    }
                    text.push(c);
                }
                if !closed {
                    let why = "a string that does not end".to_owned();
                    return Err(Wrong { at, why });
                }
                Term::Text(at, text)
            }
            c => {
                let mut atom = String::from(c);
                let is_part = |c: &char| !c.is_whitespace() && !"()[]\";".contains(*c);
                while let Some(c) = chars.next_if(is_part) {
                    column += 1;
                    atom.push(c);
                }
                Term::Atom(at, atom)
            }
        };
        match open.last_mut() {
            Some((_, list)) => list.push(term),
            None => top.push(term),
        }
    }
    match open.pop() {
        Some((at, _)) => Err(Wrong {
            at,
            why: "a parenthesis that is not closed".to_owned(),
        }),
        None => Ok(top),
    }
}
