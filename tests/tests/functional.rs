//! A frame without a clock is the frame with one: the same picture to the bit, and as many rays.

use glam::Vec2;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_runtime::effect::{Effect, Effects, Guard, find};
use srp_runtime::scene::{Map, Scene, Texture, demo::demo};
use srp_runtime::system::CoreReport;
use srp_studies::functional::FunctionalError;
use srp_tests::studio::Studio;
use std::collections::BTreeMap;
use std::time::SystemTime;

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

/// A number of a few, the ends among them.
fn one_of<T: Copy>(random: &mut Pcg32, from: &[T]) -> T {
    from[random.next_u32() as usize % from.len()]
}

/// The scene with all that there is, with other materials, options and maps.
fn odd(random: &mut Pcg32) -> Scene {
    let mut scene = everything();
    let texel = |random: &mut Pcg32| match random.next_u32() % 3 {
        0 => u32::MAX,
        1 => 0,
        _ => random.next_u32(),
    };
    let same = texel(random);
    for texel_of in &mut scene.textures[0].texels {
        *texel_of = if random.next_u32().is_multiple_of(2) {
            same
        } else {
            texel(random)
        };
    }
    // Of few kinds, so that a scene calls for few effects.
    let two = |random: &mut Pcg32, from: &[f32]| [(); 2].map(|()| one_of(random, from));
    let kinds = [(); 2].map(|()| one_of(random, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]));
    let shines = two(random, &[0.0, 0.0, 0.2, 1.0]);
    let indices = two(random, &[1.0, 1.0, 1.5, 0.8, 2.4]);
    let dissolves = two(random, &[0.0, 0.2, 0.7, 1.0, 1.0]);
    let has_maps = [(); 3].map(|()| random.next_u32().is_multiple_of(2));
    for material in &mut scene.materials {
        let map = |random: &mut Pcg32, has: bool| {
            let clamp = random.next_u32().is_multiple_of(2);
            let is_there = has && random.next_u32().is_multiple_of(2);
            is_there.then_some(Map { texture: 0, clamp })
        };
        let mut colour = || [(); 3].map(|()| one_of(random, &[0.0, 0.2, 0.7, 1.0]));
        (material.diffuse, material.filter) = (colour(), colour());
        material.specular = [one_of(random, &shines); 3];
        material.emission = [one_of(random, &[0.0, 0.0, 0.1]); 3];
        material.exponent = one_of(random, &[0.0, 1.0, 5.0, 100.0]);
        material.dissolve = one_of(random, &dissolves);
        material.refraction_index = one_of(random, &indices);
        material.illumination = one_of(random, &kinds);
        material.diffuse_map = map(random, has_maps[0]);
        material.specular_map = map(random, has_maps[1]);
        material.dissolve_map = map(random, has_maps[2]);
    }
    scene.lights.truncate(one_of(random, &[0, 1, 2]));
    let options = &mut scene.options;
    options.samples = one_of(random, &[1, 2]);
    options.bounces = one_of(random, &[0, 1, 4]);
    options.inter_reflections = one_of(random, &[0, 1]);
    options.occlusion = one_of(random, &[0, 2]);
    scene
}

/// Seeds of scenes that called for less than is seen: a dark dielectric, of which the mirrored part follows from the angle behind it.
const FOUND: [u64; 1] = [1_795_855_090];

/// Kernels that are built for more than a scene calls for make the same picture, whatever its materials are. The seed is fresh each
/// time; `SRP_ODD_SCENES` is how many there are, and `SRP_ODD_SEED` takes another.
#[test]
fn odd_scenes_call_for_all_that_is_seen() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let first = number("SRP_ODD_SEED").unwrap_or_else(|| {
        let now = SystemTime::UNIX_EPOCH.elapsed();
        now.map_or(0, |since| since.as_secs())
    });
    let count = number("SRP_ODD_SCENES").unwrap_or(12);
    println!("odd scenes: SRP_ODD_SEED={first}");
    let universal = Studio::of(demo(), (1, 1)).program(Effects::all());
    let mut programs = BTreeMap::new();
    for seed in FOUND.into_iter().chain(first..first + count) {
        let studio = Studio::of(odd(&mut Pcg32::new(seed, 0x0dd)), (32, 24));
        let found: Effects = find(&studio.scene).into_iter().collect();
        let own = programs
            .entry(found)
            .or_insert_with(|| studio.program(found));
        let [own, all] = [&*own, &universal].map(|program| {
            let frame = studio.functional(program, &Guard::default(), 2);
            frame
                .unwrap_or_else(|e| panic!("SRP_ODD_SEED={seed}: {e}"))
                .picture
        });
        assert!(
            own == all,
            "SRP_ODD_SEED={seed}: {found}: {:?}",
            studio.scene.materials
        );
    }
}
