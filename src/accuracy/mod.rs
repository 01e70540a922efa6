//! `srp accuracy`: what accuracy costs in time, and what it buys.
//!
//! A frame is rendered under many settings of machine, compiler and kernels, one knob at a time, each
//! really compiled, scheduled and simulated; every picture is held against a renderer in binary64.
//! Then settings that keep to the target are put together as long as they keep to it together.

mod blame;
mod compare;
mod explain;
mod flip;
mod page;
mod probe;
mod setting;
mod store;
mod target;
mod text;
mod trial;

pub(crate) use target::Target;

use crate::cli::Accuracy as Args;
use crate::failure::Failure;
use crate::scenes;
use crate::talk::CONSOLE;
use crate::talk::Progress;
use crate::{files, interrupt, talk};
use blame::Blame;
use compare::Comparison;
use glam::DVec3;
use probe::Edges;
use serde::Serialize;
use setting::{Setting, Subject};
use srp_archdesc::threads;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image;
use srp_studies::reference;
use srp_toolchain::{Frame, Session};

use std::sync::atomic::{AtomicU64, Ordering};
use store::Store;
use trial::{Studio, Trial, UnitError};

/// Most settings that are put together.
const MOST_TOGETHER: usize = 6;

/// Of so many tiles one is looked into for what its errors come from; all, of the machine as it is.
const ONE_IN: u32 = 8;

/// Knobs that change what is computed, not how exactly: their pictures are held against one with
/// the most of both.
const SAMPLING: [&str; 2] = ["samples a pixel", "bounces"];

fn is_sampling(knob: &str) -> bool {
    SAMPLING.contains(&knob)
}

/// What there is to say of a scene.
#[derive(Serialize)]
struct Report {
    scene: String,
    triangles: usize,
    machine: String,
    size: (u32, u32),
    target: Target,
    /// The machine as it is, then every setting, then settings together.
    trials: Vec<Trial>,
    /// Numbers of the trials that no other beats in picture and cycles.
    front: Vec<usize>,
    /// The number of the cheapest trial that keeps to the target.
    cheapest: Option<usize>,
    /// What each knob does, in words.
    sentences: Vec<String>,
    /// Whether all settings were tried.
    complete: bool,
}

/// Runs `srp accuracy`.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let session = &talk::session();
    let building = Some(&args.building);
    let frame = scenes::frame(&args.frame, building, args.bvh, args.size, session)?;
    let base = Subject {
        build: frame.build.clone(),
        options: frame.scene.options,
        arch: frame.arch.clone(),
    };
    let studio = studio(&frame, session)?;
    if let Some(pixel) = args.pixel {
        return explain::run(&studio, &base, args, pixel);
    }
    let settings = chosen(&args.knob, &base)?;
    let store = Store::open(&args.output, &base, &frame.scene, args.size)?;
    let bench = Bench::of(studio, &base, args)?;
    let mut report = interrupt::looked_for(|| bench.tried(settings, &store, args))?;
    report.finish();
    files::write(
        &store.path("report.html"),
        page::page(&report, &store).as_bytes(),
    )?;
    let json = serde_json::to_string_pretty(&report).map_err(Failure::message)? + "\n";
    files::write(&store.path("report.json"), json.as_bytes())?;
    talk::print(if args.json { json } else { text::text(&report) })?;
    talk::say(store.path("report.html").display());
    match report.complete {
        true => Ok(()),
        false => Err(Failure::Interrupted),
    }
}

/// The settings of the knobs that are asked for, without those that change nothing.
fn chosen(knobs: &[String], base: &Subject) -> Result<Vec<Setting>, Failure> {
    let all = setting::all();
    let mut names: Vec<&str> = all.iter().map(|s| s.knob.as_str()).collect();
    names.dedup();
    if let Some(unknown) = knobs.iter().find(|k| !names.contains(&k.as_str())) {
        let names = names.join(", ");
        return Err(Failure::Message(format!(
            "there is no knob `{unknown}`; there are: {names}"
        )));
    }
    let wanted = |s: &Setting| knobs.is_empty() || knobs.contains(&s.knob);
    let changes = |s: &Setting| is_sampling(&s.knob) || s.applied(base) != *base;
    Ok(all
        .into_iter()
        .filter(|s| wanted(s) && changes(s))
        .collect())
}

/// What all frames of a scene share. The error is why there is none of this size, before anything is
/// compiled or rendered for it.
fn studio<'a>(frame: &'a Frame, session: &'a Session<'a>) -> Result<Studio<'a>, Failure> {
    let (scene, bvh) = (&frame.scene, &frame.bvh);
    scene_image::check(scene, bvh, &frame.arch, frame.size).map_err(Failure::message)?;
    Ok(Studio {
        bvh,
        edges: Edges::of(scene),
        scene,
        size: frame.size,
        session,
    })
}

/// A scene on the bench: what all trials share, and what they are held against.
struct Bench<'a> {
    studio: Studio<'a>,
    base: &'a Subject,
    /// With the options of the base, and with the most samples and bounces that are tried.
    plain: Vec<DVec3>,
    finest: Vec<DVec3>,
}

impl<'a> Bench<'a> {
    fn of(studio: Studio<'a>, base: &'a Subject, args: &Args) -> Result<Bench<'a>, Failure> {
        let scene = studio.scene;
        let spinner = Progress::spinner("rendering in binary64");
        let finest = setting::finest(base);
        let plain = reference(scene, base, args)?;
        let finest = match finest.options == base.options {
            true => plain.clone(),
            false => reference(scene, &finest, args)?,
        };
        drop(spinner);
        Ok(Bench {
            studio,
            base,
            plain,
            finest,
        })
    }

    /// Tries the base, every setting, and settings together.
    fn tried(&self, settings: Vec<Setting>, store: &Store, args: &Args) -> Result<Report, Failure> {
        let mut all = vec![Setting::none()];
        all.extend(settings);
        let progress = Progress::steps("trying", all.len() as u64);
        let found = self.all(&all, store, args.threads, &progress);
        let mut trials = Vec::new();
        let mut used = Vec::new();
        for (setting, trial) in all.into_iter().zip(found) {
            if let Some(trial) = trial? {
                trials.push(trial);
                used.push(setting);
            }
        }
        let mut report = Report {
            scene: self.studio.scene.name.clone(),
            triangles: self.studio.scene.triangles.len(),
            machine: self.base.arch.name.clone(),
            size: args.size,
            target: args.target.clone(),
            complete: !interrupt::requested() && !trials.is_empty(),
            trials,
            front: Vec::new(),
            cheapest: None,
            sentences: Vec::new(),
        };
        self.together(&mut report, &used, store)?;
        Ok(report)
    }

    /// Each setting's trial; none where it was interrupted before.
    fn all(
        &self,
        settings: &[Setting],
        store: &Store,
        threads: usize,
        progress: &Progress,
    ) -> Vec<Result<Option<Trial>, Failure>> {
        let done = AtomicU64::new(0);
        let trial = |(): &mut (), i: usize| {
            let trial = match interrupt::requested() {
                true => Ok(None),
                false => match self.trial(&settings[i], store) {
                    Err(Failure::Interrupted) => Ok(None),
                    trial => trial.map(Some),
                },
            };
            progress.at(done.fetch_add(1, Ordering::Relaxed) + 1);
            Some(trial)
        };
        let all = threads::some(threads, settings.len(), || (), trial);
        all.into_iter().flatten().collect()
    }

    /// The trial of a setting, from the store where it has been made before.
    fn trial(&self, setting: &Setting, store: &Store) -> Result<Trial, Failure> {
        if let Some(trial) = store.kept(setting) {
            return Ok(trial);
        }
        let subject = setting.applied(self.base);
        let frame = self.studio.frame(&subject)?;
        let one_in = if setting.knob.is_empty() { 1 } else { ONE_IN };
        let reference = match is_sampling(&setting.knob) {
            true => &self.finest,
            false => &self.plain,
        };
        let comparison = Comparison::of(&frame.picture, reference);
        let trial = Trial {
            knob: setting.knob.clone(),
            value: setting.value.clone(),
            how: setting.how.clone(),
            blame: Blame::of(&self.studio, &subject, one_in)?,
            unit: UnitError::of(&setting.units),
            ..Trial::of(&frame, &comparison)
        };
        store.keep(setting, &trial, &frame.picture, &comparison.levels)?;
        Ok(trial)
    }

    /// Adds settings together, the one that saves most first, as long as the target is kept to.
    fn together(
        &self,
        report: &mut Report,
        settings: &[Setting],
        store: &Store,
    ) -> Result<(), Failure> {
        let Some(base) = report.trials.first().cloned() else {
            return Ok(());
        };
        let cost = |t: &Trial| target::relative_cost(t, &base);
        let mut order: Vec<usize> = (1..report.trials.len())
            .filter(|&i| {
                let trial = &report.trials[i];
                !is_sampling(&trial.knob) && cost(trial) < 1.0 && report.target.met_by(trial)
            })
            .collect();
        order.sort_by(|&a, &b| cost(&report.trials[a]).total_cmp(&cost(&report.trials[b])));
        let mut chosen: Vec<usize> = Vec::new();
        let mut tries = 0;
        for i in order {
            let knob = &report.trials[i].knob;
            if chosen.iter().any(|&c| report.trials[c].knob == *knob) || tries == MOST_TOGETHER {
                continue;
            }
            let mut with = chosen.clone();
            with.push(i);
            if with.len() > 1 {
                if interrupt::requested() {
                    return Ok(());
                }
                tries += 1;
                let parts: Vec<&Setting> = with.iter().map(|&i| &settings[i]).collect();
                let trial = match self.trial(&Setting::together(&parts), store) {
                    Err(Failure::Interrupted) => return Ok(()),
                    trial => trial?,
                };
                let keeps = report.target.met_by(&trial);
                report.trials.push(trial);
                if !keeps {
                    continue;
                }
            }
            chosen = with;
        }
        Ok(())
    }
}

/// The picture in binary64 with the options of a subject.
fn reference(scene: &Scene, subject: &Subject, args: &Args) -> Result<Vec<DVec3>, Failure> {
    let scene = Scene {
        options: subject.options,
        ..scene.clone()
    };
    let options = reference::Options {
        size: args.size,
        packet: subject.arch.system.buffers.rays,
        threads: args.threads,
        watch: &CONSOLE,
    };
    let picture = interrupt::looked_for(|| reference::picture(&scene, &options));
    picture.ok_or(Failure::Interrupted)
}

impl Report {
    /// Draws the conclusions.
    fn finish(&mut self) {
        let Some(first) = self.trials.first() else {
            return;
        };
        self.front = target::front(&self.trials, |t| t.costs.frame_cycles as f64);
        let cost = |i: &usize| target::relative_cost(&self.trials[*i], first);
        self.cheapest = (0..self.trials.len())
            .filter(|&i| !is_sampling(&self.trials[i].knob) && self.target.met_by(&self.trials[i]))
            .min_by(|a, b| cost(a).total_cmp(&cost(b)));
        self.sentences = (self.trials[1..].iter())
            .map(|trial| text::sentence(trial, first))
            .collect();
    }
}
