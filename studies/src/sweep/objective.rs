//! What a sweep is to find: figures that are to be small, or large.

use super::measure::Measure;
use crate::Error;

/// A figure that points are compared by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Objective {
    /// The column of the figure.
    pub column: String,
    /// True when larger figures are better.
    pub largest: bool,
}

impl Objective {
    /// The objective of a column, in its usual direction.
    pub(super) fn of(column: &str) -> Objective {
        Objective {
            column: column.to_owned(),
            largest: Measure::is_better_larger(column),
        }
    }

    /// Those that are compared where a plan states none: of the usual columns the ones that are there.
    pub(super) fn usual(has: &dyn Fn(&str) -> bool) -> Vec<Objective> {
        let mut columns = vec!["cycles", "ii", "energy", "area", "psnr"];
        columns.retain(|column| has(column));
        // Where there are cycles, IIs are a reason for them and no aim of their own.
        if columns.contains(&"cycles") {
            columns.retain(|column| *column != "ii");
        }
        columns.into_iter().map(Objective::of).collect()
    }

    /// Reads `cycles`, `min:cycles` or `max:psnr`.
    fn parse(text: &str) -> Result<Objective, Error> {
        let objective = match text.split_once(':') {
            Some((way @ ("min" | "max"), column)) => Objective {
                column: column.to_owned(),
                largest: way == "max",
            },
            _ => Objective::of(text),
        };
        match Measure::of_column(&objective.column) {
            Some(_) => Ok(objective),
            None => Err(Error::Invalid(format!(
                "objective `{text}`: write a column, as cycles, min:area.srp or max:psnr: there are {} and ii.LOOP",
                Measure::COLUMNS.map(|(column, _)| column).join(", ")
            ))),
        }
    }

    /// Reads all objectives of a plan.
    ///
    /// # Errors
    ///
    /// No measure has such a column, or one column is named twice.
    pub(super) fn all(texts: &[String]) -> Result<Vec<Objective>, Error> {
        let mut all: Vec<Objective> = Vec::with_capacity(texts.len());
        for text in texts {
            let objective = Objective::parse(text)?;
            if all.iter().any(|o| o.column == objective.column) {
                return Err(Error::Invalid(format!(
                    "objective `{text}`: `{}` is an objective already",
                    objective.column
                )));
            }
            all.push(objective);
        }
        Ok(all)
    }

    /// The measure that has the figure.
    pub(super) fn measure(&self) -> Option<Measure> {
        Measure::of_column(&self.column)
    }

    /// A figure so that smaller ones are better.
    pub(super) fn cost(&self, figure: f64) -> f64 {
        match self.largest {
            true => -figure,
            false => figure,
        }
    }
}
