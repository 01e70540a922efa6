//! All that the folder of a sweep knows, read for reports and tables.

use super::objective::Objective;
use super::plan::PlanFile;
use super::progress::Progress;
use super::rows::{Folder, Job, Row};
use super::search::Search;
use crate::Error;
use srp_archdesc::diagnostic::Source;
use srp_toolchain::{files, json};

/// The part of a sweep that a folder has.
pub struct Known {
    /// The plan as it was written.
    pub plan: PlanFile,
    /// Its rows, by point and subject.
    pub rows: Vec<Row>,
    /// Rows that the plan has.
    pub planned: usize,
    /// The objectives that are stated, or searched by.
    pub objectives: Vec<Objective>,
    /// How far the search has come, where points are found by one.
    pub progress: Option<Progress>,
}

impl Folder {
    /// Reads the part of the sweep that was run in the folder last.
    ///
    /// # Errors
    ///
    /// It is the folder of no sweep, or cannot be read.
    pub fn known(&self) -> Result<Known, Error> {
        let path = self.path("plan.toml");
        let text = files::read_text(&path, files::Kind::Plan).map_err(|e| {
            Error::Invalid(format!(
                "{e}: is {} the folder of a sweep?",
                self.0.display()
            ))
        })?;
        let plan = PlanFile::parse(&path.display().to_string(), &text, &self.0)?;
        let points = self.path("points.json");
        let text = files::read_text(&points, files::Kind::Rows)?;
        let jobs: Vec<Job> = json::read(&Source::new(points.display().to_string(), text))?;
        let rows = self.rows()?;
        let known = jobs
            .iter()
            .filter_map(|job| Some(job.place(rows.get(&job.key)?)));
        let rows: Vec<Row> = known.collect();
        let objectives = plan.objectives()?;
        let subjects = jobs.iter().filter(|job| job.point == 0).count();
        let search = plan.search()?;
        let progress = |search: &Search| Progress::of(search, &objectives, &rows, subjects);
        Ok(Known {
            progress: search.as_ref().map(progress),
            planned: search.map_or(jobs.len(), |search| search.points() * subjects),
            objectives,
            plan,
            rows,
        })
    }
}
