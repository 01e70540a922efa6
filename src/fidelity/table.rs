//! `srp fidelity`: what every level costs in host time and is off by, and trials of its intervals.

use super::Shot;
use super::census::{Census, Kept};
use super::clock::Took;
use super::text;
use crate::cli::{self, FidelityTable, TableForm};
use crate::failure::Failure;
use crate::scenes;
use crate::talk::Progress;
use crate::{interrupt, talk};
use serde::Serialize;
use srp_studies::fidelity::Fidelity;
use srp_studies::fidelity::{FrameFigure, FrameQuantity};
use srp_studies::figure::{Quantity, Unit, name, name_and_unit};
use srp_studies::survey::Estimate;
use srp_toolchain::Engines;

/// The table of a scene.
#[derive(Debug, Serialize)]
pub(crate) struct Table {
    pub(crate) scene: String,
    pub(crate) triangles: usize,
    pub(crate) size: (u32, u32),
    pub(crate) machine: String,
    pub(crate) levels: Vec<Row>,
    pub(crate) trials: Option<Trials>,
}

/// A level.
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) level: &'static str,
    /// Time of the host without reading the scene and compiling.
    #[serde(flatten)]
    pub(crate) took: Took,
    /// How much quicker than the top level.
    pub(crate) speed_up: f64,
    /// The part of the frame that was simulated cycle by cycle.
    pub(crate) measured: f64,
    pub(crate) figures: Vec<Cell>,
}

/// A figure at a level.
#[derive(Debug, Serialize)]
pub(crate) struct Cell {
    #[serde(flatten, serialize_with = "name_and_unit")]
    pub(crate) quantity: FrameQuantity,
    pub(crate) value: f64,
    pub(crate) half_width: Option<f64>,
    /// Difference from the top level, relative to it; rates in % are subtracted.
    pub(crate) error: f64,
}

/// What became of trials.
#[derive(Debug, Serialize)]
pub(crate) struct Trials {
    pub(crate) trials: u64,
    pub(crate) target: f64,
    /// Mean part of the tiles that was measured.
    pub(crate) measured: f64,
    /// Mean time of the host, with the first pass, and how much quicker than the top level that is.
    #[serde(flatten)]
    pub(crate) took: Took,
    pub(crate) speed_up: f64,
    pub(crate) figures: Vec<TrialFigure>,
}

/// One figure in all trials.
#[derive(Debug, Serialize)]
pub(crate) struct TrialFigure {
    #[serde(rename = "name", serialize_with = "name")]
    pub(crate) quantity: FrameQuantity,
    /// The part of the intervals that hold what the top level has.
    pub(crate) covered: f64,
    pub(crate) mean_error: f64,
    pub(crate) largest_error: f64,
    pub(crate) mean_half_width: f64,
}

/// Runs `srp fidelity`.
pub(crate) fn run(args: &FidelityTable) -> Result<(), Failure> {
    let session = &talk::session();
    let frame = scenes::frame(&args.frame, None, args.bvh, args.size, session)?;
    let image = frame.image()?;
    let compiled = interrupt::looked_for(|| frame.build.compile(None, &frame.arch, session))?;
    interrupt::end_if_requested()?;
    let program = compiled.runnable()?;
    let engines = Engines::of(program, args.engine, session)?;
    let shot = Shot {
        scene: &frame.scene,
        camera: &frame.scene.camera,
        arch: &frame.arch,
        program,
        engines: &engines,
        image,
        effects: frame.build.effects,
        guard: frame.guard,
        size: args.size,
        threads: cli::threads(args.threads),
        recorded_hits: false,
    };
    let table = table(&shot, args)?;
    let text = match args.form {
        TableForm::Text => text::table(&table),
        TableForm::Markdown => text::markdown(&table),
        TableForm::Json => serde_json::to_string_pretty(&table).map_err(Failure::message)? + "\n",
    };
    Ok(talk::print(text)?)
}

fn table(shot: &Shot<'_>, args: &FidelityTable) -> Result<Table, Failure> {
    let mut census = Census::of(shot, &shot.scene.name);
    let truth = census.level(shot, Fidelity::CycleDram)?;
    let mut levels = Vec::new();
    for level in Fidelity::ALL {
        let row = |took: Took, measured: f64, figures: Vec<Cell>| Row {
            level: level.name(),
            took,
            speed_up: truth.took.seconds / took.seconds,
            measured,
            figures,
        };
        if level == Fidelity::Sampled {
            let kept = census.sample(shot, args.seed, args.error)?;
            let cells = cells(&estimates(shot, &kept), &truth.values, true);
            levels.push(row(kept.took, kept.measured, cells));
            continue;
        }
        let known = census.level(shot, level)?;
        let all = FrameQuantity::all(&shot.kernel_names());
        let exact = all
            .into_iter()
            .zip(&known.values)
            .map(|(quantity, &value)| {
                let estimate = Estimate::exact(value);
                FrameFigure { quantity, estimate }
            });
        let exact: Vec<FrameFigure> = exact.collect();
        let mut cells = cells(&exact, &truth.values, false);
        if level == Fidelity::Functional {
            cells.retain(|c| c.quantity.is_count());
        }
        let measured = f64::from(u8::from(level > Fidelity::Sampled));
        levels.push(row(known.took, measured, cells));
    }
    let trials = match args.trials {
        0 => None,
        n => Some(trials(
            shot,
            &mut census,
            args,
            n,
            &truth.values,
            truth.took.seconds,
        )?),
    };
    Ok(Table {
        scene: shot.scene.name.clone(),
        triangles: shot.scene.triangles.len(),
        size: shot.size,
        machine: shot.arch.name.clone(),
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
fn estimates(shot: &Shot<'_>, kept: &Kept) -> Vec<FrameFigure> {
    let with = |(quantity, &(value, half_width)): (FrameQuantity, &(f64, Option<f64>))| {
        let half_width = half_width.unwrap_or(f64::INFINITY);
        let estimate = Estimate { value, half_width };
        FrameFigure { quantity, estimate }
    };
    let all = FrameQuantity::all(&shot.kernel_names()).into_iter();
    all.zip(&kept.figures).map(with).collect()
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
    shot: &Shot<'_>,
    census: &mut Census,
    args: &FidelityTable,
    count: u64,
    truth: &[f64],
    whole: f64,
) -> Result<Trials, Failure> {
    let progress = Progress::steps("trials", count);
    let mut figures: Vec<TrialFigure> = Vec::new();
    let mut measured = 0.0;
    let mut took = Took {
        seconds: 0.0,
        processor: Some(0.0),
    };
    for i in 0..count {
        let seed = args.seed.wrapping_add(i);
        let kept = census.sample(shot, seed, args.error)?;
        let trial = estimates(shot, &kept);
        measured += kept.measured / count as f64;
        took.seconds += kept.took.seconds / count as f64;
        let both = took.processor.zip(kept.took.processor);
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
        progress.at(i + 1);
        interrupt::end_if_requested()?;
    }
    Ok(Trials {
        trials: count,
        target: args.error,
        measured,
        took,
        speed_up: whole / took.seconds,
        figures,
    })
}
