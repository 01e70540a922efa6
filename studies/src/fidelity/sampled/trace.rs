//! A frame traced without time: the reads of each tile, and estimates of its work.
//!
//! The rays of all pixels are traced as the T&I unit does, without its time, and so are the rays that follow
//! from them: rays to lights, mirrored ones and those through glass, packet by packet as the kernels send
//! them. The result warms caches, and orders tiles and explains their costs: it need not be exact, and
//! may differ in bits from the kernels' results. Work that it leaves out makes intervals wider
//! ([`crate::survey`]), or the caches of a unit a little wrong, which the intervals of [`super`] allow for.

use glam::Vec3;

use srp_archdesc::ops::semantics::lanes::V4;
use srp_archdesc::ops::semantics::texture::{CLAMP, footprint};
use srp_archdesc::system::TniSpec;
use srp_kernels::number::LEAST_WEIGHT;
use srp_runtime::effect::{Effect, Effects};
use srp_runtime::scene::camera::RayFan;
use srp_runtime::scene::{Fresnel, Scene, Surface, Triangle};
use srp_runtime::scene_image::SceneImage;
use srp_runtime::tni::arithmetic::{ANY_HIT, Hit, NEAREST, Ray};
use srp_runtime::tni::{Step, Tracer};

/// Where the second half of a record of shading is: another line of the data cache.
const SECOND_LINE: u32 = 64;

/// How far secondary rays start off a surface, as a part of the distance.
const SETBACK: f32 = 1e-3;

/// A frame to trace.
pub struct TracedFrame<'a> {
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
    /// The effects that the kernels are built for.
    pub effects: Effects,
    /// Bits of the weights of texels.
    pub texel_bits: u32,
}

/// Counts of the work of rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Work {
    /// Their number.
    pub rays: f64,
    /// Those that hit something and are shaded.
    pub shaded: f64,
    /// Nodes that they visit.
    pub visits: f64,
    /// Triangles that they test.
    pub tests: f64,
    /// Samples of textures.
    pub samples: f64,
    /// Cycles of the T&I unit that they are in it, were nothing in their way.
    pub resident: f64,
    /// The cycles of that which takes longest, or of several packets the sum of these.
    pub slowest: f64,
}

impl Work {
    fn times(&self, factor: f64) -> Work {
        Work {
            rays: factor * self.rays,
            shaded: factor * self.shaded,
            visits: factor * self.visits,
            tests: factor * self.tests,
            samples: factor * self.samples,
            resident: factor * self.resident,
            slowest: factor * self.slowest,
        }
    }
}

/// A traced tile: for each packet, the addresses that are read until its hits are shaded, and the work of its
/// rays.
#[derive(Clone, Debug, Default)]
pub(super) struct TileTrace {
    /// Addresses that are read, in about their order.
    touched: Vec<u32>,
    /// For each packet, the work of its rays, and the end of its addresses.
    packets: Vec<(Work, usize)>,
}

impl TileTrace {
    /// The packets.
    pub(super) fn packets(&self) -> usize {
        self.packets.len()
    }

    /// Returns the work of the rays of a packet, and the addresses that are read for it.
    pub(super) fn packet(&self, i: usize) -> (&Work, &[u32]) {
        let start = if i == 0 { 0 } else { self.packets[i - 1].1 };
        let (work, end) = &self.packets[i];
        (work, &self.touched[start..*end])
    }
}

/// A ray that is not a shadow ray.
#[derive(Clone, Copy, Debug)]
struct PendingRay {
    from: Vec3,
    direction: Vec3,
    depth: u32,
    /// The part of its light that the pixel gets.
    weight: f32,
}

/// Where a ray has met a surface.
#[derive(Clone, Copy, Debug)]
struct SurfacePoint {
    point: Vec3,
    /// A small way off the surface on the side that the ray came from.
    off: Vec3,
    normal: Vec3,
}

/// The parts into which a surface splits light.
struct SplitLight {
    mirrored: f32,
    through: f32,
    /// Where what goes through goes.
    onward: Vec3,
}

fn largest(colour: [f32; 3]) -> f32 {
    colour.into_iter().fold(0.0, f32::max)
}

/// The normal between those of the vertices, on the side of the geometric one.
fn smooth(triangle: &Triangle, hit: &Hit, geometric: Vec3) -> Vec3 {
    let [n0, n1, n2] = triangle.normals;
    let between = n0 * (1.0 - hit.u - hit.v) + n1 * hit.u + n2 * hit.v;
    let between = between.normalize_or(geometric);
    match between.dot(geometric) < 0.0 {
        true => -between,
        false => between,
    }
}

/// How a surface parts light: Snell's law and Fresnel's equations, as `kernels/secondary.c` has them.
fn split_light(
    surface: &Surface,
    effects: Effects,
    normal: Vec3,
    way: Vec3,
    inside: bool,
) -> SplitLight {
    let cosine = (-way.dot(normal)).clamp(0.0, 1.0);
    let mut split = SplitLight {
        mirrored: 0.0,
        through: 0.0,
        onward: way,
    };
    let by_angle = effects.contains(Effect::Fresnel);
    if effects.contains(Effect::Reflection) {
        split.mirrored = largest(surface.mirror);
        if by_angle && surface.fresnel == Fresnel::Conductor {
            let (flat, colour) = (1.0 - cosine, split.mirrored);
            split.mirrored = colour + (1.0 - colour) * flat * flat * flat * flat * flat;
        }
    }
    if !effects.contains(Effect::Transparency) {
        return split;
    }
    split.through = largest(surface.through);
    if !effects.contains(Effect::Refraction) || surface.index == 1.0 {
        return split;
    }
    if inside && split.through > 0.0 {
        split.through = 1.0;
    }
    let eta = if inside {
        surface.index
    } else {
        1.0 / surface.index
    };
    let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if square <= 0.0 {
        split.mirrored = split.mirrored.max(split.through);
        split.through = 0.0;
        return split;
    }
    let behind = square.sqrt();
    split.onward = way * eta + normal * (eta * cosine - behind);
    if by_angle && surface.fresnel == Fresnel::Dielectric {
        let s = (eta * cosine - behind) / (eta * cosine + behind);
        let p = (cosine - eta * behind) / (cosine + eta * behind);
        let share = 0.5 * (s * s + p * p);
        split.mirrored *= share;
        split.through *= 1.0 - share;
    }
    split
}

/// A direction on the side of a normal, mostly along it; which one, the place decides.
fn random_direction(normal: Vec3, place: Vec3) -> Vec3 {
    let [x, y, z] = place.to_array().map(f32::to_bits);
    let seed = x ^ y.rotate_left(11) ^ z.rotate_left(22);
    let number = |i: u32| {
        let bits = (seed ^ i.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x85eb_ca6b);
        let bits = (bits ^ bits >> 15).wrapping_mul(0xc2b2_ae35);
        (bits >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let any = Vec3::new(number(1), number(2), number(3)).normalize_or_zero();
    (normal + 0.99 * any).normalize_or(normal)
}

/// Traces tiles.
#[derive(Clone)]
pub(super) struct TileTracer<'a> {
    frame: &'a TracedFrame<'a>,
    tracer: Tracer<'a>,
    surfaces: Vec<Surface>,
    traced: TileTrace,
    work: Work,
    /// The packet in hand, the surfaces that it has met, and rays that wait.
    packet: Vec<PendingRay>,
    met: Vec<SurfacePoint>,
    waiting: Vec<PendingRay>,
}

impl<'a> TileTracer<'a> {
    /// A tracer for a frame.
    pub(super) fn new(frame: &'a TracedFrame<'a>) -> TileTracer<'a> {
        TileTracer {
            frame,
            tracer: Tracer::new(frame.spec, &frame.image.tree, &frame.image.memory),
            surfaces: frame.scene.materials.iter().map(Surface::of).collect(),
            traced: TileTrace::default(),
            work: Work::default(),
            packet: Vec::new(),
            met: Vec::new(),
            waiting: Vec::new(),
        }
    }

    /// Traces the rays of a tile: one through the middle of each pixel, and all that follow from it. Packets
    /// go as the kernels send them: those to lights behind the one that they light, then the rays that wait,
    /// the last first.
    pub(super) fn tile(&mut self, tile: u32) -> TileTrace {
        let frame = self.frame;
        let (width, height) = frame.tile;
        let across = frame.image.across;
        let (left, top) = (tile % across * width, tile / across * height);
        let rays = (width * height) as usize;
        self.packet.clear();
        self.packet.extend((0..width * height).map(|i| {
            let (x, y) = ((left + i % width) as f32, (top + i / width) as f32);
            PendingRay {
                from: frame.eye,
                direction: frame.fan.corner + frame.fan.right * x + frame.fan.down * y,
                depth: 0,
                weight: 1.0,
            }
        }));
        while !self.packet.is_empty() {
            self.shade_packet();
            self.lights();
            let rest = self.waiting.len().saturating_sub(rays);
            self.packet.clear();
            self.packet.extend(self.waiting.drain(rest..));
        }
        let mut traced = std::mem::take(&mut self.traced);
        if frame.effects.contains(Effect::Antialiasing) {
            let samples = f64::from(frame.scene.options.samples);
            traced
                .packets
                .iter_mut()
                .for_each(|(work, _)| *work = work.times(samples));
        }
        traced
    }

    fn end_packet(&mut self) {
        let work = std::mem::take(&mut self.work);
        self.traced.packets.push((work, self.traced.touched.len()));
    }

    /// Traces a ray that stands for so many.
    fn trace(&mut self, from: Vec3, to: Vec3, end: f32, flags: u32, stands_for: f64) -> Hit {
        let ray = Ray::new(from.to_array(), to.to_array(), 0.0, end, flags);
        let touched = &mut self.traced.touched;
        let traced = self.tracer.follow(&ray, &mut |step| match step {
            Step::Pair { address, .. } => touched.push(address),
            Step::Triangle { address, .. } => touched.push(address),
            Step::Leaf => {}
        });
        self.work.rays += stands_for;
        self.work.visits += stands_for * f64::from(traced.inner_visits + traced.leaf_visits);
        self.work.tests += stands_for * f64::from(traced.triangle_tests);
        let spec = self.frame.spec;
        let visit = spec.pre_latency + spec.trv_l1.latency + spec.post_latency;
        let inner = visit + spec.aabb_latency;
        let test = spec.ist_latency + spec.ist_l1.latency;
        let cycles =
            traced.inner_visits * inner + traced.leaf_visits * visit + traced.triangle_tests * test;
        self.work.resident += stands_for * f64::from(cycles);
        self.work.slowest = self.work.slowest.max(stands_for * f64::from(cycles));
        traced.hit
    }

    /// Traces the packet in hand, and shades what it hits.
    fn shade_packet(&mut self) {
        let packet = std::mem::take(&mut self.packet);
        let far = srp_runtime::scene_image::FAR;
        let hits = packet
            .iter()
            .map(|r| self.trace(r.from, r.direction, far, 0, 1.0));
        let hits: Vec<Hit> = hits.collect();
        self.met.clear();
        let mut going_on = Vec::new();
        for (ray, hit) in packet.iter().zip(&hits) {
            going_on.extend(self.shade(ray, hit));
        }
        // Where light goes on is looked up behind all shading.
        for (material, sent) in going_on {
            self.traced.touched.push(material + SECOND_LINE);
            self.waiting.extend(sent.into_iter().flatten());
        }
        self.packet = packet;
        self.end_packet();
    }

    /// Shades a hit: the material that says where light goes on, and the rays that it sends, if it does.
    fn shade(&mut self, ray: &PendingRay, hit: &Hit) -> Option<(u32, [Option<PendingRay>; 3])> {
        let frame = self.frame;
        let triangle = frame.scene.triangles.get(hit.primitive as usize)?;
        let effects = frame.effects;
        let point = ray.from + ray.direction * hit.t;
        let way = ray.direction.normalize_or_zero();
        let [p, q, r] = triangle.positions;
        let geometric = (q - p).cross(r - p).normalize_or_zero();
        let inside = geometric.dot(way) > 0.0;
        let geometric = if inside { -geometric } else { geometric };
        let normal = match effects.contains(Effect::Normals) {
            true => smooth(triangle, hit, geometric),
            false => geometric,
        };
        let off = geometric * (hit.t * ray.direction.length() * SETBACK);
        self.met.push(SurfacePoint { point, off, normal });
        self.work.shaded += 1.0;
        let parts = &frame.image.shading;
        let record = parts.triangle(hit.primitive);
        let material = parts.material(triangle.material);
        self.traced.touched.push(record);
        if effects.contains(Effect::Normals) || effects.contains(Effect::Texture) {
            self.traced.touched.push(record + SECOND_LINE);
        }
        self.traced.touched.push(material);
        self.textures(triangle, hit);
        let options = &frame.scene.options;
        if ray.depth >= options.bounces {
            return None;
        }
        let surface = &self.surfaces[triangle.material as usize];
        let split = split_light(surface, effects, normal, way, inside);
        let depth = ray.depth + 1;
        let sent = |from, direction, share: f32| {
            let weight = ray.weight * share;
            (weight > LEAST_WEIGHT).then_some(PendingRay {
                from,
                direction,
                depth,
                weight,
            })
        };
        let goes_on = ray.depth < options.inter_reflections;
        let diffuse = match goes_on && effects.contains(Effect::InterReflection) {
            true => largest(surface.diffuse),
            false => 0.0,
        };
        let rays = [
            sent(point - off, split.onward, split.through),
            sent(
                point + off,
                way - 2.0 * way.dot(normal) * normal,
                split.mirrored,
            ),
            sent(point + off, random_direction(normal, point), diffuse),
        ];
        let reads = surface.mirrors() || surface.transmits() || goes_on;
        reads.then_some((material, rays))
    }

    /// Packets to lights and into the surroundings.
    fn lights(&mut self) {
        if self.met.is_empty() {
            return;
        }
        let frame = self.frame;
        let met = std::mem::take(&mut self.met);
        let nearest = match frame.effects.contains(Effect::TintedShadow) {
            true => NEAREST,
            false => 0,
        };
        if frame.effects.contains(Effect::Shadow) {
            for light in frame.scene.lights.iter().filter(|l| l.emits()) {
                for at in &met {
                    let from = at.point + at.off;
                    let to = light.position - from;
                    if to.dot(at.off) > 0.0 && to.dot(at.normal) > 0.0 {
                        let hit = self.trace(from, to, 1.0, ANY_HIT | nearest, 1.0);
                        self.tint(&hit);
                    } else {
                        self.work.rays += 1.0;
                    }
                }
                self.end_packet();
            }
        }
        let occlusion = frame.scene.options.occlusion;
        if occlusion > 0 && frame.effects.contains(Effect::Occlusion) {
            let radius = frame.scene.options.occlusion_radius;
            for at in &met {
                let way = random_direction(at.normal, at.point);
                self.trace(
                    at.point + at.off,
                    way,
                    radius,
                    ANY_HIT,
                    f64::from(occlusion),
                );
            }
            self.end_packet();
        }
        self.met = met;
    }

    /// Records the addresses that are read to know how much light passes a surface in its way.
    fn tint(&mut self, hit: &Hit) {
        let frame = self.frame;
        if let Some(triangle) = frame.scene.triangles.get(hit.primitive as usize)
            && frame.effects.contains(Effect::TintedShadow)
        {
            let parts = &frame.image.shading;
            let material = parts.material(triangle.material);
            let record = parts.triangle(hit.primitive);
            self.traced.touched.extend([record, material + SECOND_LINE]);
        }
    }

    /// The texels at a hit.
    fn textures(&mut self, triangle: &Triangle, hit: &Hit) {
        let frame = self.frame;
        if !frame.effects.contains(Effect::Texture) {
            return;
        }
        let scene = frame.scene;
        let [s, t, u] = triangle.uvs;
        let at = s + (t - s) * hit.u + (u - s) * hit.v;
        for map in scene.materials[triangle.material as usize].maps() {
            let picture = &scene.textures[map.texture as usize];
            let texels = frame.image.shading.texels[map.texture as usize];
            let clamp = if map.clamp { CLAMP } else { 0 };
            let descriptor = V4([texels, picture.width, picture.height, clamp]);
            let place = V4([at.x.to_bits(), at.y.to_bits(), 0, 0]);
            let touched = footprint(descriptor, place, frame.texel_bits).addresses;
            self.work.samples += 1.0;
            self.traced.touched.extend(touched);
        }
    }
}
