//! Shared by the tests of the T&I unit: scenes, rays, and the truth about them.

// Each test file uses a part of this.
#![allow(dead_code, unreachable_pub)]

use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3};
use srp_archdesc::system::{SystemSpec, TniSpec};
use srp_runtime::bvh::{self, Builder, Layout, TreeImage};
use srp_runtime::scene::{self, Scene, Triangle};
use srp_runtime::tni::HitRecord;
use srp_runtime::tni::arithmetic::Ray;

/// A small generator: the same numbers on every host.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / (1 << 24) as f32
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n
    }

    /// In the box.
    pub(crate) fn point(&mut self, lo: Vec3, hi: Vec3) -> Vec3 {
        lo + (hi - lo) * Vec3::new(self.unit(), self.unit(), self.unit())
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.point(-Vec3::ONE, Vec3::ONE);
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

pub(crate) fn triangle(positions: [Vec3; 3]) -> Triangle {
    Triangle {
        positions,
        normals: [Vec3::Y; 3],
        uvs: [Vec2::ZERO; 3],
        material: 0,
    }
}

/// Triangles of all sizes, anywhere in the unit cube.
pub(crate) fn soup(random: &mut Random, count: usize) -> Vec<Triangle> {
    let triangles = (0..count).map(|_| {
        let centre = random.point(Vec3::ZERO, Vec3::ONE);
        let size = 0.3 * random.unit() * random.unit();
        triangle([0, 1, 2].map(|_| centre + size * random.direction()))
    });
    triangles.collect()
}

/// The units of the shipped machine.
pub(crate) fn machine() -> SystemSpec {
    let file = srp_archdesc::machines::SGRT;
    let arch = srp_archdesc::parse(file.name, file.xml).expect("the shipped machine is valid");
    arch.system
}

/// The tree that the shipped machine reads.
pub(crate) fn image(triangles: &[Triangle], builder: Builder) -> TreeImage {
    image_for(&machine().tni, triangles, builder)
}

/// The tree that a unit reads.
pub(crate) fn image_for(spec: &TniSpec, triangles: &[Triangle], builder: Builder) -> TreeImage {
    let options = bvh::Options {
        builder,
        ..bvh::Options::default()
    };
    let tree = bvh::build(triangles, &options);
    bvh::lay_out(&tree, triangles, Layout::of(spec))
}

/// The shared scene at this path below `../shared/scenes` of the repository, if it is there.
pub(crate) fn shared_scene(path: &str) -> Option<Scene> {
    let scenes = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    if !scenes.exists() {
        println!("skipped: {} is absent", scenes.display());
        return None;
    }
    let mut load = |path: &std::path::Path, _| std::fs::read(path);
    match scene::read(&scenes.join(path), None, &mut load) {
        Ok(loaded) => Some(loaded.scene),
        Err(messages) => panic!("{messages}"),
    }
}

/// The truth about a triangle in binary64: distance, and how far inside the ray passes (the
/// smallest weight, negative outside). `None` for a ray in its plane.
pub(crate) fn truth(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64)> {
    let origin = Vec3::from(ray.origin).as_dvec3();
    let direction = Vec3::from(ray.direction).as_dvec3();
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3() - origin);
    // Scaled triple products: the weights of the vertices.
    let weights = [
        direction.dot(c.cross(b)),
        direction.dot(a.cross(c)),
        direction.dot(b.cross(a)),
    ];
    let sum: f64 = weights.iter().sum();
    if sum == 0.0 {
        return None;
    }
    let weights = weights.map(|w| w / sum);
    let point: DVec3 = a * weights[0] + b * weights[1] + c * weights[2];
    let t = point.dot(direction) / direction.length_squared();
    Some((t, weights.into_iter().fold(f64::INFINITY, f64::min)))
}

/// The nearest hit by brute force in binary64.
pub(crate) fn nearest<'a>(ray: &Ray, triangles: impl Iterator<Item = &'a Triangle>) -> Option<f64> {
    triangles
        .filter_map(|t| truth(ray, t))
        .filter(|&(t, inside)| inside >= 0.0 && t > f64::from(ray.tmin) && t <= f64::from(ray.tmax))
        .map(|(t, _)| t)
        .min_by(f64::total_cmp)
}

/// Checks one answer against the truth: the same hit or miss, distances within 1e-4 of each other,
/// or within a rounding of the origin's coordinates where the origin almost lies on the triangle.
pub(crate) fn check(ray: &Ray, record: &HitRecord, truth: Option<f64>) -> Result<(), String> {
    let got = record.hit.is_hit().then_some(record.hit.t);
    let coordinate = ray.origin.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    let close = 1e-7 * f64::from(coordinate);
    match (got, truth) {
        (None, None) => Ok(()),
        (Some(t), Some(truth)) if (f64::from(t) - truth).abs() <= 1e-4 * truth + close => Ok(()),
        // Any hit will do for a shadow ray, so the nearest is only a lower bound.
        (Some(t), Some(truth)) if ray.flags & 1 == 1 && f64::from(t) > truth => Ok(()),
        _ => Err(format!("{ray:?}: got {got:?}, the truth is {truth:?}")),
    }
}

/// Brute force made bearable for large scenes: boxes in binary64, split at the median and larger
/// than need be, only say which triangles cannot be hit.
pub(crate) struct NearestTree<'a> {
    triangles: &'a [Triangle],
    order: Vec<u32>,
    nodes: Vec<Node>,
}

struct Node {
    lo: DVec3,
    hi: DVec3,
    range: std::ops::Range<usize>,
    /// The first node that is not below this one.
    next: usize,
}

const LEAF: usize = 8;

impl<'a> NearestTree<'a> {
    pub(crate) fn new(triangles: &'a [Triangle]) -> NearestTree<'a> {
        let mut tree = NearestTree {
            triangles,
            order: (0..triangles.len() as u32).collect(),
            nodes: Vec::new(),
        };
        tree.build(0..triangles.len());
        tree
    }

    fn build(&mut self, range: std::ops::Range<usize>) {
        let points = self.order[range.clone()]
            .iter()
            .flat_map(|&i| self.triangles[i as usize].positions);
        let points: Vec<DVec3> = points.map(|p| p.as_dvec3()).collect();
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (lo, hi) = points
            .iter()
            .fold(start, |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let pad = DVec3::splat(1e-6 * (1.0 + lo.abs().max(hi.abs()).max_element()));
        let node = self.nodes.len();
        self.nodes.push(Node {
            lo: lo - pad,
            hi: hi + pad,
            range: range.clone(),
            next: 0,
        });
        if range.len() > LEAF {
            let size = hi - lo;
            let axis = if size.x >= size.y && size.x >= size.z {
                0
            } else if size.y >= size.z {
                1
            } else {
                2
            };
            let key = |i: u32| {
                self.triangles[i as usize]
                    .positions
                    .map(|p| p[axis])
                    .iter()
                    .sum::<f32>()
            };
            self.order[range.clone()].sort_by(|&a, &b| key(a).total_cmp(&key(b)));
            let middle = range.start + range.len() / 2;
            self.build(range.start..middle);
            self.build(middle..range.end);
        }
        self.nodes[node].next = self.nodes.len();
    }

    /// As [`nearest`] over all triangles.
    pub(crate) fn nearest(&self, ray: &Ray) -> Option<f64> {
        let origin = Vec3::from(ray.origin).as_dvec3();
        let inverse = Vec3::from(ray.direction).as_dvec3().recip();
        let mut best: Option<f64> = None;
        let mut at = 0;
        // Nodes stand in depth-first order; a node that is missed is skipped with all below it.
        while let Some(node) = self.nodes.get(at) {
            let Node { lo, hi, range, .. } = node;
            let (a, b) = ((*lo - origin) * inverse, (*hi - origin) * inverse);
            let enter = a.min(b).max_element();
            let leave = a.max(b).min_element();
            let before = best.is_none_or(|best| enter <= best);
            if enter <= leave && leave >= 0.0 && before {
                if range.len() <= LEAF {
                    let triangles = self.order[range.clone()]
                        .iter()
                        .map(|&i| &self.triangles[i as usize]);
                    let found = nearest(ray, triangles);
                    best = best.into_iter().chain(found).min_by(f64::total_cmp);
                }
                at += 1;
            } else {
                at = node.next;
            }
        }
        best
    }
}
