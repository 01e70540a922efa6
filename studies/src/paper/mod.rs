//! The SGRT paper's Tables 3 to 6: its figures, ours, and their ratios.
//!
//! The paper's figures are only compared with; nothing in the model knows them. Figures are given as [`Entry`]s while
//! they are found, because a table takes minutes.

mod figures;
mod frames;
mod units;

use crate::Error;
use crate::fidelity::Fidelity;
use crate::rays::Order;
use crate::views::{Level, ao_radius};
use figures::{PAPER, PaperScene};
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::Bvh;
use srp_runtime::scene::{Camera, Scene};
use srp_toolchain::cache::Shared;
use srp_toolchain::scene::Views;
use srp_toolchain::{Build, Engine, Session};

/// Secondary rays a pixel, as in the paper.
const SAMPLES: u32 = 32;

/// Tables of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Ray generation and shading by themselves, fed by recorded hits.
    Table3,
    /// One unit, traversal with a single and with parallel pipelines.
    Table4,
    /// Four units: utilisation, steps, hit rates, bandwidth.
    Table5,
    /// Frames per second of the whole system.
    Table6,
}

/// How a table is measured.
pub struct Options {
    /// The table.
    pub table: Table,
    /// Width and height of the image in pixels.
    pub size: (u32, u32),
    /// The order of the rays of Tables 4 and 5.
    pub order: Order,
    /// How much is simulated: a level with a clock.
    pub level: Level,
    /// One run of packets of secondary rays in so many is measured, at other levels than `sampled`.
    pub one_in: u64,
    /// The same of primary rays.
    pub one_in_of_primary: u64,
    /// Threads of the host; they change no figure.
    pub threads: usize,
    /// Of Tables 3 and 6: effects to add to those that scenes call for, or to leave out.
    pub effects: Option<String>,
    /// Of Tables 3 and 6: forms and permissions of the kernels. Effects and bounces follow from the scene.
    pub build: Build,
    /// Of Tables 3 and 6: the engine that runs the kernels.
    pub engine: Engine,
}

impl Options {
    /// The facts that hold for all scenes.
    pub fn heading(&self, arch: &Arch) -> String {
        let (width, height) = self.size;
        let machine = format!("machine `{}`, {width}x{height} pixels", arch.name);
        if matches!(self.table, Table::Table3 | Table::Table6) {
            return machine;
        }
        if self.level.fidelity == Fidelity::Sampled {
            let error = 100.0 * self.level.error;
            return format!(
                "{machine}, {SAMPLES} samples, sampled until drawing leaves cycles {error} %"
            );
        }
        format!(
            "{machine}, {SAMPLES} samples, primary rays one run in {}, others one in {}",
            self.one_in_of_primary, self.one_in
        )
    }
}

/// A scene to compare on.
pub struct Case {
    scene: Scene,
    bvh: Bvh,
    cameras: Vec<Camera>,
    /// Length of ambient-occlusion rays.
    radius: f32,
    paper: Option<&'static PaperScene>,
}

impl Case {
    /// A scene with its tree and its viewpoints. The paper's figures are those of the scene whose name is `stem`.
    ///
    /// # Errors
    ///
    /// A viewpoint is not usable.
    pub fn new(
        scene: Scene,
        bvh: Bvh,
        views: Option<&Views>,
        stem: Option<&str>,
    ) -> Result<Case, Error> {
        let cameras = match views {
            Some(views) => {
                let all = (0..views.points.views.len()).map(|n| views.camera(n));
                all.collect::<Result<_, _>>()?
            }
            None => vec![scene.camera],
        };
        let known = views.and_then(|v| v.points.ao_radius);
        Ok(Case {
            radius: known.unwrap_or_else(|| ao_radius(&scene)),
            paper: stem.and_then(|stem| PAPER.iter().find(|p| p.name.eq_ignore_ascii_case(stem))),
            scene,
            bvh,
            cameras,
        })
    }

    fn title(&self) -> String {
        let (name, triangles) = (&self.scene.name, self.scene.triangles.len());
        let views = self.cameras.len();
        let known = match self.paper {
            Some(_) => "",
            None => "; not one of the paper's scenes",
        };
        format!("{name}, {triangles} triangles, {views} view(s){known}")
    }
}

/// A scene on a machine.
#[derive(Clone, Copy)]
struct Subject<'a> {
    case: &'a Case,
    options: &'a Options,
    arch: &'a Arch,
    session: &'a Session<'a>,
}

/// A piece of a table, in the order in which they are found.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A scene begins.
    Scene(String),
    /// Figures of a kind of rays begin; with the relative error of those that were measured on a part of the rays.
    Group(String, Option<f64>),
    /// A figure: its name, the paper's, and ours.
    Line(String, Option<f64>, f64),
    /// A remark on the figures before it.
    Note(String),
}

/// Where entries go.
struct Sheet<'a> {
    to: &'a mut dyn FnMut(Entry),
}

impl Sheet<'_> {
    fn group(&mut self, rays: &str, error: Option<f64>) {
        (self.to)(Entry::Group(rays.to_owned(), error));
    }

    fn line(&mut self, name: &str, paper: Option<f64>, ours: f64) {
        (self.to)(Entry::Line(name.to_owned(), paper, ours));
    }

    fn note(&mut self, text: String) {
        (self.to)(Entry::Note(text));
    }
}

/// Makes the pieces of Table 4 or 5 on a scene that no process has begun which shares the work, and waits for none: then
/// processes need not wait for each other before the last scene.
///
/// # Errors
///
/// There are no rays, a piece cannot be kept, or the watch ends the work.
pub fn begin(
    case: &Case,
    options: &Options,
    arch: &Arch,
    session: &Session<'_>,
    shared: &Shared,
) -> Result<(), Error> {
    let subject = Subject {
        case,
        options,
        arch,
        session,
    };
    units::Measures::begin(subject, shared)
}

/// Measures a table on a scene. `to` gets its entries.
///
/// # Errors
///
/// The kernels or a frame fail, there are no rays, or the watch ends the work.
pub fn table(
    case: &Case,
    options: &Options,
    arch: &Arch,
    session: &Session<'_>,
    to: &mut dyn FnMut(Entry),
) -> Result<(), Error> {
    to(Entry::Scene(case.title()));
    let sheet = &mut Sheet { to };
    let subject = Subject {
        case,
        options,
        arch,
        session,
    };
    match options.table {
        Table::Table3 => frames::table3(subject, sheet),
        Table::Table4 => units::table4(subject, sheet),
        Table::Table5 => units::table5(subject, sheet),
        Table::Table6 => frames::table6(subject, sheet),
    }
}
