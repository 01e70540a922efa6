//! One pixel: the first operation at which binary32 and binary64 part, and what follows of it.

use super::exact::Exact;
use super::pixels::{Contribution, Pixel, largest, written};
use super::{Flip, Studio, flips};
use crate::functional::{self, FunctionalError, MAX_STEPS, Stage};
use srp_archdesc::arch::Arch;
use srp_ir::program::Program;
use srp_ir::shadow::tape::{Contributions, Entry, Sweep, Tape};
use srp_runtime::effect::Guard;
use srp_runtime::scene::Triangle;
use srp_runtime::scene_image::{SceneImage, tile_size};
use std::collections::BTreeMap;

/// Units of the last place beyond which a value has parted from its shadow.
const PARTED: f64 = 4.0;

/// Least part of the pixel's error that a parting must make to be told.
const LEAST_PART: f64 = 0.01;

/// Operations of the tile that are remembered: a chain goes no further back.
const MOST_REMEMBERED: usize = 1 << 24;

/// Most steps of a chain that are told: its first ones.
const MOST_STEPS: usize = 64;

/// An operation on the way to a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// `file:line`; empty for a unit outside of the program.
    pub at: String,
    /// The operation of the opcode table, or the unit.
    pub what: String,
    /// Its result.
    pub value: f32,
    /// The same in binary64.
    pub exact: f64,
    /// The difference in units of the last place of the result.
    pub ulps: f64,
    /// The effect of the difference on the pixel's error, in levels.
    pub effect: f64,
}

/// The explanation of a pixel.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// The pixel.
    pub pixel: Pixel,
    /// Its tile.
    pub tile: u32,
    /// The channel that is off most: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// Contributions, the largest first: source as `file:line`, operation or unit, and the contribution to
    /// each channel, in levels.
    pub contributions: Vec<(String, String, [f64; 3])>,
    /// The first operation that parts from binary64 by more than rounding, and the operations
    /// that hand this on, to the pixel.
    pub chain: Vec<Step>,
    /// Decisions on its way that binary64 makes otherwise: what decides, as `file:line` and
    /// operation or unit, and the flip.
    pub flips: Vec<(String, String, Flip)>,
}

/// Runs the tile of pixel (`x`, `y`) with shadows; `None` where there is no such pixel, or
/// nobody writes it.
pub fn explain(
    triangles: &[Triangle],
    image: &SceneImage,
    program: &Program,
    arch: &Arch,
    guard: &Guard,
    (x, y): (u32, u32),
) -> Result<Option<Explanation>, FunctionalError> {
    if x >= image.frame.width || y >= image.frame.height {
        return Ok(None);
    }
    let layout = functional::layout(program, arch)?;
    let stage = Stage::of(image, program, arch, &layout, guard, MAX_STEPS)?;
    let exact = Exact::of(triangles);
    let studio = Studio::of(stage, &exact, triangles.len(), MOST_REMEMBERED);
    let (width, height) = tile_size(arch.system.buffers.rays);
    let tile = y / height * (image.frame.stride / width) + x / width;
    studio.explain(tile, (x, y))
}

impl Studio<'_> {
    fn explain(
        &self,
        tile: u32,
        place: (u32, u32),
    ) -> Result<Option<Explanation>, FunctionalError> {
        let (shadows, world) = self.run(tile, self.most_nodes)?;
        let (_, writes) = world.finish();
        let tape = &shadows.shadows.tape;
        let all = written(&shadows.shadows, &self.stage.image.frame, &writes);
        let Some((_, written)) = all.into_iter().find(|(at, _)| *at == place) else {
            return Ok(None);
        };
        let (mut sweep, mut contributions) = (Sweep::default(), Contributions::default());
        contributions.collect(&mut sweep, tape, &written.roots());
        let told = largest(&contributions, usize::MAX);
        let error = written.nodes.map(|node| tape.error(node));
        let by_size = |&a: &usize, &b: &usize| error[a].abs().total_cmp(&error[b].abs());
        let channel = (0..3).rev().max_by(by_size).unwrap_or(0);
        let on_tile = |tag| self.place(tile, tag);
        let flips = flips::of(self, &shadows, &on_tile).into_iter();
        let flips = flips.filter(|flip| flip.pixel == Some(place));
        let flips: Vec<_> = flips
            .map(|flip| {
                let (at, what) = self.name(flip.source as u32);
                (at, what, flip)
            })
            .collect();
        Ok(Some(Explanation {
            pixel: Pixel {
                exact: std::array::from_fn(|i| written.value[i] - error[i]),
                value: written.value,
                flips: flips.len() as u32,
                top: told.clone(),
            },
            tile,
            channel,
            contributions: told.iter().map(|c| self.named(c)).collect(),
            chain: self.chain(tape, &mut sweep, written.nodes[channel]),
            flips,
        }))
    }

    fn named(&self, contribution: &Contribution) -> (String, String, [f64; 3]) {
        let (at, what) = self.name(contribution.source as u32);
        (at, what, contribution.error)
    }

    /// From the first operation that parts to a result.
    fn chain(&self, tape: &Tape, sweep: &mut Sweep, root: u32) -> Vec<Step> {
        /// A node behind the result.
        struct Behind {
            effect: f64,
            /// The node through which most of its error goes on, and how much.
            next: (u32, f64),
        }
        let mut behind: BTreeMap<u32, Behind> = BTreeMap::new();
        let mut next: BTreeMap<u32, (u32, f64)> = BTreeMap::new();
        sweep.run(tape, &[(root, [1.0, 0.0, 0.0])], |node, entry, weight| {
            let effect = weight[0] * entry.error();
            let on = next.get(&node).copied().unwrap_or_default();
            behind.insert(node, Behind { effect, next: on });
            for (&parent, partial) in entry.parents.iter().zip(entry.partials) {
                let through = (weight[0] * partial * tape.error(parent)).abs();
                let best = next.entry(parent).or_default();
                if through >= best.1 {
                    *best = (node, through);
                }
            }
        });
        let least = LEAST_PART * tape.error(root).abs();
        let parts = |(node, known): (&u32, &Behind)| {
            let entry = tape.get(*node)?;
            (ulps(entry).abs() > PARTED && known.effect.abs() >= least).then_some(*node)
        };
        let made = |(_, known): &(&u32, &Behind)| known.effect.abs();
        let first = behind.iter().find_map(parts).or_else(|| {
            let largest = behind.iter().max_by(|a, b| made(a).total_cmp(&made(b)));
            largest.map(|(node, _)| *node)
        });
        let mut steps = Vec::new();
        let mut node = first.unwrap_or(0);
        while let (Some(entry), Some(known)) = (tape.get(node), behind.get(&node)) {
            if steps.len() == MOST_STEPS {
                break;
            }
            let (at, mut what) = self.name(entry.source);
            if what.is_empty() {
                what = "earlier operations".to_owned();
            }
            steps.push(Step {
                at,
                what,
                value: entry.value,
                exact: entry.shadow,
                ulps: ulps(entry),
                effect: known.effect,
            });
            node = known.next.0;
        }
        steps
    }
}

/// The error of a node in units of the last place of its value.
fn ulps(entry: &Entry) -> f64 {
    let bits = entry.value.abs().to_bits();
    let next = f32::from_bits(bits + 1);
    entry.error() / (f64::from(next) - f64::from(entry.value.abs()))
}
