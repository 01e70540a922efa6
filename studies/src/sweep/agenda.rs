//! The rows that are to be measured: all of them from the beginning, or generation by generation where a search finds its
//! points on its way.

use super::bench::Bench;
use super::plan::Plan;
use super::point::Point;
use super::progress::{costs, figures_of};
use super::rows::{self, Job, Row};
use super::search::Course;
use crate::Error;
use std::collections::BTreeMap;
use std::ops::Range;

/// The rows of a plan, as far as it is decided which these are.
pub(super) struct Agenda<'a> {
    plan: &'a Plan,
    bench: &'a Bench<'a>,
    course: Option<Course<'a>>,
    /// The costs of the points whose rows are known.
    costs: Vec<Option<Vec<f64>>>,
    jobs: Vec<Job>,
}

impl<'a> Agenda<'a> {
    /// Of a plan of which nothing is decided.
    pub(super) fn new(plan: &'a Plan, bench: &'a Bench<'a>) -> Agenda<'a> {
        Agenda {
            plan,
            bench,
            course: plan.search.as_ref().map(|search| search.begin()),
            costs: Vec::new(),
            jobs: Vec::new(),
        }
    }

    /// Rows that there are in the end.
    pub(super) fn planned(&self) -> usize {
        let points = self.plan.search.as_ref().map(|search| search.points());
        points.unwrap_or(self.plan.points.len()) * self.bench.subjects()
    }

    /// The rows that are decided upon, in the order of the plan.
    pub(super) fn jobs(&self) -> &[Job] {
        &self.jobs
    }

    /// Decides upon further rows; `None` where there are no more, or some of those before have to be known first.
    ///
    /// # Errors
    ///
    /// No row has an objective of the search.
    pub(super) fn next(
        &mut self,
        known: &BTreeMap<String, Row>,
    ) -> Result<Option<Range<usize>>, Error> {
        let first = self.jobs.len();
        let points: Vec<Point> = match &mut self.course {
            None if first > 0 => return Ok(None),
            None => self.plan.points.clone(),
            Some(course) => {
                let newest = &self.jobs[self.costs.len() * self.bench.subjects()..];
                let rows: Option<Vec<&Row>> =
                    newest.iter().map(|job| known.get(&job.key)).collect();
                let Some(rows) = rows else {
                    return Ok(None);
                };
                let objectives = &self.plan.objectives;
                let of_point =
                    |rows: &[&Row]| Some(costs(objectives, &figures_of(objectives, rows)?));
                self.costs
                    .extend(rows.chunks(self.bench.subjects()).map(of_point));
                if self.costs.iter().all(Option::is_none) {
                    refuse_unknown_objective(self.plan, &rows)?;
                }
                course.next(&self.costs)
            }
        };
        self.jobs
            .extend(self.bench.jobs(first / self.bench.subjects(), &points));
        let further = first..self.jobs.len();
        Ok((!further.is_empty()).then_some(further))
    }
}

/// Refuses an objective that none of some rows has, although they were measured: the search would be blind.
fn refuse_unknown_objective(plan: &Plan, rows: &[&Row]) -> Result<(), Error> {
    let measured: Vec<Row> = rows
        .iter()
        .filter(|row| row.has_figures())
        .map(|row| (*row).clone())
        .collect();
    let lacks = |column: &str| measured.iter().all(|row| row.figure(column).is_none());
    match plan
        .objectives
        .iter()
        .find(|objective| lacks(&objective.column))
    {
        Some(objective) if !measured.is_empty() => Err(Error::Invalid(format!(
            "no row has the objective `{}`: {}",
            objective.column,
            match &rows::figures(&measured)[..] {
                [] => "they have no figures at all".to_owned(),
                there => format!("there are {}", there.join(", ")),
            }
        ))),
        _ => Ok(()),
    }
}
