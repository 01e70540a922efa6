//! Table 3, ray generation and shading by themselves, and Table 6, frames of the whole system.
//!
//! For Table 3 the T&I unit answers at once and without memory accesses, so that the cycles left are those of
//! the kernels, the job queue, and their caches. There are no shadow rays, which the paper does not mention:
//! primary rays are shaded with Phong's model and textures, and forced specular rays are two mirrorings of
//! each, on scenes where all materials mirror a half.

use super::{Options, Sheet, Subject, figures};
use crate::Error;
use crate::fidelity::sampled::Sampled;
use crate::fidelity::{Fidelity, FrameQuantity as Q, Prepared};
use crate::figure::estimate_of;
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::Bvh;
use srp_runtime::effect::{Effect, Effects, Guard, find};
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::system::{self, Report, Timing};
use srp_toolchain::{Build, Engines, Frame, system_options};

/// Mirrorings of forced specular rays.
const FORCED_BOUNCES: u32 = 2;

/// The inputs of a frame.
struct View<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    camera: &'a Camera,
    built: Effects,
    timing: Timing,
}

/// The effects that the kernels are built for: those that the scene calls for, or those that are asked for.
fn built(scene: &Scene, options: &Options) -> Result<Effects, Error> {
    let needed: Effects = find(scene).into_iter().collect();
    match &options.effects {
        None => Ok(needed),
        Some(list) => Ok(needed.parse(list).map_err(Error::invalid)?.0),
    }
}

fn render(view: &View<'_>, subject: Subject<'_>, sum: &mut Sum) -> Result<(), Error> {
    let Subject {
        options,
        arch,
        session,
        ..
    } = subject;
    let scene = Scene {
        camera: *view.camera,
        ..view.scene.clone()
    };
    let frame = Frame {
        arch: arch.clone(),
        build: Build {
            effects: view.built,
            bounces: scene.options.bounces,
            ..options.build.clone()
        },
        scene,
        bvh: view.bvh.clone(),
        size: options.size,
        guard: Guard::default(),
    };
    let image = frame.image()?;
    let kernels = frame.build.scheduled(arch, session)?;
    session.check()?;
    let program = kernels.program()?;
    let engines = Engines::of(program, options.engine, session)?;
    if options.level.fidelity == Fidelity::Sampled {
        let prepared = Prepared {
            frame: &frame,
            image,
            program,
            engines: &engines,
            threads: options.threads,
            recorded_hits: view.timing == Timing::RecordedHits,
            session,
        };
        let (sampled, _) = prepared.sampled(options.level.seed, options.level.error)?;
        sum.add_sampled(&sampled, arch);
        return Ok(());
    }
    let cores = engines.cores(arch.system.cores);
    let how = system_options(program, arch, Guard::default(), view.timing, session);
    let (_, report) = system::render(image, cores, arch, how).map_err(Error::invalid)?;
    session.check()?;
    sum.add(&report);
    Ok(())
}

/// Figures of several frames together.
#[derive(Default)]
struct Sum {
    rays: u64,
    cycles: u64,
    /// Cycles of all cores.
    at_work: u64,
    stalled: u64,
    bytes: u64,
    data: CacheCounters,
    texture: CacheCounters,
    cores: u64,
    mhz: f64,
    /// The square of half the interval of the cycles, where they were sampled.
    variance: Option<f64>,
}

impl Sum {
    fn add(&mut self, report: &Report) {
        self.rays += report.rays;
        self.cycles += report.cycles;
        self.cores = report.cores.len() as u64;
        self.mhz = f64::from(report.srp_mhz);
        let dram = &report.dram.counters;
        self.bytes += dram.bytes_read + dram.bytes_written;
        for core in &report.cores {
            self.at_work += report.cycles - core.idle;
            self.stalled += core.memory_stall
                + core.texture_stall
                + core.instruction_stall
                + core.context_stall
                + core.sram_stall;
            self.data.add(&core.data_cache);
            self.texture.add(&core.texture_cache);
        }
    }

    /// The figures of a frame that was sampled.
    fn add_sampled(&mut self, sampled: &Sampled, arch: &Arch) {
        let estimate = |quantity| estimate_of(&sampled.figures, &quantity);
        let of = |quantity| estimate(quantity).map_or(0.0, |e| e.value);
        let whole = |quantity| of(quantity).max(0.0).round() as u64;
        let cache = |accesses, hits| {
            let accesses = whole(accesses);
            let hits = (of(hits) / 100.0 * accesses as f64) as u64;
            CacheCounters {
                hits: hits.min(accesses),
                misses: accesses - hits.min(accesses),
                ..CacheCounters::default()
            }
        };
        let half_width = estimate(Q::Cycles).map_or(0.0, |e| e.half_width);
        self.variance = Some(self.variance.unwrap_or(0.0) + half_width * half_width);
        self.rays += whole(Q::Rays);
        self.cycles += whole(Q::Cycles);
        self.cores = u64::from(arch.system.cores);
        self.mhz = f64::from(arch.system.srp_mhz);
        self.bytes += whole(Q::BytesRead) + whole(Q::BytesWritten);
        self.at_work += whole(Q::Cycles) * self.cores;
        self.stalled += whole(Q::MemoryStall) + whole(Q::TextureStall);
        self.data
            .add(&cache(Q::DataCacheAccesses, Q::DataCacheHits));
        self.texture
            .add(&cache(Q::TextureCacheAccesses, Q::TextureCacheHits));
    }

    /// Half the interval of the cycles over them, where they were sampled.
    fn relative_error(&self) -> Option<f64> {
        let variance = self.variance?;
        Some(variance.sqrt() / self.cycles.max(1) as f64)
    }

    fn mrays_per_second(&self) -> f64 {
        self.rays as f64 * self.mhz / self.cycles.max(1) as f64
    }

    /// SRP cycles of one core for a ray of its own.
    fn cycles_per_ray(&self) -> f64 {
        (self.cycles * self.cores) as f64 / self.rays.max(1) as f64
    }
}

/// Table 3.
pub(super) fn table3(subject: Subject<'_>, sheet: &mut Sheet<'_>) -> Result<(), Error> {
    let (case, options) = (subject.case, subject.options);
    for forced in [false, true] {
        let mut scene = case.scene.clone();
        scene.options.bounces = 0;
        if forced {
            scene.options.bounces = FORCED_BOUNCES;
            for material in &mut scene.materials {
                material.specular = [0.5; 3];
                material.illumination = 3;
                material.dissolve = 1.0;
                material.dissolve_map = None;
            }
        }
        let built = built(&scene, options)?.without(Effect::Shadow);
        let mut sum = Sum::default();
        for camera in &case.cameras {
            let view = View {
                scene: &scene,
                bvh: &case.bvh,
                camera,
                built,
                timing: Timing::RecordedHits,
            };
            render(&view, subject, &mut sum)?;
        }
        let paper = case
            .paper
            .map(|p| if forced { &p.forced } else { &p.shaded });
        let title = if forced {
            "forced specular rays"
        } else {
            "primary"
        };
        sheet.group(title, sum.relative_error());
        sheet.line("Mrays/s", paper.map(|p| p.mrays), sum.mrays_per_second());
        let per_ray = |mrays: f64| figures::CORES * figures::SRP_MHZ / mrays;
        let theirs = paper.map(|p| per_ray(p.mrays));
        sheet.line("SRP cycles a ray, each core", theirs, sum.cycles_per_ray());
        let data = 100.0 * sum.data.hit_rate();
        sheet.line("data cache hits %", paper.map(|p| p.data_hit), data);
        if sum.texture.hits + sum.texture.misses > 0 {
            let texture = 100.0 * sum.texture.hit_rate();
            let theirs = paper.and_then(|p| p.texture_hit);
            sheet.line("texture cache hits %", theirs, texture);
        }
        let seconds = sum.cycles as f64 / (sum.mhz * 1e6);
        let rate = sum.bytes as f64 / seconds / 1e9;
        sheet.line("GB/s", paper.map(|p| p.gb_s), rate);
        let stalled = 100.0 * sum.stalled as f64 / sum.at_work.max(1) as f64;
        sheet.line("cycles stalled by caches %", None, stalled);
        sheet.note(format!("  kernels built for: {built}"));
    }
    Ok(())
}

/// Table 6.
pub(super) fn table6(subject: Subject<'_>, sheet: &mut Sheet<'_>) -> Result<(), Error> {
    let (case, options) = (subject.case, subject.options);
    let built = built(&case.scene, options)?;
    let mut sum = Sum::default();
    for camera in &case.cameras[..1] {
        let view = View {
            scene: &case.scene,
            bvh: &case.bvh,
            camera,
            built,
            timing: Timing::Full,
        };
        render(&view, subject, &mut sum)?;
    }
    let seconds = sum.cycles as f64 / (sum.mhz * 1e6);
    sheet.group("whole frames", sum.relative_error());
    let paper = case.paper.and_then(|p| p.frames_per_second);
    sheet.line("frames per second", paper, 1.0 / seconds);
    let pixels = f64::from(options.size.0) * f64::from(options.size.1);
    sheet.line("rays a pixel", None, sum.rays as f64 / pixels);
    sheet.line("Mrays/s", None, sum.mrays_per_second());
    sheet.line("data cache hits %", None, 100.0 * sum.data.hit_rate());
    if sum.texture.hits + sum.texture.misses > 0 {
        sheet.line("texture cache hits %", None, 100.0 * sum.texture.hit_rate());
    }
    sheet.line("GB/s", None, sum.bytes as f64 / seconds / 1e9);
    for (name, fps) in figures::OTHERS {
        sheet.note(format!(
            "  the paper's Fairy on {name}: {fps} frames per second"
        ));
    }
    sheet.note(format!("  kernels built for: {built}"));
    Ok(())
}
