//! Effects change no bit that they have no business with: a frame is the same from kernels that are
//! built for what the scene calls for and from kernels that are built for more; and kernels that
//! are built for less stop.
//!
//! `SRP_EFFECTS=all` tries every effect more, every pair, and 50 random sets.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_runtime::effect::{Effect, Effects, Guard, TABLE, find};
use srp_runtime::scene::{Scene, demo::demo};
use srp_runtime::system::SystemError;
use srp_tests::studio::Studio;

/// Pixels of a frame.
const SIZE: (u32, u32) = (40, 32);

/// The default scene without mirrors and glass: it calls for few effects.
fn dull() -> Scene {
    let mut scene = demo();
    for material in &mut scene.materials {
        material.illumination = material.illumination.min(2);
        material.dissolve = 1.0;
    }
    scene
}

fn needed(scene: &Scene) -> Effects {
    find(scene).into_iter().collect()
}

/// Sets that hold `least`: some, or many where that is asked for.
fn supersets(least: Effects) -> Vec<Effects> {
    let absent: Vec<Effect> = Effects::all().minus(least).collect();
    if std::env::var("SRP_EFFECTS").as_deref() != Ok("all") {
        let some = [Effect::Antialiasing];
        let some = some.into_iter().filter(|e| absent.contains(e));
        return some
            .map(|e| least.with(e))
            .chain([Effects::all()])
            .collect();
    }
    let mut sets = vec![Effects::all()];
    for (i, &first) in absent.iter().enumerate() {
        sets.push(least.with(first));
        sets.extend(
            absent[i + 1..]
                .iter()
                .map(|&second| least.with(first).with(second)),
        );
    }
    let mut random = Pcg64Mcg::seed_from_u64(0x5e7);
    for _ in 0..50 {
        let chosen = TABLE.iter().filter(|_| random.next_u32() % 2 == 0);
        sets.push(chosen.fold(least, |set, entry| set.with(entry.effect)));
    }
    sets
}

#[test]
fn effects_that_a_scene_does_not_call_for_change_no_bit() {
    let studio = Studio::of(dull(), SIZE);
    let least = needed(&studio.scene);
    assert!(!least.contains(Effect::Reflection) && least.contains(Effect::Shadow));
    let expected = studio.picture(least);
    for set in supersets(least) {
        assert!(studio.picture(set) == expected, "{set}");
    }
    // And those that it calls for are seen.
    for effect in least.iter() {
        let without = least.without(effect);
        assert!(studio.picture(without) != expected, "{without}");
    }
}

/// Kernels call nothing that another set of effects has left out.
#[test]
fn kernels_compile_for_any_effects() {
    let studio = Studio::of(dull(), SIZE);
    for entry in &TABLE {
        studio.program(Effects::NONE.with(entry.effect));
        studio.program(Effects::all().without(entry.effect));
    }
}

#[test]
fn a_simulator_stops_at_what_it_was_not_built_for() {
    let studio = Studio::of(demo(), SIZE);
    let least = needed(&studio.scene);
    let guarded = |built: Effects| Guard::of(&studio.scene, built);
    let built = least.without(Effect::Highlight);
    let guard = guarded(built).expect("it is of surfaces");
    let stopped = studio.frame(built, guard).expect_err("it meets highlights");
    let SystemError::Effect { missing, .. } = stopped else {
        panic!("{stopped}");
    };
    assert_eq!(missing.effect, Effect::Highlight);
    assert!(missing.by.contains("material `"), "{missing}");
    assert!(guarded(least).expect("nothing is missing").is_idle());
    let unlit = guarded(least.without(Effect::Light)).expect_err("no surface has the light");
    assert_eq!(unlit.effect, Effect::Light);
}
