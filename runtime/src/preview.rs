//! A first look at a frame: about what each tile will take, from a few rays of it.
//!
//! Rays are traced as the T&I unit does, without its time; what they lead to, shadow rays, mirrored
//! rays and rays through glass, is followed along the geometric normals. What comes out orders tiles by
//! size and is right by no more than it needs to be: strata and regression of [`crate::survey`]
//! depend on it, the figures that are estimated do not.

use glam::Vec3;

use crate::effect::{Effect, Effects};
use crate::scene::camera::RayFan;
use crate::scene::{Scene, Surface, Triangle};
use crate::scene_image::SceneImage;
use crate::tni::arithmetic::{ANY_HIT, Hit, Ray};
use crate::tni::{Step, Tracer};
use srp_archdesc::system::TniSpec;

/// Rays through a tile.
const RAYS: u32 = 10;

/// Most rays that one ray leads to.
const MOST_FOLLOWED: u32 = 24;

/// SRP cycles of a ray by itself, of a visit or a test, and of a line of a texture that comes from
/// memory: round figures of the default machine. Only their proportions matter.
const OF_RAY: f64 = 25.0;
const OF_VISIT: f64 = 1.5;
const OF_LINE: f64 = 250.0;

/// Texels along a side of a line of the texture cache: 4 of 4 bytes (SGRT 3.4).
const LINE_SIDE: u32 = 4;

/// Where the second half of a record of shading is: another line of the data cache.
const SECOND_LINE: u32 = 64;

/// Most addresses that are kept of a frame.
const MOST_TOUCHED: usize = 1 << 26;

/// How far secondary rays start off a surface, as a part of the distance.
const SETBACK: f32 = 1e-3;

/// A frame to look at.
pub struct View<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The scene in memory.
    pub image: &'a SceneImage,
    /// The unit that traces.
    pub spec: &'a TniSpec,
    /// The rays of its picture.
    pub fan: RayFan,
    /// Where they start.
    pub eye: Vec3,
    /// Width and height of the picture.
    pub size: (u32, u32),
    /// Width and height of a tile.
    pub tile: (u32, u32),
    /// What the kernels are built for.
    pub effects: Effects,
}

/// What a look at tiles finds.
#[derive(Clone, Debug, Default)]
pub struct Preview {
    /// The size of each tile, row by row: above 0, about in SRP cycles.
    pub sizes: Vec<f64>,
    /// What a few rays of each tile read of memory, tile behind tile.
    touched: Vec<u32>,
    /// Where each tile begins there.
    starts: Vec<usize>,
}

impl Preview {
    /// Addresses that a few rays of a tile read, in their order.
    pub fn touched(&self, tile: u32) -> &[u32] {
        let start = self.starts[tile as usize];
        &self.touched[start..self.starts[tile as usize + 1]]
    }
}

/// Looks at all tiles of a frame.
pub fn look(view: &View<'_>) -> Preview {
    let (across, down) = view.tiles();
    let mut preview = Preview::default();
    let mut look = Look::new(view);
    for tile in 0..across * down {
        preview.starts.push(preview.touched.len());
        preview.sizes.push(look.tile(tile, RAYS));
        if preview.touched.len() < MOST_TOUCHED {
            preview.touched.append(&mut look.touched);
        }
        look.touched.clear();
    }
    preview.starts.push(preview.touched.len());
    preview
}

impl View<'_> {
    /// Tiles in a row, and rows of tiles.
    fn tiles(&self) -> (u32, u32) {
        let (width, height) = self.size;
        (width.div_ceil(self.tile.0), height.div_ceil(self.tile.1))
    }

    /// Addresses that the rays of all pixels of a tile read, in about their order.
    pub fn touches(&self, tile: u32) -> Vec<u32> {
        let mut look = Look::new(self);
        look.tile(tile, self.tile.0 * self.tile.1);
        look.touched
    }
}

/// Where ray `i` goes through a tile, in the unit square: points that fill it evenly (the multiples of
/// powers of 1/1.3247), turned by an amount of the tile's own.
fn place(tile: u32, i: u32) -> (f32, f32) {
    let turn = tile.wrapping_mul(0x9e37_79b9);
    let part = |step: u32, turn: u32| {
        let bits = turn.wrapping_add(step.wrapping_mul(i));
        (bits >> 8) as f32 / (1 << 24) as f32
    };
    (
        part(0xc13f_a9a9, turn),
        part(0x91e1_0da5, turn.rotate_left(16)),
    )
}

/// Whether shading looks at a picture.
fn scene_maps(view: &View<'_>, triangle: &Triangle) -> bool {
    let material = &view.scene.materials[triangle.material as usize];
    view.effects.contains(Effect::Texture) && material.maps().next().is_some()
}

struct Look<'a> {
    view: &'a View<'a>,
    tracer: Tracer<'a>,
    surfaces: Vec<Surface>,
    /// Rays that the one from the eye may still lead to.
    left: u32,
    /// What was read.
    touched: Vec<u32>,
}

impl<'a> Look<'a> {
    fn new(view: &'a View<'a>) -> Look<'a> {
        Look {
            view,
            tracer: Tracer::new(view.spec, &view.image.tree, &view.image.memory),
            surfaces: view.scene.materials.iter().map(Surface::of).collect(),
            left: 0,
            touched: Vec::new(),
        }
    }

    /// The size of a tile, from so many of its rays.
    fn tile(&mut self, tile: u32, rays: u32) -> f64 {
        let view = self.view;
        let (width, height) = view.tile;
        let across = view.tiles().0;
        let (left, top) = (tile % across * width, tile / across * height);
        let rays = rays.min(width * height);
        let all = rays == width * height;
        let mut cost = 0.0;
        for i in 0..rays {
            let (x, y) = match all {
                true => ((i % width) as f32, (i / width) as f32),
                false => {
                    let (x, y) = place(tile, i);
                    (x * width as f32 - 0.5, y * height as f32 - 0.5)
                }
            };
            let (x, y) = (left as f32 + x, top as f32 + y);
            let direction = view.fan.corner + view.fan.right * x + view.fan.down * y;
            self.left = MOST_FOLLOWED;
            cost += self.follow(view.eye, direction, 0.0, 0);
        }
        let samples = match view.effects.contains(Effect::Antialiasing) {
            true => f64::from(view.scene.options.samples),
            false => 1.0,
        };
        cost * samples * f64::from(width * height) / f64::from(rays)
    }

    fn trace(&mut self, from: Vec3, to: Vec3, end: f32, flags: u32) -> (f64, Hit) {
        let ray = Ray::new(from.to_array(), to.to_array(), 0.0, end, flags);
        let touched = &mut self.touched;
        let traced = self.tracer.follow(&ray, &mut |step| match step {
            Step::Pair { address, .. } => touched.push(address),
            Step::Triangle { address, .. } => touched.push(address),
            Step::Leaf => {}
        });
        let steps = traced.inner_visits + traced.leaf_visits + traced.triangle_tests;
        (OF_RAY + OF_VISIT * f64::from(steps), traced.hit)
    }

    /// The cost of a ray and of all that it leads to; `gone` is the length of the way to its start.
    fn follow(&mut self, from: Vec3, direction: Vec3, gone: f32, depth: u32) -> f64 {
        let (mut cost, hit) = self.trace(from, direction, crate::scene_image::FAR, 0);
        let view = self.view;
        let Some(triangle) = view.scene.triangles.get(hit.primitive as usize) else {
            return cost;
        };
        let length = hit.t * direction.length();
        let point = from + direction * hit.t;
        let way = direction.normalize_or_zero();
        let normal = triangle.geometric_normal();
        let normal = if normal.dot(way) > 0.0 {
            -normal
        } else {
            normal
        };
        let off = normal * (length * SETBACK);
        let parts = &view.image.shading;
        let record = parts.triangle(hit.primitive);
        let material = parts.material(triangle.material);
        let surface = self.surfaces[triangle.material as usize];
        self.touched.extend([record, material]);
        // Normals and texture coordinates are on the second line, mirrors and glass too.
        if scene_maps(view, triangle) || !triangle.is_flat() {
            self.touched.push(record + SECOND_LINE);
        }
        if surface.mirrors() || surface.transmits() {
            self.touched.push(material + SECOND_LINE);
        }
        cost += self.textures(triangle, &hit, gone + length, way.dot(normal));
        cost += self.lights(point + off, normal);
        let options = &view.scene.options;
        if depth >= options.bounces {
            return cost;
        }
        let effects = view.effects;
        if surface.mirrors() && effects.contains(Effect::Reflection) && self.may_follow() {
            let mirrored = way - 2.0 * way.dot(normal) * normal;
            cost += self.follow(point + off, mirrored, gone + length, depth + 1);
        }
        if surface.transmits() && effects.contains(Effect::Transparency) && self.may_follow() {
            cost += self.follow(point - off, way, gone + length, depth + 1);
        }
        if depth < options.inter_reflections
            && effects.contains(Effect::InterReflection)
            && self.may_follow()
        {
            cost += self.follow(point + off, normal, gone + length, depth + 1);
        }
        cost
    }

    fn may_follow(&mut self) -> bool {
        let may = self.left > 0;
        self.left = self.left.saturating_sub(1);
        may
    }

    /// Rays to lights and into the surroundings.
    fn lights(&mut self, point: Vec3, normal: Vec3) -> f64 {
        let view = self.view;
        let mut cost = 0.0;
        if view.effects.contains(Effect::Shadow) {
            for light in view.scene.lights.iter().filter(|l| l.emits()) {
                if !self.may_follow() {
                    break;
                }
                cost += match (light.position - point).dot(normal) > 0.0 {
                    true => self.trace(point, light.position - point, 1.0, ANY_HIT).0,
                    false => OF_RAY,
                };
            }
        }
        let occlusion = view.scene.options.occlusion;
        if occlusion > 0 && view.effects.contains(Effect::Occlusion) && self.may_follow() {
            let radius = view.scene.options.occlusion_radius;
            cost += f64::from(occlusion) * self.trace(point, normal, radius, ANY_HIT).0;
        }
        cost
    }

    /// Lines of the textures: one for each pixel, where a pixel is as large as a line.
    fn textures(&mut self, triangle: &Triangle, hit: &Hit, distance: f32, cosine: f32) -> f64 {
        let view = self.view;
        if !view.effects.contains(Effect::Texture) {
            return 0.0;
        }
        let scene = view.scene;
        let [a, b, c] = triangle.positions;
        let area = (b - a).cross(c - a).length().max(f32::MIN_POSITIVE);
        let [s, t, u] = triangle.uvs;
        let covered = (t - s).perp_dot(u - s).abs();
        let at = s + (t - s) * hit.u + (u - s) * hit.v;
        let pixel = distance * view.fan.right.length() / cosine.abs().max(0.05).sqrt();
        let mut cost = 0.0;
        for map in scene.materials[triangle.material as usize].maps() {
            let picture = &scene.textures[map.texture as usize];
            let (width, height) = (picture.width, picture.height);
            let texels = covered * width as f32 * height as f32;
            let step = pixel * (texels / area).sqrt();
            cost += OF_LINE * f64::from((step / LINE_SIDE as f32).min(1.0));
            let along = |x: f32, n: u32| ((x - x.floor()) * n as f32) as u32 % n.max(1);
            let (x, y) = (along(at.x, width), along(at.y, height));
            let tile = y / LINE_SIDE * width.div_ceil(LINE_SIDE) + x / LINE_SIDE;
            let texels = view.image.shading.texels[map.texture as usize];
            self.touched.push(texels + 64 * tile);
        }
        cost
    }
}
