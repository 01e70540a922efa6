//! The subjects that a sweep measures machines on: scenes and programs.

use super::plan::{Choices, Plan};
use crate::Error;
use crate::reference;
use glam::DVec3;
use srp_archdesc::Watch;
use srp_archdesc::arch::Arch;
use srp_archdesc::watch::Event;
use srp_runtime::bvh::{self, Builder, Bvh};
use srp_runtime::effect::Guard;
use srp_runtime::scene::{Camera, Scene};
use srp_toolchain::cache::{Key, Kind};
use srp_toolchain::scene::Views;
use srp_toolchain::{Build, Frame, FrameOptions, Session, files, scene};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A scene or a program.
pub(super) struct Subject {
    /// Its name in the plan, without folders.
    pub name: String,
    /// Names all of its contents.
    pub(super) digest: String,
    pub(super) kind: SubjectKind,
}

/// The two kinds of subject.
pub(super) enum SubjectKind {
    /// A scene, which is rendered.
    Scene(Box<Stage>),
    /// A C file, which is run.
    Program(PathBuf),
}

/// A scene that was read, with what is made of it once for all points.
pub(super) struct Stage {
    scene: Scene,
    build: Build,
    guard: Guard,
    size: (u32, u32),
    trees: Mutex<BTreeMap<&'static str, Arc<Bvh>>>,
    reference: Mutex<Option<Arc<[DVec3]>>>,
}

impl Subject {
    /// The subjects of a plan; the default scene where it names none.
    pub(super) fn all(plan: &Plan, session: &Session<'_>) -> Result<Vec<Subject>, Error> {
        let file = &plan.file;
        let default = ["default".to_owned()];
        let scenes = match file.scenes.is_empty() && file.programs.is_empty() {
            true => &default[..],
            false => &file.scenes,
        };
        let scenes = scenes
            .iter()
            .map(|name| Subject::scene(name, plan, session));
        let programs = file.programs.iter().map(|path| Subject::program(path));
        scenes.chain(programs).collect()
    }

    fn scene(name: &str, plan: &Plan, session: &Session<'_>) -> Result<Subject, Error> {
        let (path, view) = match name.split_once('@') {
            Some((path, view)) => (path, Some(view)),
            None => (name, None),
        };
        let camera = view.map(camera).transpose()?;
        let options = FrameOptions {
            scene: (path != "default").then(|| PathBuf::from(path)),
            camera,
            size: plan.size,
            kernels: plan.file.kernels.as_ref().map(PathBuf::from),
            ..FrameOptions::default()
        };
        let mut told = |loaded: &scene::Loaded| {
            let doubts = loaded.warnings.render(false);
            let unsupported = loaded
                .unsupported
                .iter()
                .map(|what| format!("warning: {what}"));
            let doubts = doubts.lines().map(str::to_owned).chain(unsupported);
            doubts.for_each(|line| session.watch.tell(Event::Note(&line)));
        };
        let (scene, build, guard) = Build::of_scene(&options, &mut told, session)?;
        let digest = Key::of(Kind::Trials).value(&scene).finish().to_string();
        let view = view.map(|v| format!("@{}", last(v))).unwrap_or_default();
        Ok(Subject {
            name: format!("{}{view}", last(path)),
            digest,
            kind: SubjectKind::Scene(Box::new(Stage {
                scene,
                build,
                guard,
                size: plan.size,
                trees: Mutex::default(),
                reference: Mutex::default(),
            })),
        })
    }

    /// Names the kernels that render it by their contents; empty of those that come along, and of programs.
    pub(super) fn kernels(&self) -> &str {
        match &self.kind {
            SubjectKind::Scene(stage) => stage.build.kernels.digest(),
            SubjectKind::Program(_) => "",
        }
    }

    fn program(path: &str) -> Result<Subject, Error> {
        let path = PathBuf::from(path);
        Ok(Subject {
            name: last(&path.display().to_string()).to_owned(),
            digest: digest_of_sources(std::slice::from_ref(&path))?,
            kind: SubjectKind::Program(path),
        })
    }
}

/// A digest over C files and all headers beside them.
fn digest_of_sources(paths: &[PathBuf]) -> Result<String, Error> {
    let mut all: Vec<PathBuf> = paths.to_vec();
    for path in paths {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        let entries = std::fs::read_dir(folder.unwrap_or(Path::new(".")));
        let files = entries.into_iter().flatten().flatten().map(|e| e.path());
        all.extend(files.filter(|f| f.extension().is_some_and(|e| e == "h")));
    }
    all.sort();
    all.dedup();
    let mut key = Key::of(Kind::Trials);
    for path in all {
        key = key.text(
            &files::read_text(&path, files::Kind::Source).map_err(srp_toolchain::Error::from)?,
        );
    }
    Ok(key.finish().to_string())
}

/// A path without its folders.
fn last(path: &str) -> &str {
    path.rsplit_once('/').map_or(path, |(folders, name)| {
        // A view is FILE:NAME/N, of which the name belongs to the number.
        match name.parse::<usize>() {
            Ok(_) => folders
                .rsplit_once('/')
                .map_or(path, |(f, _)| &path[f.len() + 1..]),
            Err(_) => name,
        }
    })
}

/// The view `FILE.json:NAME/N`.
fn camera(view: &str) -> Result<Camera, Error> {
    let parts = view.rsplit_once(':').and_then(|(path, which)| {
        let (name, number) = which.rsplit_once('/')?;
        Some((path, name, number.parse().ok()?))
    });
    let (path, name, number) = parts.ok_or_else(|| {
        Error::Invalid(format!(
            "`{view}` is no view: write SCENE@CAMERAS.json:NAME/N"
        ))
    })?;
    Ok(Views::read(Path::new(path), name)?.camera(number)?)
}

impl Stage {
    /// The frame of a machine and its choices.
    ///
    /// # Errors
    ///
    /// There is no effect of a name.
    pub(super) fn frame(
        &self,
        arch: Arch,
        choices: &Choices,
        session: &Session<'_>,
    ) -> Result<Frame, Error> {
        let effects = match choices.effects.is_empty() {
            true => self.build.effects,
            false => {
                let changed = self.build.effects.parse(&choices.effects);
                changed.map_err(srp_toolchain::Error::from)?.0
            }
        };
        Ok(Frame {
            arch,
            scene: self.scene.clone(),
            bvh: self.tree(choices.tree, session).as_ref().clone(),
            size: self.size,
            build: Build {
                forms: choices.forms,
                fast_math: choices.fast_math,
                prefetch: choices.prefetch,
                effort: choices.effort,
                effects,
                ..self.build.clone()
            },
            guard: self.guard.clone(),
        })
    }

    /// The tree, which the first to ask builds.
    fn tree(&self, builder: Builder, session: &Session<'_>) -> Arc<Bvh> {
        let mut trees = self.trees.lock().unwrap_or_else(PoisonError::into_inner);
        let tree = trees.entry(builder.name()).or_insert_with(|| {
            let options = bvh::Options {
                builder,
                ..bvh::Options::default()
            };
            Arc::new(scene::build(&self.scene, &options, session))
        });
        tree.clone()
    }

    /// The picture in binary64, which the first to ask renders. `None` where that was cancelled.
    pub(super) fn reference(&self, packet: u32, watch: &dyn Watch) -> Option<Arc<[DVec3]>> {
        let mut known = self
            .reference
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if known.is_none() {
            let options = reference::Options {
                size: self.size,
                packet,
                threads: 1,
                watch,
            };
            *known = reference::picture(&self.scene, &options).map(Arc::from);
        }
        known.clone()
    }
}
