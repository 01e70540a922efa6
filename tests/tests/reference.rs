//! Pictures of the kernels against an independent renderer in binary64, which shares with them the
//! document of the shading and nothing else.
//!
//! Where binary32 decides otherwise (an edge, a shadow's border) a pixel flips: such pixels are
//! counted, and all others must agree to 45 dB.

use srp_archdesc::Unwatched;
use srp_runtime::effect::{Effect, Effects, find};
use srp_runtime::scene::{
    Map, Material, Options, Scene, Texture, camera::Viewpoints, demo::demo, read,
};
use srp_studies::reference;
use srp_tests::studio::Studio;
use std::path::Path;

/// A channel that differs by more levels has had another decision.
const FLIPPED: f64 = 8.0;

fn compare(scene: Scene, size: (u32, u32)) {
    let name = scene.name.clone();
    let studio = Studio::of(scene, size);
    let built: Effects = find(&studio.scene).into_iter().collect();
    let ours = studio.picture(built);
    let options = reference::Options {
        size,
        packet: studio.arch.system.buffers.rays,
        threads: 1,
        watch: &Unwatched,
    };
    let expected = reference::picture(&studio.scene, &options).expect("nobody cancels");
    let (mut flipped, mut squares, mut channels) = (0, 0.0, 0);
    for (pixel, expected) in ours.rgba.chunks_exact(4).zip(&expected) {
        let off = |i: usize| f64::from(pixel[i]) - expected[i].round();
        let off = [off(0), off(1), off(2)];
        if off.iter().any(|d| d.abs() > FLIPPED) {
            flipped += 1;
            continue;
        }
        squares += off.iter().map(|d| d * d).sum::<f64>();
        channels += 3;
    }
    let mean = (squares / f64::from(channels)).max(1e-9);
    let decibels = 10.0 * (255.0 * 255.0 / mean).log10();
    let pixels = size.0 * size.1;
    println!("{name}: {decibels:.1} dB, {flipped} of {pixels} pixels flipped");
    assert!(decibels >= 45.0, "{name}: {decibels:.1} dB");
    assert!(
        flipped * 1000 <= pixels,
        "{name}: {flipped} of {pixels} flipped"
    );
}

/// Coarse texels with holes, so that every filter and border shows.
fn cloth() -> Texture {
    let texels = (0..7 * 5u32).map(|i| {
        let byte = |n: u32| (i * n % 251) as u8;
        u32::from_le_bytes([byte(97), byte(53), byte(29), byte(71)])
    });
    Texture {
        name: "cloth".to_owned(),
        width: 7,
        height: 5,
        texels: texels.collect(),
        levels: true,
    }
}

#[test]
fn the_default_scene() {
    compare(demo(), (64, 48));
}

/// The default scene with textures on everything flat, one with holes, and two lights.
#[test]
fn textures_holes_and_two_lights() {
    let mut scene = demo();
    scene.textures = vec![cloth()];
    let map = |clamp| Some(Map { texture: 0, clamp });
    for (i, material) in scene.materials.iter_mut().enumerate() {
        material.diffuse_map = map(i % 2 == 0);
        material.specular_map = map(i % 2 == 1).filter(|_| i > 1);
        material.dissolve_map = map(false).filter(|_| material.name == "stone");
    }
    let mut second = scene.lights[0];
    second.position.x = -second.position.x;
    second.colour = [0.2, 0.3, 0.5];
    scene.lights.push(second);
    let found: Effects = find(&scene).into_iter().collect();
    assert!(found.contains(Effect::Texture) && found.contains(Effect::Alpha));
    compare(scene, (64, 48));
}

/// Several rays a pixel, occlusion rays and diffuse reflection.
#[test]
fn samples() {
    let mut scene = demo();
    scene.options = Options {
        bounces: 2,
        samples: 3,
        occlusion: 4,
        occlusion_radius: 1.5,
        inter_reflections: 2,
    };
    compare(scene, (32, 24));
}

/// A light that sends nothing stands for no lamp: diffuse rays find what faces send out.
#[test]
fn faces_that_shine_alone() {
    let mut scene = demo();
    scene.lights[0].colour = [0.0; 3];
    for material in &mut scene.materials {
        if matches!(material.name.as_str(), "stone" | "blue") {
            material.emission = [1.0, 0.8, 0.6];
        }
    }
    scene.options = Options {
        bounces: 1,
        inter_reflections: 1,
        ..scene.options
    };
    compare(scene, (32, 24));
}

/// Glass, veils and mirrors of every illumination model. One curved glass seen through another
/// magnifies what binary32 rounds, so rays go on twice only. Nothing goes through the blocks, blue and stone,
/// whose lower faces are where the floor is: which of the two a ray finds is anybody's choice.
#[test]
fn every_illumination_model() {
    const MODELS: [u8; 8] = [0, 6, 7, 4, 1, 5, 2, 3];
    let mut scene = demo();
    scene.options.bounces = 2;
    for (i, material) in scene.materials.iter_mut().enumerate() {
        *material = Material {
            illumination: MODELS[i % MODELS.len()],
            dissolve: if i % 3 == 0 { 0.6 } else { 1.0 },
            refraction_index: 1.3,
            filter: [0.9, 0.7, 0.8],
            ..material.clone()
        };
    }
    compare(scene, (64, 48));
}

/// Scenes that nobody here made, where they are at hand.
#[test]
fn scenes_at_hand() {
    let folder = srp_tests::root().join("../shared/scenes");
    let Ok(views) = std::fs::read(folder.join("cameras.json")) else {
        println!("skipped: there is no {}", folder.display());
        return;
    };
    let views: serde_json::Value = serde_json::from_slice(&views).expect("JSON");
    for (name, file) in [
        ("sibenik", "sibenik/sibenik.obj"),
        ("lamborghini", "lamborghini/lamborghini.obj"),
        ("cornell", "cornell/CornellBox-Sphere.obj"),
        ("cornell", "cornell/CornellBox-Water.obj"),
    ] {
        let views: Viewpoints =
            serde_json::from_value(views[name].clone()).expect("the scene's views");
        let camera = views.camera(0).expect("a view");
        let load = &mut |path: &Path, _| std::fs::read(path);
        let loaded = read(&folder.join(file), Some(camera), load);
        compare(loaded.unwrap_or_else(|e| panic!("{e}")).scene, (96, 72));
    }
}
