//! The formats that there are, each with its schema.

use crate::failure::Failure;
use crate::{
    accuracy, area, cache, compile, dram, effects, paper, pixel, profile, render, run, sweep, tni,
    units,
};
use schemars::Schema;
use srp_studies::comparison::Comparison;
use srp_studies::hard_cases::{CaseList, Listing};
use srp_studies::loops::{Differences, Report};
use srp_studies::{fidelity, map, watertight};
use srp_toolchain::envelope::{Contents, schema};

/// A format.
struct Format {
    name: &'static str,
    schema: fn() -> Schema,
}

impl Format {
    const fn of<T: Contents>() -> Format {
        Format {
            name: T::FORMAT,
            schema: schema::<T>,
        }
    }
}

/// All formats, by name.
const FORMATS: &[Format] = &[
    Format::of::<srp_studies::accuracy::Report>(),
    Format::of::<area::Document>(),
    Format::of::<cache::Document>(),
    Format::of::<CaseList>(),
    Format::of::<compile::Seconds>(),
    Format::of::<Comparison>(),
    Format::of::<dram::Summary>(),
    Format::of::<effects::Report>(),
    Format::of::<fidelity::Table>(),
    Format::of::<render::Account<'static>>(),
    Format::of::<render::Figures>(),
    Format::of::<fidelity::sampled::Sampled>(),
    Format::of::<Listing>(),
    Format::of::<accuracy::Kernels<'static>>(),
    Format::of::<map::Table>(),
    Format::of::<paper::Document>(),
    Format::of::<accuracy::PixelDocument>(),
    Format::of::<pixel::HistoryDocument>(),
    Format::of::<profile::Document<'static>>(),
    Format::of::<tni::RayDocument>(),
    Format::of::<run::Registers>(),
    Format::of::<Report>(),
    Format::of::<Differences>(),
    Format::of::<run::Account>(),
    Format::of::<sweep::Report>(),
    Format::of::<tni::Document<'static>>(),
    Format::of::<tni::Counts>(),
    Format::of::<units::Report>(),
    Format::of::<watertight::Report>(),
];

/// The names of all formats.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().map(|format| format.name)
}

/// The text of the schema of a format, if there is one of this name.
pub(crate) fn schema_of(name: &str) -> Result<String, Failure> {
    let format = FORMATS.iter().find(|format| format.name == name);
    let format = format.ok_or_else(|| {
        let names: Vec<&str> = names().collect();
        Failure::Usage(format!(
            "no format is named `{name}`; there are {}",
            names.join(", ")
        ))
    })?;
    let text = serde_json::to_string_pretty(&(format.schema)()).map_err(Failure::message)?;
    Ok(text + "\n")
}
