//! The hits of every test and of both pipelines against brute force in binary64, on rays that nobody
//! has aimed. `SRP_TRUTH_RAYS` says how many; they are spread over the scenes that are there.
//!
//! A ray that passes an edge as closely as binary32 can tell may hit either side, and of triangles
//! that are equally far as binary32 can tell any may be named. Beyond that nothing is excused but
//! what the paper's own test loses, which is counted.

mod support;

use glam::Vec3;
use srp_archdesc::datapath::Intersection;
use srp_archdesc::system::{Pipeline, SystemSpec, TniSpec};
use srp_runtime::bvh::Builder;
use srp_runtime::scene::{Triangle, bounds, demo::demo};
use srp_runtime::tni::Tracer;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use srp_runtime::tni::standalone::{drive, place_for};
use support::{NearestTree, Random, image_for, machine, shared_scene, truth};

/// How closely binary32 tells whether a ray passes an edge: parts of the coordinates on the way.
const EDGE: f64 = 2e-6;

/// How closely it tells distances.
const DISTANCE: f64 = 1e-4;

fn count() -> usize {
    let all = std::env::var("SRP_TRUTH_RAYS");
    all.map_or(100_000, |n| n.parse().expect("SRP_TRUTH_RAYS is a number"))
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
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let slope = (Vec3::from(ray.direction).as_dvec3() / length).dot(normal);
    let size = f64::from(origin) + t.abs() * length + longest;
    Some((t, inside * height * slope.abs() / size))
}

/// What is wrong with a hit, if anything is.
fn wrong(ray: &Ray, hit: &Hit, triangles: &[Triangle], tree: &NearestTree<'_>) -> Option<String> {
    let sure = tree.nearest(ray);
    let got = hit.is_hit().then(|| f64::from(hit.t));
    let near = |a: f64, b: f64| {
        let coordinate = f64::from(Vec3::from(ray.origin).abs().max_element());
        (a - b).abs() <= DISTANCE * b.abs() + 1e-6 * coordinate
    };
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

fn with(test: Intersection) -> SystemSpec {
    let system = machine();
    SystemSpec {
        tni: TniSpec {
            intersection: test,
            ..system.tni
        },
        ..system
    }
}

#[test]
fn every_test_hits_what_brute_force_hits() {
    let scenes = scenes();
    let each = count().div_ceil(scenes.len());
    let mut lost_by_wald = 0;
    for (name, triangles) in &scenes {
        let truth = NearestTree::new(triangles);
        let rays = rays(triangles, each, &mut Random::new(21));
        for test in Intersection::ALL {
            let spec = with(test);
            let image = image_for(&spec.tni, triangles, Builder::Sweep);
            let (memory, tree) = place_for(&spec, &image);
            let mut tracer = Tracer::new(&spec.tni, &tree, &memory);
            let mut wrongs = Vec::new();
            for ray in &rays {
                wrongs.extend(wrong(ray, &tracer.trace(ray).hit, triangles, &truth));
            }
            println!("{name}, {}: {} of {each} wrong", test.name(), wrongs.len());
            if matches!(test, Intersection::Wald | Intersection::AnchorWald) {
                lost_by_wald += wrongs.len();
            } else {
                assert!(wrongs.is_empty(), "{name}, {}: {}", test.name(), wrongs[0]);
            }
        }
    }
    println!("lost between triangles by the tests without a remedy: {lost_by_wald}");
}

#[test]
fn both_pipelines_hit_what_the_arithmetic_says() {
    let mut random = Random::new(22);
    for (name, triangles) in &scenes()[..2.min(scenes().len())] {
        let rays = rays(triangles, count().min(1_000_000) / 20, &mut random);
        for test in Intersection::ALL {
            for pipeline in [Pipeline::Single, Pipeline::Parallel] {
                let mut spec = with(test);
                spec.tni.pipeline = pipeline;
                let image = image_for(&spec.tni, triangles, Builder::Sweep);
                let hits = drive(&spec, &image, &rays).hits;
                let (memory, tree) = place_for(&spec, &image);
                let mut tracer = Tracer::new(&spec.tni, &tree, &memory);
                for (ray, record) in rays.iter().zip(&hits) {
                    let expected = tracer.trace(ray).hit;
                    assert_eq!(
                        record.hit,
                        expected,
                        "{name}, {}, {pipeline:?}",
                        test.name()
                    );
                }
            }
        }
    }
}
