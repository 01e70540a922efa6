//! Measures which rays the T&I unit loses on a scene's own edges, and how far its distances are off.
//!
//! Rays go from the camera to points of edges that two triangles share, one on each side of the edge as
//! the camera sees it. However a unit rounds, it must find one of the two or something nearer; at
//! outlines it may take either side. A ray's direction is rounded to binary32, so that far from the origin of
//! the scene it may pass both triangles: only those rays count that meet one of them in exact arithmetic.

use crate::exact;
use crate::rays::kernel_ray;
use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Arch;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::tni::Tracer;
use srp_runtime::tni::arithmetic::Ray;
use std::collections::BTreeMap;

/// Most rays that are aimed.
const RAYS: usize = 20_000;

/// Where on an edge they are aimed, in 16ths.
const PLACES: [u32; 5] = [3, 5, 8, 11, 13];

/// The part of the products that make up a volume by which it has to differ from 0: what is
/// narrower is seen from its edge.
const NARROW: f64 = 1e-6;

/// How much farther than the two triangles a hit may be and still be on them, besides what the
/// unit's reciprocal allows.
const FARTHER: f64 = 1e-3;

/// The outcome of aimed rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Leaks {
    /// Rays that were aimed, and meet a triangle in exact arithmetic.
    pub aimed: u32,
    /// Of these, rays that the unit let through.
    pub leaks: u32,
    /// Error of the distances of the rest in units of the last place: half of them are below.
    pub ulp_median: f64,
    /// 99 of 100 are below.
    pub ulp_99: f64,
}

type Key = [u32; 3];

/// A ray from the camera that meets one of two triangles at an edge that they share.
struct Aimed {
    direction: Vec3,
    /// How far along it the planes of both are passed.
    t: f64,
}

/// The rays that are aimed at edges between triangles.
pub(super) struct Edges(Vec<Aimed>);

impl Edges {
    /// Aims rays at edges that have a triangle on each side, as the camera sees them; the edges are evenly
    /// drawn where they are more than are needed.
    pub(super) fn of(scene: &Scene) -> Edges {
        let key = |v: Vec3| v.to_array().map(|x| (x + 0.0).to_bits());
        let mut first: BTreeMap<[Key; 2], usize> = BTreeMap::new();
        let mut shared = Vec::new();
        for (i, triangle) in scene.triangles.iter().enumerate() {
            let [a, b, c] = triangle.positions;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let mut ends = [key(p), key(q)];
                ends.sort_unstable();
                match first.insert(ends, i) {
                    Some(other) if other != i => shared.push(([p, q], [other, i])),
                    _ => {}
                }
            }
        }
        let step = shared.len().div_ceil(RAYS / PLACES.len()).max(1);
        let origin = scene.camera.position;
        let mut aimed = Vec::new();
        for (ends, triangles) in shared.into_iter().step_by(step) {
            let triangles = triangles.map(|t| &scene.triangles[t]);
            let corners = triangles.map(|t| t.positions);
            if !between(ends, corners, origin) {
                continue;
            }
            for place in PLACES {
                let direction = ends[0].lerp(ends[1], place as f32 / 16.0) - origin;
                let ray = Ray::new(origin.into(), direction.into(), 0.0, f32::MAX, 0);
                let is_closed = || triangles.iter().any(|t| exact::meets(&ray, t));
                match farthest(corners, origin, direction) {
                    Some(t) if is_closed() => aimed.push(Aimed { direction, t }),
                    _ => {}
                }
            }
        }
        Edges(aimed)
    }

    /// Traces the rays on a machine.
    pub(super) fn probe(&self, scene: &Scene, image: &SceneImage, arch: &Arch) -> Leaks {
        let mut tracer = Tracer::new(&arch.system.tni, &image.tree, &image.memory);
        let farther = 1.0 + FARTHER + allowance(arch);
        let origin = scene.camera.position;
        let mut leaks = Leaks {
            aimed: self.0.len() as u32,
            ..Leaks::default()
        };
        let mut ulps = Vec::new();
        for &Aimed { direction, t } in &self.0 {
            let hit = tracer
                .trace(&kernel_ray(
                    &arch.precision,
                    origin.into(),
                    direction.into(),
                    f32::MAX,
                ))
                .hit;
            if !hit.is_hit() || f64::from(hit.t) > t * farther {
                leaks.leaks += 1;
                continue;
            }
            let found = scene.triangles.get(hit.primitive as usize);
            if let Some(exact) = found.and_then(|t| distance(t.positions, origin, direction)) {
                let ulp = f64::from(hit.t.next_up() - hit.t);
                ulps.push((f64::from(hit.t) - exact).abs() / ulp);
            }
        }
        ulps.sort_by(f64::total_cmp);
        let at = |part: f64| ulps.get((ulps.len() as f64 * part) as usize).copied();
        leaks.ulp_median = at(0.5).unwrap_or(0.0);
        leaks.ulp_99 = at(0.99).unwrap_or(0.0);
        leaks
    }
}

/// How far off a distance may be for want of bits, as a part of it: by the unit's reciprocal, and by that
/// of the slabs, for no hit is nearer than the box of its leaf.
fn allowance(arch: &Arch) -> f64 {
    2.0 * (arch.system.tni.rcp.error_bound() + arch.precision.reciprocal_error())
}

/// True when two triangles lie on either side of the edge that they share, as it is seen from a point.
fn between(ends: [Vec3; 2], corners: [[Vec3; 3]; 2], eye: Vec3) -> bool {
    let eye = eye.as_dvec3();
    let [p, q] = ends.map(|p| p.as_dvec3() - eye);
    let normal = p.cross(q);
    let side = |corners: [Vec3; 3]| {
        let third = corners.into_iter().find(|c| !ends.contains(c))?;
        let third = third.as_dvec3() - eye;
        let size = bound(p.abs(), q.abs()).dot(third.abs());
        let volume = normal.dot(third);
        (volume.abs() > NARROW * size).then_some(volume > 0.0)
    };
    matches!((side(corners[0]), side(corners[1])), (Some(a), Some(b)) if a != b)
}

/// How far along a ray both triangles are passed.
fn farthest(corners: [[Vec3; 3]; 2], origin: Vec3, direction: Vec3) -> Option<f64> {
    let [a, b] = corners.map(|c| distance(c, origin, direction));
    Some(a?.max(b?)).filter(|t| *t > 0.0 && t.is_finite())
}

/// How far along a ray the plane of a triangle is.
fn distance(corners: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<f64> {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let normal = (b - a).cross(c - a);
    let along = normal.dot(direction.as_dvec3());
    (along != 0.0).then(|| normal.dot(a - origin.as_dvec3()) / along)
}

/// A cross product of what is nowhere negative, with sums in the place of differences.
fn bound(p: DVec3, q: DVec3) -> DVec3 {
    DVec3::new(
        p.y * q.z + p.z * q.y,
        p.z * q.x + p.x * q.z,
        p.x * q.y + p.y * q.x,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_archdesc::machines;
    use srp_runtime::bvh;
    use srp_runtime::scene::demo::demo;
    use srp_runtime::scene_image;

    /// The default scene moved so far that a unit in the last place of its coordinates is a thousandth.
    #[test]
    fn far_from_the_origin_nothing_leaks_that_is_closed() {
        let arch =
            srp_archdesc::parse("sgrt", machines::SGRT.xml).expect("the machine that comes along");
        for far in [0.0, 1e4] {
            let mut scene = demo();
            let offset = Vec3::new(far, -far, far);
            for triangle in &mut scene.triangles {
                triangle.positions = triangle.positions.map(|p| p + offset);
            }
            scene.camera.position += offset;
            let tree = bvh::build(&scene.triangles, &bvh::Options::default());
            let image = scene_image::build(&scene, &tree, &scene.camera, &arch, (16, 16));
            let image = image.expect("the scene fits");
            let leaks = Edges::of(&scene).probe(&scene, &image, &arch);
            assert!(leaks.aimed > 20, "{far}: {leaks:?}");
            assert_eq!(leaks.leaks, 0, "{far}: {leaks:?}");
        }
    }
}
