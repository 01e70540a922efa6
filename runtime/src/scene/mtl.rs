//! The line-level check of an MTL file.
//!
//! `tobj` panics on a colour of fewer than three numbers, takes texture options for a part of the
//! file name, and has no line numbers. It gets a plain rewriting with complete colours and bare
//! texture names.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use srp_archdesc::diagnostic::{Diagnostic, Span};
use srp_archdesc::nearest::nearest;

use super::lines::{Findings, Line, join_continued, lines, number, numbers};
use super::{MAX_MATERIALS, Origin, map};

/// Statements that are read.
const READ: [&str; 13] = [
    "newmtl", "Ka", "Kd", "Ks", "Ke", "Tf", "Ns", "Ni", "illum", "map_Kd", "map_Ks", "map_d", "d",
];

/// Statements that others read, as they write them.
const OTHERS: [&str; 30] = [
    "map_Ka",
    "map_Ke",
    "map_Ns",
    "map_Pr",
    "map_Pm",
    "map_Ps",
    "map_RMA",
    "map_ORM",
    "map_Bump",
    "map_bump",
    "map_Tr",
    "map_opacity",
    "map_refl",
    "map_aat",
    "bump",
    "Bump",
    "norm",
    "disp",
    "decal",
    "refl",
    "sharpness",
    "Km",
    "Kr",
    "Kt",
    "Pr",
    "Pm",
    "Ps",
    "Pc",
    "Pcr",
    "aniso",
];

/// Longest name of a material, in bytes.
const MAX_NAME: usize = 1024;

/// Checks `text` line by line; mistakes go to `findings`. Returns the rewriting for `tobj`, and by
/// name where each material is defined.
pub(super) fn check(
    file: &str,
    text: &str,
    findings: &mut Findings,
) -> (String, BTreeMap<String, Origin>) {
    let joined = join_continued(text);
    // A file of another kind, such as a list of passwords that a stranger's scene names, is not quoted.
    if !lines(&joined).any(|line| line.key.text == "newmtl") && !text.trim().is_empty() {
        let message = "it is no material library: it has no `newmtl`";
        findings.push(Diagnostic::error("R0215", file, message));
        return (String::new(), BTreeMap::new());
    }
    let mut reader = Reader {
        file,
        findings,
        plain: String::with_capacity(text.len()),
        names: BTreeSet::new(),
        name: None,
        origins: BTreeMap::new(),
        clear: BTreeMap::new(),
        by_tr: BTreeMap::new(),
    };
    let (mut number, mut counted) = (1, 0);
    for line in lines(&joined) {
        number += joined[counted..line.key.start].matches('\n').count() as u32;
        counted = line.key.start;
        reader.line(&line);
        reader.remember(&line, number);
    }
    reader.warn_of_clear_glass();
    reader.warn_of_transparency();
    (reader.plain, reader.origins)
}

struct Reader<'a> {
    file: &'a str,
    findings: &'a mut Findings,
    plain: String,
    /// The names of the materials.
    names: BTreeSet<String>,
    /// The name of the material in hand.
    name: Option<String>,
    origins: BTreeMap<String, Origin>,
    /// Materials that let light through without bending it, each with where `illum` says so.
    clear: BTreeMap<String, (Span, String)>,
    /// Materials that are transparent in part by `Tr`, each with where it says so.
    by_tr: BTreeMap<String, Span>,
}

impl Reader<'_> {
    fn line(&mut self, line: &Line<'_>) {
        let key = line.key.text;
        if key == "newmtl" {
            return self.new_material(line);
        }
        if self.name.is_none() {
            self.error(line, "R0202", format!("`{key}` before the first `newmtl`"));
            return;
        }
        match key {
            "Ka" | "Kd" | "Ks" | "Ke" | "Tf" => self.colour(line),
            "Ns" | "Ni" => {
                if let Some(value) = self.scalar(line, f32::MIN, f32::MAX) {
                    self.plain(format_args!("{key} {value:?}"));
                    if key == "Ni" && value <= 0.0 {
                        let message = format!("`Ni {value}` is no index of refraction");
                        let label = "light goes straight through; vacuum has 1, and glass 1.5";
                        let warning = Diagnostic::warning("R0219", self.file, message);
                        self.findings.push(warning.at(line.span(), label));
                    }
                }
            }
            "d" | "Tr" => self.dissolve(line),
            "illum" => self.illumination(line),
            "map_Kd" | "map_Ks" | "map_d" => self.texture(line),
            // What is read by nobody yet is not judged, but for what is hardly meant to be something else.
            _ if OTHERS.contains(&key) => {}
            _ => {
                if let Some(meant) = nearest(key, READ) {
                    let message = format!("`{key}` is no statement of a material");
                    let label = format!("`{meant}` was probably meant");
                    let warning = Diagnostic::warning("R0220", self.file, message);
                    self.findings.push(warning.at(line.key.span(), label));
                }
            }
        }
    }

    /// Keeps where the material in hand and its statements stand.
    fn remember(&mut self, line: &Line<'_>, number: u32) {
        let Some(name) = &self.name else {
            return;
        };
        if line.key.text == "newmtl" {
            let origin = Origin {
                file: self.file.to_owned(),
                line: number,
                statements: BTreeMap::new(),
            };
            self.origins.insert(name.clone(), origin);
        } else if let Some(origin) = self.origins.get_mut(name) {
            origin.statements.insert(line.key.text.to_owned(), number);
        }
    }

    /// Warns of materials that let all light through because neither `Tf` nor `d` says otherwise.
    fn warn_of_clear_glass(&mut self) {
        for (name, (span, illum)) in self.clear.clone() {
            let says = |key: &str| {
                let origin = self.origins.get(&name);
                origin.is_some_and(|origin| origin.statements.contains_key(key))
            };
            if says("Tf") || says("d") {
                continue;
            }
            let message = format!("material `{name}` lets all light through");
            let label = format!("`illum {illum}` is glass, and neither `Tf` nor `d` limits it");
            self.findings
                .push(Diagnostic::warning("R0214", self.file, message).at(span, label));
        }
    }

    /// Warns of materials that say by `Tr` alone that light goes through them in part.
    fn warn_of_transparency(&mut self) {
        for (name, span) in std::mem::take(&mut self.by_tr) {
            let origin = self.origins.get(&name);
            // Glass is told of by itself.
            let is_glass = self.clear.contains_key(&name);
            if is_glass || origin.is_some_and(|origin| origin.statements.contains_key("d")) {
                continue;
            }
            let message = format!("material `{name}` is opaque, for `Tr` is not read");
            let label = "exporters write it with either meaning: write `d`, which is 1 for opaque";
            self.findings
                .push(Diagnostic::warning("R0218", self.file, message).at(span, label));
        }
    }

    fn error(&mut self, line: &Line<'_>, code: &'static str, message: String) {
        self.findings
            .push(Diagnostic::error(code, self.file, message).at(line.span(), ""));
    }

    fn plain(&mut self, line: std::fmt::Arguments<'_>) {
        writeln!(self.plain, "{line}").expect("writing to a String does not fail");
    }

    fn new_material(&mut self, line: &Line<'_>) {
        let name = line.rest.text;
        if name.is_empty() {
            return self.error(line, "R0201", "`newmtl` without a name".to_owned());
        }
        if name.len() > MAX_NAME {
            let message = format!("the name of a material is longer than {MAX_NAME} bytes");
            return self.error(line, "R0216", message);
        }
        if self.names.len() == MAX_MATERIALS {
            let message = format!("more than {MAX_MATERIALS} materials");
            return self.error(line, "R0217", message);
        }
        if !self.names.insert(name.to_owned()) {
            self.findings.push(
                Diagnostic::warning(
                    "R0203",
                    self.file,
                    format!("material `{name}` is defined twice"),
                )
                .at(line.rest.span(), "the later definition counts"),
            );
        }
        self.name = Some(name.to_owned());
        self.plain(format_args!("newmtl {name}"));
    }

    fn numbers(&mut self, line: &Line<'_>) -> Option<Vec<f32>> {
        let mut values = Vec::new();
        for word in &line.words {
            match number(word.text) {
                Ok(value) => values.push(value),
                Err(why) => {
                    self.findings.push(
                        Diagnostic::error(
                            "R0205",
                            self.file,
                            format!("bad number in `{}`", line.key.text),
                        )
                        .at(word.span(), why),
                    );
                    return None;
                }
            }
        }
        Some(values)
    }

    /// One number stands for three equal ones.
    fn colour(&mut self, line: &Line<'_>) {
        let key = line.key.text;
        if let Some(kind) = line.words.first().map(|w| w.text)
            && (kind == "spectral" || kind == "xyz")
        {
            self.findings.push(
                Diagnostic::warning("R0206", self.file, format!("`{key} {kind}` is ignored"))
                    .at(line.span(), "only rgb colours are supported"),
            );
            return;
        }
        let Some(values) = self.numbers(line) else {
            return;
        };
        let [r, g, b] = match values[..] {
            [r] => [r; 3],
            [r, g, b] => [r, g, b],
            _ => {
                let message = format!("`{key}` with {} instead of 1 or 3", numbers(values.len()));
                return self.error(line, "R0204", message);
            }
        };
        if [r, g, b].iter().any(|&c| c < 0.0) {
            return self.error(line, "R0207", format!("negative colour in `{key}`"));
        }
        self.plain(format_args!("{key} {r:?} {g:?} {b:?}"));
    }

    fn scalar(&mut self, line: &Line<'_>, least: f32, most: f32) -> Option<f32> {
        let key = line.key.text;
        let values = self.numbers(line)?;
        let [value] = values[..] else {
            let message = format!("`{key}` with {} instead of 1", numbers(values.len()));
            self.error(line, "R0204", message);
            return None;
        };
        if !(least..=most).contains(&value) {
            let message = format!("`{key}` is not between {least} and {most}");
            self.error(line, "R0208", message);
            return None;
        }
        Some(value)
    }

    /// `d` counts; `Tr`, which exporters write with either meaning, is not used.
    fn dissolve(&mut self, line: &Line<'_>) {
        let without_option = Line {
            key: line.key,
            words: line
                .words
                .iter()
                .copied()
                .filter(|w| w.text != "-halo")
                .collect(),
            rest: line.rest,
        };
        let value = self.scalar(&without_option, 0.0, 1.0);
        match (value, line.key.text) {
            (Some(d), "d") => self.plain(format_args!("d {d:?}")),
            (Some(part), _) if part > 0.0 && part < 1.0 => {
                if let Some(name) = self.name.clone() {
                    self.by_tr.insert(name, line.span());
                }
            }
            _ => {}
        }
    }

    fn illumination(&mut self, line: &Line<'_>) {
        match line.words[..] {
            [word] if word.text.parse::<u8>().is_ok_and(|i| i <= 10) => {
                self.plain(format_args!("illum {}", word.text));
                if let Some(name) = self.name.clone() {
                    match word.text {
                        "4" | "9" => {
                            let illum = (line.span(), word.text.to_owned());
                            self.clear.insert(name, illum);
                        }
                        _ => {
                            self.clear.remove(&name);
                        }
                    }
                }
            }
            _ => {
                let message = "`illum` is not an integer between 0 and 10".to_owned();
                self.error(line, "R0209", message);
            }
        }
    }

    /// Drops the options, which [`map`] reads.
    fn texture(&mut self, line: &Line<'_>) {
        let Some(name) = map::file(line) else {
            let message = format!("`{}` without a file name", line.key.text);
            return self.error(line, "R0210", message);
        };
        self.plain(format_args!("{} {name}", line.key.text));
    }
}
