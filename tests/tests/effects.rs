//! Effects change no bit that they have no business with: a frame is the same from kernels that are
//! built for what the scene calls for and from kernels that are built for more; and kernels that
//! are built for less stop.
//!
//! `SRP_EFFECTS=all` tries every effect more, every pair, and 50 random sets.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::arch::Arch;
use srp_csimgen::{Interpreter, link};
use srp_ir::split;
use srp_runtime::bvh::{self, Bvh};
use srp_runtime::core::Core;
use srp_runtime::effect::{Effect, Effects, Guard, TABLE, find};
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Scene, demo::demo};
use srp_runtime::scene_image;
use srp_runtime::system::{self, Report, SystemError};
use srp_scheduler::{Known, Options, schedule};
use srp_tests::{c_files, compiled_for, machine};

/// Pixels of a frame.
const SIZE: (u32, u32) = (40, 32);

/// A scene, and what all its frames share.
struct Studio {
    arch: Arch,
    scene: Scene,
    bvh: Bvh,
    known: Known,
}

impl Studio {
    fn of(scene: Scene) -> Studio {
        Studio {
            arch: machine("sgrt"),
            bvh: bvh::build(&scene.triangles, &bvh::Options::default()),
            scene,
            known: Known::default(),
        }
    }

    fn frame(&self, built: Effects, guard: Guard) -> Result<(Picture, Report), SystemError> {
        let Studio { arch, scene, .. } = self;
        let program = compiled_for(&c_files("kernels"), arch, built.defines().collect());
        let program = program.unwrap_or_else(|messages| panic!("{built}: {messages}"));
        let divided = split::split(&program);
        assert_eq!(divided.not_pipelined, [], "{built}");
        let options = Options {
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            known: Some(&self.known),
            ..Options::default()
        };
        let scheduled = schedule(&divided.dre, arch, &options);
        let scheduled = scheduled.unwrap_or_else(|e| panic!("{built}: {e}"));
        let spec = link(&scheduled.program, arch).unwrap_or_else(|e| panic!("{built}: {e}"));
        let image = scene_image::build(scene, &self.bvh, &scene.camera, arch, SIZE);
        let cores =
            (0..arch.system.cores).map(|_| Box::new(Interpreter::new(&spec)) as Box<dyn Core>);
        let options = system::Options {
            max_cycles: 100_000_000,
            sram_image: &scheduled.program.image,
            guard,
            kernel_names: Vec::new(),
            progress: &mut |_| {},
            cancelled: &|| false,
        };
        system::render(image.expect("it fits"), cores.collect(), arch, options)
    }

    fn picture(&self, built: Effects) -> Picture {
        let frame = self.frame(built, Guard::default());
        frame.unwrap_or_else(|e| panic!("{built}: {e}")).0
    }
}

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
    let studio = Studio::of(dull());
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

#[test]
fn a_simulator_stops_at_what_it_was_not_built_for() {
    let studio = Studio::of(demo());
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
