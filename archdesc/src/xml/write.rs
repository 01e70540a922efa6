//! The expanded form: a machine written out with every unit, link and file, nothing left to a
//! default.

use std::fmt::Write;

use super::dram::{PARTS, ROW_POLICIES};
use super::links::{TOPOLOGIES, Topology};
use super::system::RAU_RAYS;
use super::wires::HOPS;
use crate::arch::{Approx, Arch, FileKind, FileSpec, Fu, FuSpec, Input, WireSpec};
use crate::cost::special::Build;
use crate::datapath::FpLatency;
use crate::dram::{BankedSpec, DramModel, DramSpec};
use crate::format::{Format, KINDS};
use crate::precision::Refine;
use crate::structure::{Special, Structure};
use crate::system::{BankSpec, CacheSpec, Pipeline, SystemSpec};

/// The machine file that spells out `arch`. [`parse`](super::parse) gives the same machine back.
pub fn write(arch: &Arch) -> String {
    let mut out = String::new();
    write_machine(&mut out, arch).expect("writing to a string does not fail");
    out
}

fn write_machine(out: &mut String, arch: &Arch) -> std::fmt::Result {
    writeln!(out, "<machine name=\"{}\">", arch.name)?;
    for resource in arch.srp.resources.values() {
        let (name, count) = (&resource.name, resource.count);
        writeln!(out, "  <resource name=\"{name}\" count=\"{count}\"/>")?;
    }
    for function in arch.precision.specials() {
        let approx = arch.precision.of(function);
        write_special(out, "  ", function, approx, arch.builds.of(function))?;
    }
    let subnormals = arch.precision.subnormals.name();
    write!(out, "  <float subnormals=\"{subnormals}\"")?;
    for ((name, _), format) in KINDS.iter().zip(arch.precision.formats.all()) {
        if format != Format::SINGLE {
            write!(out, " {name}=\"{}\"", format.name())?;
        }
    }
    writeln!(out, "/>")?;
    let none = TOPOLOGIES.iter().find(|(_, t)| *t == Topology::None);
    let none = none.map_or("", |(name, _)| name);
    let hops = match arch.srp.hops == HOPS {
        true => String::new(),
        false => format!(" hops=\"{}\"", arch.srp.hops),
    };
    writeln!(
        out,
        "  <array rows=\"{}\" cols=\"{}\" topology=\"{none}\"{hops} contexts=\"{}\" \
         shared-contexts=\"{}\">",
        arch.srp.rows, arch.srp.cols, arch.srp.contexts, arch.srp.shared_contexts
    )?;
    for unit in arch.srp.fus.values() {
        write_unit(out, arch, unit)?;
    }
    for file in arch.srp.files.values() {
        write_file(out, arch, file)?;
    }
    for link in arch.srp.links.values() {
        writeln!(
            out,
            "    <link from=\"{}\" to=\"{}\" delay=\"{}\" width=\"{}\"/>",
            arch.srp.fus[link.from].name, arch.srp.fus[link.to].name, link.delay, link.width
        )?;
    }
    for wire in arch.srp.wires.values() {
        write_wire(out, arch, wire)?;
    }
    writeln!(out, "  </array>")?;
    writeln!(
        out,
        "  <vliw slots=\"0\" branch-delay=\"{}\" mode-switch=\"{}\" preload-width=\"{}\"/>",
        arch.srp.branch_delay, arch.srp.mode_switch, arch.srp.preload_width
    )?;
    write_system(out, arch)?;
    writeln!(out, "</machine>")
}

fn write_special(
    out: &mut String,
    indent: &str,
    function: Special,
    approx: Approx,
    build: &Build,
) -> std::fmt::Result {
    write!(out, "{indent}<special function=\"{}\"", function.name())?;
    match approx {
        Approx::Exact => {
            write!(out, " bits=\"exact\"")?;
            if let Some(structure) = build.exact {
                write_structure(out, structure)?;
            }
        }
        Approx::Table {
            structure,
            bits,
            steps,
            fused,
            refine,
        } => {
            write!(out, " bits=\"{bits}\"")?;
            write_structure(out, structure)?;
            if structure.is_tabulated() {
                write!(out, " steps=\"{steps}\"")?;
                // How steps are taken is said where there are some.
                if steps > 0 || !fused || refine != Refine::Unit {
                    write!(out, " fused=\"{fused}\" refine=\"{}\"", refine.name())?;
                }
            }
        }
    }
    let numbers = [
        ("datapath", build.datapath),
        ("latency", build.latency),
        ("interval", build.interval),
        ("area-um2", build.area_um2),
        ("energy-fj", build.energy_fj),
    ];
    for (name, number) in numbers {
        if let Some(number) = number {
            write!(out, " {name}=\"{number}\"")?;
        }
    }
    writeln!(out, "/>")
}

fn write_structure(out: &mut String, structure: Structure) -> std::fmt::Result {
    write!(out, " structure=\"{}\"", structure.name())?;
    match structure {
        Structure::Offsets { tables } if tables > 1 => write!(out, " tables=\"{tables}\""),
        Structure::Polynomial { degree, segments } => {
            write!(
                out,
                " degree=\"{degree}\" segments=\"{}\"",
                1u32 << segments
            )
        }
        Structure::Recurrence { radix, unrolled } => {
            write!(out, " radix=\"{radix}\" unrolled=\"{unrolled}\"")
        }
        _ => Ok(()),
    }
}

fn write_unit(out: &mut String, arch: &Arch, unit: &FuSpec) -> std::fmt::Result {
    write!(
        out,
        "    <fu name=\"{}\" row=\"{}\" col=\"{}\" width=\"{}\" pred-out=\"{}\" constants=\"{}\"",
        unit.name, unit.row, unit.col, unit.width, unit.pred_out, unit.constants
    )?;
    if let Some(slot) = unit.slot {
        write!(out, " slot=\"{slot}\"")?;
    }
    if unit.ops.is_empty() {
        return writeln!(out, "/>");
    }
    writeln!(out, ">")?;
    for op in &unit.ops {
        let uses: Vec<&str> = op
            .uses
            .iter()
            .map(|&r| arch.srp.resources[r].name.as_str())
            .collect();
        write!(out, "      <op class=\"{}\"", op.class)?;
        // Cycles that follow from clock, structure or format follow from them again.
        if op.given[0] {
            write!(out, " latency=\"{}\"", op.latency)?;
        }
        if op.given[1] {
            write!(out, " interval=\"{}\"", op.interval)?;
        }
        writeln!(out, " uses=\"{}\"/>", uses.join(" "))?;
    }
    writeln!(out, "    </fu>")
}

fn write_file(out: &mut String, arch: &Arch, file: &FileSpec) -> std::fmt::Result {
    let kind = match file.kind {
        FileKind::Central => "central",
        FileKind::Rotating => "rotating",
        FileKind::Static => "static",
    };
    let units = |list: &[Fu]| {
        let names: Vec<&str> = list
            .iter()
            .map(|&fu| arch.srp.fus[fu].name.as_str())
            .collect();
        names.join(" ")
    };
    writeln!(
        out,
        "    <file name=\"{}\" kind=\"{kind}\" width=\"{}\" size=\"{}\" read-ports=\"{}\" \
         write-ports=\"{}\" readers=\"{}\" writers=\"{}\" from-links=\"{}\"/>",
        file.name,
        file.width,
        file.size,
        file.read_ports,
        file.write_ports,
        units(&file.readers),
        units(&file.writers),
        file.from_links
    )
}

fn write_wire(out: &mut String, arch: &Arch, wire: &WireSpec) -> std::fmt::Result {
    let unit = |fu: Fu| arch.srp.fus[fu].name.as_str();
    let input = |&input: &Input| match input {
        Input::Unit(fu) => unit(fu),
        Input::Wire(wire) => arch.srp.wires[wire].name.as_str(),
    };
    let from: Vec<&str> = wire.from.iter().map(input).collect();
    let to: Vec<&str> = wire.to.iter().map(|&fu| unit(fu)).collect();
    let (name, from) = (&wire.name, from.join(" "));
    write!(out, "    <wire name=\"{name}\" from=\"{from}\"")?;
    if !to.is_empty() {
        write!(out, " to=\"{}\"", to.join(" "))?;
    }
    let (delay, width) = (wire.delay, wire.width);
    writeln!(out, " delay=\"{delay}\" width=\"{width}\"/>")
}

fn write_cache(
    out: &mut String,
    indent: &str,
    element: &str,
    cache: &CacheSpec,
) -> std::fmt::Result {
    let CacheSpec {
        bytes,
        ways,
        line,
        latency,
        banks,
        misses,
        blocking,
    } = cache;
    let blocking = match element {
        "data-cache" | "texture-cache" => format!(" blocking=\"{blocking}\""),
        _ => String::new(),
    };
    writeln!(
        out,
        "{indent}<{element} size=\"{bytes}\" ways=\"{ways}\" line=\"{line}\" \
         latency=\"{latency}\" banks=\"{banks}\" misses=\"{misses}\"{blocking}/>"
    )
}

fn write_system(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let system = &arch.system;
    let SystemSpec {
        cores,
        tile_block,
        srp_mhz,
        tni_mhz,
        fo4_ps,
        sram_bytes,
        sram_banks,
        data_cache,
        texture_cache,
        instruction_cache,
        buffers,
        tni: _,
        bus,
        dram,
    } = system;
    writeln!(
        out,
        "  <system cores=\"{cores}\" tile-block=\"{tile_block}\" srp-mhz=\"{srp_mhz}\" \
         tni-mhz=\"{tni_mhz}\" fo4-ps=\"{fo4_ps}\">"
    )?;
    write!(out, "    <sram size=\"{sram_bytes}\"")?;
    if let Some(BankSpec {
        count,
        width,
        shared,
    }) = sram_banks
    {
        write!(
            out,
            " banks=\"{count}\" width=\"{width}\" shared=\"{shared}\""
        )?;
    }
    writeln!(out, "/>")?;
    write_cache(out, "    ", "data-cache", data_cache)?;
    write_cache(out, "    ", "texture-cache", texture_cache)?;
    if let Some(CacheSpec {
        bytes, ways, line, ..
    }) = instruction_cache
    {
        writeln!(
            out,
            "    <instruction-cache size=\"{bytes}\" ways=\"{ways}\" line=\"{line}\"/>"
        )?;
    }
    let bits = arch.precision.texture_weight_bits;
    writeln!(out, "    <texture weight-bits=\"{bits}\"/>")?;
    writeln!(
        out,
        "    <buffers rays=\"{}\" ray-buffers=\"{}\" hit-buffers=\"{}\" ray-bytes=\"{}\" \
         hit-bytes=\"{}\"/>",
        buffers.rays,
        buffers.ray_buffers,
        buffers.hit_buffers,
        buffers.ray_bytes,
        buffers.hit_bytes
    )?;
    write_tni(out, system)?;
    let (width, mhz, latency) = (bus.width, bus.mhz, bus.latency);
    writeln!(
        out,
        "    <bus width=\"{width}\" mhz=\"{mhz}\" latency=\"{latency}\"/>"
    )?;
    write_dram(out, dram)?;
    writeln!(out, "  </system>")
}

fn write_tni(out: &mut String, system: &SystemSpec) -> std::fmt::Result {
    let tni = &system.tni;
    let pipeline = match tni.pipeline {
        Pipeline::Single => "single",
        Pipeline::Parallel => "parallel",
    };
    // Latencies that follow from operators follow from them again.
    let given = &tni.given;
    let latencies = [
        ("pre", given.pre, tni.pre_latency),
        ("aabb", given.aabb, tni.aabb_latency),
        ("post", given.post, tni.post_latency),
        ("ist", given.ist, tni.ist_latency),
    ];
    let latencies = latencies.into_iter().filter(|&(_, given, _)| given);
    let latencies = latencies.map(|(name, _, n)| format!(" {name}-latency=\"{n}\""));
    let latencies: String = latencies.collect();
    let rau_rays = match (tni.rau_rows, tni.rau_rays) {
        (0, RAU_RAYS) => String::new(),
        (_, rays) => format!(" rau-rays=\"{rays}\""),
    };
    writeln!(
        out,
        "    <tni trvs=\"{}\" ists=\"{}\" pipeline=\"{pipeline}\" pres=\"{}\" aabbs=\"{}\" \
         posts=\"{}\" stacks=\"{}\" stack-depth=\"{}\"\n        {latencies}\n         fifo=\"{}\" \
         rau-rows=\"{}\"{rau_rays} node-format=\"{}\" node-bytes=\"{}\" triangle-bytes=\"{}\"\n         \
         intersection=\"{}\" any-hit=\"{}\">",
        tni.trvs,
        tni.ists,
        tni.pres,
        tni.aabbs,
        tni.posts,
        tni.stacks,
        tni.stack_depth,
        tni.fifo,
        tni.rau_rows,
        tni.node_format.name(),
        tni.node_bytes,
        tni.triangle_bytes,
        tni.intersection.name(),
        tni.any_hit
    )?;
    if let Some(FpLatency { add, mul, cmp, rcp }) = given.operators {
        writeln!(
            out,
            "      <fp add=\"{add}\" mul=\"{mul}\" cmp=\"{cmp}\" rcp=\"{rcp}\"/>"
        )?;
    }
    write_cache(out, "      ", "trv-l1", &tni.trv_l1)?;
    write_cache(out, "      ", "trv-l2", &tni.trv_l2)?;
    write_cache(out, "      ", "ist-l1", &tni.ist_l1)?;
    write_special(out, "      ", Special::Rcp, tni.rcp, &tni.rcp_build)?;
    writeln!(out, "    </tni>")
}

fn write_dram(out: &mut String, dram: &DramSpec) -> std::fmt::Result {
    let kind = match dram.model {
        DramModel::Fixed => "fixed",
        DramModel::Banked(_) => "banked",
    };
    write!(
        out,
        "    <dram kind=\"{kind}\" mhz=\"{}\" channels=\"{}\" bits=\"{}\" shared=\"{}\" \
         latency-ns=\"{}\"",
        dram.mhz, dram.channels, dram.bits, dram.shared, dram.latency_ns
    )?;
    match &dram.model {
        DramModel::Fixed => writeln!(out, "/>"),
        DramModel::Banked(banked) => write_banks(out, banked),
    }
}

fn write_banks(out: &mut String, banked: &BankedSpec) -> std::fmt::Result {
    let fields = banked.mapping.iter().map(|field| {
        let word = PARTS.iter().find(|(_, part)| *part == field.part);
        format!("{}:{}", word.map_or("", |(word, _)| word), field.bits)
    });
    writeln!(
        out,
        "\n          banks=\"{}\" rows=\"{}\" columns=\"{}\" burst=\"{}\"\n          \
         mapping=\"{}\">",
        banked.banks,
        banked.rows,
        banked.columns,
        banked.burst,
        fields.collect::<Vec<_>>().join(" ")
    )?;
    let timing = banked.timing.rows();
    let attributes = timing.map(|(name, cycles)| format!("{name}=\"{cycles}\""));
    let (first, second) = attributes.split_at(8);
    writeln!(
        out,
        "      <timing {}\n              {}/>",
        first.join(" "),
        second.join(" ")
    )?;
    let c = &banked.controller;
    let policy = ROW_POLICIES.iter().find(|(_, p)| *p == c.row_policy);
    writeln!(
        out,
        "      <controller read-queue=\"{}\" write-queue=\"{}\" command-queue=\"{}\" \
         row-policy=\"{}\"\n                  row-hits=\"{}\" write-drain=\"{}\"/>",
        c.read_queue,
        c.write_queue,
        c.command_queue,
        policy.map_or("", |(word, _)| word),
        c.row_hits,
        c.write_drain
    )?;
    writeln!(out, "    </dram>")
}
