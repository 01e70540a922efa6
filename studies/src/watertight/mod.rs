//! Rays that a mesh loses between its triangles, and rays that hit what they pass by, with every triangle test.
//!
//! A test that is careful about the one is often careless about the other: an epsilon that closes every edge makes
//! triangles larger than they are. So both are counted, over the same rays, at meshes that are hard: needles and slivers,
//! far from the origin, very small, very large. Whether a ray meets a mesh is decided by [`exact`](crate::exact)
//! arithmetic, and by nothing else: so answers of other ray tracers can be held beside ours.

mod aim;
mod mesh;
mod oracle;

use crate::Error;
use crate::survey::Random;
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::area;
use srp_archdesc::datapath::{Intersection, Operations};
use srp_archdesc::system::{SystemSpec, TniSpec};
use srp_archdesc::watch::Stage;
use srp_runtime::bvh::{self, Bvh, Layout};
use srp_runtime::tni::{Tracer, place_for};
use srp_toolchain::Session;
use srp_toolchain::envelope::Contents;
use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

pub use aim::{APART, Aim};
use aim::{Shot, Target};
pub use mesh::Mesh;

/// Most rays of each mesh and aim.
pub const MOST_RAYS: u32 = 1_000_000;

/// How many rays are shot, and which.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Rays of each mesh and aim.
    pub rays: u32,
    /// The seed that they are drawn by.
    pub seed: u64,
}

/// Answers of another ray tracer to exported rays.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Its name.
    pub name: String,
    /// By mesh, in the order of its rays: whether each hits.
    pub hits: Vec<Vec<bool>>,
}

/// Lost rays and false hits of each test.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// The triangle tests of the T&I unit, the machine's own first.
    pub tests: Vec<Test>,
    /// Other ray tracers, whose answers were brought.
    pub others: Vec<String>,
    /// How meshes of one's own are made.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Made>,
    /// By mesh and aim.
    pub rows: Vec<Row>,
}

impl Contents for Report {
    const FORMAT: &'static str = "srp-watertight";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp watertight --json`";
}

/// A triangle test, and what it takes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Test {
    /// Its name, as in a machine file.
    pub name: String,
    /// Operations of a test of one triangle.
    pub operations: Operations,
    /// The area of a T&I unit with it, mm².
    pub mm2: f64,
}

/// How a mesh is made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Made {
    /// The mesh.
    pub mesh: String,
    /// Its triangles.
    pub triangles: u64,
    /// Those of them without area, which nothing meets.
    pub degenerate: u64,
    /// Edges that one triangle with area has alone.
    pub borders: u64,
}

/// Rays of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Row {
    /// The mesh.
    pub mesh: String,
    /// How they are aimed.
    pub aim: Aim,
    /// How many there are.
    pub rays: u64,
    /// How many of them meet the mesh in exact arithmetic.
    pub meet: u64,
    /// By test, then by other ray tracer.
    pub counts: Vec<Count>,
}

/// Wrong answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Count {
    /// Rays that meet the mesh, and hit nothing.
    pub lost: u64,
    /// Rays that meet nothing, and hit.
    pub false_hits: u64,
}

/// A mesh for other ray tracers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// Its name.
    pub name: String,
    /// The mesh as an `.obj` file.
    pub obj: String,
    /// The rays, a line each, `ox oy oz dx dy dz # mesh, aim: meets|passes`.
    pub rays: String,
}

/// The meshes of the families: all, or one alone; `None` where none has this name.
pub fn meshes(only: Option<&str>) -> Option<Vec<Mesh>> {
    let mut meshes = mesh::all();
    meshes.retain(|mesh| only.is_none_or(|only| only == mesh.name));
    (!meshes.is_empty()).then_some(meshes)
}

/// Shoots rays at some meshes with every triangle test, on the T&I unit of a machine.
///
/// # Errors
///
/// The watch ended the work, or answers are not one for each ray.
pub fn measure(
    arch: &Arch,
    meshes: &[Mesh],
    options: Options,
    others: &[Answers],
    session: &Session<'_>,
) -> Result<Report, Error> {
    let own = arch.system.tni.intersection;
    let mut tests = vec![own];
    tests.extend(Intersection::ALL.into_iter().filter(|&test| test != own));
    let units: Vec<SystemSpec> = tests.iter().map(|&test| with(arch, test)).collect();
    let rows = each_mesh(meshes, session, |number, mesh| {
        let tree = bvh::build(&mesh.triangles, &bvh::Options::default());
        let kinds = rays(mesh, &tree, options, session)?;
        for other in others {
            let (found, all) = (other.hits[number].len(), kinds.iter().map(|k| k.1.len()));
            let all: usize = all.sum();
            if found != all {
                return Err(Error::invalid(format!(
                    "{} has {found} answers of the {all} rays at `{}`: its rays are those of --export with \
                     the same --rays and --seed",
                    other.name, mesh.name
                )));
            }
        }
        Ok(rows((mesh, &tree), &kinds, &units, number, others))
    })?;
    Ok(Report {
        tests: (tests.iter().zip(&units))
            .map(|(test, system)| Test {
                name: test.name().to_owned(),
                operations: test.operations(system.tni.rcp),
                mm2: area::area(&system.tni, &system.buffers, system.tni_mhz_at_65nm()).total,
            })
            .collect(),
        others: others.iter().map(|other| other.name.clone()).collect(),
        meshes: meshes.iter().filter_map(Mesh::made).collect(),
        rows: rows.into_iter().flatten().collect(),
    })
}

/// A mesh and its rays as text, for other ray tracers.
///
/// # Errors
///
/// The watch ended the work.
pub fn export(mesh: &Mesh, options: Options, session: &Session<'_>) -> Result<Exported, Error> {
    let tree = bvh::build(&mesh.triangles, &bvh::Options::default());
    let mut text = format!("# seed {}\n", options.seed);
    for (aim, shots) in rays(mesh, &tree, options, session)? {
        for Shot { ray, meets } in shots {
            let [a, b, c] = ray.origin;
            let [x, y, z] = ray.direction;
            let meets = if meets { "meets" } else { "passes" };
            let aim = aim.name();
            let _ = writeln!(text, "{a:e} {b:e} {c:e} {x:e} {y:e} {z:e} # {aim}: {meets}");
        }
    }
    Ok(Exported {
        name: mesh.name.clone(),
        obj: mesh.obj(),
        rays: text,
    })
}

/// The system of a machine with another triangle test.
fn with(arch: &Arch, intersection: Intersection) -> SystemSpec {
    SystemSpec {
        tni: TniSpec {
            intersection,
            ..arch.system.tni
        },
        ..arch.system.clone()
    }
}

/// Does the same for each mesh, on the session's threads; the results are in the order of the meshes.
fn each_mesh<T: Send>(
    meshes: &[Mesh],
    session: &Session<'_>,
    work: impl Fn(usize, &Mesh) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let stage = Stage::of(session.watch, "shooting rays", meshes.len() as u64);
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut done = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(mesh) = meshes.get(number) else {
                return done;
            };
            let result = match session.watch.cancelled() {
                true => Err(Error::cancelled()),
                false => work(number, mesh),
            };
            stage.done(1);
            done.push((number, result));
        }
    };
    let mut all = std::thread::scope(|scope| {
        let threads = session.threads.clamp(1, meshes.len().max(1));
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        let mut all = Vec::new();
        for thread in threads {
            match thread.join() {
                Ok(done) => all.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_by_key(|&(number, _)| number);
    all.into_iter().map(|(_, result)| result).collect()
}

/// The rays of a mesh, which depend on nothing but its name, their number and their seed.
fn rays(
    mesh: &Mesh,
    tree: &Bvh,
    options: Options,
    session: &Session<'_>,
) -> Result<Vec<(Aim, Vec<Shot>)>, Error> {
    let count = options.rays as usize;
    let target = Target::new(mesh, tree);
    let aims = (0..).zip(Aim::at(mesh.form));
    aims.map(|(place, aim)| {
        let name = mesh.name.bytes().fold(place, |sum: u64, byte| {
            Random::new(sum ^ u64::from(byte)).draw()
        });
        let mut random = Random::new(options.seed ^ name);
        let shots = target.shots(aim, count, &mut random, session);
        Ok((aim, shots.ok_or_else(Error::cancelled)?))
    })
    .collect()
}

/// Counts the wrong answers of all rays of a mesh.
fn rows(
    (mesh, tree): (&Mesh, &Bvh),
    kinds: &[(Aim, Vec<Shot>)],
    units: &[SystemSpec],
    number: usize,
    others: &[Answers],
) -> Vec<Row> {
    let placed: Vec<_> = units
        .iter()
        .map(|system| {
            let image = bvh::lay_out(tree, &mesh.triangles, Layout::of(&system.tni));
            place_for(system, &image)
        })
        .collect();
    let mut tracers: Vec<Tracer<'_>> = (units.iter().zip(&placed))
        .map(|(system, (memory, tree))| Tracer::new(&system.tni, tree, memory))
        .collect();
    let mut answers: Vec<_> = others.iter().map(|o| o.hits[number].iter()).collect();
    let row = |(aim, shots): &(Aim, Vec<Shot>)| {
        let mut counts = vec![Count::default(); units.len() + others.len()];
        for shot in shots {
            let hits = tracers
                .iter_mut()
                .map(|tracer| tracer.trace(&shot.ray).hit.is_hit());
            let brought = answers.iter_mut().map(|of| of.next() == Some(&true));
            for (count, hit) in counts.iter_mut().zip(hits.chain(brought)) {
                count.lost += u64::from(shot.meets && !hit);
                count.false_hits += u64::from(!shot.meets && hit);
            }
        }
        Row {
            mesh: mesh.name.clone(),
            aim: *aim,
            rays: shots.len() as u64,
            meet: shots.iter().filter(|shot| shot.meets).count() as u64,
            counts,
        }
    };
    kinds.iter().map(row).collect()
}
