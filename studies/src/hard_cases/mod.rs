//! Cases that go wrong in float arithmetic, tried on the host, on the simulated SRP and in the T&I unit,
//! with each setting of precision that a machine has.
//!
//! The cases are data ([`catalogue`]). `driver.c` calls the functions of the kernels that they are about,
//! and an oracle of the tests computes every answer that the catalogue states again.

mod aimed;
mod call;
mod catalogue;
mod engine;
pub mod export;
mod functions;
mod judge;
pub(crate) mod meshes;
mod narrow;
mod operands;
#[cfg(test)]
mod oracle;
mod picture;
mod report;
mod settings;
pub(crate) mod shared;
mod surface;
mod unit;

pub use catalogue::{Case, Level, Oracle};
pub use judge::Verdict;
pub use report::{
    Allowance, Argument, CaseList, CaseResult, Column, ListedCase, Listing, Matrix, WrittenCase,
};
pub use settings::Setting;

use crate::Error;
use crate::functional::FunctionalError;
use crate::rays::kernel_ray;
use aimed::AimedRays;
use call::Calls;
use engine::{Host, Kernels, Srp};
use functions::Function;
use narrow::Narrow;
use operands::Recorder;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::{Approx, Arch, Precision};
use srp_archdesc::diagnostic::Source;
use srp_archdesc::format::Format;
use srp_archdesc::watch::Stage;
use srp_runtime::scene::Scene;
use srp_runtime::tni::arithmetic::{self, Prepared, Ray};
use srp_toolchain::cache::{Key, Kind};
use srp_toolchain::{BUILD_ID, Session};
use std::collections::{BTreeMap, BTreeSet};
use std::iter;
use std::path::Path;
use surface::Made;
use unit::{Mesh, Unit};

/// The cases whose identifiers begin with `prefix`, of some files in the form of the catalogue (`docs/hard-cases.md`),
/// or of the catalogue itself.
///
/// # Errors
///
/// A file is wrong, or there is no such case.
pub fn cases(files: Option<&[Source]>, prefix: &str) -> Result<Vec<Case>, Error> {
    let cases = match files {
        Some(files) => catalogue::read(files),
        None => catalogue::own(),
    };
    let cases = cases.map_err(srp_toolchain::Error::Messages)?;
    let chosen = |case: &Case| case.id.starts_with(prefix);
    let cases: Vec<Case> = cases.into_iter().filter(chosen).collect();
    match cases.is_empty() {
        true => Err(Error::invalid(
            "no case has an identifier that begins so: `srp hard-cases --list` lists them",
        )),
        false => Ok(cases),
    }
}

/// Tries the cases on a machine with all its settings; rays are aimed at a scene's own edges too. The kernels are
/// those that come along, or those of a folder.
///
/// # Errors
///
/// The folder cannot be read, the driver does not compile or does not end, or the work was cancelled.
pub fn run(
    arch: &Arch,
    cases: Vec<Case>,
    scene: &Scene,
    kernels: Option<&Path>,
    session: &Session<'_>,
) -> Result<Matrix, Error> {
    let folder = srp_toolchain::Kernels::of(kernels)?;
    let kernels = &Kernels::of(kernels)?;
    let settings = settings::of(arch);
    let trial = Trial {
        session,
        scene,
        folder,
        kernels,
        meshes: (cases.iter().map(|c| Mesh::of(meshes::of(c, scene)))).collect(),
        aimed: cases.iter().map(|c| aimed_of(c, scene)).collect(),
        cases: &cases,
    };
    let stage = Stage::of(session.watch, "trying", settings.len() as u64 + 1);
    let host = trial.on_host(&settings[0])?;
    stage.done(1);
    let about = trial.about(arch, scene)?;
    let key = |number: usize| {
        let key = Key::of(Kind::Trials).text("hard cases");
        Ok(key.bytes(about.digest()).value(&number).finish())
    };
    let try_all = |(): &mut (), number: usize| {
        let found = trial.in_setting(number, &settings[number])?;
        stage.done(1);
        Ok::<_, Error>(found)
    };
    let found = session.pieces(session.threads, settings.len(), key, || (), try_all)?;
    let found = found.ok_or_else(Error::cancelled)?;
    let mut verdicts = BTreeMap::new();
    let mut skipped = Vec::new();
    for (setting, found) in iter::once((0, host)).chain(found.into_iter().enumerate()) {
        skipped.extend(found.skipped);
        for (case, level, verdict) in found.verdicts {
            verdicts.insert((case, Column { level, setting }), verdict);
        }
    }
    let mut columns: Vec<Column> = verdicts.keys().map(|(_, column)| *column).collect();
    columns.sort();
    columns.dedup();
    Ok(Matrix {
        machine: arch.name.clone(),
        settings,
        columns,
        verdicts,
        skipped,
        cases,
    })
}

fn aimed_of(case: &Case, scene: &Scene) -> Option<AimedRays> {
    matches!(case.call.as_str(), "leaks" | "acne").then(|| AimedRays::of(case, scene))
}

struct Trial<'a> {
    cases: &'a [Case],
    meshes: Vec<Mesh>,
    aimed: Vec<Option<AimedRays>>,
    kernels: &'a Kernels,
    /// The same, as frames take them.
    folder: srp_toolchain::Kernels,
    /// The scene at hand.
    scene: &'a Scene,
    session: &'a Session<'a>,
}

/// The verdicts in one setting.
#[derive(Default, Serialize, Deserialize)]
struct Found {
    /// The case by its number, and where it was run.
    verdicts: Vec<(usize, Level, Verdict)>,
    /// Levels that could not be run, and why.
    skipped: Vec<String>,
}

/// The place of a case in the driver's calls.
enum Placed {
    /// One call.
    Call(usize),
    /// A call for each hit, with the triangle that was hit.
    Hits(Vec<(u32, usize)>),
}

impl Trial<'_> {
    /// Names all that verdicts depend on, but for the number of the setting.
    fn about(&self, arch: &Arch, scene: &Scene) -> Result<Key, Error> {
        let mut key = Key::of(Kind::Trials)
            .text(BUILD_ID)
            .value(arch)
            .value(scene);
        key = key.text(&export::text(self.cases));
        for source in self.kernels.all()? {
            key = key.text(&source.name).text(&source.text);
        }
        Ok(key.finish())
    }

    /// The verdicts in a setting, but for those of the host's compiler.
    fn in_setting(&self, number: usize, setting: &Setting) -> Result<Found, Error> {
        let mut found = Found::default();
        // An array alone runs no programs.
        let has_slots = (setting.arch.srp.fus.values()).any(|fu| fu.slot.is_some());
        if has_slots && (setting.changes_kernels || setting.changes_textures) {
            self.on_srp(number, setting, &mut found)?;
        }
        if setting.changes_tni {
            self.in_unit(number, setting, &mut found)?;
        }
        if has_slots && number == 0 {
            self.in_frames(setting, &mut found)?;
        }
        Ok(found)
    }

    /// Pictures of the machine as it is; those whose kernels it has no room for are left out.
    fn in_frames(&self, setting: &Setting, found: &mut Found) -> Result<(), Error> {
        for (i, case) in self.cases.iter().enumerate() {
            if case.call != "picture" {
                continue;
            }
            self.session.check()?;
            match picture::judge(case, setting, self.scene, &self.folder, self.session) {
                Ok(verdict) => {
                    let verdict = match (narrow_formats(&setting.arch), verdict) {
                        (Some(formats), Verdict::Wrong(what)) => Verdict::Unbounded(format!(
                            "{what}; sums and products of a frame in {formats}, of which `srp accuracy` compares pictures"
                        )),
                        (_, verdict) => verdict,
                    };
                    found.verdicts.push((i, Level::Frame, verdict));
                }
                Err(Error::Functional(FunctionalError::TooLarge(why))) => {
                    found.skipped.push(format!("frame: {}: {why}", case.id));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The calls of the cases of a level.
    fn calls(
        &self,
        level: Level,
        arch: &Arch,
        wanted: impl Fn(&Case) -> bool,
    ) -> Result<(Calls, Vec<(usize, Placed)>), Error> {
        let mut calls = Calls::new();
        let mut placed = Vec::new();
        for (i, case) in self.cases.iter().enumerate() {
            let Some(function) = function_of(case) else {
                continue;
            };
            if !case.levels.contains(&level) || !wanted(case) {
                continue;
            }
            let at = match (case.call.as_str(), &self.aimed[i]) {
                ("acne", Some(rays)) => rays
                    .add_hits(&mut calls, case, function, arch)
                    .map(Placed::Hits),
                ("surface", _) => surface::add(&mut calls, case, function, &self.meshes[i], arch)
                    .map(Placed::Call),
                ("box", _) => Ok(Placed::Call(
                    calls.add(function, &box_arguments(case, arch)),
                )),
                _ => Ok(Placed::Call(calls.add_case(case, function))),
            };
            let wrong = |e| Error::invalid(format_args!("{}: {e}", case.place));
            placed.push((i, at.map_err(wrong)?));
        }
        Ok((calls, placed))
    }

    fn on_host(&self, setting: &Setting) -> Result<Found, Error> {
        let mut found = Found::default();
        let arch = exact(&setting.arch);
        let wanted = |case: &Case| case.call != "acne";
        let (calls, placed) = self.calls(Level::Host, &arch, wanted)?;
        let Some(host) = Host::compile(self.kernels, self.session)? else {
            let note = "host: there is no C compiler `cc`";
            found.skipped.push(note.to_owned());
            return Ok(found);
        };
        let memory = calls.memory();
        if memory.len() > engine::HOST_MEMORY {
            return Err(Error::invalid(
                "the driver's memory does not hold the cases",
            ));
        }
        let results = calls.results(&host.run(&memory)?);
        let exact = Setting {
            arch,
            ..setting.clone()
        };
        for (case, at) in placed {
            let verdict = self.judge(case, &at, &results, &exact);
            found.verdicts.push((case, Level::Host, verdict));
        }
        Ok(found)
    }

    fn on_srp(&self, number: usize, setting: &Setting, found: &mut Found) -> Result<(), Error> {
        let textures = engine::has_textures(&setting.arch);
        if !textures && number == 0 {
            let note = "srp: no unit of the machine samples textures";
            found.skipped.push(note.to_owned());
        }
        let wanted = |case: &Case| match case.call.as_str() {
            "texture" => textures && (setting.changes_textures || setting.changes_kernels),
            _ => setting.changes_kernels,
        };
        let (calls, placed) = self.calls(Level::Srp, &setting.arch, wanted)?;
        if placed.is_empty() {
            return Ok(());
        }
        let srp = Srp::compile(self.kernels, &calls, &setting.arch, self.session)?;
        let results = calls.results(&srp.run(calls.memory(), self.session)?);
        let mut recorder: Option<Recorder> = None;
        let mut narrow: Option<Narrow> = None;
        for (case, at) in placed {
            let mut verdict = self.judge(case, &at, &results, setting);
            if let Verdict::Off { .. } = &verdict
                && let Some(call) = call_alone(&self.cases[case])
            {
                let compile = || Recorder::compile(self.kernels, &calls, &setting.arch);
                let recorder = filled(&mut recorder, compile)?;
                let setting = &Setting {
                    at_operands: Some(recorder.errors(&call)?),
                    ..setting.clone()
                };
                verdict = self.judge(case, &at, &results, setting);
            }
            if let Some(formats) = narrow_formats(&setting.arch)
                && let Verdict::Wrong(what) = verdict
            {
                let compile = || Narrow::compile(self.kernels, &calls, &setting.arch);
                verdict = match narrow_call(&self.cases[case]) {
                    // Boxes are widened by what products of the machine round.
                    None if self.cases[case].call == "box"
                        && has_range_of_single(&setting.arch) =>
                    {
                        Verdict::Wrong(what)
                    }
                    None => Verdict::Unbounded(format!(
                        "{what}; decided by what is computed in {formats}"
                    )),
                    Some(call) => match filled(&mut narrow, compile)?.most(&call) {
                        Err(why) => Verdict::Unbounded(format!("{what}; in {formats} {}", why.0)),
                        Ok(most) => {
                            let setting = &Setting {
                                narrow: Some(most),
                                ..setting.clone()
                            };
                            self.judge(case, &at, &results, setting)
                        }
                    },
                };
            }
            found.verdicts.push((case, Level::Srp, verdict));
        }
        Ok(())
    }

    /// Returns the verdict on a case from the driver's results.
    fn judge(&self, case: usize, at: &Placed, results: &[Vec<u32>], setting: &Setting) -> Verdict {
        let (i, case) = (case, &self.cases[case]);
        let call = match (at, &self.aimed[i]) {
            (Placed::Hits(hits), Some(rays)) => {
                return rays.judge_acne(&setting.arch, hits, results);
            }
            (Placed::Call(call), _) => &results[*call],
            (Placed::Hits(_), None) => return Verdict::Right,
        };
        allowing(case, |case| match case.call.as_str() {
            "box" => {
                let words = std::array::from_fn(|k| call[k]);
                judge_box(case, Ray::from_words(words))
            }
            "surface" => surface::judge(case, &setting.arch, &self.meshes[i], &Made::of(call)),
            "basis" => judge::basis(case, setting, call),
            "bytes" => judge::bytes(case, setting, call),
            _ => judge::numbers(case, setting, call),
        })
    }

    fn in_unit(&self, number: usize, setting: &Setting, found: &mut Found) -> Result<(), Error> {
        for i in 0..self.cases.len() {
            self.session.check()?;
            let case = &self.cases[i];
            if !case.levels.contains(&Level::Tni) {
                continue;
            }
            let verdict = match (case.call.as_str(), &self.aimed[i]) {
                ("ray", _) => allowing(case, |case| judge_ray(case, setting, &self.meshes[i])),
                ("leaks", Some(rays)) => match rays.leaks(case, setting) {
                    Some(verdict) => verdict,
                    None => continue,
                },
                ("box", _) if number == 0 => {
                    allowing(case, |case| judge_box(case, plain_ray(case)))
                }
                _ => continue,
            };
            found.verdicts.push((i, Level::Tni, verdict));
        }
        Ok(())
    }
}

/// The verdict on a case, whose other answers are right where they are allowed.
fn allowing(case: &Case, judge: impl Fn(&Case) -> Verdict) -> Verdict {
    match judge(case) {
        Verdict::Wrong(why) => {
            let found = case
                .others()
                .find(|other| !matches!(judge(other), Verdict::Wrong(_)));
            found.map_or(Verdict::Wrong(why), |other| {
                Verdict::Bounded(format!("{}, which is allowed", other.gives.join(" ")))
            })
        }
        verdict => verdict,
    }
}

/// The function of the driver that a case calls; boxes call the one that makes rays.
fn function_of(case: &Case) -> Option<&'static Function> {
    functions::find(match case.call.as_str() {
        "box" => "ray",
        "acne" => "surface",
        name => name,
    })
}

/// The names of the narrow formats that a machine computes in; `None` where it has none.
fn narrow_formats(arch: &Arch) -> Option<String> {
    let narrow = arch.precision.formats.all().into_iter();
    let names = narrow.filter(|f| *f != Format::SINGLE).map(Format::name);
    let names: BTreeSet<String> = names.collect();
    (!names.is_empty()).then(|| names.into_iter().collect::<Vec<_>>().join(", "))
}

/// True if a machine's formats have the exponents of binary32.
fn has_range_of_single(arch: &Arch) -> bool {
    let formats = arch.precision.formats.all();
    formats
        .iter()
        .all(|f| f.exponent == Format::SINGLE.exponent)
}

/// The call of a case whose answer is numbers, which may be off by what narrow formats round away.
fn narrow_call(case: &Case) -> Option<Calls> {
    if matches!(case.call.as_str(), "box" | "surface" | "acne" | "bytes") {
        return None;
    }
    let mut calls = Calls::new();
    calls.add_case(case, function_of(case)?);
    Some(calls)
}

/// The value in a place, made where there is none yet.
fn filled<T, E>(place: &mut Option<T>, make: impl FnOnce() -> Result<T, E>) -> Result<&mut T, E> {
    match place {
        Some(there) => Ok(there),
        none => Ok(none.insert(make()?)),
    }
}

/// The call of a case whose answer is numbers that units of the SRP take part in.
fn call_alone(case: &Case) -> Option<Calls> {
    if matches!(case.call.as_str(), "box" | "surface" | "acne") || case.costs.is_empty() {
        return None;
    }
    let mut calls = Calls::new();
    calls.add_case(case, function_of(case)?);
    Some(calls)
}

/// The machine with exact functions, as those of the host are.
fn exact(arch: &Arch) -> Arch {
    let mut arch = arch.clone();
    arch.precision = Precision::EXACT;
    arch.system.tni.rcp = Approx::Exact;
    arch
}

/// Origin with the machine's widening, and direction.
fn box_arguments(case: &Case, arch: &Arch) -> [[u32; 4]; 2] {
    let [x, y, z] = case.words("from");
    let widening = arch.precision.widening();
    let [dx, dy, dz] = case.words("along");
    [[x, y, z, widening.to_bits()], [dx, dy, dz, 0]]
}

/// The ray of a case, with exact reciprocals; `range` is its ends, from 0 to the largest number where
/// it has none.
fn plain_ray(case: &Case) -> Ray {
    let (tmin, tmax) = ends(case);
    Ray::new(case.floats("from"), case.floats("along"), tmin, tmax, 0)
}

fn ends(case: &Case) -> (f32, f32) {
    let [tmin, tmax] = match case.argument("range") {
        Some(_) => case.floats("range"),
        None => [0.0, f32::MAX],
    };
    (tmin, tmax)
}

fn judge_box(case: &Case, ray: Ray) -> Verdict {
    let (tmin, tmax) = ends(case);
    let ray = Ray { tmin, tmax, ..ray };
    let (low, high) = (case.floats("low"), case.floats("high"));
    let meets = |p: Prepared| p.meets(&low, &high, tmax).is_some();
    let met = Prepared::of(&ray).is_some_and(meets);
    match (met, case.gives("hit")) {
        (a, b) if a == b => Verdict::Right,
        (true, false) if case.gives("pass") => {
            Verdict::Bounded("a hit where there is none costs a visit".to_owned())
        }
        (true, false) => Verdict::Wrong("a hit".to_owned()),
        _ => Verdict::Wrong("a miss".to_owned()),
    }
}

/// The unit's function, and the unit cycle by cycle.
fn judge_ray(case: &Case, setting: &Setting, mesh: &Mesh) -> Verdict {
    let (tmin, tmax) = ends(case);
    let flags = case.argument("any").map_or(0, |_| arithmetic::ANY_HIT);
    let made = kernel_ray(
        &setting.arch.precision,
        case.floats("from"),
        case.floats("along"),
        tmax,
    );
    let ray = Ray {
        tmin,
        flags,
        ..made
    };
    let unit = Unit::of(&setting.arch, mesh);
    let found = unit.tracer().trace(&ray).hit;
    let timed = unit.answer(&ray);
    match timed {
        Some(timed) if timed == found => judge::hit(case, setting, Some(found)),
        other => Verdict::Wrong(format!("{found:?}, but cycle by cycle {other:?}")),
    }
}
