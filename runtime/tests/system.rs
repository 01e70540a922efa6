//! Whole frames, with engines written by hand in the place of simulated SRPs.

mod support;

use glam::Vec3;
use srp_archdesc::Watch;
use srp_archdesc::arch::Approx;
use srp_archdesc::{Arch, ports};
use srp_runtime::bvh;
use srp_runtime::core::{Activity, Bus, Core, Run, Trap};
use srp_runtime::memory::BASE;
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Scene, demo::demo};
use srp_runtime::scene_image::{self, ImageError};
use srp_runtime::solo::{self, Finish, Solo, SoloError};
use srp_runtime::system::{
    self, CoreView, MemoryRequest, Observer, Options, QueuedTile, Report, Requester, Stall,
    SystemError, TileQueue, Timing, WarmCaches,
};
use srp_runtime::tni::arithmetic::{NO_HIT, Ray, widening};
use srp_runtime::tni::{HIT_BYTES, HitRecord, RAY_BYTES, RayCost};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

fn machine() -> Arch {
    let file = srp_archdesc::machines::SGRT;
    srp_archdesc::parse(file.name, file.xml).expect("the shipped machine is valid")
}

/// An engine that casts primary rays and paints each pixel by the normal it hits, one packet after
/// the other, with two packets in flight. It talks to the world only through the bus.
#[derive(Default)]
struct Caster {
    step: Step,
    /// Tiles in flight, oldest first.
    tiles: Vec<u32>,
    sent: u32,
    no_more: bool,
    header: Vec<f32>,
}

#[derive(Clone, Copy, Default, PartialEq)]
enum Step {
    #[default]
    Header,
    Tile,
    Generate(u32),
    Start(u32),
    Collect,
    Shade,
}

const RAYS: u32 = 64;
const HITS_AT: u32 = 3 * RAYS * RAY_BYTES;

impl Caster {
    fn float(&self, at: usize) -> f32 {
        self.header[at / 4]
    }

    fn word(&self, at: usize) -> u32 {
        self.float(at).to_bits()
    }

    fn vector(&self, at: usize) -> Vec3 {
        Vec3::new(self.float(at), self.float(at + 4), self.float(at + 8))
    }

    fn pixel(&self, tile: u32, i: u32) -> (u32, u32) {
        let (width, height) = (self.word(136), self.word(140));
        let (column, row) = (tile % self.word(144), tile / self.word(144));
        (column * width + i % width, row * height + i / width)
    }

    fn generate(&self, bus: &mut dyn Bus, tile: u32) {
        let buffer = (self.sent % 3) * RAYS * RAY_BYTES;
        for i in 0..RAYS {
            let (x, y) = self.pixel(tile, i);
            let direction =
                self.vector(16) + x as f32 * self.vector(32) + y as f32 * self.vector(48);
            let ray = Ray::new(
                self.vector(0).to_array(),
                direction.normalize().to_array(),
                0.0,
                self.float(188),
                0,
            );
            let at = (buffer + i * RAY_BYTES) as usize;
            for (bytes, word) in bus.sram()[at..].chunks_exact_mut(4).zip(ray.words()) {
                bytes.copy_from_slice(&word.to_le_bytes());
            }
        }
    }

    fn shade(&self, bus: &mut dyn Bus, buffer: u32, tile: u32) -> Option<()> {
        for i in 0..RAYS {
            let at = (HITS_AT + (buffer * RAYS + i) * HIT_BYTES) as usize;
            let mut words = [0; 6];
            for (word, bytes) in words.iter_mut().zip(bus.sram()[at..].chunks_exact(4)) {
                *word = u32::from_le_bytes(bytes.try_into().expect("4 bytes"));
            }
            let record = HitRecord::from_words(words);
            let colour = if record.hit.primitive == NO_HIT {
                self.vector(64)
            } else {
                let triangle = self.word(160) + 128 * record.hit.primitive;
                let mut normal = Vec3::ZERO;
                let weights = [
                    1.0 - record.hit.u - record.hit.v,
                    record.hit.u,
                    record.hit.v,
                ];
                for (k, weight) in weights.into_iter().enumerate() {
                    let lanes = bus.cached_load(triangle + 48 + 16 * k as u32, 16)?;
                    let n = [0, 1, 2].map(|i| f32::from_bits(lanes[i]));
                    normal += weight * Vec3::from(n);
                }
                0.5 * normal + 0.5
            };
            let [r, g, b] = colour.to_array().map(|c| u32::from((255.0 * c) as u8));
            let (x, y) = self.pixel(tile, record.ray);
            let address = self.word(156) + 4 * (y * self.word(152) + x);
            bus.cached_store(address, 4, [r | g << 8 | b << 16 | 255 << 24, 0, 0, 0])?;
        }
        Some(())
    }

    fn advance(&mut self, bus: &mut dyn Bus) -> Option<(Activity, u64)> {
        let waits = |port| Some((Activity::Wait(port), 1));
        match self.step {
            Step::Header => {
                let lanes = bus.cached_load(BASE + 4 * self.header.len() as u32, 16)?;
                self.header.extend(lanes.map(f32::from_bits));
                if self.header.len() * 4 == 224 {
                    self.step = Step::Tile;
                }
            }
            Step::Tile => {
                let tile = bus.port_in(ports::TILE)?;
                self.no_more = tile == u32::MAX;
                self.step = match (self.no_more, self.tiles.is_empty()) {
                    (false, _) => {
                        self.tiles.push(tile);
                        Step::Generate(tile)
                    }
                    (true, false) => Step::Collect,
                    (true, true) => return Some((Activity::Halted(0), 0)),
                };
            }
            Step::Generate(tile) => {
                self.generate(bus, tile);
                self.step = Step::Start(0);
                return Some((Activity::Array(0), 200));
            }
            Step::Start(n) => {
                let (port, value) = match n {
                    0 => (ports::TNI_RAYS, (self.sent % 3) * RAYS * RAY_BYTES),
                    1 => (
                        ports::TNI_HITS,
                        HITS_AT + (self.sent % 2) * RAYS * HIT_BYTES,
                    ),
                    _ => (ports::TNI_START, RAYS),
                };
                if !bus.port_out(port, value) {
                    return waits(port);
                }
                self.step = Step::Start(n + 1);
                if n == 2 {
                    self.sent += 1;
                    let full = self.tiles.len() == 2;
                    self.step = if full { Step::Collect } else { Step::Tile };
                }
            }
            Step::Collect => {
                if bus.port_in(ports::TNI_DONE).is_none() {
                    return waits(ports::TNI_DONE);
                }
                let counts = [
                    ports::TNI_SHADOW_MISSES,
                    ports::TNI_OTHER_HITS,
                    ports::TNI_OTHER_MISSES,
                ]
                .map(|port| bus.port_in(port).expect("counts do not wait"));
                assert_eq!(counts[0], 0);
                assert_eq!(counts[1] + counts[2], RAYS);
                self.step = Step::Shade;
            }
            Step::Shade => {
                let tile = self.tiles.remove(0);
                let buffer = (self.sent - 1 - self.tiles.len() as u32) % 2;
                self.shade(bus, buffer, tile)?;
                self.step = if self.no_more && self.tiles.is_empty() {
                    return Some((Activity::Halted(0), 0));
                } else if self.no_more {
                    Step::Collect
                } else {
                    Step::Tile
                };
                return Some((Activity::Array(1), 300));
            }
        }
        Some((Activity::Vliw, 1))
    }
}

impl Core for Caster {
    fn run(&mut self, bus: &mut dyn Bus, _budget: u64) -> Result<Run, Trap> {
        let (activity, cycles) = self.advance(bus).expect("every address is mapped");
        Ok(Run { cycles, activity })
    }
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
    fn tile_taken(&mut self, core: &CoreView<'_>, place: Option<u32>) {
        assert_eq!(core.core, 0);
        if let Some(place) = place {
            assert_eq!(place, self.tiles);
            self.tiles += 1;
        }
    }

    fn packet_sent(&mut self, _core: &CoreView<'_>, packet: u64, rays: u32) {
        assert_eq!((packet, rays), (self.packets[0], RAYS));
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
        assert_eq!(sums.data, 64 * core.data_cache.misses);
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
    assert_eq!(
        result.expect_err("too long").to_string(),
        "the frame takes more than 100000 cycles"
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
    assert_eq!(factor, widening(arch.precision.rcp));
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
