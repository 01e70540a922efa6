//! A machine as text to read.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::arch::{
    Approx, Arch, Fast, FileKind, FuOp, FuSpec, Input, Precision, Refine, Resource, Subnormals,
    WireSpec,
};
use crate::cost::FO4_PS;
use crate::dram::{DramModel, DramSpec, RowPolicy};
use crate::format::{Format, KINDS};
use crate::isa::Class;
use crate::structure::Structure;
use crate::system::{CacheSpec, Pipeline};

/// The machine at a glance: the array as a grid of units, the classes that each kind of unit runs, register
/// files, peak rates, memories and the T&I unit. Several lines, each with its line break.
pub fn show(arch: &Arch) -> String {
    let mut out = String::new();
    show_machine(&mut out, arch).expect("writing to a string does not fail");
    out
}

/// The properties that units of one kind share.
type UnitKind<'a> = (u32, bool, u32, &'a [FuOp]);

fn unit_kind(unit: &FuSpec) -> UnitKind<'_> {
    (unit.width, unit.pred_out, unit.constants, &unit.ops)
}

fn show_machine(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let mut kinds: Vec<UnitKind<'_>> = Vec::new();
    for unit in arch.srp.fus.values() {
        if !kinds.contains(&unit_kind(unit)) {
            kinds.push(unit_kind(unit));
        }
    }
    let flops = arch.srp.peak_flops_per_cycle();
    let ghz = f64::from(arch.system.srp_mhz) / 1000.0;
    let cores = f64::from(arch.system.cores);
    writeln!(
        out,
        "machine {}: {} × SRP of {}×{} units at {} MHz{}",
        arch.name,
        arch.system.cores,
        arch.srp.rows,
        arch.srp.cols,
        arch.system.srp_mhz,
        match f64::from(arch.system.fo4_ps) {
            FO4_PS => String::new(),
            ps => format!(", FO4 {ps} ps"),
        }
    )?;
    // The product of two decimals has digits that neither has.
    let rounded = |gflops: f64| (gflops * 1000.0).round() / 1000.0;
    writeln!(
        out,
        "peak {} GFLOPS per core, {} in all ({flops} floating-point operations per cycle)",
        rounded(flops * ghz),
        rounded(flops * ghz * cores)
    )?;
    writeln!(out)?;
    show_grid(out, arch, &kinds)?;
    writeln!(out)?;
    show_kinds(out, arch, &kinds)?;
    writeln!(out)?;
    show_classes(out, arch)?;
    writeln!(out)?;
    show_wires(out, arch)?;
    show_files(out, arch)?;
    writeln!(out)?;
    show_engine(out, arch)?;
    writeln!(out)?;
    show_system(out, arch)
}

/// A letter for each kind of unit: `A` to `Z`, then `A1` and so on.
fn letter(kind: usize) -> String {
    let letter = char::from(b'A' + (kind % 26) as u8);
    match kind / 26 {
        0 => letter.to_string(),
        n => format!("{letter}{n}"),
    }
}

fn show_grid(out: &mut String, arch: &Arch, kinds: &[UnitKind<'_>]) -> std::fmt::Result {
    let cell = |unit: &FuSpec| {
        let kind = kinds.iter().position(|kind| *kind == unit_kind(unit));
        let kind = letter(kind.unwrap_or(0));
        match unit.slot {
            Some(slot) => format!("{kind}:{slot}"),
            None => kind,
        }
    };
    let cells: Vec<String> = arch.srp.fus.values().map(cell).collect();
    let width = cells.iter().map(String::len).max().unwrap_or(1);
    let rule = format!(
        "  +{}",
        format!("{:-<1$}+", "", width + 2).repeat(arch.srp.cols as usize)
    );
    let wires = match arch.srp.wires.len() {
        0 => String::new(),
        wires => format!(", {wires} wires"),
    };
    writeln!(
        out,
        "array (unit kind:VLIW slot), {} links{wires}",
        arch.srp.links.len()
    )?;
    for row in cells.chunks(arch.srp.cols as usize) {
        writeln!(out, "{rule}")?;
        let row: Vec<String> = row.iter().map(|c| format!(" {c:<width$} ")).collect();
        writeln!(out, "  |{}|", row.join("|"))?;
    }
    writeln!(out, "{rule}")
}

fn show_kinds(out: &mut String, arch: &Arch, kinds: &[UnitKind<'_>]) -> std::fmt::Result {
    for (n, kind) in kinds.iter().enumerate() {
        let (width, pred_out, constants, ops) = *kind;
        let count = arch
            .srp
            .fus
            .values()
            .filter(|u| unit_kind(u) == *kind)
            .count();
        let predicates = if pred_out { "own" } else { "no" };
        writeln!(
            out,
            "{}: {count} of {width} bits, {predicates} predicate output, {constants} constant(s)",
            letter(n)
        )?;
        let classes: Vec<&str> = ops.iter().map(|op| op.class.name()).collect();
        writeln!(out, "   {}", classes.join(" "))?;
    }
    Ok(())
}

/// A way in which a class runs: whether it is that of one operation only, whose name it is, latency,
/// interval, and what is taken.
type Way<'a> = ((bool, &'a str), u32, u32, Vec<Resource>);

/// Latency, interval and units of each class; classes that run differently on some units have
/// several lines.
fn show_classes(out: &mut String, arch: &Arch) -> std::fmt::Result {
    writeln!(out, "class   latency  interval  units  slots  shares")?;
    for &class in Class::ALL {
        let mut ways: BTreeMap<Way<'_>, (u32, u32)> = BTreeMap::new();
        for unit in arch.srp.fus.values() {
            let Some(op) = unit.op(class) else { continue };
            // The class first, then operations of it that run differently.
            let all = std::iter::once(((false, class.name()), op));
            let special = op.special.iter().map(|s| ((true, s.op.name()), &s.how));
            for (name, how) in all.chain(special) {
                let way = ways.entry((name, how.latency, how.interval, how.uses.clone()));
                let (units, slots) = way.or_default();
                *units += 1;
                *slots += u32::from(unit.slot.is_some());
            }
        }
        for (((_, name), latency, interval, uses), (units, slots)) in ways {
            let uses: Vec<String> = uses
                .iter()
                .map(|&r| {
                    format!(
                        "{} ({})",
                        arch.srp.resources[r].name, arch.srp.resources[r].count
                    )
                })
                .collect();
            let line = format!(
                "{:<8}{latency:>7}{interval:>10}{units:>7}{slots:>7}  {}",
                name,
                uses.join(", ")
            );
            writeln!(out, "{}", line.trim_end())?;
        }
    }
    Ok(())
}

/// Switches and buses: wires that are alike, in one line.
fn show_wires(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let srp = &arch.srp;
    let ends = |from: &Input| matches!(from, Input::Wire(_));
    let kind = |wire: &WireSpec| {
        let of_switch = wire.from.iter().any(ends);
        (of_switch, wire.width, wire.delay, wire.to.len())
    };
    let mut kinds: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for wire in srp.wires.values() {
        kinds.entry(kind(wire)).or_default().push(wire.from.len());
    }
    for ((of_switch, width, delay, readers), inputs) in &kinds {
        let (count, least, most) = (inputs.len(), inputs.iter().min(), inputs.iter().max());
        let (least, most) = (least.unwrap_or(&0), most.unwrap_or(&0));
        let inputs = match least == most {
            true => format!("{most}"),
            false => format!("{least} to {most}"),
        };
        let from = match of_switch {
            true => "unit(s) and wires",
            false => "unit(s)",
        };
        writeln!(
            out,
            "{count} wire(s) of {width} bits: from {inputs} {from} to {readers} unit(s), delay {delay}"
        )?;
    }
    match kinds.is_empty() {
        true => Ok(()),
        false => writeln!(
            out,
            "a value passes up to {} wire(s) in a cycle\n",
            srp.hops
        ),
    }
}

fn show_files(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let mut local: BTreeMap<(&str, u32, u32), usize> = BTreeMap::new();
    for file in arch.srp.files.values() {
        match file.kind {
            FileKind::Central => writeln!(
                out,
                "central file {}: {} × {} bits, {} read and {} write ports",
                file.name, file.size, file.width, file.read_ports, file.write_ports
            )?,
            FileKind::Rotating => {
                *local
                    .entry(("rotating", file.size, file.width))
                    .or_default() += 1
            }
            FileKind::Static => *local.entry(("static", file.size, file.width)).or_default() += 1,
        }
    }
    for ((kind, size, width), count) in local {
        writeln!(out, "{count} {kind} files: {size} × {width} bits")?;
    }
    Ok(())
}

fn show_engine(out: &mut String, arch: &Arch) -> std::fmt::Result {
    writeln!(
        out,
        "{} VLIW slots, branch delay {}; mode switch {} cycles, {} registers set per cycle; {} contexts{}",
        arch.srp.slots().len(),
        arch.srp.branch_delay,
        arch.srp.mode_switch,
        arch.srp.preload_width,
        arch.srp.contexts,
        match arch.srp.shared_contexts {
            true => " for all kernels",
            false => " for each kernel",
        }
    )?;
    let Precision {
        rcp,
        rsqrt,
        sqrt,
        div,
        exp2,
        log2,
        sincos,
        fast,
        subnormals,
        formats,
        texture_weight_bits: _,
    } = arch.precision;
    let functions = [
        ("rcp", rcp),
        ("rsqrt", rsqrt),
        ("sqrt", sqrt),
        ("div", div),
        ("exp2", exp2),
        ("log2", log2),
        ("sincos", sincos),
    ];
    let Fast {
        rcp,
        rsqrt,
        sqrt,
        div,
    } = fast;
    let fast = [
        ("rcp_fast", rcp),
        ("rsqrt_fast", rsqrt),
        ("sqrt_fast", sqrt),
        ("div_fast", div),
    ];
    let fast = fast
        .into_iter()
        .filter_map(|(name, approx)| Some((name, approx?)));
    let functions: Vec<String> = (functions.into_iter().chain(fast))
        .map(|(name, approx)| format!("{name} {}", precision(approx)))
        .collect();
    writeln!(out, "special functions: {}", functions.join(", "))?;
    let software = arch.srp.in_software();
    if !software.is_empty() && !arch.srp.slots().is_empty() {
        let classes: Vec<&str> = software.iter().map(|class| class.name()).collect();
        writeln!(
            out,
            "in software, for want of units: {}",
            classes.join(", ")
        )?;
    }
    for ((_, what), format) in KINDS.iter().zip(formats.all()) {
        if format != Format::SINGLE {
            writeln!(out, "{what} in {}", format.name())?;
        }
    }
    match subnormals {
        Subnormals::Keep => Ok(()),
        Subnormals::Flush => writeln!(out, "subnormal floats are flushed to zero"),
    }
}

fn precision(approx: Approx) -> String {
    match approx {
        Approx::Exact => "exact".to_owned(),
        Approx::Table {
            structure,
            bits,
            steps: 0,
            ..
        } => format!("{bits} bits{}", by(structure)),
        Approx::Table {
            structure,
            bits,
            steps,
            fused,
            refine,
        } => {
            let by = by(structure);
            let separate = if fused { "" } else { " not fused" };
            let place = match refine {
                Refine::Unit => "",
                Refine::Code => " in code",
            };
            format!("{bits} bits{by} + {steps} steps{separate}{place}")
        }
    }
}

/// How a first approximation is made, unless it is by the plain table.
fn by(structure: Structure) -> String {
    match structure {
        Structure::Table => String::new(),
        other => format!(" by {other}"),
    }
}

fn bytes(n: u32) -> String {
    match n {
        n if n % 1024 == 0 => format!("{} KiB", n / 1024),
        n => format!("{n} bytes"),
    }
}

fn cache(name: &str, c: &CacheSpec) -> String {
    format!(
        "{name}: {}, {} ways, lines of {} bytes, latency {}, {} bank(s), {} misses{}",
        bytes(c.bytes),
        c.ways,
        c.line,
        c.latency,
        c.banks,
        c.misses,
        if c.blocking { ", blocking" } else { "" }
    )
}

fn show_system(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let s = &arch.system;
    match s.tile_block {
        1 => writeln!(out, "tiles: one by one, in rows")?,
        side => writeln!(
            out,
            "tiles: in blocks of up to {side}×{side}, each for one core"
        )?,
    }
    write!(out, "SRAM: {}", bytes(s.sram_bytes))?;
    if let Some(banks) = s.sram_banks {
        let shared = match banks.shared {
            true => ", the T&I unit's too",
            false => "",
        };
        write!(out, ", {banks}{shared}")?;
    }
    writeln!(out)?;
    writeln!(out, "{}", cache("data cache", &s.data_cache))?;
    writeln!(out, "{}", cache("texture cache", &s.texture_cache))?;
    if let Some(c) = &s.instruction_cache {
        writeln!(
            out,
            "instruction cache: {}, {} ways, lines of {} bytes",
            bytes(c.bytes),
            c.ways,
            c.line
        )?;
    }
    let bits = arch.precision.texture_weight_bits;
    writeln!(out, "texture unit: weights of {bits} bits")?;
    let b = &s.buffers;
    writeln!(
        out,
        "buffers of {} rays: {} of rays ({} bytes each), {} of hits ({} bytes each)",
        b.rays, b.ray_buffers, b.ray_bytes, b.hit_buffers, b.hit_bytes
    )?;
    let t = &s.tni;
    let pipeline = match t.pipeline {
        Pipeline::Single => "single pipeline",
        Pipeline::Parallel => "parallel pipelines",
    };
    writeln!(
        out,
        "T&I unit: {} TRV ({pipeline}) and {} IST at {} MHz; {} stacks of {} per TRV",
        t.trvs, t.ists, s.tni_mhz, t.stacks, t.stack_depth
    )?;
    if t.pipeline == Pipeline::Parallel {
        writeln!(
            out,
            "  sub-pipelines of a TRV: {} PRE, {} AABB, {} POST",
            t.pres, t.aabbs, t.posts
        )?;
    }
    writeln!(
        out,
        "  latencies: pre {}, aabb {}, post {}, ist {}; FIFOs of {}, RAU of {} rows",
        t.pre_latency, t.aabb_latency, t.post_latency, t.ist_latency, t.fifo, t.rau_rows
    )?;
    writeln!(
        out,
        "  nodes of {} bytes ({}), triangles of {} bytes, test {}, reciprocal {}, {}",
        t.node_bytes,
        t.node_format.name(),
        t.triangle_bytes,
        t.intersection.name(),
        precision(t.rcp),
        if t.any_hit {
            "any-hit exit"
        } else {
            "no any-hit exit"
        }
    )?;
    for (name, spec) in [
        ("TRV L1", &t.trv_l1),
        ("TRV L2", &t.trv_l2),
        ("IST L1", &t.ist_l1),
    ] {
        writeln!(out, "  {}", cache(name, spec))?;
    }
    writeln!(
        out,
        "bus: {} bytes at {} MHz, latency {}",
        s.bus.width, s.bus.mhz, s.bus.latency
    )?;
    show_dram(out, &s.dram)
}

fn show_dram(out: &mut String, d: &DramSpec) -> std::fmt::Result {
    let peak = f64::from(d.mhz) * 2.0 * f64::from(d.channels) * f64::from(d.bits) / 8.0 / 1000.0;
    let whose = match d.shared {
        true => "shared by all cores",
        false => "one for each core",
    };
    writeln!(
        out,
        "DRAM, {whose}: {} channel(s) of {} bits at {} MHz, peak {peak} GB/s, {} ns on top",
        d.channels, d.bits, d.mhz, d.latency_ns
    )?;
    let DramModel::Banked(b) = &d.model else {
        return Ok(());
    };
    writeln!(
        out,
        "  {} banks of {} rows of {}, bursts of {}",
        b.banks,
        b.rows,
        bytes(b.columns * d.bits / 8),
        bytes(b.burst_bytes(d.bits)),
    )?;
    write!(out, " ")?;
    for (name, cycles) in b.timing.rows() {
        write!(out, " {} {cycles}", name.to_uppercase())?;
    }
    writeln!(out)?;
    let c = &b.controller;
    let policy = match c.row_policy {
        RowPolicy::Open => "open",
        RowPolicy::Closed => "closed",
    };
    writeln!(
        out,
        "  queues of {} reads, {} writes and {} commands a bank; rows {policy}, {} hits at a time",
        c.read_queue, c.write_queue, c.command_queue, c.row_hits
    )
}
