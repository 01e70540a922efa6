//! Whole pictures of scenes that are the same but for what must not matter: their size, their place,
//! the order of their triangles, their tree, the threads of the host.
//!
//! Where arithmetic is exact nothing changes, to the bit: a scene and its lengths times a power of two,
//! a ray from a place on a grid to a vertex on it. Elsewhere what changes is bounded. A scene that is
//! moved is rounded otherwise where points on surfaces are computed, by units of the last place of
//! larger coordinates; that moves a shadow's border or a reflection's by less than a pixel, so only
//! pixels on such borders may change by more than a level.

use glam::Vec3;
use srp_ir::Program;
use srp_runtime::bvh::{self, Builder, Layout, Options};
use srp_runtime::effect::{Effects, Guard, find};
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Scene, demo::demo};
use srp_runtime::scene_image::FAR;
use srp_runtime::tni::Tracer;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use srp_runtime::tni::place_for;
use srp_tests::studio::Studio;

const SIZE: (u32, u32) = (64, 48);

/// A scene with all its points changed.
fn mapped(scene: &Scene, to: impl Fn(Vec3) -> Vec3) -> Scene {
    let mut scene = scene.clone();
    for triangle in &mut scene.triangles {
        triangle.positions = triangle.positions.map(&to);
    }
    for light in &mut scene.lights {
        light.position = to(light.position);
    }
    scene.camera.position = to(scene.camera.position);
    scene
}

/// The default scene with all its points on a grid of 2^-10.
fn on_a_grid() -> Scene {
    mapped(&demo(), |p| (p * 1024.0).round() / 1024.0)
}

fn program(scene: &Scene) -> Program {
    let needed: Effects = find(scene).into_iter().collect();
    Studio::of(scene.clone(), SIZE).program(needed)
}

fn picture(studio: &Studio, program: &Program, threads: usize) -> Picture {
    let frame = studio.functional(program, &Guard::default(), threads);
    frame.unwrap_or_else(|e| panic!("{e}")).picture
}

/// Pixels that differ by more than so many levels.
fn differing(a: &Picture, b: &Picture, levels: u8) -> usize {
    let pixels = a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4));
    let differ = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > levels);
    pixels.filter(differ).count()
}

/// Returns the hits of the primary rays of a scene.
fn hits(studio: &Studio, options: &Options) -> Vec<Hit> {
    let Studio { arch, scene, .. } = studio;
    let tree = bvh::build(&scene.triangles, options);
    let image = bvh::lay_out(&tree, &scene.triangles, Layout::of(&arch.system.tni));
    let (memory, tree) = place_for(&arch.system, &image);
    let mut tracer = Tracer::new(&arch.system.tni, &tree, &memory);
    let fan = scene.camera.ray_fan(SIZE.0, SIZE.1);
    let origin = scene.camera.position.to_array();
    let pixels = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y)));
    let rays = pixels.map(|(x, y)| {
        let direction = fan.corner + fan.right * x as f32 + fan.down * y as f32;
        Ray::new(origin, direction.to_array(), 0.0, FAR, 0)
    });
    rays.map(|ray| tracer.trace(&ray).hit).collect()
}

#[test]
fn a_scene_times_a_power_of_two_is_the_same_picture() {
    let scene = demo();
    let program = program(&scene);
    let expected = picture(&Studio::of(scene.clone(), SIZE), &program, 2);
    for exponent in [-30, -1, 1, 40] {
        let scaled = mapped(&scene, |p| p * 2f32.powi(exponent));
        let found = picture(&Studio::of(scaled, SIZE), &program, 2);
        assert!(found == expected, "times 2^{exponent}");
    }
    // It can fail: other factors round.
    let scaled = mapped(&scene, |p| p * 1.1);
    let found = hits(&Studio::of(scaled, SIZE), &Options::default());
    assert!(found != hits(&Studio::of(scene, SIZE), &Options::default()));
}

#[test]
fn a_scene_that_is_moved_along_its_grid_is_hit_at_the_same_places() {
    let scene = on_a_grid();
    let program = program(&scene);
    let still = Studio::of(scene.clone(), SIZE);
    let (expected, places) = (
        picture(&still, &program, 2),
        hits(&still, &Options::default()),
    );
    for by in [Vec3::X * 32.0, Vec3::new(-64.0, 128.0, 512.0)] {
        let moved = Studio::of(mapped(&scene, |p| p + by), SIZE);
        // 10 + 10 bits of a coordinate: all differences are exact, so all decisions are the same.
        assert_eq!(hits(&moved, &Options::default()), places, "by {by}");
        let found = picture(&moved, &program, 2);
        let changed = differing(&found, &expected, 1);
        println!("moved by {by}: {changed} of {} pixels change", 64 * 48);
        assert!(changed * 100 <= 64 * 48, "by {by}: {changed} pixels");
    }
}

#[test]
fn the_order_of_triangles_does_not_matter() {
    let scene = demo();
    let program = program(&scene);
    let studio = Studio::of(scene.clone(), SIZE);
    let expected = picture(&studio, &program, 2);
    let places = hits(&studio, &Options::default());
    let count = scene.triangles.len();
    // 7919 is a prime that does not divide their number.
    assert!(!count.is_multiple_of(7919));
    let order: Vec<usize> = (0..count).map(|i| i * 7919 % count).collect();
    let permuted = Scene {
        triangles: order.iter().map(|&i| scene.triangles[i]).collect(),
        ..scene
    };
    let studio = Studio::of(permuted, SIZE);
    let mut ties = 0;
    for (new, old) in hits(&studio, &Options::default()).iter().zip(&places) {
        assert_eq!(new.t, old.t);
        let same = !new.is_hit() || order[new.primitive as usize] == old.primitive as usize;
        ties += usize::from(!same);
    }
    let found = picture(&studio, &program, 2);
    let changed = differing(&found, &expected, 0);
    println!("{ties} ties, {changed} pixels change");
    // A point that two triangles share belongs to the first of them, which is another now.
    assert!(
        ties * 100 <= 64 * 48 && changed <= ties + 64 * 48 / 200,
        "{ties}, {changed}"
    );
}

#[test]
fn the_tree_does_not_matter() {
    let scene = demo();
    let program = program(&scene);
    let expected = picture(&Studio::of(scene.clone(), SIZE), &program, 2);
    let trees = Builder::ALL.map(|builder| Options {
        builder,
        ..Options::default()
    });
    let leaves = [1, 16].map(|max_leaf| Options {
        max_leaf,
        ..Options::default()
    });
    for options in trees.into_iter().chain(leaves) {
        let studio = Studio::of(scene.clone(), SIZE).with_tree(&options);
        let found = picture(&studio, &program, 2);
        assert_eq!(differing(&found, &expected, 0), 0, "{options:?}");
    }
}

#[test]
fn threads_do_not_matter() {
    let scene = demo();
    let program = program(&scene);
    let studio = Studio::of(scene, SIZE);
    assert!(picture(&studio, &program, 1) == picture(&studio, &program, 2));
}
