//! All that is known of a sweep as one table in columns: settings, figures, and where each row comes from.

use super::columnar::{self, Cells, Column};
use super::known::Known;
use super::rows::{self, Outcome, Row};
use crate::Error;

/// The table as a Parquet file: a row for every point and subject. Settings are numbers where all values of a parameter
/// are. Other than the table of [`rows::csv`], it has the hosts and seconds of rows, so no two runs give the same file.
///
/// # Errors
///
/// The plan has an objective, a size or a way of sampling that does not exist.
pub fn parquet(known: &Known) -> Result<Vec<u8>, Error> {
    let rows = &known.rows;
    let plan = &known.plan;
    let mut columns = vec![
        whole("point", rows, |row| Some(row.point)),
        text("subject", rows, |row| Some(row.subject.clone())),
    ];
    let settings = rows::settings(rows);
    columns.extend(settings.iter().map(|name| {
        let values = rows.iter().map(|row| row.settings.get(name).cloned());
        Column {
            name: name.clone(),
            cells: Cells::of_texts(values.collect()),
        }
    }));
    let figures = rows::figures(rows);
    columns.extend(
        figures
            .iter()
            .map(|name| number(name, rows, |row| row.figure(name))),
    );
    columns.push(text("outcome", rows, |row| Some(outcome(row).0.to_owned())));
    columns.push(text("error", rows, |row| outcome(row).1.map(str::to_owned)));
    if let Some(search) = plan.search()? {
        columns.push(whole("generation", rows, |row| {
            Some(row.point / search.generation())
        }));
    }
    // Where these are varied, they are settings.
    let is_set = |name: &str| settings.iter().any(|setting| setting == name);
    if !is_set("machine") {
        let machine = plan.machine.as_deref().unwrap_or("sgrt");
        columns.push(text("machine", rows, |_| Some(machine.to_owned())));
    }
    if !is_set("effort") {
        columns.push(number("effort", rows, |_| Some(plan.effort.unwrap_or(1.0))));
    }
    if !is_set("fidelity") {
        columns.push(text("fidelity", rows, |_| Some(plan.level().to_owned())));
    }
    let (width, height) = plan.sides()?;
    columns.extend([
        text("machine_hash", rows, |row| there(&row.machine)),
        text("subject_hash", rows, |row| there(&row.subject_hash)),
        text("kernels_hash", rows, |row| there(&row.kernels_hash)),
        whole("width", rows, |_| usize::try_from(width).ok()),
        whole("height", rows, |_| usize::try_from(height).ok()),
        text("build", rows, |row| there(&row.build)),
        text("host", rows, |row| there(&row.host)),
        number("seconds", rows, |row| Some(row.seconds)),
        text("key", rows, |row| there(&row.key)),
    ]);
    columnar::file(&columns).map_err(Error::invalid)
}

/// The outcome of a row in a word, and why it is no other.
fn outcome(row: &Row) -> (&'static str, Option<&str>) {
    match &row.outcome {
        Outcome::Figures(_) => ("figures", None),
        Outcome::Invalid(why) => ("invalid", Some(why)),
        Outcome::Failed(why) => ("failed", Some(why)),
    }
}

fn there(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

fn whole(name: &str, rows: &[Row], of: impl Fn(&Row) -> Option<usize>) -> Column {
    let cell = |row: &Row| of(row).and_then(|n| i64::try_from(n).ok());
    Column {
        name: name.to_owned(),
        cells: Cells::Whole(rows.iter().map(cell).collect()),
    }
}

fn number(name: &str, rows: &[Row], of: impl Fn(&Row) -> Option<f64>) -> Column {
    Column {
        name: name.to_owned(),
        cells: Cells::Number(rows.iter().map(of).collect()),
    }
}

fn text(name: &str, rows: &[Row], of: impl Fn(&Row) -> Option<String>) -> Column {
    Column {
        name: name.to_owned(),
        cells: Cells::Text(rows.iter().map(of).collect()),
    }
}
