//! A frame without a clock is the frame with one: the same picture to the bit, and as many rays.

use glam::Vec2;
use srp_runtime::effect::{Effect, Effects, Guard, find};
use srp_runtime::scene::{Map, Scene, Texture, demo::demo};
use srp_runtime::system::CoreReport;
use srp_studies::functional::FunctionalError;
use srp_tests::studio::Studio;

/// The default scene with all that a scene can call for.
fn everything() -> Scene {
    let mut scene = demo();
    let texel = |i: u32| i.wrapping_mul(0x9e37_79b9) | 0x8000_0000;
    scene.textures = vec![Texture {
        name: "cloth".to_owned(),
        width: 7,
        height: 5,
        texels: (0..35).map(texel).collect(),
        levels: true,
    }];
    for (i, material) in scene.materials.iter_mut().enumerate() {
        let map = |clamp| Some(Map { texture: 0, clamp });
        material.diffuse_map = map(i % 2 == 0);
        material.specular_map = map(i % 2 == 1);
        material.dissolve_map = map(false).filter(|_| material.name == "stone");
    }
    for (i, triangle) in scene.triangles.iter_mut().enumerate() {
        let corner = |k: usize| Vec2::new(0.3 * k as f32, 0.1 * (i % 9) as f32);
        triangle.uvs = [corner(0), corner(1), corner(2)];
    }
    let mut second = scene.lights[0];
    second.position.x = -second.position.x;
    scene.lights.push(second);
    let options = &mut scene.options;
    options.samples = 2;
    options.bounces = 2;
    options.inter_reflections = 1;
    options.occlusion = 2;
    options.occlusion_radius = 0.5;
    scene
}

#[test]
fn the_picture_is_that_of_the_frame_with_a_clock() {
    let studio = Studio::of(everything(), (40, 24));
    let built = Effects::all();
    let found: Effects = find(&studio.scene).into_iter().collect();
    for effect in [Effect::Alpha, Effect::Refraction, Effect::InterReflection] {
        assert!(found.contains(effect), "{found}");
    }
    let program = studio.program(built);
    let frame = studio.functional(&program, &Guard::default(), 2);
    let frame = frame.unwrap_or_else(|e| panic!("{e}"));
    let (picture, report) = studio
        .frame(built, Guard::default())
        .unwrap_or_else(|e| panic!("{e}"));
    assert!(frame.complete);
    assert!(frame.picture == picture);
    let counts = frame.counts(studio.arch.system.cores);
    let sum = |of: &dyn Fn(&CoreReport) -> u64| report.cores.iter().map(of).sum::<u64>();
    assert_eq!(counts.rays.rays(), sum(&|core| core.tni.unit.rays));
    assert_eq!(counts.rays.hits(), sum(&|core| core.tni.unit.hits));
    let tests = counts.rays.triangle_tests;
    assert_eq!(tests, sum(&|core| core.tni.triangle_tests));
    let lookups = counts.texture_lookups;
    assert!(lookups > 0 && lookups == sum(&|core| core.texture_samples));
}

#[test]
fn threads_change_nothing_and_what_is_missing_is_told() {
    let studio = Studio::of(demo(), (24, 16));
    let needed: Effects = find(&studio.scene).into_iter().collect();
    let program = studio.program(needed);
    let [one, three] = [1, 3].map(|threads| {
        let frame = studio.functional(&program, &Guard::default(), threads);
        frame.unwrap_or_else(|e| panic!("{e}"))
    });
    assert_eq!(one.tiles, three.tiles);
    assert_eq!(one.profile, three.profile);
    assert!(one.picture == three.picture);

    let built = needed.without(Effect::Highlight);
    let guard = Guard::of(&studio.scene, built).expect("it is of surfaces");
    let stopped = studio.functional(&studio.program(built), &guard, 2);
    let stopped = stopped.expect_err("it meets highlights");
    let FunctionalError::Effect(missing) = stopped else {
        panic!("{stopped}");
    };
    assert_eq!(missing.effect, Effect::Highlight);
}
