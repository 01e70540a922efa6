//! `srp hard-cases`: cases that go wrong in float arithmetic, as text, as JSON and as a page.

use crate::cli::{self, HardCases};
use crate::failure::Failure;
use crate::{document, files, interrupt, scenes, sharing, talk};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_studies::hard_cases::{
    self, Case, CaseList, Column, Level, Listing, Matrix, Verdict, export,
};
use srp_toolchain::Session;
use srp_toolchain::envelope::About;
use srp_toolchain::files::{FileError, Kind, read_source};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Runs `srp hard-cases`: 1 where a case is wrong that is not listed as failing by design.
pub(crate) fn run(args: &HardCases) -> Result<i32, Failure> {
    for path in args.html.iter().chain(&args.export) {
        files::check_writable(path)?;
    }
    let arch = args.machine.read()?;
    let sources = (!args.cases.is_empty()).then(|| sources(&args.cases));
    let sources = sources.transpose()?;
    let filter = args.filter.as_deref().unwrap_or_default();
    let cases = hard_cases::cases(sources.as_deref(), filter).map_err(Failure::of_arguments)?;
    if let Some(path) = &args.export {
        files::write(path, exported(path, &arch, &cases)?.as_bytes())?;
        return Ok(0);
    }
    if args.list {
        talk::print(match args.json {
            true => document::json(About::machine(&arch), &CaseList::of(&cases))?,
            false => list_of(&cases),
        })?;
        return Ok(0);
    }
    let session = &Session {
        threads: cli::threads(args.threads),
        ..sharing::session(&args.sharing, args.threads)?
    };
    let scene = scenes::read(args.scene.as_deref(), None, session)?;
    let kernels = args.kernels.as_deref();
    let matrix = interrupt::looked_for(|| hard_cases::run(&arch, cases, &scene, kernels, session))?;
    let again = Again { args };
    if let Some(path) = &args.html {
        files::write(path, page(&matrix, &again).as_bytes())?;
    }
    talk::print(match args.json {
        true => document::json(About::scene(&arch, &scene), &Listing::of(&matrix))?,
        false => text(&matrix, &again),
    })?;
    Ok(i32::from(matrix.is_wrong()))
}

/// The files of cases: those named, and those of the folders named, by name.
fn sources(paths: &[PathBuf]) -> Result<Vec<Source>, Failure> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let wrong = |e| FileError::reading(path, e);
        let entries = std::fs::read_dir(path).map_err(wrong)?;
        let entries: Result<Vec<_>, _> = entries.map(|entry| entry.map(|e| e.path())).collect();
        let mut found = entries.map_err(wrong)?;
        found.retain(|path| path.extension().is_some_and(|e| e == "cases"));
        if found.is_empty() {
            let folder = path.display();
            return Err(Failure::message(format!(
                "no file of the folder {folder} ends in .cases"
            )));
        }
        found.sort();
        files.extend(found);
    }
    let read = files.iter().map(|path| read_source(path, Kind::Cases));
    Ok(read.collect::<Result<_, _>>()?)
}

/// Cases in the form that the ending of a file says.
fn exported(path: &Path, arch: &Arch, cases: &[Case]) -> Result<String, Failure> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("c" | "h") => Ok(export::c(cases)),
        Some("cases") => Ok(export::text(cases)),
        Some("json") => Ok(document::json(About::machine(arch), &CaseList::of(cases))?),
        _ => Err(Failure::usage(
            "the file of --export ends in .c, .json or .cases",
        )),
    }
}

/// Cases as text: a line each.
fn list_of(cases: &[Case]) -> String {
    let mut text = String::new();
    for case in cases {
        let levels: Vec<&str> = case.levels.iter().map(|l| l.name()).collect();
        let (levels, call) = (levels.join(" "), &case.call);
        let _ = writeln!(text, "{:8} {call:18} {levels:12} {}", case.id, case.title);
    }
    text
}

/// The command that tries a case again.
struct Again<'a> {
    args: &'a HardCases,
}

impl Again<'_> {
    fn command(&self, case: &Case) -> String {
        let mut words = vec!["srp hard-cases".to_owned()];
        words.extend(self.args.scene.iter().map(|scene| in_shell(scene)));
        let machine = &self.args.machine.machine;
        if machine.as_os_str() != "sgrt" {
            words.push(format!("--machine {}", in_shell(machine)));
        }
        let changes = self.args.machine.changes.set.iter();
        words.extend(changes.map(|c| format!("--set {}", in_shell(Path::new(&c.to_string())))));
        let kernels = self.args.kernels.iter();
        words.extend(kernels.map(|path| format!("--kernels {}", in_shell(path))));
        let files = self.args.cases.iter();
        words.extend(files.map(|path| format!("--cases {}", in_shell(path))));
        words.push(format!("--filter {}", in_shell(Path::new(&case.id))));
        words.join(" ")
    }
}

/// A word as a shell takes it.
fn in_shell(word: &Path) -> String {
    let word = word.display().to_string();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,+:@".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word,
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// The sign of a verdict in the text.
fn sign(verdict: Option<&Verdict>) -> char {
    match verdict {
        None => ' ',
        Some(Verdict::Right) => '.',
        Some(Verdict::Bounded(_) | Verdict::Off { .. }) => 'o',
        Some(Verdict::Unbounded(_)) => '?',
        Some(Verdict::Wrong(_)) => 'X',
    }
}

fn heading(matrix: &Matrix) -> String {
    let right = matrix.count(|v| *v == Verdict::Right);
    let bounded = matrix.bounded();
    let wrong = matrix.count(|v| matches!(v, Verdict::Wrong(_)));
    let unbounded = match matrix.count(|v| matches!(v, Verdict::Unbounded(_))) {
        0 => String::new(),
        count => format!(", {count} other ones without a bound"),
    };
    let room = matrix.room().map_or(String::new(), |room| {
        format!("; where a number is off, its bound is {room:.1} times that at the median")
    });
    format!(
        "{}: {} cases, {} answers: {right} right, {bounded} within the bound stated for their \
         setting{unbounded}, {wrong} wrong{room}",
        matrix.machine,
        matrix.cases.len(),
        matrix.verdicts.len(),
    )
}

/// The columns of a level.
fn columns(matrix: &Matrix, level: Level) -> impl Iterator<Item = Column> {
    let columns = matrix.columns.iter().copied();
    columns.filter(move |c| c.level == level)
}

/// Columns as a letter each: a to z, then A to Z.
fn letters() -> impl Iterator<Item = char> {
    ('a'..='z').chain('A'..='Z').cycle()
}

/// The matrix as text: a line for each case, a sign for each column.
fn text(matrix: &Matrix, again: &Again<'_>) -> String {
    let mut text = heading(matrix) + "\n\n";
    let mut header = String::new();
    let mut named = letters();
    for level in Level::ALL {
        for column in columns(matrix, level) {
            let letter = named.next().unwrap_or('?');
            header.push(letter);
            let name = matrix.setting(column);
            let _ = writeln!(text, "  {letter}  {:5} {name}", level.name());
        }
        header.push(' ');
    }
    let _ = writeln!(
        text,
        "\n  .  right   o  wrong by design, within its bound   ?  another, without a bound   X  wrong\n\n{:8} {header}",
        "case"
    );
    for (i, case) in matrix.cases.iter().enumerate() {
        let _ = write!(text, "{:8} ", case.id);
        for level in Level::ALL {
            let of = |column| sign(matrix.verdicts.get(&(i, column)));
            text.extend(columns(matrix, level).map(of));
            text.push(' ');
        }
        let _ = writeln!(text, "{}", case.title);
    }
    list(&mut text, matrix, "Wrong by design", "bounded");
    list(&mut text, matrix, "Without a bound", "unbounded");
    list(&mut text, matrix, "Wrong", "wrong");
    let wrong = matrix
        .cases
        .iter()
        .enumerate()
        .filter(|&(i, _)| rank(matrix, i) == 0);
    for (k, (_, case)) in wrong.enumerate() {
        let what = if k == 0 { "\nOne alone, again:\n" } else { "" };
        let _ = writeln!(text, "{what}  {}", again.command(case));
    }
    for note in &matrix.skipped {
        let _ = writeln!(text, "\nskipped: {note}");
    }
    text
}

/// 0 for a case with a wrong answer, 1 for one with a bounded one, 2 for the others.
fn rank(matrix: &Matrix, case: usize) -> u8 {
    let of_case = (matrix.verdicts.iter()).filter(|((i, _), _)| *i == case);
    let ranks = of_case.map(|(_, verdict)| match verdict {
        Verdict::Wrong(_) => 0,
        Verdict::Bounded(_) | Verdict::Off { .. } | Verdict::Unbounded(_) => 1,
        Verdict::Right => 2,
    });
    ranks.min().unwrap_or(2)
}

/// Lists texts about verdicts of a kind, each once for all settings of the case that have it.
fn list(text: &mut String, matrix: &Matrix, title: &str, kind: &str) {
    let mut said: BTreeMap<(usize, Level), Vec<String>> = BTreeMap::new();
    for ((case, column), verdict) in &matrix.verdicts {
        if let (found, what) = verdict.told()
            && found == kind
        {
            let line = format!("{}: {what}", matrix.setting(*column));
            said.entry((*case, column.level)).or_default().push(line);
        }
    }
    if said.is_empty() {
        return;
    }
    let _ = writeln!(text, "\n{title}:");
    for ((case, level), lines) in said {
        let case = &matrix.cases[case];
        for line in lines {
            let _ = writeln!(
                text,
                "  {} {} ({})  {line}",
                case.id,
                level.name(),
                case.place
            );
        }
    }
}

const STYLE: &str = include_str!("hard.css");

/// The matrix as one page without network.
fn page(matrix: &Matrix, again: &Again<'_>) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Hard cases on " (matrix.machine) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Hard cases on " (matrix.machine) }
                p { (heading(matrix)) "." }
                p.legend {
                    span { i.right {} "right" }
                    span { i.bounded {} "wrong by design in this setting, within the bound stated" }
                    span { i.unbounded {} "another answer, without a bound in this setting" }
                    span { i.wrong {} "wrong" }
                    span { i.none {} "not run there" }
                }
                @for note in &matrix.skipped { p.note { "Skipped: " (note) } }
                (table(matrix, again))
            }
        }
    }
    .into_string()
}

fn table(matrix: &Matrix, again: &Again<'_>) -> Markup {
    let mut cases: Vec<(usize, &Case)> = matrix.cases.iter().enumerate().collect();
    // Those with wrong answers come first.
    cases.sort_by_key(|&(i, _)| rank(matrix, i) > 0);
    let levels = || Level::ALL.into_iter();
    let of = |level| columns(matrix, level).collect::<Vec<_>>();
    let title = |level| match level {
        Level::Host => "host",
        Level::Srp => "kernels on the simulated SRP",
        Level::Tni => "T&I unit",
        Level::Frame => "frames",
    };
    html! {
        div.scroll { table {
            thead {
                tr {
                    th colspan="2" {}
                    @for level in levels() { @if !of(level).is_empty() {
                        th.level colspan=(of(level).len()) { (title(level)) }
                    } }
                }
                tr {
                    th { "case" } th.words {}
                    @for level in levels() {
                        @for (k, column) in of(level).into_iter().enumerate() {
                            th.setting.first[k == 0] { span { (matrix.setting(column)) } }
                        }
                    }
                }
            }
            tbody {
                @for (i, case) in cases {
                    tr {
                        td.id { (case.id) }
                        td.words { (about(case, &again.command(case))) }
                        @for level in levels() {
                            @for (k, column) in of(level).into_iter().enumerate() {
                                (cell(matrix.verdicts.get(&(i, column)), k == 0))
                            }
                        }
                    }
                }
            }
        } }
    }
}

fn cell(verdict: Option<&Verdict>, first: bool) -> Markup {
    let (class, what) = verdict.map_or(("none", "".into()), Verdict::told);
    html! { td.cell.first[first] { i class=(class) title=(what) {} } }
}

/// The title, and the whole case behind it.
fn about(case: &Case, again: &str) -> Markup {
    let bits = |words: &[u32]| {
        let words = words.iter().map(|w| format!("{w:08x}"));
        words.collect::<Vec<_>>().join(" ")
    };
    html! {
        details {
            summary { (case.title) }
            p { code { (case.call) } " gives " code { (case.gives.join(" ")) }
                @if case.within > 0.0 { ", within " (case.within) " units of the last place" }
                @for answer in &case.may { ", or " code { (answer.join(" ")) } } }
            @for (name, words) in &case.arguments { @if words.len() <= 48 {
                p.soft { (name) " " code { (bits(words)) } }
            } }
            p.soft { code { (again) } }
            p.soft { "Oracle: " (case.oracle.name()) ". Source: " (case.source) ". " code { (case.place) } }
        }
    }
}
