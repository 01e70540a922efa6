//! Host time and error of every level, and trials of its intervals.

use super::host_time::HostTime;
use super::kept::{Kept, Sample};
use super::{Fidelity, FrameFigure, FrameQuantity, Prepared};
use crate::Error;
use crate::figure::{NameAndUnit, Quantity, Unit, name, name_and_unit};
use crate::survey::Estimate;
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::watch::Stage;
use srp_toolchain::envelope::Contents;

/// How frames are sampled for the table.
#[derive(Clone, Copy, Debug)]
pub struct TableOptions {
    /// Half the width that drawing may leave to the intervals of cycles, as a part of 1.
    pub error: f64,
    /// Seed of the sample of the table, and of the first trial.
    pub seed: u64,
    /// Samples of as many seeds: how often the intervals hold.
    pub trials: u64,
}

/// The table of a scene.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Table {
    /// The scene's name, which the envelope of a document has.
    #[serde(skip)]
    pub scene: String,
    /// How many triangles it has.
    pub triangles: usize,
    /// Width and height of the frame in pixels.
    pub size: (u32, u32),
    /// The machine's name, which the envelope has.
    #[serde(skip)]
    pub machine: String,
    /// The levels, from the cheapest.
    pub levels: Vec<Row>,
    /// Trials, if there were to be any.
    pub trials: Option<Trials>,
}

impl Contents for Table {
    const FORMAT: &'static str = "srp-fidelity";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp fidelity --json`";
}

/// A level.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Row {
    /// Its name.
    pub level: &'static str,
    /// Time of the host without reading the scene and compiling.
    #[serde(flatten)]
    pub took: HostTime,
    /// How much quicker than the top level.
    pub speed_up: f64,
    /// The part of the frame that was simulated cycle by cycle.
    pub measured: f64,
    /// Its figures.
    pub figures: Vec<Cell>,
}

/// A figure at a level.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Cell {
    /// The quantity that the figure measures.
    #[serde(flatten, serialize_with = "name_and_unit")]
    #[schemars(with = "NameAndUnit")]
    pub quantity: FrameQuantity,
    /// Its value.
    pub value: f64,
    /// Half its interval, if it was sampled.
    pub half_width: Option<f64>,
    /// Difference from the top level, relative to it; rates in % are subtracted.
    pub error: f64,
}

/// Samples of several seeds.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Trials {
    /// How many there were.
    pub trials: u64,
    /// Half the width that drawing might leave to intervals, as a part of 1.
    pub target: f64,
    /// Mean part of the tiles that was measured.
    pub measured: f64,
    /// Mean time of the host, with the first pass.
    #[serde(flatten)]
    pub took: HostTime,
    /// How much quicker than the top level they were on average.
    pub speed_up: f64,
    /// The figures.
    pub figures: Vec<TrialFigure>,
}

/// One figure in all trials.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TrialFigure {
    /// The quantity that the figure measures.
    #[serde(rename = "name", serialize_with = "name")]
    #[schemars(with = "String")]
    pub quantity: FrameQuantity,
    /// The part of the intervals that hold what the top level has.
    pub covered: f64,
    /// Mean of the errors' sizes.
    pub mean_error: f64,
    /// The largest of them.
    pub largest_error: f64,
    /// Mean of half the intervals, relative to what the top level has.
    pub mean_half_width: f64,
}

/// Runs a frame at every level, or finds what was run before.
///
/// # Errors
///
/// The frame was not finished, or the work was cancelled.
pub fn table(prepared: &Prepared<'_>, options: &TableOptions) -> Result<Table, Error> {
    let frame = prepared.frame;
    let kept = Kept::of(prepared);
    let truth = kept.level(Fidelity::CycleDram)?;
    let mut levels = Vec::new();
    for level in Fidelity::ALL {
        let row = |took: HostTime, measured: f64, figures: Vec<Cell>| Row {
            level: level.name(),
            took,
            speed_up: truth.took.seconds / took.seconds,
            measured,
            figures,
        };
        if level == Fidelity::Sampled {
            let sample = kept.sample(options.seed, options.error)?;
            let cells = cells(&estimates(prepared, &sample), &truth.values, true);
            levels.push(row(sample.took, sample.measured, cells));
            continue;
        }
        let all = FrameQuantity::all(&prepared.kernel_names());
        let all = all.into_iter().zip(truth.values.iter().copied());
        let (known, compared): (_, Vec<_>) = match level {
            Fidelity::Functional => (
                kept.untimed()?,
                all.filter(|(quantity, _)| quantity.is_count()).collect(),
            ),
            _ => (kept.level(level)?, all.collect()),
        };
        let (quantities, truth): (Vec<_>, Vec<_>) = compared.into_iter().unzip();
        let exact = |(quantity, &value)| FrameFigure {
            quantity,
            estimate: Estimate::exact(value),
        };
        let figures: Vec<FrameFigure> = quantities
            .into_iter()
            .zip(&known.values)
            .map(exact)
            .collect();
        let measured = f64::from(u8::from(level > Fidelity::Sampled));
        levels.push(row(known.took, measured, cells(&figures, &truth, false)));
    }
    let trials = match options.trials {
        0 => None,
        _ => Some(trials(&kept, options, &truth.values, truth.took.seconds)?),
    };
    Ok(Table {
        scene: frame.scene.name.clone(),
        triangles: frame.scene.triangles.len(),
        size: frame.size,
        machine: frame.arch.name.clone(),
        levels,
        trials,
    })
}

fn cells(figures: &[FrameFigure], truth: &[f64], intervals: bool) -> Vec<Cell> {
    let cell = |(figure, &truth): (&FrameFigure, &f64)| Cell {
        quantity: figure.quantity.clone(),
        value: figure.estimate.value,
        half_width: intervals.then_some(figure.estimate.half_width),
        error: error(&figure.quantity, figure.estimate.value, truth),
    };
    figures.iter().zip(truth).map(cell).collect()
}

/// The figures of a sample.
fn estimates(prepared: &Prepared<'_>, sample: &Sample) -> Vec<FrameFigure> {
    let with = |(quantity, &(value, half_width)): (FrameQuantity, &(f64, f64))| {
        let estimate = Estimate { value, half_width };
        FrameFigure { quantity, estimate }
    };
    let all = FrameQuantity::all(&prepared.kernel_names()).into_iter();
    all.zip(&sample.figures).map(with).collect()
}

/// How far a value is off: relative to the truth, or for rates the difference over 100 %.
fn error(quantity: &FrameQuantity, value: f64, truth: f64) -> f64 {
    let against = match quantity.unit() {
        Unit::Percent => 100.0,
        _ => truth,
    };
    match against == 0.0 {
        true => value - truth,
        false => (value - truth) / against,
    }
}

/// Samples with many seeds.
fn trials(
    kept: &Kept<'_>,
    options: &TableOptions,
    truth: &[f64],
    whole: f64,
) -> Result<Trials, Error> {
    let session = kept.prepared.session;
    let count = options.trials;
    let stage = Stage::of(session.watch, "trials", count);
    let mut figures: Vec<TrialFigure> = Vec::new();
    let mut measured = 0.0;
    let mut took = HostTime {
        seconds: 0.0,
        processor: Some(0.0),
    };
    for i in 0..count {
        let seed = options.seed.wrapping_add(i);
        let sample = kept.sample(seed, options.error)?;
        let trial = estimates(kept.prepared, &sample);
        measured += sample.measured / count as f64;
        took.seconds += sample.took.seconds / count as f64;
        let both = took.processor.zip(sample.took.processor);
        took.processor = both.map(|(sum, more)| sum + more / count as f64);
        if figures.is_empty() {
            let figure = |figure: &FrameFigure| TrialFigure {
                quantity: figure.quantity.clone(),
                covered: 0.0,
                mean_error: 0.0,
                largest_error: 0.0,
                mean_half_width: 0.0,
            };
            figures = trial.iter().map(figure).collect();
        }
        for ((sum, figure), &truth) in figures.iter_mut().zip(&trial).zip(truth) {
            let estimate = figure.estimate;
            let off = error(&figure.quantity, estimate.value, truth).abs();
            let width = error(&figure.quantity, truth + estimate.half_width, truth);
            sum.covered += f64::from(u8::from(estimate.covers(truth))) / count as f64;
            sum.mean_error += off / count as f64;
            sum.largest_error = sum.largest_error.max(off);
            sum.mean_half_width += width / count as f64;
        }
        stage.done(1);
        session.check()?;
    }
    Ok(Trials {
        trials: count,
        target: options.error,
        measured,
        took,
        speed_up: whole / took.seconds,
        figures,
    })
}
