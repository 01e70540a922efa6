//! How frames and programs end that do not draw a picture: refused, stuck, stopped, or with a status.

use super::{casters, frame, machine};
use srp_archdesc::Watch;
use srp_archdesc::arch::Approx;
use srp_archdesc::ports;
use srp_runtime::bvh;
use srp_runtime::core::{Activity, Bus, Core, Run, Trap};
use srp_runtime::memory::BASE;
use srp_runtime::scene::demo::demo;
use srp_runtime::scene_image;
use srp_runtime::scene_image::ImageError;
use srp_runtime::solo;
use srp_runtime::solo::{Finish, Solo, SoloError};
use srp_runtime::system;
use srp_runtime::system::{Options, SharedWords, SystemError};
use std::sync::atomic::{AtomicU32, Ordering};

/// An engine that does one thing for ever, or once.
struct Simple(fn(&mut dyn Bus) -> Run);

impl Core for Simple {
    fn run(&mut self, bus: &mut dyn Bus, _budget: u64) -> Result<Run, Trap> {
        Ok((self.0)(bus))
    }
}

fn run(activity: Activity) -> Run {
    Run {
        cycles: 1,
        activity,
        operations: 0,
    }
}

fn error_of(engine: fn(&mut dyn Bus) -> Run) -> String {
    let engines: Vec<Box<dyn Core>> = vec![Box::new(Simple(engine))];
    let result = frame(&demo(), (8, 8), engines, &machine());
    result.expect_err("the frame cannot end").to_string()
}

#[test]
fn cores_that_wait_for_ever_are_named() {
    assert_eq!(
        error_of(|bus| {
            assert!(bus.port_in(ports::TNI_DONE).is_none());
            run(Activity::Wait(ports::TNI_DONE))
        }),
        "nobody moves any more in cycle 65:\n  \
         core 0 waits for port 4 (a finished submission); its T&I unit: 0 submissions \
         (0 complete), 0 rays resident, 0 of them waiting for nodes and 0 for triangles\n  \
         0 memory requests are on the way"
    );
    assert!(error_of(|_| run(Activity::Wait(77))).contains("port 77 (which does not exist)"));
}

/// A core that writes four words, or reads as many, and ends.
struct Toucher {
    address: u32,
    writes: bool,
}

impl Core for Toucher {
    fn run(&mut self, bus: &mut dyn Bus, _budget: u64) -> Result<Run, Trap> {
        let done = match self.writes {
            true => bus.cached_store(self.address, 16, [1; 4]).is_some(),
            false => bus.cached_load(self.address, 16).is_some(),
        };
        assert!(done, "it is mapped");
        Ok(run(Activity::Halted(0)))
    }
}

/// One core writes; another reads the same words, or others, or the first one is alone with them.
#[test]
fn words_that_cores_share_are_told() {
    let (scene, arch) = (demo(), machine());
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    for (uses, count) in [
        (&[(0, true), (0, false)][..], 4),
        (&[(0, true), (16, false)], 0),
        (&[(0, false), (0, false)], 0),
        (&[(0, true)], 0),
    ] {
        let image =
            scene_image::build(&scene, &bvh, &scene.camera, &arch, (8, 8)).expect("it fits");
        let first = image.memory.first_writable_address();
        let engine = |&(offset, writes)| -> Box<dyn Core> {
            let address = first + offset;
            Box::new(Toucher { address, writes })
        };
        let engines = uses.iter().map(engine).collect();
        let rendered = system::render(image, engines, &arch, Options::new(b""));
        let report = rendered.expect("the frame ends").1;
        let expected = SharedWords {
            count,
            first: (count > 0).then_some(first),
        };
        assert_eq!(report.shared_words, expected, "{uses:?}");
        assert_eq!(
            report
                .text()
                .contains("nothing keeps their caches coherent"),
            count > 0
        );
    }
}

#[test]
fn what_cannot_be_done_is_said() {
    assert_eq!(
        error_of(|bus| {
            bus.port_out(ports::TNI_RAYS, 0x3_f000);
            bus.port_out(ports::TNI_START, 64);
            run(Activity::Vliw)
        }),
        "core 0 handed its T&I unit a buffer of 4096 bytes at 0x3f000, which is outside the SRAM \
         or not aligned to 4 bytes"
    );
    let result = frame(&demo(), (8, 8), Vec::new(), &machine());
    assert_eq!(result.expect_err("no cores"), SystemError::NoCores);
    let mut arch = machine();
    arch.system.tni.trv_l1.line = 96;
    let result = frame(&demo(), (8, 8), casters(1), &arch);
    assert_eq!(
        result.expect_err("odd lines").to_string(),
        "this machine cannot be simulated: a line of the T&I unit's level-2 cache, of 64 bytes, is not \
         made of lines of level 1, of 96: make it a multiple of them"
    );
}

#[test]
fn only_the_frame_buffer_can_be_written() {
    let engine = |bus: &mut dyn Bus| {
        assert_eq!(bus.sram().len(), 240 << 10);
        assert_eq!(bus.sram()[..6], *b"data\0\0");
        let lanes = bus
            .cached_load(BASE + 144, 16)
            .expect("the header is mapped");
        let framebuffer = lanes[3];
        assert!(bus.cached_store(framebuffer, 16, [1, 2, 3, 4]).is_some());
        assert_eq!(bus.cached_load(framebuffer + 4, 4), Some([2, 0, 0, 0]));
        assert_eq!(bus.cached_load(framebuffer + 6, 1), Some([0; 4]));
        for (address, bytes) in [(BASE, 4), (framebuffer - 4, 4), (framebuffer + 2, 4)] {
            assert!(bus.cached_store(address, bytes, [0; 4]).is_none());
        }
        for (address, bytes) in [
            (0, 4),
            (BASE - 4, 4),
            (BASE + 8, 16),
            (u32::MAX - 3, 4),
            (BASE, 8),
        ] {
            assert!(bus.cached_load(address, bytes).is_none());
        }
        run(Activity::Halted(3))
    };
    let engines: Vec<Box<dyn Core>> = vec![Box::new(Simple(engine))];
    let (_, report) = frame(&demo(), (8, 8), engines, &machine()).expect("it ends");
    assert_eq!(report.cores[0].exit_status, 3);
}

#[test]
fn printing_and_exit() {
    let engine = |bus: &mut dyn Bus| {
        for &byte in b"hello" {
            assert!(bus.port_out(ports::PUTCHAR, u32::from(byte)));
        }
        assert!(bus.port_out(ports::EXIT, (-2i32) as u32));
        run(Activity::Vliw)
    };
    let engines: Vec<Box<dyn Core>> = vec![Box::new(Simple(engine))];
    let (_, report) = frame(&demo(), (8, 8), engines, &machine()).expect("it ends");
    let core = &report.cores[0];
    assert_eq!((core.output.as_str(), core.exit_status), ("hello", -2));
    assert_eq!((core.vliw, core.idle), (1, report.cycles - 1));
}

/// A watch that wants work to end as soon as it asks.
#[derive(Default)]
struct Impatient {
    asked: AtomicU32,
}

impl Watch for Impatient {
    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed);
        true
    }
}

#[test]
fn frames_stop_when_told() {
    let (scene, arch) = (demo(), machine());
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let image = |size| scene_image::build(&scene, &bvh, &scene.camera, &arch, size);
    let forever = || -> Vec<Box<dyn Core>> { vec![Box::new(Simple(|_| run(Activity::Vliw)))] };
    let patience = Impatient::default();
    let result = system::render(
        image((8, 8)).expect("it fits"),
        forever(),
        &arch,
        Options {
            watch: &patience,
            ..Options::new(&[])
        },
    );
    let (_, report) = result.expect("what there is until then");
    assert_eq!(patience.asked.load(Ordering::Relaxed), 1);
    assert!(!report.complete && report.tiles_taken == 0 && report.tiles == 1);
    assert_eq!(report.cores[0].vliw, report.cycles);
    assert!(
        report.text().starts_with("0 of 1 tiles of 8x8 pixels"),
        "{}",
        report.text()
    );
    let result = system::render(
        image((8, 8)).expect("it fits"),
        forever(),
        &arch,
        Options {
            max_cycles: 100_000,
            ..Options::new(&[])
        },
    );
    let error = result.expect_err("too long").to_string();
    let (first, waits) = error.split_once('\n').expect("several lines");
    assert_eq!(first, "the frame takes more than 100000 cycles:");
    assert!(
        waits.starts_with("  core 0 runs; its T&I unit: "),
        "{waits}"
    );
    for size in [(0, 8), (8, 0), (20_000, 8)] {
        assert!(image(size).is_err());
    }
}

#[test]
fn a_frame_that_is_too_large_is_known_before_it_is_built() {
    let (scene, arch) = (demo(), machine());
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let check = |size| scene_image::check(&scene, &bvh, &arch, size);
    assert_eq!(check((320, 240)), Ok(()));
    assert!(matches!(
        check((16384, 16384)),
        Err(ImageError::TooLarge { .. })
    ));
    assert!(matches!(check((0, 8)), Err(ImageError::Size { .. })));
}

#[test]
fn the_header_tells_the_widening_of_the_machine() {
    let mut arch = machine();
    arch.precision.rcp = Approx::table(12, 0);
    let scene = demo();
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let image = scene_image::build(&scene, &bvh, &scene.camera, &arch, (8, 8)).expect("it fits");
    let bytes = image
        .memory
        .get(BASE + 184, 4)
        .expect("the header is mapped");
    let factor = f32::from_le_bytes(bytes.try_into().expect("4 bytes"));
    assert_eq!(factor, arch.precision.widening());
    assert!(factor > 1.0 + 2.0 / 4096.0);
}

#[test]
fn a_core_by_itself_stops_when_told() {
    let mut core = Simple(|_| run(Activity::Vliw));
    let mut bus = Solo::new(&[], 64);
    for (limit, why) in [
        (u64::MAX, SoloError::Stopped),
        (1000, SoloError::Endless { limit: 1000 }),
    ] {
        let mut account = Finish::default();
        let end = solo::run_until(
            &mut core,
            &mut bus,
            limit,
            &Impatient::default(),
            &mut account,
        );
        assert_eq!(end, Err(why));
        assert!(account.vliw > 0 && account.cycles() == account.vliw);
        assert!(account.vliw <= limit);
    }
}
