//! A frame without a clock: its picture and its counts, from the program's meaning alone. The program is
//! neither divided nor scheduled, and no simulator is generated.

use crate::Error;
use crate::fidelity::{FrameFigure, FrameQuantity};
use crate::figure::Figure;
use crate::functional::{self, Counts, MAX_STEPS};
use crate::survey::Estimate;
use srp_archdesc::Arch;
use srp_ir::program::Program;
use srp_runtime::effect::Guard;
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::SceneImage;
use srp_toolchain::Session;

/// A frame without the figures that need a clock.
pub struct Untimed {
    /// The picture: that of the frame with a clock, to the bit.
    pub picture: Picture,
    /// The figures that [are counts](FrameQuantity::is_count).
    pub figures: Vec<FrameFigure>,
}

/// Runs a frame by a program before it is divided.
///
/// # Errors
///
/// The program traps, or the work was cancelled.
pub fn untimed(
    image: &SceneImage,
    program: &Program,
    arch: &Arch,
    guard: &Guard,
    session: &Session<'_>,
) -> Result<Untimed, Error> {
    let options = functional::Options {
        guard,
        threads: session.threads,
        tiles: None,
        steps: MAX_STEPS.min(session.cycles),
        watch: session.watch,
    };
    let frame = functional::render(image, program, arch, options)?;
    session.check()?;
    let counts = frame.counts(arch.system.cores);
    let figures = FrameQuantity::all(&[]).into_iter().filter_map(|quantity| {
        let value = count(&counts, &quantity)?;
        Some(Figure {
            quantity,
            estimate: Estimate::exact(value),
        })
    });
    Ok(Untimed {
        figures: figures.collect(),
        picture: frame.picture,
    })
}

/// A quantity that is a count.
fn count(counts: &Counts, quantity: &FrameQuantity) -> Option<f64> {
    let rays = counts.rays.rays();
    let per_ray = |count: u64| match rays {
        0 => 0.0,
        rays => count as f64 / rays as f64,
    };
    let runs = &counts.rays.runs;
    Some(match quantity {
        FrameQuantity::Rays => rays as f64,
        FrameQuantity::HitsPerRay => {
            per_ray(u64::from(runs.shadow_hits) + u64::from(runs.other_hits))
        }
        FrameQuantity::InnerNodesPerRay => per_ray(counts.rays.inner_visits),
        FrameQuantity::LeavesPerRay => per_ray(counts.rays.leaf_visits),
        FrameQuantity::TestsPerRay => per_ray(counts.rays.triangle_tests),
        FrameQuantity::TextureSamples => counts.texture_lookups as f64,
        _ => return None,
    })
}
