//! `srp effects`: which effects a scene calls for, why, and what they cost.

mod output;

use crate::cli::Effects as Args;
use crate::failure::Failure;
use crate::ready::more;
use crate::{document, files, interrupt, scenes, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_runtime::effect::{self, Effect, Effects};
use srp_runtime::scene::Scene;
use srp_studies::effects::{Cost, Costs, Measured, costs};
use srp_toolchain::envelope::{About, Contents};
use srp_toolchain::{Build, Frame, Ready};

/// The report on a scene.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Report {
    /// Its name, which the envelope has.
    #[serde(skip)]
    scene: String,
    /// Its triangles.
    triangles: usize,
    /// Key of the simulator that is built for what the scene calls for.
    key: String,
    /// Names of the effects that it is built for.
    built: Vec<&'static str>,
    /// Names of the effects of the kernels that `srp render --ready` takes; none if no kernels that do all of this are ready.
    ready: Option<Vec<&'static str>>,
    /// The same in a sentence.
    #[serde(skip)]
    readiness: String,
    /// All effects that there are.
    effects: Vec<Line>,
    /// Features of the scene that no effect supports.
    lacks: Vec<String>,
    /// Pixels of the frames that were measured.
    size: (u32, u32),
    /// Simulators by what they are built for, where they were measured.
    simulators: Vec<Measured>,
}

impl Contents for Report {
    const FORMAT: &'static str = "srp-effects";
    const VERSION: u32 = 2;
    const WRITTEN_BY: &'static str = "`srp effects --json`";
}

/// One effect.
#[derive(Serialize, JsonSchema)]
struct Line {
    /// Its name.
    effect: &'static str,
    /// What it does.
    what: &'static str,
    /// True if the scene calls for it.
    on: bool,
    /// True if the simulator is built for it.
    built: bool,
    /// The witness.
    why: String,
    /// Its cost in a frame, where that was measured.
    cost: Option<Cost>,
}

/// Runs `srp effects`.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(html) = &args.html {
        files::check_writable(html)?;
    }
    let session = &talk::session();
    let arch = args.frame.machine.read()?;
    let options = (args.frame).options(Some(&args.building), args.bvh, args.size)?;
    let mut of_scene = Build::of_scene(&options, &mut scenes::say, session)?;
    of_scene.1.effort = args.search.effort();
    let (scene, build, _) = &of_scene;
    let about = About::scene(&arch, scene);
    let built = build.effects;
    let nearest = build.nearest(&arch, session);
    let mut report = Report {
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        key: build.name(&arch),
        built: built.iter().map(Effect::name).collect(),
        ready: (nearest.as_ref())
            .map(|ready| ready.build.effects.iter().map(Effect::name).collect()),
        readiness: readiness(build, nearest.as_ref()),
        effects: lines(scene, built),
        lacks: (effect::unsupported(scene).iter())
            .map(ToString::to_string)
            .collect(),
        size: args.size,
        simulators: Vec::new(),
    };
    if !args.no_costs {
        // Only frames take a tree.
        let frame = Frame::of(arch, of_scene, &options, session);
        let measured = interrupt::looked_for(|| costs(&frame, args.engine, session));
        let Costs {
            effects,
            simulators,
        } = measured.map_err(|error| match Failure::from(error) {
            Failure::Message(text) => Failure::Message(format!("{text}; --no-costs builds none")),
            other => other,
        })?;
        for (line, cost) in report.effects.iter_mut().zip(effects) {
            line.cost = Some(cost);
        }
        report.simulators = simulators.into();
    }
    if let Some(html) = &args.html {
        files::write(html, output::page(&report).as_bytes())?;
        talk::say(html.display());
    }
    match args.json {
        true => talk::print(document::json(about, &report)?)?,
        false => talk::print(output::text(&report))?,
    }
    Ok(())
}

/// A sentence about the kernels that `srp render --ready` takes.
fn readiness(build: &Build, nearest: Option<&Ready>) -> String {
    match nearest {
        None => "No kernels that do all of this are ready: srp render --ready schedules those of all effects.".to_owned(),
        Some(ready) if ready.build == *build => "The kernels for it are ready.".to_owned(),
        Some(ready) => {
            let more = more(&ready.more, build.bounces, &ready.build);
            format!("srp render --ready takes kernels that are ready, with more than this: {more}.")
        }
    }
}

fn lines(scene: &Scene, built: Effects) -> Vec<Line> {
    let findings = effect::find(scene).into_iter();
    let line = |finding: effect::Finding| Line {
        effect: finding.effect.name(),
        what: finding.effect.entry().what,
        on: finding.on,
        built: built.contains(finding.effect),
        why: finding.why,
        cost: None,
    };
    findings.map(line).collect()
}
