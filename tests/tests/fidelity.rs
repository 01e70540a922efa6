//! Levels of simulation: the same picture and counts on all that run a whole frame, and samples that do
//! not depend on threads.

use srp_csimgen::{Interpreter, link};
use srp_runtime::core::Core;
use srp_runtime::effect::{Effects, Guard, find};
use srp_runtime::picture::Picture;
use srp_runtime::scene::demo::demo;
use srp_runtime::scene_image::tile_size;
use srp_runtime::system::{CodeSizes, Options, Timing};
use srp_studies::fidelity::Fidelity;
use srp_studies::fidelity::sampled::{self, FirstPass, Frame, TracedFrame};
use srp_studies::fidelity::{self, FrameFigure, FrameQuantity};
use srp_studies::figure::estimate_of;
use srp_tests::studio::Studio;
use srp_tests::{LITTLE, session};
use srp_toolchain::{Session, schedule};

const LIMIT: u64 = 1_000_000_000;

struct Kernels {
    interpreter: Interpreter,
    data: Vec<u8>,
    names: Vec<String>,
}

fn kernels(studio: &Studio, built: Effects) -> Kernels {
    let program = studio.program(built);
    let compiled = schedule(program, &studio.arch, LITTLE, &session());
    let scheduled = compiled.unwrap_or_else(|e| panic!("{e}")).schedule.program;
    let spec = link(&scheduled).unwrap_or_else(|e| panic!("{e}"));
    Kernels {
        interpreter: Interpreter::new(&spec),
        names: scheduled
            .kernels
            .values()
            .map(|k| k.dfg.name.clone())
            .collect(),
        data: scheduled.image.clone(),
    }
}

impl Kernels {
    fn cores(&self, studio: &Studio) -> Vec<Box<dyn Core>> {
        let core = |_| Box::new(self.interpreter.clone()) as Box<dyn Core>;
        (0..studio.arch.system.cores).map(core).collect()
    }

    fn options(&self, timing: Timing) -> Options<'_> {
        Options {
            timing,
            max_cycles: LIMIT,
            kernel_names: self.names.clone(),
            ..Options::new(&self.data)
        }
    }
}

fn at(studio: &Studio, kernels: &Kernels, level: Fidelity) -> (Picture, Vec<FrameFigure>) {
    let arch = level.machine(&studio.arch);
    let mut image = studio.image();
    let options = kernels.options(level.timing());
    let part = fidelity::render_tiles(&mut image, kernels.cores(studio), &arch, options)
        .unwrap_or_else(|e| panic!("{}: {e}", level.name()));
    let figures = fidelity::known(&part, &arch, &kernels.names);
    // The ledgers of all tiles, and what is around them, are the account of the frame.
    let assert_is = |quantity, cycles: u64| {
        let found = estimate_of(&figures, &quantity).map(|e| e.value);
        assert_eq!(found, Some(cycles as f64), "{}, {quantity}", level.name());
    };
    let report = &part.report;
    assert_is(FrameQuantity::Cycles, report.cycles);
    let stalls = report.cores.iter().map(|c| c.memory_stall).sum();
    assert_is(FrameQuantity::MemoryStall, stalls);
    for (number, kernel) in (0..).zip(&kernels.names) {
        let arrays = report.cores.iter().flat_map(|c| &c.array);
        let own = arrays.filter(|k| k.kernel == *kernel);
        let quantity = FrameQuantity::Array {
            kernel: number,
            name: kernel.clone(),
        };
        assert_is(quantity, own.map(|k| k.cycles).sum());
    }
    (Picture::of(&image.memory, &image.frame), figures)
}

#[test]
fn levels_agree_on_picture_and_counts_and_samples_on_themselves() {
    let studio = Studio::of(demo(), (96, 64));
    let built: Effects = find(&studio.scene).into_iter().collect();
    let kernels = kernels(&studio, built);
    let (picture, truth) = at(&studio, &kernels, Fidelity::CycleDram);
    let of = |figures: &[FrameFigure], quantity: &FrameQuantity| {
        let estimate = estimate_of(figures, quantity);
        estimate.unwrap_or_else(|| panic!("no {quantity}")).value
    };
    for level in [Fidelity::Functional, Fidelity::Analytic, Fidelity::Cycle] {
        let (other, figures) = at(&studio, &kernels, level);
        assert!(other == picture, "{}", level.name());
        for figure in figures.iter().filter(|f| f.quantity.is_count()) {
            let value = figure.estimate.value;
            assert_eq!(
                value,
                of(&truth, &figure.quantity),
                "{} {}",
                level.name(),
                figure.quantity
            );
        }
        if level != Fidelity::Functional {
            let off =
                of(&figures, &FrameQuantity::Cycles) / of(&truth, &FrameQuantity::Cycles) - 1.0;
            assert!(off.abs() < 0.3, "{} is off by {off}", level.name());
        }
    }
}

#[test]
fn samples_are_near_the_frame_and_the_same_for_any_number_of_threads() {
    let size = (512, 384);
    let studio = Studio::of(demo(), size);
    let built: Effects = find(&studio.scene).into_iter().collect();
    let kernels = kernels(&studio, built);
    let (_, truth) = at(&studio, &kernels, Fidelity::CycleDram);
    let image = studio.image();
    let traced = TracedFrame {
        scene: &studio.scene,
        image: &image,
        spec: &studio.arch.system.tni,
        fan: studio.scene.camera.ray_fan(size.0, size.1),
        eye: studio.scene.camera.position,
        size,
        tile: tile_size(studio.arch.system.buffers.rays),
        effects: built,
        texel_bits: studio.arch.precision.texture_weight_bits,
    };
    let sample = |threads: usize, seed: u64, error: f64| {
        let frame = Frame {
            image: &image,
            first_pass: &FirstPass::of(&traced, &studio.arch, threads),
            engines: &|| kernels.cores(&studio),
            arch: &studio.arch,
            sram_image: &kernels.data,
            guard: Guard::default(),
            recorded_hits: false,
            kernel_names: &kernels.names,
            code: &CodeSizes::default(),
            max_cycles: LIMIT,
            threads,
            session: &Session::default(),
            name: "",
        };
        let sampled = sampled::sample(&frame, seed, error);
        sampled
            .unwrap_or_else(|e| panic!("{e}"))
            .expect("nobody has cancelled it")
    };
    let one = sample(1, 5, 1.0);
    assert_eq!(one, sample(3, 5, 1.0));
    assert_ne!(one, sample(1, 6, 1.0));
    assert!(one.measured < one.tiles / 2, "{one:?}");
    for (name, most) in [
        (FrameQuantity::Cycles, 0.15),
        (FrameQuantity::Rays, 0.1),
        (FrameQuantity::DataCacheHits, 0.02),
    ] {
        let value = |figures: &[FrameFigure]| {
            let estimate = estimate_of(figures, &name);
            estimate.unwrap_or_else(|| panic!("no {name}")).value
        };
        let off = value(&one.figures) / value(&truth) - 1.0;
        assert!(off.abs() < most, "{name} is off by {off}");
    }
    // Where a sample would be most of the frame, it is the frame.
    let all = sample(2, 5, 1e-6);
    assert_eq!((all.measured, all.strata), (all.tiles, 0));
    assert_eq!(all.figures, truth);
}
