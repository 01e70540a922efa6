//! The hits of every test and of both pipelines against brute force in binary64, on rays that nobody
//! has aimed. `SRP_TRUTH_RAYS` says how many; they are spread over the scenes that are there.
//! `SRP_PIPED_RAYS`, a tenth otherwise, says how many of them go through both pipelines, whose hits have
//! to be those of the arithmetic. Brute force is made bearable by a tree, which is compared with it.
//!
//! A ray that passes an edge as closely as binary32 can tell may hit either side, and of triangles
//! that are equally far as binary32 can tell any may be named. Beyond that nothing is excused but
//! what the paper's own test loses, which is counted.

use crate::support::{NearestTree, Random, image_for, machine, nearest, shared_scene, truth};
use glam::Vec3;
use srp_archdesc::datapath::Intersection;
use srp_archdesc::system::{NodeFormat, Pipeline, SystemSpec, TniSpec};
use srp_runtime::bvh::{Builder, TreeImage};
use srp_runtime::scene::{Triangle, bounds, demo::demo};
use srp_runtime::tni::Tracer;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use srp_runtime::tni::place_for;
use srp_studies::tni::drive;

/// How closely binary32 tells whether a ray passes an edge: parts of the coordinates on the way.
const EDGE: f64 = 2e-6;

/// How closely it tells distances.
const DISTANCE: f64 = 1e-4;

/// How many rays, and how many of them go through both pipelines.
fn counts() -> (usize, usize) {
    let number = |name: &str| {
        let text = std::env::var(name).ok()?;
        Some(
            text.parse()
                .unwrap_or_else(|_| panic!("{name} is a number")),
        )
    };
    let all = number("SRP_TRUTH_RAYS").unwrap_or(100_000);
    (all, number("SRP_PIPED_RAYS").unwrap_or(all / 10))
}

fn scenes() -> Vec<(&'static str, Vec<Triangle>)> {
    let mut scenes = vec![("default", demo().triangles)];
    for (name, path) in [
        ("sibenik", "sibenik/sibenik.obj"),
        ("lamborghini", "lamborghini/lamborghini.obj"),
        ("bunny", "bunny/stanford-bunny.obj"),
        ("water", "cornell/CornellBox-Water.obj"),
        ("mirror", "cornell/CornellBox-Mirror.obj"),
    ] {
        scenes.extend(shared_scene(path).map(|scene| (name, scene.triangles)));
    }
    scenes
}

fn rays(triangles: &[Triangle], count: usize, random: &mut Random) -> Vec<Ray> {
    let (lo, hi) = bounds(triangles).expect("a scene has triangles");
    let ray = |_| {
        let origin = random.point(lo, hi).to_array();
        Ray::new(origin, random.direction().to_array(), 0.0, f32::MAX, 0)
    };
    (0..count).map(ray).collect()
}

/// How far inside a triangle a ray passes, in units of length over the coordinates on the way; and
/// the distance.
fn passes(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64)> {
    let (t, inside) = truth(ray, triangle)?;
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let height = (b - a).cross(c - a).length() / longest;
    let origin = Vec3::from(ray.origin).abs().max_element();
    let length = Vec3::from(ray.direction).as_dvec3().length();
    // A ray along the plane crosses the edge in a long stretch.
    let size = f64::from(origin) + t.abs() * length + longest;
    Some((t, inside * height * slope(ray, triangle) / size))
}

/// Sine of the angle between a ray and a triangle's plane.
fn slope(ray: &Ray, triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let direction = Vec3::from(ray.direction).as_dvec3().normalize();
    direction.dot(normal).abs()
}

/// Returns the fault of a hit, if it has one; `sure` is where the nearest really is.
fn wrong(
    test: Intersection,
    ray: &Ray,
    hit: &Hit,
    sure: Option<f64>,
    triangles: &[Triangle],
) -> Option<String> {
    let got = hit.is_hit().then(|| f64::from(hit.t));
    let origin = Vec3::from(ray.origin);
    // Woop's test interpolates between the vertices relative to the origin: a rounding of them moves
    // the plane by as much, and the hit by that over the slope.
    let rounded = match test {
        Intersection::Woop if hit.is_hit() => {
            let triangle = &triangles[hit.primitive as usize];
            let reach = triangle.positions.map(|p| (p - origin).abs().max_element());
            let largest = reach.into_iter().fold(origin.abs().max_element(), f32::max);
            f64::from(largest) / slope(ray, triangle).max(1e-3)
        }
        _ => f64::from(origin.abs().max_element()),
    };
    let near = |a: f64, b: f64| (a - b).abs() <= DISTANCE * b.abs() + 1e-6 * rounded;
    let close = match (got, sure) {
        (None, None) => true,
        (Some(t), Some(truth)) => near(t, truth),
        _ => false,
    };
    let named = |hit: &Hit| {
        let passed = passes(ray, &triangles[hit.primitive as usize]);
        passed.is_some_and(|(t, inside)| inside >= -EDGE && near(f64::from(hit.t), t))
    };
    if close && (got.is_none() || named(hit)) {
        return None;
    }
    // Is there a triangle that it hits without any doubt, before what was found?
    let missed = triangles
        .iter()
        .filter_map(|t| passes(ray, t))
        .any(|(t, inside)| {
            let before = got.is_none_or(|got| t < got && !near(t, got));
            t > DISTANCE && inside > EDGE && before
        });
    let invented = hit.is_hit() && !named(hit);
    (missed || invented).then(|| format!("{ray:?}: got {hit:?}, the truth is {sure:?}"))
}

/// All tests, and boxes in all formats.
const UNITS: [(Intersection, NodeFormat); 7] = [
    (Intersection::Wald, NodeFormat::F32),
    (Intersection::AnchorWald, NodeFormat::F32),
    (Intersection::AnchorWaldScaled, NodeFormat::F32),
    (Intersection::Woop, NodeFormat::F32),
    (Intersection::AnchorWaldScaled, NodeFormat::F16),
    (Intersection::Woop, NodeFormat::Q8),
    (Intersection::WoopWide, NodeFormat::F32),
];

fn with((test, node_format): (Intersection, NodeFormat)) -> SystemSpec {
    let system = machine();
    SystemSpec {
        tni: TniSpec {
            intersection: test,
            node_format,
            node_bytes: node_format.bytes(),
            ..system.tni
        },
        ..system
    }
}

/// Rays that are in memory at once.
const CHUNK: usize = 1 << 18;

/// A machine with one of the ray–triangle tests, and the scene's tree for it.
struct Bench {
    spec: SystemSpec,
    image: TreeImage,
}

impl Bench {
    fn new(unit: (Intersection, NodeFormat), triangles: &[Triangle]) -> Bench {
        let spec = with(unit);
        let image = image_for(&spec.tni, triangles, Builder::Sweep);
        Bench { spec, image }
    }

    fn test(&self) -> Intersection {
        self.spec.tni.intersection
    }

    /// Traces the rays, and the first `piped` of them with both pipelines too, which have to agree.
    fn hits(&self, rays: &[Ray], piped: usize) -> Vec<Hit> {
        let (memory, tree) = place_for(&self.spec, &self.image);
        let mut tracer = Tracer::new(&self.spec.tni, &tree, &memory);
        let hits: Vec<Hit> = rays.iter().map(|ray| tracer.trace(ray).hit).collect();
        let piped = &rays[..piped.min(rays.len())];
        for pipeline in [Pipeline::Single, Pipeline::Parallel] {
            let mut spec = self.spec.clone();
            spec.tni.pipeline = pipeline;
            for (record, hit) in drive(&spec, &self.image, piped).hits.iter().zip(&hits) {
                assert_eq!(record.hit, *hit, "{}, {pipeline:?}", self.test().name());
            }
        }
        hits
    }
}

/// How many hits of each unit are wrong, of `count` rays, and one that is.
fn wrongs(triangles: &[Triangle], count: usize, piped: usize) -> [(usize, Option<String>); 6] {
    let tree = NearestTree::new(triangles);
    let benches = UNITS.map(|unit| Bench::new(unit, triangles));
    let mut found = [const { (0, None) }; 6];
    let mut random = Random::new(21);
    for start in (0..count).step_by(CHUNK) {
        let rays = rays(triangles, CHUNK.min(count - start), &mut random);
        let truths: Vec<Option<f64>> = rays.iter().map(|ray| tree.nearest(ray)).collect();
        for (bench, (number, example)) in benches.iter().zip(&mut found) {
            let hits = bench.hits(&rays, piped.saturating_sub(start));
            for ((ray, hit), truth) in rays.iter().zip(&hits).zip(&truths) {
                if let Some(wrong) = wrong(bench.test(), ray, hit, *truth, triangles) {
                    *number += 1;
                    *example = Some(wrong);
                }
            }
        }
    }
    found
}

#[test]
fn every_test_and_pipeline_hits_what_brute_force_hits() {
    let scenes = scenes();
    let (all, piped) = counts();
    let (each, piped) = (all.div_ceil(scenes.len()), piped.div_ceil(scenes.len()));
    let mut lost_without_remedy = 0;
    for (name, triangles) in &scenes {
        let wrongs = wrongs(triangles, each, piped);
        for ((test, format), (wrong, example)) in UNITS.into_iter().zip(wrongs) {
            let boxes = format.name();
            println!("{name}, {}, {boxes}: {wrong} of {each} wrong", test.name());
            if matches!(test, Intersection::Wald | Intersection::AnchorWald) {
                lost_without_remedy += wrong;
            } else {
                assert_eq!(example, None, "{name}, {}, {boxes}", test.name());
            }
        }
    }
    println!(
        "lost between triangles, or inexact, by the tests without a remedy: {lost_without_remedy}"
    );
}

/// The tree of boxes that stands for brute force leaves out no triangle that is hit.
#[test]
fn the_tree_in_binary64_is_brute_force() {
    for (name, triangles) in scenes() {
        let tree = NearestTree::new(&triangles);
        let count = (counts().0 * 20 / triangles.len()).clamp(20, 2000);
        for ray in rays(&triangles, count, &mut Random::new(23)) {
            let brute = nearest(&ray, triangles.iter());
            assert_eq!(tree.nearest(&ray), brute, "{name}: {ray:?}");
        }
    }
}
