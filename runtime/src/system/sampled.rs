//! A frame from a sample of its tiles.
//!
//! Tiles are sized by a cheap look ([`crate::preview`]) and parted into strata. A batch takes a tile of
//! every stratum and runs them like a frame of its own, in the order of the frame, with tiles before and
//! behind them that are not measured: so cores, T&I units and memory are as busy as in the frame. Each
//! tile's cycles and counters come from the [`ledger`](super::ledger); from them come the frame's, with
//! intervals ([`crate::survey`]). Batches are drawn until the cycles are known well enough.
//!
//! Measuring few units of a long run and telling how far they can be trusted is that of SMARTS
//! (Wunderlich et al., ISCA 2003); doing it with parts of a picture is that of Zatel (ISPASS 2024).

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;
use srp_archdesc::Arch;

use super::ledger::{COLUMNS, Column, Tally};
use super::{Options, Part, Report, SystemError, Timing, render_part};
use crate::core::Core;
use crate::effect::Guard;
use crate::preview::{Preview, View};
use crate::scene_image::{SceneImage, tile_size};
use crate::survey::{Estimate, LEAST_DRAWS, Population, Random, Sample, draws_needed};

/// Tiles of a frame for each stratum, about.
const TILES_A_STRATUM: usize = 80;

/// Least strata: a batch should be longer than what leads in and out of it.
const LEAST_STRATA: usize = 48;

/// Tiles that show how cores take turns, for each distance that is looked at.
const OBSERVED: u32 = 4;

/// Most tiles before one that are looked at for what the caches hold.
const HISTORY: u32 = 4096;

/// A frame that is to be sampled.
pub struct Frame<'a> {
    /// System memory at its start.
    pub image: &'a SceneImage,
    /// What rays read, and what a look at all tiles has found.
    pub view: &'a View<'a>,
    /// The same, of a few rays of every tile.
    pub preview: &'a Preview,
    /// How cores take turns.
    pub turns: &'a Turns,
    /// The cores at their start, as often as they are asked for.
    pub engines: &'a (dyn Fn() -> Vec<Box<dyn Core>> + Sync),
    /// The machine.
    pub arch: &'a Arch,
    /// The program's data.
    pub sram_image: &'a [u8],
    /// What the program was not built for.
    pub guard: Guard,
    /// Whether T&I units answer at once.
    pub recorded_hits: bool,
    /// Names of the kernels.
    pub kernel_names: &'a [String],
    /// Most SRP cycles of a batch.
    pub max_cycles: u64,
    /// Threads of the host; they change no figure.
    pub threads: usize,
    /// Told how many tiles have been measured.
    pub progress: &'a (dyn Fn(usize) + Sync),
    /// Asked whether to stop.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Tiles in strata. Units of the population are tiles along a Z-curve through the frame, so that those
/// with neighbouring numbers are neighbours.
#[derive(Clone, Debug)]
pub struct Tiles {
    population: Population,
    /// The tile of each unit.
    tiles: Vec<u32>,
}

impl Tiles {
    /// The tiles of a frame that is `across` tiles wide, of these sizes.
    pub fn of(sizes: &[f64], across: u32) -> Tiles {
        let mut tiles: Vec<u32> = (0..sizes.len() as u32).collect();
        let across = across.max(1);
        tiles.sort_by_key(|&t| interleaved(t % across) | interleaved(t / across) << 1);
        let strata = (tiles.len() / TILES_A_STRATUM).max(LEAST_STRATA);
        let sizes = tiles.iter().map(|&t| sizes[t as usize]).collect();
        Tiles {
            population: Population::of(sizes, strata),
            tiles,
        }
    }

    /// Number of strata.
    pub fn strata(&self) -> usize {
        self.population.strata()
    }
}

/// The bits of a number with a 0 between each two.
fn interleaved(n: u32) -> u64 {
    (0..16).fold(0, |sum, bit| sum | u64::from(n >> bit & 1) << (2 * bit))
}

/// What a batch of units took.
#[derive(Clone, Debug, Default)]
struct Batch {
    /// Units of the population.
    units: Vec<u32>,
    /// What each took.
    tallies: Vec<Tally>,
    /// SRP cycles of all cores before their first tiles, and after their last.
    around: u64,
    /// Cycles of all reads from memory, over their number, in ns.
    read_ns: f64,
}

/// A figure of a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value and interval.
    #[serde(flatten)]
    pub estimate: Estimate,
}

/// Runs batches, several at a time. `None` where it was cancelled.
///
/// # Errors
///
/// Those of [`super::render`].
fn run(
    frame: &Frame<'_>,
    tiles: &Tiles,
    batches: &[Vec<u32>],
) -> Result<Option<Vec<Batch>>, SystemError> {
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<Result<Batch, SystemError>>>> =
        Mutex::new(vec![None; batches.len()]);
    std::thread::scope(|scope| {
        for _ in 0..frame.threads.clamp(1, batches.len().max(1)) {
            scope.spawn(|| {
                let mut image = frame.image.clone();
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= batches.len() || (frame.cancelled)() {
                        return;
                    }
                    let batch = run_batch(frame, tiles, &mut image, &batches[i]);
                    let measured = done.fetch_add(batches[i].len(), Ordering::Relaxed);
                    (frame.progress)(measured + batches[i].len());
                    results.lock().expect("no thread panics with it")[i] = Some(batch);
                }
            });
        }
    });
    let results = results.into_inner().expect("no thread panics with it");
    let results: Option<Vec<_>> = results.into_iter().collect();
    match results {
        Some(all) if !(frame.cancelled)() => all.into_iter().collect::<Result<_, _>>().map(Some),
        _ => Ok(None),
    }
}

/// Runs the tiles of some units, and enough of their neighbours for them to find and leave a busy
/// machine.
fn run_batch(
    frame: &Frame<'_>,
    tiles: &Tiles,
    image: &mut SceneImage,
    units: &[u32],
) -> Result<Batch, SystemError> {
    let mut drawn: Vec<(u32, u32)> = (units.iter())
        .map(|&u| (tiles.tiles[u as usize], u))
        .collect();
    drawn.sort_unstable();
    let system = &frame.arch.system;
    let lead = system.cores * system.buffers.hit_buffers.max(1);
    let (Some(first), Some(last)) = (drawn.first(), drawn.last()) else {
        return Ok(Batch::default());
    };
    let before = (1..=lead).rev().map(|i| first.0.saturating_sub(i));
    let behind = (1..=lead).map(|i| (last.0 + i).min(image.tiles - 1));
    let chosen = before.chain(drawn.iter().map(|d| d.0)).chain(behind);
    let mut known = vec![None; system.cores as usize];
    let mut warm = |core: u32, _: u32, tile: u32| {
        let known = &mut known[core as usize];
        let from = known.replace(tile).map(|known| known.min(tile));
        frame.turns.touched(frame, from, tile)
    };
    let options = Options {
        warm: Some(&mut warm),
        max_cycles: frame.max_cycles,
        sram_image: frame.sram_image,
        guard: frame.guard.clone(),
        timing: match frame.recorded_hits {
            true => Timing::RecordedHits,
            false => Timing::Full,
        },
        chosen: Some(chosen.collect()),
        kernel_names: frame.kernel_names.to_vec(),
        progress: &mut |_| {},
        cancelled: frame.cancelled,
    };
    let Part {
        report,
        tallies,
        before,
        ..
    } = render_part(image, (frame.engines)(), frame.arch, options)?;
    let lead = lead as usize;
    let idle: u64 = report.cores.iter().map(|c| c.idle).sum();
    Ok(Batch {
        units: drawn.iter().map(|d| d.1).collect(),
        tallies: tallies.into_iter().skip(lead).take(drawn.len()).collect(),
        around: before + idle,
        read_ns: read_ns(&report, frame.arch),
    })
}

/// How tiles that follow each other go to cores: for each distance, from 1, the part of tiles that run on
/// the core that ran the tile so far before them.
#[derive(Clone, Debug, PartialEq)]
pub struct Turns {
    same: Vec<f64>,
}

impl Turns {
    /// Distances that are looked at.
    fn most(arch: &Arch) -> usize {
        (2 * arch.system.cores * arch.system.buffers.hit_buffers.max(1)) as usize
    }

    /// Runs a few tiles from the middle of the frame to see how cores take turns.
    ///
    /// # Errors
    ///
    /// Those of [`super::render`].
    pub fn of(
        image: &SceneImage,
        engines: Vec<Box<dyn Core>>,
        arch: &Arch,
        mut options: Options<'_>,
    ) -> Result<Turns, SystemError> {
        let most = Turns::most(arch);
        let tiles = (OBSERVED * most as u32).min(image.tiles);
        let first = (image.tiles - tiles) / 2;
        options.chosen = Some((first..first + tiles).collect());
        let cores = render_part(&mut image.clone(), engines, arch, options)?.cores;
        let same = |distance: usize| {
            let after = cores.iter().skip(distance);
            let equal = cores.iter().zip(after).filter(|(a, b)| a == b).count();
            equal as f64 / cores.len().saturating_sub(distance).max(1) as f64
        };
        Ok(Turns {
            same: (1..=most).map(same).collect(),
        })
    }

    /// What a core has read before `tile`, as far as it is known from the tiles from `from` on: of those
    /// far away a few rays, of the nearest all. Which of them were the core's is drawn, always alike.
    /// Before the first tile (`from` is none) what shading reads anywhere in the frame is there, the
    /// farthest first: what stays in a cache for good is missed once a frame, not once a batch.
    fn touched(&self, frame: &Frame<'_>, from: Option<u32>, tile: u32) -> Vec<u32> {
        let near = tile.saturating_sub(self.same.len() as u32);
        let mut random = Random::new(u64::from(tile));
        let mut drawn = |part: f64| (random.draw() >> 11) as f64 / (1u64 << 53) as f64 <= part;
        let even = 1.0 / f64::from(frame.arch.system.cores.max(1));
        let mut touched: Vec<u32> = Vec::new();
        if from.is_none() {
            let tree = frame.image.tree.nodes..frame.image.shading.triangles;
            for other in (tile..frame.image.tiles).rev().chain(0..tile) {
                let all = frame.preview.touched(other).iter();
                touched.extend(all.filter(|address| !tree.contains(address)));
            }
        }
        let from = from.unwrap_or(0);
        for far in from.max(near.saturating_sub(HISTORY))..near {
            if drawn(even) {
                touched.extend_from_slice(frame.preview.touched(far));
            }
        }
        for close in near..tile {
            if drawn(self.same[(tile - close) as usize - 1]) {
                touched.extend(frame.view.touches(close));
            }
        }
        touched
    }
}

/// How long reads took on average.
fn read_ns(report: &Report, arch: &Arch) -> f64 {
    let dram = &report.dram.counters;
    dram.read_cycles as f64 / dram.reads.max(1) as f64 * 1e3 / f64::from(arch.system.dram.mhz)
}

/// A frame, estimated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sampled {
    /// Tiles of the frame.
    pub tiles: usize,
    /// Tiles measured.
    pub measured: usize,
    /// Strata.
    pub strata: usize,
    /// The seed.
    pub seed: u64,
    /// The figures, with 95 % intervals; the first is the cycles of the frame.
    pub figures: Vec<Figure>,
}

/// Samples a frame until half the interval of its cycles is at most `error` of them, or all of it is
/// measured. `None` where it was cancelled.
///
/// # Errors
///
/// Those of [`super::render`].
pub fn sample(
    frame: &Frame<'_>,
    tiles: &Tiles,
    seed: u64,
    error: f64,
) -> Result<Option<Sampled>, SystemError> {
    let batches = tiles.population.batches(seed);
    let mut done: Vec<Batch> = Vec::new();
    let mut wanted = LEAST_DRAWS.min(batches.len());
    loop {
        let Some(more) = run(frame, tiles, &batches[done.len()..wanted])? else {
            return Ok(None);
        };
        done.extend(more);
        let figures = figures(tiles, &done, frame.arch, frame.kernel_names);
        let found = figures.first().map_or(0.0, |f| f.estimate.relative());
        if found <= error || done.len() == batches.len() {
            return Ok(Some(Sampled {
                tiles: tiles.population.len(),
                measured: done.iter().map(|b| b.units.len()).sum(),
                strata: tiles.strata(),
                seed,
                figures,
            }));
        }
        wanted = draws_needed(done.len(), found, error).min(batches.len());
    }
}

/// The figures of a frame from some batches of it.
fn figures(tiles: &Tiles, batches: &[Batch], arch: &Arch, kernel_names: &[String]) -> Vec<Figure> {
    let units: Vec<u32> = batches.iter().flat_map(|b| b.units.clone()).collect();
    let tallies: Vec<&Tally> = batches.iter().flat_map(|b| &b.tallies).collect();
    let sample = Sample::new(&tiles.population, &units);
    let values = |columns: &[usize]| -> Vec<f64> {
        let sum = |t: &&Tally| columns.iter().map(|&c| t[c]).sum::<u64>() as f64;
        tallies.iter().map(sum).collect()
    };
    let mean = |of: &dyn Fn(&Batch) -> f64| {
        batches.iter().map(of).sum::<f64>() / batches.len().max(1) as f64
    };
    let latencies: Vec<f64> = batches.iter().map(|b| b.read_ns).collect();
    let latency = Estimate {
        value: mean(&|b| b.read_ns),
        half_width: match crate::survey::relative_error(&latencies) {
            Some(error) => error * mean(&|b| b.read_ns),
            None => f64::INFINITY,
        },
    };
    table(
        &|columns| sample.total(&values(columns)),
        &|above, below| sample.ratio(&values(above), &values(below)),
        mean(&|b| b.around as f64),
        latency,
        arch,
        kernel_names,
    )
}

/// The same figures of a frame that was run as a whole, from the tallies of all its tiles.
pub fn known(part: &Part, arch: &Arch, kernel_names: &[String]) -> Vec<Figure> {
    let sum = |columns: &[usize]| -> f64 {
        let of = |t: &Tally| {
            columns
                .iter()
                .map(|&c| t.get(c).copied().unwrap_or(0))
                .sum::<u64>()
        };
        part.tallies.iter().map(of).sum::<u64>() as f64
    };
    let idle: u64 = part.report.cores.iter().map(|c| c.idle).sum();
    let ratio = |above: &[usize], below: &[usize]| match sum(below) {
        0.0 => Estimate::exact(0.0),
        below => Estimate::exact(sum(above) / below),
    };
    table(
        &|columns| Estimate::exact(sum(columns)),
        &ratio,
        (part.before + idle) as f64,
        Estimate::exact(read_ns(&part.report, arch)),
        arch,
        kernel_names,
    )
}

/// The figures of a frame, without values.
pub fn names(arch: &Arch, kernel_names: &[String]) -> Vec<Figure> {
    let none = Estimate::exact(0.0);
    table(&|_| none, &|_, _| none, 0.0, none, arch, kernel_names)
}

/// Whether a figure counts what is done, and so needs no clock.
pub fn is_count(name: &str) -> bool {
    let counts = ["rays", "texture samples"];
    counts.contains(&name) || (name.ends_with(" a ray") && !name.starts_with("residence"))
}

type Total<'a> = dyn Fn(&[usize]) -> Estimate + 'a;
type Ratio<'a> = dyn Fn(&[usize], &[usize]) -> Estimate + 'a;

/// The figures, in their order. `around` are the cycles of all cores outside of tiles.
fn table(
    total: &Total<'_>,
    ratio: &Ratio<'_>,
    around: f64,
    latency: Estimate,
    arch: &Arch,
    kernel_names: &[String],
) -> Vec<Figure> {
    use Column as C;
    let mut figures = Vec::new();
    let mut put = |name: &str, unit: &'static str, estimate: Estimate| {
        figures.push(Figure {
            name: name.to_owned(),
            unit,
            estimate,
        });
    };
    let one = |column: C| [column as usize];
    let cores = f64::from(arch.system.cores);
    let mhz = f64::from(arch.system.srp_mhz);
    let at_work = total(&one(C::Cycles));
    let cycles = Estimate {
        value: (at_work.value + around) / cores,
        half_width: at_work.half_width / cores,
    };
    // What is measured in cycles of tiles, for cycles of the frame.
    let share = at_work.value / (at_work.value + around).max(1.0) * cores;
    let per_cycle = |above: &[usize]| ratio(above, &one(C::Cycles)).times(share);
    put("frame", "cycles", cycles);
    put("frame time", "ms", cycles.times(1e-3 / mhz));
    put("rays", "", total(&one(C::Rays)));
    put("rate", "Mrays/s", per_cycle(&one(C::Rays)).times(mhz));
    let work = [
        ("VLIW", C::Vliw),
        ("mode switch", C::Switch),
        ("memory stall", C::MemoryStall),
        ("texture stall", C::TextureStall),
        ("wait", C::Wait),
    ];
    for (name, column) in work {
        put(name, "cycles", total(&one(column)));
    }
    for (i, name) in kernel_names.iter().enumerate() {
        put(&format!("array: {name}"), "cycles", total(&[COLUMNS + i]));
    }
    let a_ray = [
        ("hits a ray", "", C::Hits),
        ("inner nodes a ray", "", C::InnerVisits),
        ("leaves a ray", "", C::LeafVisits),
        ("triangle tests a ray", "", C::Tests),
        ("residence of a ray", "T&I cycles", C::Resident),
    ];
    for (name, unit, column) in a_ray {
        put(name, unit, ratio(&one(column), &one(C::Rays)));
    }
    let caches = [
        ("TRV L1 hits", C::TrvL1Hits, C::TrvL1Misses),
        ("TRV L2 hits", C::TrvL2Hits, C::TrvL2Misses),
        ("IST L1 hits", C::IstL1Hits, C::IstL1Misses),
        ("data cache hits", C::DataHits, C::DataMisses),
        ("texture cache hits", C::TextureHits, C::TextureMisses),
    ];
    for (name, hits, misses) in caches {
        let rate = ratio(&one(hits), &[hits as usize, misses as usize]);
        put(name, "%", rate.times(100.0));
    }
    let accesses = [
        (
            "data cache accesses",
            [C::DataHits as usize, C::DataMisses as usize],
        ),
        (
            "texture cache accesses",
            [C::TextureHits as usize, C::TextureMisses as usize],
        ),
    ];
    for (name, columns) in accesses {
        put(name, "", total(&columns));
    }
    put("texture samples", "", total(&one(C::Samples)));
    let read = [C::TniBytes as usize, C::BytesRead as usize];
    let moved = [read[0], read[1], C::BytesWritten as usize];
    put("bytes read", "", total(&read));
    put("bytes written", "", total(&one(C::BytesWritten)));
    put("memory", "GB/s", per_cycle(&moved).times(mhz * 1e-3));
    put("latency of reads", "ns", latency);
    figures
}

/// Width of a frame in tiles.
pub fn across(width: u32, arch: &Arch) -> u32 {
    width.div_ceil(tile_size(arch.system.buffers.rays).0)
}
