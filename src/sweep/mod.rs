//! `srp sweep`: many machines measured, and their rows as a table, a text and a page.

mod page;
mod parallel;
mod search;
mod text;

use crate::cli::{self, SweepAction};
use crate::count::count;
use crate::failure::Failure;
use crate::{document, files, interrupt, sharing, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_studies::jobs::{Engine, Jobs};
use srp_studies::sweep::analysis::analyse;
use srp_studies::sweep::plan::Point;
use srp_studies::sweep::rows::csv;
use srp_studies::sweep::table::parquet;
use srp_studies::sweep::{
    self, Analysis, Folder, Known, Outcome, Plan, PlanFile, Progress, Row, Shard,
};
use srp_toolchain::Session;
use srp_toolchain::envelope::{About, Contents};
use std::path::Path;

/// Everything that is known of a sweep.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Report {
    /// The plan.
    plan: PlanFile,
    /// Rows that it has.
    planned: usize,
    /// Those that are known.
    rows: Vec<Row>,
    /// The findings.
    analyses: Vec<Analysis>,
    /// How far the search has come; null where points are not found by one.
    search: Option<Progress>,
}

impl Contents for Report {
    const FORMAT: &'static str = "srp-sweep";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp sweep --json` and `srp sweep report --json`";
}

impl Report {
    fn of(known: Known) -> Report {
        Report {
            analyses: analyse(&known.rows, &known.objectives),
            search: known.progress,
            plan: known.plan,
            planned: known.planned,
            rows: known.rows,
        }
    }

    fn show(&self, json: bool) -> Result<(), Failure> {
        let text = match json {
            true => document::json(About::default(), self)?,
            false => text::text(self),
        };
        Ok(talk::print(text)?)
    }
}

/// Runs `srp sweep`.
pub(crate) fn run(args: &cli::Sweep) -> Result<(), Failure> {
    match &args.action {
        None => sweep(args),
        Some(SweepAction::Report { folder, html, json }) => {
            if let Some(path) = html {
                files::check_writable(path)?;
            }
            let report = Report::of(Folder::at(folder).known()?);
            if let Some(path) = html {
                files::write(path, page::page(&report).as_bytes())?;
            }
            report.show(*json)
        }
        Some(SweepAction::Show {
            folder,
            point,
            output,
        }) => show(folder, *point, output),
    }
}

fn sweep(args: &cli::Sweep) -> Result<(), Failure> {
    sharing::check_build(args.build.as_deref())?;
    // Without a file, all of the plan is arguments.
    let plan = Plan::of(args.plan()?).map_err(|error| match args.plan {
        None => Failure::of_arguments(error),
        Some(_) => error.into(),
    })?;
    files::make_folder(&args.output)?;
    let folder = Folder::make(&args.output)?;
    let session = &Session {
        threads: cli::threads(args.threads),
        ..talk::session()
    };
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let run = || match Engine::parse(&args.engine) {
        None => sweep::run(&plan, &folder, shard, session),
        Some(engine) => {
            let jobs = Jobs {
                engine,
                count: args.jobs as usize,
                threads: args.threads.unwrap_or(1),
            };
            let program = std::env::current_exe().map_err(srp_studies::Error::invalid)?;
            sweep::jobs::run(&plan, &folder, &jobs, &program, session)
        }
    };
    let findings = interrupt::looked_for(run)?;
    if findings.reused > 0 {
        talk::say(format_args!(
            "{} known from an earlier run",
            count(findings.reused as u64, "row")
        ));
    }
    if shard != Shard::WHOLE {
        talk::say(format_args!(
            "{} of {} known; srp sweep report {} shows them",
            findings.rows.len(),
            count(findings.planned as u64, "row"),
            args.output.display()
        ));
        if plan.search.is_some() && findings.rows.len() < findings.planned {
            talk::say(
                "the search needs the rows of the other shards: when all have ended, the same commands go on",
            );
        }
        return interrupt::end_if_requested();
    }
    let known = folder.known()?;
    files::write(&folder.path("results.csv"), csv(&known.rows).as_bytes())?;
    files::write(&folder.path("results.parquet"), &parquet(&known)?)?;
    let report = Report::of(known);
    let html = folder.path("report.html");
    files::write(&html, page::page(&report).as_bytes())?;
    report.show(args.json)?;
    talk::say(html.display());
    interrupt::end_if_requested()?;
    let missing = report.planned - report.rows.len();
    if missing > 0 {
        return Err(Failure::message(format_args!(
            "{} missing; the same command goes on",
            match missing {
                1 => "1 row is".to_owned(),
                n => format!("{n} rows are"),
            }
        )));
    }
    let none = !report.rows.is_empty()
        && (report.rows.iter()).all(|row| !matches!(row.outcome, Outcome::Figures(_)));
    match none {
        true => Err(Failure::message("no point of the sweep has a figure")),
        false => Ok(()),
    }
}

/// Writes the machine file of a point, and says how to render with it.
fn show(path: &Path, number: usize, output: &Path) -> Result<(), Failure> {
    files::check_writable(output)?;
    let known = Folder::at(path).known()?;
    let row = known.rows.iter().find(|row| row.point == number);
    let row = row.ok_or_else(|| {
        Failure::message(format_args!(
            "{} has no row of the point {number}: it has {}",
            path.display(),
            count(known.rows.len() as u64, "row")
        ))
    })?;
    let plan = Plan::of(known.plan)?;
    let (_, text) = plan.text_of(&Point(row.settings.clone()))?;
    files::write(output, text.as_bytes())?;
    let machine = match output == Path::new("-") {
        true => "FILE.xml".to_owned(),
        false => output.display().to_string(),
    };
    for scene in scenes(&plan) {
        talk::say(command(&plan, row, &scene, &machine));
    }
    for program in &plan.file.programs {
        talk::say(format_args!(
            "srp run {program} --machine {machine}{}{}",
            effort(&plan, row),
            features(row)
        ));
    }
    Ok(())
}

fn scenes(plan: &Plan) -> Vec<String> {
    match plan.file.scenes.is_empty() && plan.file.programs.is_empty() {
        true => vec!["default".to_owned()],
        false => plan.file.scenes.clone(),
    }
}

/// The command that renders a scene as a row did.
fn command(plan: &Plan, row: &Row, scene: &str, machine: &str) -> String {
    let mut words = vec!["srp render".to_owned()];
    match scene.split_once('@') {
        Some((file, view)) => words.push(format!("{file} --cameras {view}")),
        None if scene == "default" => {}
        None => words.push(scene.to_owned()),
    }
    words.push(format!(
        "--machine {machine} --size {}x{}",
        plan.size.0, plan.size.1
    ));
    if let Some(kernels) = &plan.file.kernels {
        words.push(format!("--kernels {kernels}"));
    }
    let level = row
        .settings
        .get("fidelity")
        .map_or(plan.fidelity.name(), String::as_str);
    if level != "cycle+dram" {
        words.push(format!("--fidelity {level}"));
    }
    for (name, value) in &row.settings {
        match name.strip_prefix("form:") {
            Some(form) => words.push(format!("--form {form}={value}")),
            None if name == "bvh" => words.push(format!("--bvh {value}")),
            None => {}
        }
    }
    let effects: Vec<String> = (row.settings.iter())
        .filter_map(|(name, value)| {
            let sign = if is_on(value) { '+' } else { '-' };
            Some(format!("{sign}{}", name.strip_prefix("effect:")?))
        })
        .collect();
    if !effects.is_empty() {
        words.push(format!("--effects {}", effects.join(",")));
    }
    words.join(" ") + &effort(plan, row) + &features(row)
}

/// The flag of the row's effort, or the plan's, with a space before it; empty if it is the usual one.
fn effort(plan: &Plan, row: &Row) -> String {
    let of_plan = || plan.file.effort.map(|times| times.to_string());
    let times = row.settings.get("effort").cloned().or_else(of_plan);
    times.map_or(String::new(), |times| format!(" --effort {times}"))
}

fn is_on(value: &str) -> bool {
    matches!(value, "on" | "true" | "yes")
}

/// The permissions of the compiler that a row has.
fn features(row: &Row) -> String {
    let on = |(name, value): (&String, &String)| {
        let feature = name.strip_prefix("f:")?;
        let feature = match feature {
            "fp-contract" => "fp-contract=fast",
            feature => feature,
        };
        is_on(value).then(|| format!(" -f {feature}"))
    };
    row.settings.iter().filter_map(on).collect()
}
