//! A frame: cores, T&I units, bus and memory under one clock.
//!
//! The system ticks and decides nothing: which rays are traced and what becomes of their hits is
//! the business of the C code on the cores. At any instant the memory comes first, then the T&I
//! units whose cycle begins, then the cores, each in the order of their numbers; so the same input
//! gives the same cycles on any host.

mod core_unit;
mod data_cache;
mod error;
mod ledger;
mod report;
pub mod sampled;
mod tags;
mod texture_cache;
mod tiles;

use srp_archdesc::watch::{Stage, Watch};
use srp_archdesc::{Arch, SystemSpec, ports};

use self::core_unit::{CoreUnit, Miss, State};
use self::ledger::Ledger;
use self::tiles::{Errand, TileQueue};
use crate::bvh::TRIANGLE_BYTES;
use crate::core::Core;
use crate::effect::Guard;
use crate::memory::SystemMemory;
use crate::memory::dram::Request;
use crate::memory::path::{Clock, MemoryPath};
use crate::picture::Picture;
use crate::scene_image::SceneImage;
use crate::tni::{Client, HIT_BYTES, RAY_BYTES};

pub use error::SystemError;
pub use ledger::{COLUMNS, Column, Tally};
pub use report::{Account, CoreReport, KernelCycles, PortCycles, Report};

/// Cycles without progress after which a frame is given up.
pub const MAX_SILENCE: u64 = 4_000_000;

/// Cycles after which cores that all wait are given up, where nothing is on the way to them.
const MAX_STILLNESS: u64 = 64;

/// SRP cycles between two looks at the outside.
const REPORT_INTERVAL: u64 = 1 << 16;

/// How a frame is run.
pub struct Options<'a> {
    /// Most SRP cycles of a frame.
    pub max_cycles: u64,
    /// What each SRAM holds at the start, from address 0: the program's data. The rest is zero.
    pub sram_image: &'a [u8],
    /// Stops the frame where the program meets what it was not built for.
    pub guard: Guard,
    /// How the units keep time.
    pub timing: Timing,
    /// Names of the kernels, by their number in the scheduled program.
    pub kernel_names: Vec<String>,
    /// Watches the frame, tile by tile.
    pub watch: &'a dyn Watch,
}

/// How the units of a system keep time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// All of them, cycle by cycle.
    #[default]
    Full,
    /// T&I units answer at once and without memory accesses, so that the kernels can be measured by
    /// themselves.
    RecordedHits,
    /// T&I units answer when rays would be back that hinder each other as little as can be.
    Estimated,
    /// T&I units and memory take no time: what is computed is right, and cycles mean nothing.
    Untimed,
}

/// Runs a frame: one SGRT core of the machine for each engine, over the scene in `image`.
/// The picture is what the cores have written to the frame buffer. A frame that was cancelled has an
/// account of what it came to, which says that it is not [complete](Report::complete).
pub fn render(
    image: SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
) -> Result<(Picture, Report), SystemError> {
    let names = options.kernel_names.clone();
    let (system, cycles) = run(image, engines, arch, options, None, false)?;
    let picture = Picture::of(&system.memory, &system.frame);
    Ok((picture, Report::of(&system, cycles, arch, &names)))
}

/// What a part of a frame took.
#[derive(Clone, Debug)]
pub struct Part {
    /// The account of all of it.
    pub report: Report,
    /// What each of its tiles took, in their order, or core by core where they were dealt out.
    pub tallies: Vec<Tally>,
    /// What all cores took before their first tiles and after their last.
    pub around: Tally,
}

/// Runs a frame, with what each of its tiles took; the image gets its pixels.
pub fn render_tiles(
    image: &mut SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
) -> Result<Part, SystemError> {
    render_part(image, engines, arch, options, None)
}

/// Runs the tiles that are dealt out, or all where none are.
fn render_part(
    image: &mut SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
    dealt: Option<Vec<Vec<Errand>>>,
) -> Result<Part, SystemError> {
    let names = options.kernel_names.clone();
    let (mut system, cycles) = run(image.take(), engines, arch, options, dealt, true)?;
    let report = Report::of(&system, cycles, arch, &names);
    let mut tallies = vec![Tally::new(); system.tiles.count() as usize];
    let mut around = Tally::new();
    for core in &mut system.cores {
        core.close_ledger();
        let Some(ledger) = core.ledger.take() else {
            continue;
        };
        ledger::add(&mut around, &ledger.of_none);
        for (place, tally) in ledger.tallies {
            tallies[place as usize] = tally;
        }
    }
    image.memory = system.memory;
    Ok(Part {
        report,
        tallies,
        around,
    })
}

fn run(
    image: SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
    dealt: Option<Vec<Vec<Errand>>>,
    ledgers: bool,
) -> Result<(System, u64), SystemError> {
    if engines.is_empty() {
        return Err(SystemError::NoCores);
    }
    check(&arch.system).map_err(SystemError::Machine)?;
    let sram_bytes = arch.system.sram_bytes as usize;
    if options.sram_image.len() > sram_bytes {
        return Err(SystemError::Machine(format!(
            "the program's data take {} bytes, and the SRAM has {sram_bytes}",
            options.sram_image.len()
        )));
    }
    let mut sram = options.sram_image.to_vec();
    sram.resize(sram_bytes, 0);
    let mut system = System::new(image, engines, arch, &sram);
    for core in &mut system.cores {
        core.ledger = ledgers.then(|| Ledger::new(options.kernel_names.len()));
        core.set_timing(options.timing, &arch.system);
    }
    if let Some(dealt) = dealt {
        system.tiles = TileQueue::dealt(dealt);
    }
    let cycles = system.run(options.max_cycles, options.watch, &options.guard)?;
    Ok((system, cycles))
}

/// Whether the units of a machine fit each other; what does not, where not.
pub fn check(spec: &SystemSpec) -> Result<(), String> {
    let tni = &spec.tni;
    let rays = u64::from(tni.trvs) * u64::from(tni.stacks);
    let at_least = |what: &str, is: u32, least: u32| match is >= least {
        true => Ok(()),
        false => Err(format!("{what} is {is}, and must be at least {least}")),
    };
    let exactly = |what: &str, is: u32, must: u32| match is == must {
        true => Ok(()),
        false => Err(format!("{what} is {is}, and must be {must}")),
    };
    at_least("the number of traversal units", tni.trvs, 1)?;
    at_least("the number of intersection units", tni.ists, 1)?;
    at_least("the number of stacks", tni.stacks, 1)?;
    at_least(
        "the size of a node",
        tni.node_bytes,
        tni.node_format.bytes(),
    )?;
    at_least("the size of a triangle", tni.triangle_bytes, TRIANGLE_BYTES)?;
    exactly("the size of a ray", spec.buffers.ray_bytes, RAY_BYTES)?;
    exactly("the size of a hit", spec.buffers.hit_bytes, HIT_BYTES)?;
    if rays >= u64::from(u16::MAX) {
        return Err(format!(
            "{rays} rays in a T&I unit, which numbers them with 16 bits"
        ));
    }
    if !tni.node_bytes.is_multiple_of(4) || !tni.triangle_bytes.is_multiple_of(4) {
        return Err("nodes and triangles do not consist of whole words".to_owned());
    }
    if !tni.trv_l2.line.is_multiple_of(tni.trv_l1.line) {
        return Err(format!(
            "a line of the T&I unit's level-2 cache, of {} bytes, is not made of lines of level 1, of {}: make \
             it a multiple of them",
            tni.trv_l2.line, tni.trv_l1.line
        ));
    }
    for (name, cache) in [
        ("data", &spec.data_cache),
        ("texture", &spec.texture_cache),
        ("TRV L1", &tni.trv_l1),
        ("TRV L2", &tni.trv_l2),
        ("IST L1", &tni.ist_l1),
    ] {
        let whole = cache.ways > 0 && cache.line > 0 && cache.sets() > 0 && cache.misses > 0;
        if !whole {
            return Err(format!("the {name} cache has no sets, or allows no miss"));
        }
    }
    Ok(())
}

/// Who a request belongs to: this many numbers a core, of which the data cache has 0, the level-2
/// cache 1, the texture cache 2, and the intersection units those after.
const CLIENTS: u32 = 1 << 16;
const TEXTURE: u32 = 2;
const IST: u32 = 3;

struct System {
    cores: Vec<CoreUnit>,
    memory: SystemMemory,
    frame: crate::scene_image::FrameBuffer,
    /// The bus and memory of all cores, or those of each core.
    paths: Vec<MemoryPath>,
    tiles: TileQueue,
    srp: Clock,
    tni: Clock,
}

impl System {
    fn new(image: SceneImage, engines: Vec<Box<dyn Core>>, arch: &Arch, sram: &[u8]) -> System {
        let spec = &arch.system;
        let core = |(i, engine)| CoreUnit::new(i as u32, engine, spec, sram.to_vec(), image.tree);
        let paths = if spec.dram.shared { 1 } else { engines.len() };
        System {
            cores: engines.into_iter().enumerate().map(core).collect(),
            paths: (0..paths).map(|_| MemoryPath::new(spec)).collect(),
            tiles: TileQueue::Common {
                next: 0,
                count: image.tiles,
            },
            srp: Clock::new(spec.srp_mhz),
            tni: Clock::new(spec.tni_mhz),
            frame: image.frame,
            memory: image.memory,
        }
    }

    /// Runs until all cores have halted and everything is written, or the user has had enough.
    /// Returns the SRP cycles.
    fn run(
        &mut self,
        max_cycles: u64,
        watch: &dyn Watch,
        guard: &Guard,
    ) -> Result<u64, SystemError> {
        let stage = Stage::of(watch, "rendering", u64::from(self.tiles.count()));
        let mut told = 0;
        let (mut srp, mut tni) = (0, 0);
        let (mut last_progress, mut last_results, mut look_up) = (0, 0, 0);
        while !self.is_over() {
            let (srp_time, tni_time) = (self.srp.start(srp), self.tni.start(tni));
            let time = srp_time.min(tni_time);
            self.take_answers(time, tni);
            if tni_time == time {
                for core in &mut self.cores {
                    core.tick_tni(tni, &self.memory);
                }
                tni += 1;
            }
            if srp_time == time {
                let mut moved = false;
                for core in &mut self.cores {
                    moved |= core.step(srp, &mut self.memory, &mut self.tiles, guard)?;
                }
                let results = self.cores.iter().map(|c| c.tni.results()).sum();
                if moved || results != last_results || self.in_flight() > 0 {
                    (last_progress, last_results) = (srp, results);
                }
                self.check_silence(srp, srp - last_progress)?;
                srp += 1;
                if srp >= look_up {
                    look_up = srp + REPORT_INTERVAL;
                    let taken = self.tiles.taken();
                    stage.done(u64::from(taken - told));
                    told = taken;
                    if watch.cancelled() {
                        break;
                    }
                    if srp > max_cycles {
                        return Err(SystemError::TooLong { cycles: max_cycles });
                    }
                }
            }
            self.send_requests(time);
            (srp, tni) = self.skip(srp, tni);
        }
        for core in &mut self.cores {
            core.count_stall(srp);
        }
        let ends = self.cores.iter().map(|c| c.ready);
        Ok(ends.fold(srp, u64::max))
    }

    fn is_over(&self) -> bool {
        self.cores
            .iter()
            .all(|c| c.state == State::Halted && c.tni.is_idle())
            && self.in_flight() == 0
    }

    /// How many requests are on the way to the memory and back.
    fn in_flight(&self) -> u32 {
        self.paths.iter().map(MemoryPath::in_flight).sum()
    }

    fn take_answers(&mut self, time: u64, tni_cycle: u64) {
        for path in &mut self.paths {
            while let Some(answer) = path.answer(time) {
                if answer.is_write {
                    continue;
                }
                let core = &mut self.cores[(answer.source / CLIENTS) as usize];
                let address = answer.address;
                match answer.source % CLIENTS {
                    0 => core.data.fill(address),
                    1 => core.tni.fill(tni_cycle, Client::TrvL2, address),
                    TEXTURE => core.texture.lines.fill(address),
                    i => core.tni.fill(tni_cycle, Client::IstL1(i - IST), address),
                }
            }
        }
    }

    fn send_requests(&mut self, time: u64) {
        for (i, core) in self.cores.iter_mut().enumerate() {
            let source = i as u32 * CLIENTS;
            if core.timing == Timing::Untimed {
                while core.next_request(source).is_some() {}
                continue;
            }
            let path = i % self.paths.len();
            let path = &mut self.paths[path];
            // A miss of a core that has run ahead is sent when its time has come.
            if self.srp.start(core.ready) <= time + self.srp.start(1) {
                while let Some(request) = core.next_request(source) {
                    path.request(time, request);
                }
            }
            while let Some((client, address, bytes)) = core.tni.take_request() {
                let client = match client {
                    Client::TrvL2 => 1,
                    Client::IstL1(i) => i + IST,
                };
                let request = Request {
                    address,
                    bytes,
                    is_write: false,
                    source: source + client,
                };
                if let Some(ledger) = &mut core.ledger {
                    ledger.tni_read += u64::from(bytes);
                }
                path.request(time, request);
            }
        }
    }

    /// Leaves out cycles in which nothing can happen: no T&I unit has rays, and every core is
    /// ahead, halted, or waits for the memory.
    fn skip(&self, srp: u64, tni: u64) -> (u64, u64) {
        let mut until = u64::MAX;
        for core in &self.cores {
            match core.state {
                _ if !core.tni.is_idle() => return (srp, tni),
                State::Waiting(_) => return (srp, tni),
                State::Halted => {}
                State::Running if core.ready > srp => {
                    until = until.min(self.srp.start(core.ready - 1))
                }
                State::Stalled(_, miss) if core.misses() == Some(miss) => {}
                State::Running | State::Stalled(..) => return (srp, tni),
            }
        }
        let events = self.paths.iter().filter_map(MemoryPath::next_event);
        until = events.fold(until, u64::min);
        if until == u64::MAX {
            return (srp, tni);
        }
        let srp = srp.max(self.srp.cycle_from(until));
        (srp, tni.max(self.tni.cycle_from(until)))
    }

    fn check_silence(&self, cycle: u64, silence: u64) -> Result<(), SystemError> {
        let idle = || self.cores.iter().all(|c| c.tni.is_idle());
        if silence > MAX_SILENCE || (silence > MAX_STILLNESS && idle()) {
            return Err(SystemError::Deadlock {
                cycle,
                waits: self.waits(),
            });
        }
        Ok(())
    }

    fn waits(&self) -> String {
        let mut text = String::new();
        for (i, core) in self.cores.iter().enumerate() {
            let what = match core.state {
                State::Running => "runs".to_owned(),
                State::Halted => "has ended".to_owned(),
                State::Stalled(since, miss) => {
                    let cache = match miss {
                        Miss::Data => "data",
                        Miss::Texture => "texture",
                    };
                    format!("waits for its {cache} cache since cycle {since}")
                }
                State::Waiting(port) => format!("waits for port {port} ({})", port_name(port)),
            };
            text.push_str(&format!(
                "  core {i} {what}; its T&I unit: {}\n",
                core.tni.describe_state()
            ));
        }
        let in_flight = self.in_flight();
        text.push_str(&format!("  {in_flight} memory requests are on the way"));
        text
    }
}

/// What a port is, in words.
fn port_name(port: u32) -> &'static str {
    match port {
        ports::TILE => "next tile",
        ports::TNI_RAYS => "ray buffer",
        ports::TNI_HITS => "hit buffer",
        ports::TNI_START => "room for a submission",
        ports::TNI_DONE => "a finished submission",
        ports::TNI_SHADOW_MISSES => "shadow misses",
        ports::TNI_OTHER_HITS => "other hits",
        ports::TNI_OTHER_MISSES => "other misses",
        ports::CORE => "core number",
        ports::PUTCHAR => "output",
        ports::EXIT => "exit",
        _ => "which does not exist",
    }
}
