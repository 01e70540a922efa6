//! Many rays at once, where a single one proves little: aimed at what triangles share, and started
//! on surfaces.

use super::call::Calls;
use super::catalogue::Case;
use super::functions::Function;
use super::judge::{Verdict, distance_error};
use super::meshes;
use super::settings::Setting;
use super::shared::Shared;
use super::surface::{Made, Scenery};
use super::unit::{Mesh, Unit};
use crate::exact::{self, Distance};
use crate::rays::kernel_ray;
use crate::survey::Random;
use glam::Vec3;
use srp_archdesc::arch::{Approx, Arch};
use srp_archdesc::datapath::Intersection;
use srp_runtime::scene::{Scene, Triangle};
use srp_runtime::scene_image;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use std::cmp::Ordering;

/// The sine of the angle at which a ray must meet a face, for the face to be more than an outline.
const LEAST_SLANT: f64 = 1e-3;

/// Distances are off by so much over the sine of the angle at which a ray meets a triangle: some roundings
/// of its numerator and its denominator.
const OFF: f64 = 16.0 / (1 << 24) as f64;

/// So many places are looked at for each ray that is to be aimed.
const TRIES: usize = 40;

/// A place among `n`.
fn place(n: usize, random: &mut Random) -> usize {
    ((random.unit() * n as f32) as usize).min(n.saturating_sub(1))
}

/// The sine of the angle between a direction and the plane of a triangle; 0 where it has none.
fn slant(direction: Vec3, triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero();
    normal.dot(direction.as_dvec3().normalize_or_zero()).abs()
}

/// A ray that is aimed at something.
struct AimedRay {
    origin: [f32; 3],
    direction: [f32; 3],
    /// The triangles round it.
    round: Vec<u32>,
    /// How far the nearest of them is that the ray meets in exact arithmetic; `None` where it meets
    /// none of them.
    met: Option<Distance>,
    /// The least sine of the angles at which it meets the planes of these.
    slant: f64,
}

/// The rays of a case, and what they are aimed at.
pub(super) struct AimedRays {
    mesh: Mesh,
    light: Vec3,
    /// True if the rays start inside a closed, convex mesh.
    inside: bool,
    rays: Vec<AimedRay>,
}

impl AimedRays {
    /// The rays of a case: so many `rays`, from a `seed`, at `edges`, `vertices`, `faces` or along the
    /// surface (`grazing`). A sphere is looked at from inside and has its `light` there, a scene from
    /// its camera.
    pub(super) fn of(case: &Case, scene: &Scene) -> AimedRays {
        let triangles = meshes::of(case, scene);
        let mut random = Random::new(u64::from(case.words::<1>("seed")[0]));
        let [count] = case.floats("rays");
        let shared = Shared::of(&triangles);
        let inside = case.argument("sphere").is_some();
        let [_, _, radius, x, y, z] = case.floats("sphere");
        let centre = Vec3::new(x, y, z);
        let eye = scene.camera.position;
        let own = scene.lights.first().map_or(eye, |l| l.position);
        let light = case
            .argument("light")
            .map(|_| Vec3::from(case.floats("light")));
        // A scene may have no triangle to aim at, or none that shares anything.
        let tries = match triangles.is_empty() {
            true => 0,
            false => TRIES * count as usize,
        };
        let is_leak = case.call == "leaks" && !inside;
        let rays = (0..tries).filter_map(|_| {
            let i = place(triangles.len(), &mut random);
            let corner = place(3, &mut random);
            let [a, b, c] = [0, 1, 2].map(|k| triangles[i].positions[(corner + k) % 3]);
            let between = a.lerp(b, random.unit());
            let (to, round, is_closed): (Vec3, Vec<u32>, bool) = match case {
                case if case.argument("vertices").is_some() => {
                    let is_closed = is_leak && shared.is_closed_vertex(eye, a);
                    (a, shared.vertex(a).to_vec(), is_closed)
                }
                case if case.argument("faces").is_some() => {
                    (between.lerp(c, random.unit()), vec![i as u32], true)
                }
                _ => {
                    let is_closed = is_leak && shared.is_closed_edge(eye, a, b);
                    (between, shared.edge(a, b), is_closed)
                }
            };
            let from = match (inside, case.argument("grazing").is_some()) {
                (true, true) => {
                    // Far away, no point is nearer to the surface than a rounding and still inside.
                    let least = 8.0 * f32::EPSILON * centre.abs().max_element() / radius;
                    let slope: f32 = [1e-1, 1e-2, 1e-3, 1e-4][place(4, &mut random)];
                    ((a + b + c) / 3.0).lerp(centre, slope.max(least))
                }
                (true, false) => centre + 0.5 * radius * random.direction(),
                (false, _) => eye,
            };
            let (origin, direction) = (from.to_array(), (to - from).to_array());
            let slants = round
                .iter()
                .map(|&t| slant(to - from, &triangles[t as usize]));
            let slant = slants.fold(1.0, f64::min);
            let is_edge_on = case.argument("faces").is_some() && slant < LEAST_SLANT;
            if is_leak && (is_edge_on || !is_closed) {
                return None;
            }
            let ray = Ray::new(origin, direction, 0.0, f32::MAX, 0);
            let distance = |t: &u32| exact::distance(&ray, &triangles[*t as usize]);
            let ahead = |t: &Distance| t.compare_number(0.0) == Ordering::Greater;
            let distances = round.iter().filter_map(distance).filter(ahead);
            Some(AimedRay {
                origin,
                direction,
                met: distances.min_by(Distance::compare),
                round,
                slant,
            })
        });
        let rays = rays.take(count as usize);
        AimedRays {
            rays: rays.collect(),
            light: light.unwrap_or(own),
            mesh: Mesh::of(triangles),
            inside,
        }
    }

    /// True if a ray went between triangles: it found nothing, or a hit farther behind the one of exact
    /// arithmetic than the unit's distances can be off.
    fn is_lost(&self, aimed: &AimedRay, hit: &Hit, arch: &Arch) -> bool {
        if self.inside {
            return !hit.is_hit();
        }
        let Some(met) = &aimed.met else {
            return false;
        };
        if !hit.is_hit() {
            return true;
        }
        let off = distance_error(arch).max(1e-6) + OFF / aimed.slant.max(f64::EPSILON);
        let behind = f64::from(hit.t) > met.value() * (1.0 + 4.0 * off);
        behind && !aimed.round.contains(&hit.primitive)
    }

    /// How many of the rays go between triangles in a setting; `None` where there is nothing to aim at.
    pub(super) fn leaks(&self, case: &Case, setting: &Setting) -> Option<Verdict> {
        if self.rays.is_empty() {
            return None;
        }
        let arch = &setting.arch;
        let unit = Unit::of(arch, &self.mesh);
        let mut tracer = unit.tracer();
        let lost = |aimed: &&AimedRay| {
            let ray = kernel_ray(&arch.precision, aimed.origin, aimed.direction, f32::MAX);
            self.is_lost(aimed, &tracer.trace(&ray).hit, arch)
        };
        let lost = self.rays.iter().filter(lost).count();
        if lost == 0 {
            return Some(Verdict::Right);
        }
        let share = lost as f64 / self.rays.len() as f64;
        let text = format!("{lost} of {} rays lost", self.rays.len());
        let test = arch.system.tni.intersection;
        // Woop's test bends a ray by as much as the SRP's reciprocal is off.
        let rcp = match test {
            Intersection::Woop => arch.precision.rcp,
            _ => arch.system.tni.rcp,
        };
        let coarse = match rcp {
            Approx::Exact => test.name().to_owned(),
            _ => format!("{}-coarse", test.name()),
        };
        let bound = case.may_lose(&coarse).or(case.may_lose(test.name()));
        Some(match bound {
            Some(bound) if share <= bound => {
                Verdict::Bounded(format!("{text}, at most {:.0} %", 100.0 * bound))
            }
            _ => Verdict::Wrong(text),
        })
    }

    /// Adds what the kernels are to make of the hits in a setting. What the rays went in with, for
    /// [`judge_acne`](Self::judge_acne).
    pub(super) fn add_hits(
        &self,
        calls: &mut Calls,
        case: &Case,
        function: &'static Function,
        arch: &Arch,
    ) -> Result<Vec<(u32, usize)>, String> {
        let light = self.light;
        let [index] = case.floats("index");
        let scenery = Scenery::place(calls, &self.mesh, index, light, arch)?;
        let unit = Unit::of(arch, &self.mesh);
        let mut tracer = unit.tracer();
        let hits = self.rays.iter().filter_map(|aimed| {
            let direction = Vec3::from(aimed.direction).normalize_or_zero().to_array();
            let ray = kernel_ray(&arch.precision, aimed.origin, direction, scene_image::FAR);
            let hit = tracer.trace(&ray).hit;
            hit.is_hit().then_some((hit, direction))
        });
        let added = hits.map(|(hit, direction)| {
            let at = (hit.u, hit.v, hit.primitive);
            let call = calls.add(function, &scenery.arguments(at, direction, light));
            (hit.primitive, call)
        });
        Ok(added.collect())
    }

    /// Secondary rays that hit the triangle that they start on, and of those inside a convex mesh the
    /// shadow rays that find something before the light inside it, and mirrored rays that find nothing.
    pub(super) fn judge_acne(
        &self,
        arch: &Arch,
        hits: &[(u32, usize)],
        results: &[Vec<u32>],
    ) -> Verdict {
        let unit = Unit::of(arch, &self.mesh);
        let mut tracer = unit.tracer();
        let (mut own, mut dark, mut lost, mut rays) = (0, 0, 0, 0);
        for &(primitive, call) in hits {
            let made = Made::of(&results[call]);
            let mut find = |ray: &Ray| tracer.trace(ray).hit;
            rays += 1;
            if made.shadow.tmax >= 0.0 {
                let nearest = Ray {
                    flags: 0,
                    ..made.shadow
                };
                let hit = find(&nearest);
                own += u32::from(hit.primitive == primitive);
                dark += u32::from(self.inside && hit.is_hit());
            }
            if let Some((origin, direction)) = made.mirrored {
                let hit = find(&kernel_ray(
                    &arch.precision,
                    origin,
                    direction,
                    scene_image::FAR,
                ));
                own += u32::from(hit.primitive == primitive);
                lost += u32::from(self.inside && !hit.is_hit());
            }
            if let Some((origin, direction)) = made.through {
                let hit = find(&kernel_ray(
                    &arch.precision,
                    origin,
                    direction,
                    scene_image::FAR,
                ));
                own += u32::from(hit.primitive == primitive);
            }
        }
        let test = arch.system.tni.intersection;
        let slips = matches!(test, Intersection::Wald | Intersection::AnchorWald);
        match own + dark + lost {
            0 if rays > 0 => Verdict::Right,
            // As many as these tests lose of rays aimed at edges, at most.
            n if slips && n == lost && 20 * lost <= rays => Verdict::Bounded(format!(
                "{lost} of {rays} rays slip through {}",
                test.name()
            )),
            _ => Verdict::Wrong(format!(
                "of {rays} hits: {own} rays hit their own triangle, {dark} lights are hidden, {lost} \
                 mirrored rays are lost"
            )),
        }
    }
}
