//! Reads `.cases` files.

use super::check;
use super::{Case, Level, Oracle, VERSION, number};
use srp_archdesc::diagnostic::{Diagnostic, Messages, Source, Span};
use std::collections::BTreeMap;

/// Most mistakes that are told of a file.
const MAX_MISTAKES: usize = 20;

/// Most cases of all files together.
const MAX_CASES: usize = 1 << 16;

/// A mistake, and the word or line that it is about.
pub(super) struct Mistake {
    pub(super) message: String,
    /// Bytes of the text.
    pub(super) at: Span,
    pub(super) help: Option<String>,
}

/// A case, and where its lines are.
#[derive(Clone)]
struct Draft {
    case: Case,
    /// The line of each of its keywords.
    lines: BTreeMap<String, Span>,
}

/// The cases of some files, in their order.
///
/// # Errors
///
/// All that is wrong with them.
pub(in super::super) fn read(sources: &[Source]) -> Result<Vec<Case>, Messages> {
    let (mut cases, mut diagnostics) = (Vec::new(), Vec::new());
    let mut seen = BTreeMap::new();
    for source in sources {
        let mut mistakes = Vec::new();
        for draft in drafts(source, &mut mistakes) {
            let at = draft.lines["case"];
            let mut wrong = |message: String, help: Option<String>| {
                mistakes.push(Mistake { message, at, help });
            };
            if cases.len() == MAX_CASES {
                wrong(format!("more than {MAX_CASES} cases"), None);
                break;
            }
            match seen.insert(draft.case.id.clone(), draft.case.place.clone()) {
                Some(other) => wrong(
                    format!("a case `{}` stands at {other} too", draft.case.id),
                    Some("give each case an identifier of its own".to_owned()),
                ),
                None => match checked(draft) {
                    Ok(case) => cases.push(case),
                    Err(mistake) => mistakes.push(mistake),
                },
            }
        }
        mistakes.truncate(MAX_MISTAKES);
        diagnostics.extend(mistakes.into_iter().map(|mistake| {
            let error = Diagnostic::error("R0701", &source.name, mistake.message);
            let error = error.at(mistake.at, "");
            match mistake.help {
                Some(help) => error.help(help),
                None => error,
            }
        }));
    }
    match diagnostics.is_empty() {
        true => Ok(cases),
        false => Err(Messages {
            sources: sources.to_vec(),
            diagnostics,
        }),
    }
}

/// A case that can be tried.
fn checked(draft: Draft) -> Result<Case, Mistake> {
    let Draft { case, lines } = draft;
    match check::check(&case) {
        Ok(()) => Ok(case),
        Err(check::Refusal {
            keyword,
            message,
            help,
        }) => Err(Mistake {
            message: format!("{}: {message}", case.id),
            at: lines.get(keyword).copied().unwrap_or(lines["case"]),
            help,
        }),
    }
}

/// The cases as they are written.
fn drafts(source: &Source, mistakes: &mut Vec<Mistake>) -> Vec<Draft> {
    let mut common = Draft {
        case: Case::empty(),
        lines: BTreeMap::new(),
    };
    let mut drafts: Vec<Draft> = Vec::new();
    let mut start = 0;
    for (number, line) in (1..).zip(source.text.split_inclusive('\n')) {
        let text = line.split('#').next().unwrap_or_default();
        let from = start + (text.len() - text.trim_start().len());
        let text = text.trim();
        let at = Span::new(from as u32, (from + text.len()) as u32);
        start += line.len();
        if text.is_empty() {
            continue;
        }
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let rest = rest.trim();
        let mut wrong = |(message, help)| mistakes.push(Mistake { message, at, help });
        if rest.is_empty() {
            wrong((format!("nothing stands behind `{keyword}`"), None));
        } else if keyword == "case" {
            let (id, title) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            let mut draft = common.clone();
            draft.case.id = id.to_owned();
            draft.case.title = title.trim().to_owned();
            draft.case.place = format!("{}:{number}", source.name);
            draft.lines.insert(keyword.to_owned(), at);
            drafts.push(draft);
        } else {
            let draft = drafts.last_mut().unwrap_or(&mut common);
            match property(&mut draft.case, keyword, rest) {
                Ok(()) => drop(draft.lines.insert(keyword.to_owned(), at)),
                Err(why) => wrong(why),
            }
        }
    }
    drafts
}

/// Why a line is wrong, and what to do.
type Why = (String, Option<String>);

fn property(case: &mut Case, keyword: &str, rest: &str) -> Result<(), Why> {
    let owned = || rest.split_whitespace().map(str::to_owned);
    match keyword {
        "version" if rest == VERSION.to_string() => {}
        "version" => {
            let why = format!("version `{rest}` of the form is not known");
            return Err((why, Some(format!("this tool reads version {VERSION}"))));
        }
        "call" => call(case, rest)?,
        "gives" => case.gives = owned().collect(),
        "may" => case.may.push(owned().collect()),
        "flushed" => case.flushed = owned().collect(),
        "by" => case.oracle = named(rest, Oracle::ALL, Oracle::name)?,
        "source" => case.source = rest.to_owned(),
        "on" => {
            let levels = rest.split_whitespace();
            let levels = levels.map(|word| named(word, Level::ALL, Level::name));
            case.levels = levels.collect::<Result<_, _>>()?;
        }
        "within" => case.within = positive(rest)?,
        "costs" => case.costs = pairs(rest)?,
        "loses" => case.loses = pairs(rest)?,
        _ => {
            let known =
                "version, case, call, gives, may, flushed, by, source, on, within, costs, loses";
            let why = format!("`{keyword}` is no keyword");
            return Err((why, Some(format!("the keywords are {known}"))));
        }
    }
    Ok(())
}

fn call(case: &mut Case, rest: &str) -> Result<(), Why> {
    let mut words = rest.split_whitespace();
    case.call = words.next().unwrap_or_default().to_owned();
    case.arguments.clear();
    for word in words {
        match (number(word), case.arguments.last_mut()) {
            (Some(bits), Some((_, values))) => values.push(bits),
            (Some(_), None) => {
                let help = "an argument is a name and numbers: `of 1 0.5`";
                let why = format!("`{word}` has no name before it");
                return Err((why, Some(help.to_owned())));
            }
            (None, _) => case.arguments.push((word.to_owned(), Vec::new())),
        }
    }
    Ok(())
}

fn named<T: Copy, const N: usize>(
    word: &str,
    all: [T; N],
    name: fn(T) -> &'static str,
) -> Result<T, Why> {
    all.into_iter()
        .find(|&one| name(one) == word)
        .ok_or_else(|| {
            let names = all.map(name).join(", ");
            (
                format!("`{word}` is not known"),
                Some(format!("choose of {names}")),
            )
        })
}

fn positive(word: &str) -> Result<f64, Why> {
    let number = word
        .parse()
        .ok()
        .filter(|n: &f64| *n >= 0.0 && n.is_finite());
    number.ok_or_else(|| {
        let why = format!("`{word}` is not a number from 0 on");
        (why, None)
    })
}

/// Names, each with a number.
fn pairs(text: &str) -> Result<Vec<(String, f64)>, Why> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let pair = |pair: &[&str]| match pair {
        [name, number] => Ok(((*name).to_owned(), positive(number)?)),
        _ => Err((
            format!("`{}` has no number behind it", pair.join(" ")),
            None,
        )),
    };
    words.chunks(2).map(pair).collect()
}
