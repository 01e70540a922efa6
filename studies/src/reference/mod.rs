//! Another renderer of `docs/shading.md`, in binary64: what pictures of the kernels are measured
//! against.
//!
//! It is recursive and scalar, finds hits by another test in another tree, and shares with the
//! kernels the document and the random numbers of samples, no code.

pub(crate) mod geometry;
mod numbers;
mod path;
mod pictures;
mod surface;

use glam::DVec3;
use numbers::{Place, fraction, scrambled};
use path::{Paths, Ray};
use srp_archdesc::threads;
use srp_archdesc::watch::{Stage, Watch};
use srp_runtime::scene::Scene;
use srp_runtime::scene_image::tile_size;

/// How a picture is made.
pub struct Options<'a> {
    /// Its pixels in a row, and its rows.
    pub size: (u32, u32),
    /// Rays of a packet, on which it depends which samples a pixel has.
    pub packet: u32,
    /// Threads of the host; they change nothing.
    pub threads: usize,
    /// Watches the work, row by row.
    pub watch: &'a dyn Watch,
}

/// The picture as sRGB from 0 to 255, not yet rounded, row by row; `None` where it was cancelled.
pub fn picture(scene: &Scene, options: &Options<'_>) -> Option<Vec<DVec3>> {
    let view = View::of(scene, options);
    let stage = Stage::of(options.watch, "reference", u64::from(options.size.1));
    let row = |(): &mut (), row: usize| {
        let made = (!options.watch.cancelled()).then(|| view.row(row as u32));
        stage.done(1);
        made
    };
    let rows = threads::all(options.threads, options.size.1 as usize, || (), row)?;
    Some(rows.concat())
}

/// One pixel of [`picture`], by its column and row.
pub fn pixel(scene: &Scene, options: &Options<'_>, (x, y): (u32, u32)) -> DVec3 {
    View::of(scene, options).shown(x, y)
}

/// A camera that looks at a scene.
struct View<'a> {
    scene: &'a Scene,
    paths: Paths<'a>,
    size: (u32, u32),
    tile: (u32, u32),
    forward: DVec3,
    /// One pixel to the right, and down.
    right: DVec3,
    down: DVec3,
    /// How much wider the cone of a ray gets in a unit of length along the camera's axis.
    spread: f64,
}

impl<'a> View<'a> {
    fn of(scene: &'a Scene, options: &Options<'_>) -> View<'a> {
        let camera = &scene.camera;
        let forward = camera.forward.as_dvec3().normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let side = f64::from(options.size.0.min(options.size.1));
        let step = 2.0 * libm::tan(f64::from(camera.fov).to_radians() / 2.0) / side;
        // Several rays share a pixel.
        let spread = step / f64::from(scene.options.samples).sqrt();
        View {
            scene,
            paths: Paths::of(scene, spread),
            spread,
            size: options.size,
            tile: tile_size(options.packet),
            forward,
            right: right * step,
            down: forward.cross(right) * step,
        }
    }

    fn row(&self, y: u32) -> Vec<DVec3> {
        (0..self.size.0).map(|x| self.shown(x, y)).collect()
    }

    fn shown(&self, x: u32, y: u32) -> DVec3 {
        self.pixel(x, y).to_array().map(shown).into()
    }

    /// The mean light of a pixel's rays.
    fn pixel(&self, x: u32, y: u32) -> DVec3 {
        let (width, height) = self.tile;
        let tile = y / height * self.size.0.div_ceil(width) + x / width;
        let pixel = y % height * width + x % width;
        let samples = self.scene.options.samples;
        let mut sum = DVec3::ZERO;
        for sample in 0..samples {
            let (mut dx, mut dy) = (0.0, 0.0);
            if samples > 1 {
                // Multiples of powers of 1 / 1.3247 as fractions of 2^32, turned by a hash.
                let bits = scrambled(tile.wrapping_mul(0x9e37_79b9).wrapping_add(pixel));
                let place = |step: u32, turn: u32| {
                    (fraction(sample.wrapping_mul(step)) + fraction(turn)).fract() - 0.5
                };
                dx = place(0xc13f_a9a9, bits);
                dy = place(0x91e1_0da5, bits.wrapping_mul(0x2545_f491));
            }
            let across = f64::from(x) + 0.5 + dx - f64::from(self.size.0) / 2.0;
            let below = f64::from(y) + 0.5 + dy - f64::from(self.size.1) / 2.0;
            let direction = self.forward + self.right * across + self.down * below;
            let ray = Ray {
                origin: self.scene.camera.position.as_dvec3(),
                direction: direction.normalize(),
                weight: DVec3::ONE,
                depth: 0,
                diffuse: 0,
                is_diffuse: false,
                width: 0.0,
                spread: self.spread / direction.length(),
            };
            let seed = tile.wrapping_add(sample << 20);
            sum += self.paths.seen(ray, Place { seed, pixel });
        }
        sum / f64::from(samples)
    }
}

/// An intensity as an sRGB value from 0 to 255.
fn shown(x: f64) -> f64 {
    let x = x.clamp(0.0, 2.0);
    let x = (x * (1.0 - x / 4.0)).min(1.0);
    255.0
        * match x {
            ..=0.0031308 => 12.92 * x,
            _ => 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055,
        }
}
