//! Whole frames, with engines written by hand in the place of simulated SRPs.

mod caster;
mod ends;
#[path = "../support/mod.rs"]
mod support;

use caster::{Caster, RAYS};
use srp_archdesc::Arch;
use srp_runtime::bvh;
use srp_runtime::core::{Core, Run};
use srp_runtime::memory::BASE;
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Scene, demo::demo};
use srp_runtime::scene_image;
use srp_runtime::system::{
    self, CoreView, MemoryRequest, Observer, Options, QueuedTile, Report, Requester, SentPacket,
    Stall, SystemError, TakenTile, TileQueue, Timing, WarmCaches,
};
use srp_runtime::tni::arithmetic::Ray;
use srp_runtime::tni::{HitRecord, RayCost};
use std::sync::Arc;

fn machine() -> Arch {
    let file = srp_archdesc::machines::SGRT;
    srp_archdesc::parse(file.name, file.xml).expect("the shipped machine is valid")
}

fn frame(
    scene: &Scene,
    size: (u32, u32),
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
) -> Result<(Picture, Report), SystemError> {
    frame_of(scene, size, engines, arch, Timing::Full)
}

fn frame_of(
    scene: &Scene,
    size: (u32, u32),
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    timing: Timing,
) -> Result<(Picture, Report), SystemError> {
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let image = scene_image::build(scene, &bvh, &scene.camera, arch, size)
        .expect("a small scene fits in memory");
    let options = Options {
        timing,
        max_cycles: 1_000_000_000,
        kernel_names: vec!["primary".to_owned()],
        ..Options::new(b"data")
    };
    system::render(image, engines, arch, options)
}

fn casters(count: usize) -> Vec<Box<dyn Core>> {
    (0..count)
        .map(|_| Box::new(Caster::default()) as Box<dyn Core>)
        .collect()
}

#[test]
fn a_frame_is_drawn_and_accounted_for() {
    let (scene, arch) = (demo(), machine());
    // Neither side is a multiple of a tile.
    let size = (90, 61);
    let (picture, report) = frame(&scene, size, casters(4), &arch).expect("the frame ends");
    if let Ok(path) = std::env::var("SRP_TEST_PICTURE") {
        std::fs::write(path, picture.png()).expect("the path can be written");
    }
    assert_eq!((picture.width, picture.height), size);
    assert_eq!(report.rays, 12 * 8 * 64);
    for core in &report.cores {
        let array: u64 = core.array.iter().map(|k| k.cycles).sum();
        let wait: u64 = core.wait.iter().map(|w| w.cycles).sum();
        let sum = core.vliw
            + array
            + core.switch
            + core.memory_stall
            + core.texture_stall
            + core.instruction_stall
            + core.context_stall
            + core.sram_stall
            + wait
            + core.idle;
        assert_eq!(sum, report.cycles);
        assert!(core.memory_stall > 0 && wait > 0);
    }
    assert!(report.text().contains("array: primary"));

    // Every pixel is what brute force says.
    let fan = scene.camera.ray_fan(size.0, size.1);
    for (i, pixel) in picture.rgba.chunks_exact(4).enumerate() {
        let (x, y) = (i as u32 % size.0, i as u32 / size.0);
        let direction = fan.corner + x as f32 * fan.right + y as f32 * fan.down;
        let ray = Ray::new(
            scene.camera.position.to_array(),
            direction.normalize().to_array(),
            0.0,
            1e30,
            0,
        );
        let hit = support::nearest(&ray, scene.triangles.iter()).is_some();
        let background = scene.background.map(|c| (255.0 * c) as u8);
        assert_eq!(pixel[..3] != background, hit, "pixel {x}, {y}");
        assert_eq!(pixel[3], 255);
    }

    let (again, same) = frame(&scene, size, casters(4), &arch).expect("the frame ends");
    assert_eq!(again, picture);
    assert_eq!(same, report);

    let (alone, slower) = frame(&scene, size, casters(1), &arch).expect("the frame ends");
    assert_eq!(alone, picture);
    assert!(slower.cycles > 2 * report.cycles);

    // With hits that are there at once, nothing is left of the T&I units but what they answer.
    let fed =
        frame_of(&scene, size, casters(4), &arch, Timing::RecordedHits).expect("the frame ends");
    assert_eq!(fed.0, picture);
    assert_eq!(
        (fed.1.rays, fed.1.tni().unit.hits),
        (report.rays, report.tni().unit.hits)
    );
    assert_eq!(fed.1.tni().trv_l1.hits + fed.1.tni().pre.passes, 0);
    assert!(fed.1.cycles < report.cycles);
}

/// Adds up what it is told.
#[derive(Default)]
struct Sums {
    tiles: u32,
    rays: u64,
    packets: [u64; 2],
    running: u64,
    stalled: [u64; 2],
    stall: Option<(u64, Stall)>,
    /// Bytes of the data cache, and of the T&I unit.
    data: u64,
    tni: u64,
    halted: u32,
    finished: u32,
    cycle: u64,
}

impl Observer for Sums {
    fn tile_taken(&mut self, core: &CoreView<'_>, taken: Option<TakenTile>) {
        assert_eq!(core.core, 0);
        if let Some(taken) = taken {
            assert_eq!(taken.place, self.tiles);
            self.tiles += 1;
        }
    }

    fn packet_sent(&mut self, _core: &CoreView<'_>, packet: &SentPacket<'_>) {
        let rays = packet.buffers.count;
        assert_eq!((packet.number, rays), (self.packets[0], RAYS));
        assert_eq!(packet.rays.len(), 64 * RAYS as usize);
        self.packets[0] += 1;
    }

    fn packet_returned(&mut self, core: &CoreView<'_>, packet: u64, hits: &[HitRecord]) {
        assert_eq!((packet, hits.len()), (self.packets[1], RAYS as usize));
        assert!(core.tni().unit.results >= (packet + 1) * u64::from(RAYS));
        self.packets[1] += 1;
    }

    fn ray_returned(&mut self, _core: u32, _cycle: u64, cost: &RayCost) {
        assert!(cost.submission < self.packets[0] && cost.cycles > 0);
        self.rays += 1;
    }

    fn requested(&mut self, _core: &CoreView<'_>, request: &MemoryRequest) {
        assert!(request.address >= BASE);
        match request.requester {
            Requester::Tni(_) => self.tni += u64::from(request.bytes),
            _ if !request.is_write => self.data += u64::from(request.bytes),
            _ => {}
        }
    }

    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        assert!(core.cycle >= self.cycle);
        self.cycle = core.cycle + run.cycles;
        self.running += run.cycles;
    }

    fn stall_began(&mut self, core: &CoreView<'_>, stall: Stall) {
        assert_eq!((core.cycle, self.stall), (self.cycle, None));
        self.stall = Some((core.cycle, stall));
    }

    fn stall_ended(&mut self, core: &CoreView<'_>, stall: Stall) {
        let (since, of) = self.stall.take().expect("a stall has begun");
        assert_eq!(of, stall);
        self.stalled[stall as usize] += core.cycle - since;
    }

    fn halted(&mut self, _core: &CoreView<'_>) {
        self.halted += 1;
    }

    fn finished(&mut self, core: &CoreView<'_>) {
        self.finished += 1;
        assert_eq!(
            core.account.total(),
            self.running + self.stalled[0] + self.stalled[1]
        );
    }
}

#[test]
fn observers_are_told_everything_and_change_nothing() {
    let (scene, arch) = (demo(), machine());
    let size = (48, 32);
    for timing in [
        Timing::Full,
        Timing::Estimated,
        Timing::RecordedHits,
        Timing::Untimed,
    ] {
        let expected = frame_of(&scene, size, casters(1), &arch, timing).expect("the frame ends");
        let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
        let image = scene_image::build(&scene, &bvh, &scene.camera, &arch, size);
        let mut sums = Sums::default();
        let options = Options {
            timing,
            kernel_names: vec!["primary".to_owned()],
            observer: Some(&mut sums),
            ..Options::new(b"data")
        };
        let found = system::render(image.expect("it fits"), casters(1), &arch, options);
        let found = found.expect("the frame ends");
        assert!(found == expected, "{timing:?}");
        let (report, core) = (&found.1, &found.1.cores[0]);
        assert_eq!((sums.tiles, sums.packets), (24, [24, 24]));
        let full = timing == Timing::Full;
        assert_eq!(sums.rays, if full { report.rays } else { 0 });
        assert_eq!(sums.stalled, [core.memory_stall, core.texture_stall]);
        let line = u64::from(arch.system.data_cache.line);
        assert_eq!(sums.data, line * core.data_cache.misses);
        assert_eq!(sums.tni, core.tni.bytes_read);
        assert_eq!(sums.tni > 0, full || timing == Timing::Estimated);
        assert_eq!((sums.halted, sums.finished), (1, 1));
    }
}

/// Cores take what is queued for them, and nothing else.
#[test]
fn tiles_can_be_queued_for_cores() {
    let (scene, arch) = (demo(), machine());
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let mut image =
        scene_image::build(&scene, &bvh, &scene.camera, &arch, (48, 32)).expect("it fits");
    let mut caches = WarmCaches::new(&arch.system, &image);
    caches.read(&[image.tree.nodes, image.tree.triangles]);
    let caches = Arc::new(caches);
    let queued = |tile| QueuedTile {
        tile,
        caches: (tile == 5).then(|| Arc::clone(&caches)),
    };
    let options = Options {
        tiles: Some(TileQueue::of_cores(vec![
            vec![queued(5), queued(2)],
            Vec::new(),
            vec![queued(7)],
        ])),
        ..Options::new(b"data")
    };
    let report = system::run(&mut image, casters(3), &arch, options).expect("it ends");
    assert_eq!((report.tiles_taken, report.tiles, report.rays), (3, 3, 192));
    let rays: Vec<u64> = report.cores.iter().map(|c| c.tni.unit.rays).collect();
    assert_eq!(rays, [128, 0, 64]);
    let picture = Picture::of(&image.memory, &image.frame);
    for (i, pixel) in picture.rgba.chunks_exact(4).enumerate() {
        let tile = i as u32 % 48 / 8 + i as u32 / 48 / 8 * 6;
        assert_eq!(pixel[3] == 255, [2, 5, 7].contains(&tile), "tile {tile}");
    }
}
