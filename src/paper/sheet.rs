//! Output of `srp paper`: the paper's figure, ours and their ratio, as text or as JSON.

use crate::failure::Failure;
use crate::{document, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_studies::paper::Entry;
use srp_toolchain::envelope::{About, Contents};
use srp_toolchain::files::FileError;

/// The output under way. Text is printed as it comes, JSON at the end.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    json: bool,
    heading: String,
    scenes: Vec<SceneSheet>,
    /// The failure to print, if there was one: nothing is printed after it.
    failed: Option<FileError>,
}

/// The output as JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Document {
    /// The table of the paper.
    table: String,
    /// What holds for all figures, in words.
    about: String,
    /// The scenes.
    scenes: Vec<SceneSheet>,
}

impl Contents for Document {
    const FORMAT: &'static str = "srp-paper";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp paper TABLE --json`";
}

/// The figures of a scene.
#[derive(Debug, Serialize, JsonSchema)]
struct SceneSheet {
    /// Its name.
    name: String,
    /// Its figures, by kinds of rays.
    groups: Vec<Group>,
}

/// The figures of one kind of rays.
#[derive(Debug, Serialize, JsonSchema)]
struct Group {
    /// The rays.
    rays: String,
    /// The figures.
    figures: Vec<Figure>,
    /// Remarks on them.
    notes: Vec<String>,
}

/// One line.
#[derive(Debug, Serialize, JsonSchema)]
struct Figure {
    /// What is measured.
    what: String,
    /// The paper's figure; null where it has none.
    paper: Option<f64>,
    /// Ours.
    ours: f64,
    /// Ours over the paper's.
    ratio: Option<f64>,
}

impl Sheet {
    pub(super) fn new(json: bool) -> Sheet {
        Sheet {
            json,
            ..Sheet::default()
        }
    }

    /// Prints the facts that hold for all of it.
    pub(super) fn heading(&mut self, text: String) {
        self.put(&text);
        self.heading = text;
    }

    /// Takes the next entry.
    pub(super) fn take(&mut self, entry: Entry) {
        match entry {
            Entry::Scene(name) => self.scene(name),
            Entry::Group(rays, error) => self.group(rays, error),
            Entry::Line(what, paper, ours) => self.line(&what, paper, ours),
            Entry::Note(text) => self.note(&text),
        }
    }

    /// A scene begins.
    fn scene(&mut self, name: String) {
        self.put(&format!("\n{name}"));
        self.scenes.push(SceneSheet {
            name,
            groups: Vec::new(),
        });
    }

    /// Begins the figures of one kind of rays; `error` is the relative error of figures that are measured on
    /// a part of the rays.
    fn group(&mut self, rays: String, error: Option<f64>) {
        let error = error.map_or(String::new(), |e| format!(" ± {:.1} %", 100.0 * e));
        self.put(&format!(
            "{rays:36} {:>9} {:>9} {:>7}{error}",
            "paper", "ours", "ratio"
        ));
        if let Some(scene) = self.scenes.last_mut() {
            scene.groups.push(Group {
                rays,
                figures: Vec::new(),
                notes: Vec::new(),
            });
        }
    }

    /// One line: the paper's figure, ours, and ours over the paper's.
    fn line(&mut self, what: &str, paper: Option<f64>, ours: f64) {
        let ratio = paper.map(|paper| ours / paper);
        match (paper, ratio) {
            (Some(paper), Some(ratio)) => {
                self.put(&format!(
                    "  {what:34} {paper:>9.2} {ours:>9.2} {ratio:>7.2}"
                ));
            }
            _ => self.put(&format!("  {what:34} {:>9} {ours:>9.2} {:>7}", "–", "–")),
        }
        if let Some(group) = self.last_group() {
            group.figures.push(Figure {
                what: what.trim().to_owned(),
                paper,
                ours,
                ratio,
            });
        }
    }

    /// A remark on the figures before it.
    fn note(&mut self, text: &str) {
        self.put(text);
        if let Some(group) = self.last_group() {
            let words: Vec<&str> = text.split_whitespace().collect();
            group.notes.push(words.join(" "));
        }
    }

    fn last_group(&mut self) -> Option<&mut Group> {
        self.scenes.last_mut()?.groups.last_mut()
    }

    fn put(&mut self, text: &str) {
        if !self.json && self.failed.is_none() {
            self.failed = talk::print(format!("{text}\n")).err();
        }
    }

    /// Prints what is to be printed at the end.
    pub(super) fn finish(self, table: &str, about: About) -> Result<(), Failure> {
        if let Some(failed) = self.failed {
            return Err(failed.into());
        }
        if !self.json {
            return Ok(());
        }
        let document = Document {
            table: table.to_owned(),
            about: self.heading,
            scenes: self.scenes,
        };
        Ok(talk::print(document::json(about, &document)?)?)
    }
}
