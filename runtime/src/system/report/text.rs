//! The report of a frame as text, for people: rows of cycles by core, then tables of units, caches and memory.

use super::{CoreReport, KernelCycles, KernelRuns, Report};
use crate::digits::thousands;
use crate::memory::cache::CacheCounters;
use crate::system::ContextCounters;
use crate::tni::PipeCounters;
use std::fmt::Write as _;

impl Report {
    /// The report as text, for people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let out = &mut text;
        let (width, height) = (self.width, self.height);
        let _ = match self.complete {
            true => write!(out, "{width}x{height} pixels in"),
            false => write!(
                out,
                "{} of {} tiles of {width}x{height} pixels begun in the first",
                self.tiles_taken, self.tiles
            ),
        };
        line(
            out,
            format_args!(
                " {} cycles at {} MHz: {:.3} ms, {} rays, {:.1} Mrays/s",
                thousands(self.cycles),
                self.srp_mhz,
                self.milliseconds,
                thousands(self.rays),
                self.mrays_per_second
            ),
        );
        self.text_of_cores(out);
        self.text_of_tni(out);
        self.text_of_memory(out);
        text
    }

    /// One row for each thing that cores did, one column for each core.
    fn text_of_cores(&self, out: &mut String) {
        let mut rows: Vec<(String, Vec<u64>, Option<f64>)> = Vec::new();
        let sum = |of: &dyn Fn(&CoreReport) -> u64| self.cores.iter().map(of).sum::<u64>();
        let mut row = |name: &str, of: &dyn Fn(&CoreReport) -> u64, operations: Option<u64>| {
            let cells: Vec<u64> = self.cores.iter().map(of).collect();
            let cycles: u64 = cells.iter().sum();
            if cycles > 0 {
                let a_cycle = operations.map(|operations| operations as f64 / cycles as f64);
                rows.push((name.to_owned(), cells, a_cycle));
            }
        };
        row("VLIW", &|c| c.vliw, Some(sum(&|c| c.vliw_operations)));
        let of_kernel = |all: &[KernelCycles], kernel: &str| -> u64 {
            let of_kernel = all.iter().filter(|k| k.kernel == kernel);
            of_kernel.map(|k| k.cycles).sum()
        };
        let kernels = names(self.cores.iter().flat_map(|c| &c.array).map(|k| &k.kernel));
        for kernel in &kernels {
            let runs = |c: &CoreReport, of: fn(&KernelRuns) -> u64| -> u64 {
                let runs = c.array.iter().filter(|run| run.kernel == *kernel);
                runs.map(of).sum()
            };
            let operations = sum(&|c| runs(c, |run| run.operations));
            let name = format!("array: {kernel}");
            row(&name, &|c| runs(c, |run| run.cycles), Some(operations));
        }
        row("mode switch", &|c| c.switch, None);
        row("memory stall", &|c| c.memory_stall, None);
        row("texture stall", &|c| c.texture_stall, None);
        row("instruction stall", &|c| c.instruction_stall, None);
        row("context stall", &|c| c.context_stall, None);
        for kernel in &kernels {
            let stalls = |c: &CoreReport| of_kernel(&c.kernel_stalls, kernel);
            row(&format!("  of both in {kernel}"), &stalls, None);
        }
        row("SRAM bank stall", &|c| c.sram_stall, None);
        for kernel in &kernels {
            let stalls = |c: &CoreReport| of_kernel(&c.kernel_sram_stalls, kernel);
            row(&format!("  of it in {kernel}"), &stalls, None);
        }
        for port in names(self.cores.iter().flat_map(|c| &c.wait).map(|w| &w.port)) {
            let waits = |c: &CoreReport| {
                let of_port = c.wait.iter().filter(|w| w.port == port);
                of_port.map(|w| w.cycles).sum()
            };
            row(&format!("wait: {port}"), &waits, None);
        }
        row("idle", &|c| c.idle, None);
        let width = rows.iter().map(|r| r.0.len()).max().unwrap_or(0).max(10);
        let mut head = format!("\n{:width$} {:>7} {:>5}", "SRP cycles", "share", "IPC");
        for i in 0..self.cores.len() {
            let _ = write!(head, " {:>14}", format!("core {i}"));
        }
        line(out, format_args!("{head}"));
        let all = self.cycles * self.cores.len() as u64;
        for (name, cells, a_cycle) in rows {
            let share = percent(cells.iter().sum(), all);
            let a_cycle = a_cycle.map_or(String::new(), |n| format!("{n:.2}"));
            let mut text = format!("{name:width$} {share:>7} {a_cycle:>5}");
            for cell in cells {
                let _ = write!(text, " {:>14}", thousands(cell));
            }
            line(out, format_args!("{text}"));
        }
    }

    fn text_of_tni(&self, out: &mut String) {
        let tni = self.tni();
        let per_ray = |n: u64| n as f64 / tni.unit.rays.max(1) as f64;
        let tni_cycles =
            (self.cycles as f64 * f64::from(self.tni_mhz) / f64::from(self.srp_mhz)).max(1.0);
        line(
            out,
            format_args!(
                "\nT&I: {} rays, {} hits; a ray: {:.2} inner nodes, {:.2} leaves, {:.2} triangle \
                 tests, {:.1} cycles resident",
                thousands(tni.unit.rays),
                thousands(tni.unit.hits),
                per_ray(tni.trv.inner_visits),
                per_ray(tni.trv.leaf_visits),
                per_ray(tni.triangle_tests),
                per_ray(tni.unit.resident_cycles),
            ),
        );
        let head = ["unit", "passes", "busy", "issuing", "bypassed", "repeated"];
        line(
            out,
            format_args!(
                "{:10} {:>14} {:>7} {:>7} {:>10} {:>10}",
                head[0], head[1], head[2], head[3], head[4], head[5]
            ),
        );
        let mut row = |name: &str, pipe: &PipeCounters, count: u64| {
            let cycles = tni_cycles * count as f64;
            line(
                out,
                format_args!(
                    "{name:10} {:>14} {:>7} {:>7} {:>10} {:>10}",
                    thousands(pipe.passes),
                    share(pipe.busy_cycles as f64 / cycles),
                    share(pipe.issue_cycles as f64 / cycles),
                    thousands(pipe.bypasses),
                    thousands(pipe.recirculated),
                ),
            );
        };
        row("TRV_PRE", &tni.pre, tni.trvs);
        row("TRV_AABB", &tni.aabb, tni.trvs);
        row("TRV_POST", &tni.post, tni.trvs);
        row("IST", &tni.ist, tni.ists);
        let stacks = &tni.stacks;
        line(
            out,
            format_args!(
                "stacks: {} pushes, {} pops, {} culled, {} overflows, {} restarts",
                thousands(stacks.pushes),
                thousands(stacks.pops),
                thousands(stacks.culled),
                thousands(stacks.overflows),
                thousands(stacks.restarts),
            ),
        );
    }

    fn text_of_memory(&self, out: &mut String) {
        let tni = self.tni();
        let (mut data, mut texture) = (CacheCounters::default(), CacheCounters::default());
        let (mut samples, mut texture_bytes) = (0, 0);
        let mut instructions: Option<CacheCounters> = None;
        let mut contexts: Option<ContextCounters> = None;
        for core in &self.cores {
            data.add(&core.data_cache);
            texture.add(&core.texture_cache);
            if let Some(of_core) = &core.instruction_cache {
                instructions.get_or_insert_default().add(of_core);
            }
            if let Some(of_core) = &core.contexts {
                contexts.get_or_insert_default().add(of_core);
            }
            samples += core.texture_samples;
            texture_bytes += core.texture_bytes;
        }
        line(
            out,
            format_args!(
                "\n{:10} {:>14} {:>12} {:>12} {:>7}",
                "cache", "accesses", "misses", "joined", "hits"
            ),
        );
        for (name, cache) in [
            ("TRV L1", Some(&tni.trv_l1)),
            ("TRV L2", Some(&tni.trv_l2)),
            ("IST L1", Some(&tni.ist_l1)),
            ("SRP data", Some(&data)),
            ("texture", Some(&texture)),
            ("SRP code", instructions.as_ref()),
        ] {
            let Some(cache) = cache else { continue };
            let accesses = cache.hits + cache.misses + cache.joined;
            let hits = match accesses {
                0 => "–".to_owned(),
                _ => share(cache.hit_rate()),
            };
            line(
                out,
                format_args!(
                    "{name:10} {:>14} {:>12} {:>12} {hits:>7}",
                    thousands(accesses),
                    thousands(cache.misses),
                    thousands(cache.joined),
                ),
            );
        }
        if data.prefetches + data.dropped > 0 {
            let [prefetches, dropped] = [data.prefetches, data.dropped].map(thousands);
            line(
                out,
                format_args!(
                    "prefetches: {prefetches} lines requested, {dropped} dropped for want of room"
                ),
            );
        }
        if samples > 0 {
            let (samples, bytes) = (thousands(samples), thousands(texture_bytes));
            line(
                out,
                format_args!("textures: {samples} samples, {bytes} bytes read"),
            );
        }
        if let Some(contexts) = contexts {
            let [launches, loads, bytes] =
                [contexts.launches, contexts.loads, contexts.bytes].map(thousands);
            line(
                out,
                format_args!(
                    "contexts: {launches} launches, {loads} of them of kernels that were not there, {bytes} bytes read"
                ),
            );
        }
        out.push_str(&self.bus.text());
        out.push_str(&self.dram.text());
        if let Some(first) = self.shared_words.first {
            let count = thousands(self.shared_words.count);
            line(
                out,
                format_args!(
                    "{count} words are shared by cores, the first at {first:#010x}: one writes and another uses them, and \
                     nothing keeps their caches coherent"
                ),
            );
        }
    }
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    writeln!(out, "{text}").expect("writing to a String does not fail");
}

/// The different names, in order of first appearance.
fn names<'a>(all: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in all {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

fn percent(part: u64, all: u64) -> String {
    share(if all == 0 {
        0.0
    } else {
        part as f64 / all as f64
    })
}

fn share(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::super::PortCycles;
    use super::*;
    use crate::memory::dram::{ChannelCounters, DramCounters, DramReport};
    use crate::memory::path::BusReport;
    use crate::system::SharedWords;
    use crate::tni::{TniCounters, TrvCounters};
    use srp_archdesc::dram::presets;

    fn core(kernel: &str, cycles: u64) -> CoreReport {
        let pipe = |passes| PipeCounters {
            passes,
            issue_cycles: passes,
            busy_cycles: 3 * passes,
            ..PipeCounters::default()
        };
        let mut tni = TniCounters {
            trvs: 4,
            ists: 1,
            trv: TrvCounters {
                inner_visits: 900,
                leaf_visits: 100,
                ..TrvCounters::default()
            },
            triangle_tests: 120,
            pre: pipe(1000),
            aabb: pipe(900),
            post: pipe(1000),
            ist: pipe(120),
            ..TniCounters::default()
        };
        (tni.unit.rays, tni.unit.hits, tni.unit.resident_cycles) = (64, 60, 12_800);
        (tni.stacks.pushes, tni.stacks.pops) = (450, 440);
        (tni.trv_l1.hits, tni.trv_l1.misses) = (890, 10);
        CoreReport {
            vliw: 1000,
            vliw_operations: 1500,
            array: vec![KernelRuns {
                kernel: kernel.to_owned(),
                cycles,
                operations: 8 * cycles,
            }],
            switch: 0,
            memory_stall: 250,
            texture_stall: 50,
            instruction_stall: 0,
            context_stall: 0,
            sram_stall: 0,
            kernel_sram_stalls: Vec::new(),
            instruction_cache: None,
            contexts: None,
            kernel_stalls: vec![KernelCycles {
                kernel: kernel.to_owned(),
                cycles: 280,
            }],
            wait: vec![PortCycles {
                port: "a finished submission".to_owned(),
                cycles: 300,
            }],
            idle: 8400 - cycles,
            data_cache: CacheCounters {
                hits: 999,
                misses: 1,
                ..CacheCounters::default()
            },
            texture_cache: CacheCounters {
                hits: 90,
                misses: 10,
                ..CacheCounters::default()
            },
            texture_bytes: 640,
            texture_samples: 64,
            tni,
            exit_status: 0,
            output: String::new(),
        }
    }

    /// Two channels that have worked for 10,000 cycles.
    fn dram() -> DramReport {
        let [paper, ..] = presets();
        let channel = ChannelCounters {
            reads: 1500,
            writes: 500,
            read_row_hits: 1000,
            activates: 700,
            refreshes: 3,
            busy_cycles: 4000,
            queued_cycles: 25_000,
            ..ChannelCounters::default()
        };
        let counters = DramCounters {
            reads: 1000,
            bytes_read: 64_000,
            bytes_written: 512,
            read_cycles: 45_000,
            max_read_cycles: 180,
            channels: vec![channel, ChannelCounters::default()],
            ..DramCounters::default()
        };
        DramReport::of(&paper.spec, 1, 10_000, counters)
    }

    #[test]
    fn text_shows_where_the_cycles_went() {
        let report = Report {
            width: 16,
            height: 8,
            complete: true,
            tiles_taken: 2,
            tiles: 2,
            cycles: 10_000,
            srp_mhz: 1000,
            tni_mhz: 500,
            milliseconds: 0.01,
            rays: 128,
            mrays_per_second: 12.8,
            cores: vec![core("primary", 5000), core("shade", 8400)],
            bus: BusReport {
                width: 16,
                mhz: 1000,
                requests: 0.125,
                answers: 0.5,
            },
            dram: dram(),
            shared_words: SharedWords {
                count: 3,
                first: Some(0x8000_1000),
            },
        };
        let expected = "\
16x8 pixels in 10 000 cycles at 1000 MHz: 0.010 ms, 128 rays, 12.8 Mrays/s

SRP cycles                    share   IPC         core 0         core 1
VLIW                         10.0 %  1.50          1 000          1 000
array: primary               25.0 %  8.00          5 000              0
array: shade                 42.0 %  8.00              0          8 400
memory stall                  2.5 %                  250            250
texture stall                 0.5 %                   50             50
  of both in primary          1.4 %                  280              0
  of both in shade            1.4 %                    0            280
wait: a finished submission   3.0 %                  300            300
idle                         17.0 %                3 400              0

T&I: 128 rays, 120 hits; a ray: 14.06 inner nodes, 1.56 leaves, 1.88 triangle tests, 200.0 cycles resident
unit               passes    busy issuing   bypassed   repeated
TRV_PRE             2 000  15.0 %   5.0 %          0          0
TRV_AABB            1 800  13.5 %   4.5 %          0          0
TRV_POST            2 000  15.0 %   5.0 %          0          0
IST                   240   7.2 %   2.4 %          0          0
stacks: 900 pushes, 880 pops, 0 culled, 0 overflows, 0 restarts

cache            accesses       misses       joined    hits
TRV L1              1 800           20            0  98.9 %
TRV L2                  0            0            0       –
IST L1                  0            0            0       –
SRP data            2 000            2            0  99.9 %
texture               200           20            0  90.0 %
textures: 128 samples, 1 280 bytes read
bus: answers take 50.0 % of its cycles, requests and writes 12.5 %, 16 bytes at 1000 MHz
memory: 64 000 bytes read, 512 written, 6.451 GB/s of 16.0; reads take 45.0 ns, at most 180.0
channel             GB/s    busy        reads       writes row hits       opened refreshes  queued
0                  3.200  40.0 %        1 500          500   50.0 %          700         3    2.50
1                  0.000   0.0 %            0            0    0.0 %            0         0    0.00
3 words are shared by cores, the first at 0x80001000: one writes and another uses them, and nothing keeps their caches coherent
";
        assert_eq!(report.text(), expected);
    }
}
