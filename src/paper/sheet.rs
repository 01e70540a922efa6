//! Output of `srp paper`: the paper's figure, ours and their ratio, as text or as JSON.

use crate::failure::Failure;
use crate::talk;
use serde::Serialize;

/// The output under way. Text is printed as it comes, JSON at the end.
#[derive(Debug, Default)]
pub(super) struct Sheet {
    json: bool,
    heading: String,
    scenes: Vec<SceneSheet>,
}

/// The figures of a scene.
#[derive(Debug, Serialize)]
struct SceneSheet {
    scene: String,
    groups: Vec<Group>,
}

/// The figures of one kind of rays.
#[derive(Debug, Serialize)]
struct Group {
    rays: String,
    figures: Vec<Figure>,
    notes: Vec<String>,
}

/// One line.
#[derive(Debug, Serialize)]
struct Figure {
    what: String,
    paper: Option<f64>,
    ours: f64,
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
    pub(super) fn heading(&mut self, text: String) -> Result<(), Failure> {
        self.put(&text)?;
        self.heading = text;
        Ok(())
    }

    /// A scene begins.
    pub(super) fn scene(&mut self, name: String) -> Result<(), Failure> {
        self.put(&format!("\n{name}"))?;
        self.scenes.push(SceneSheet {
            scene: name,
            groups: Vec::new(),
        });
        Ok(())
    }

    /// Begins the figures of one kind of rays; `error` is the relative error of figures that are measured on
    /// a part of the rays.
    pub(super) fn group(&mut self, rays: &str, error: Option<f64>) -> Result<(), Failure> {
        let error = error.map_or(String::new(), |e| format!(" ± {:.1} %", 100.0 * e));
        self.put(&format!(
            "{rays:36} {:>9} {:>9} {:>7}{error}",
            "paper", "ours", "ratio"
        ))?;
        if let Some(scene) = self.scenes.last_mut() {
            scene.groups.push(Group {
                rays: rays.to_owned(),
                figures: Vec::new(),
                notes: Vec::new(),
            });
        }
        Ok(())
    }

    /// One line: the paper's figure, ours, and ours over the paper's.
    pub(super) fn line(
        &mut self,
        what: &str,
        paper: Option<f64>,
        ours: f64,
    ) -> Result<(), Failure> {
        let ratio = paper.map(|paper| ours / paper);
        match (paper, ratio) {
            (Some(paper), Some(ratio)) => {
                self.put(&format!(
                    "  {what:34} {paper:>9.2} {ours:>9.2} {ratio:>7.2}"
                ))?;
            }
            _ => self.put(&format!("  {what:34} {:>9} {ours:>9.2} {:>7}", "–", "–"))?,
        }
        if let Some(group) = self.last_group() {
            group.figures.push(Figure {
                what: what.trim().to_owned(),
                paper,
                ours,
                ratio,
            });
        }
        Ok(())
    }

    /// A remark on the figures before it.
    pub(super) fn note(&mut self, text: String) -> Result<(), Failure> {
        self.put(&text)?;
        if let Some(group) = self.last_group() {
            let words: Vec<&str> = text.split_whitespace().collect();
            group.notes.push(words.join(" "));
        }
        Ok(())
    }

    fn last_group(&mut self) -> Option<&mut Group> {
        self.scenes.last_mut()?.groups.last_mut()
    }

    fn put(&self, text: &str) -> Result<(), Failure> {
        if self.json {
            return Ok(());
        }
        Ok(talk::print(format!("{text}\n"))?)
    }

    /// Prints what is to be printed at the end.
    pub(super) fn finish(self, table: &str) -> Result<(), Failure> {
        if !self.json {
            return Ok(());
        }
        let json = serde_json::json!({
            "table": table,
            "about": self.heading,
            "scenes": self.scenes,
        });
        let text = serde_json::to_string_pretty(&json).map_err(Failure::message)?;
        Ok(talk::print(text + "\n")?)
    }
}
