//! `srp area`: what the chip of a machine costs: the T&I unit in the form of the paper's Tables 1 and 2, the
//! SRP by its parts, bus, cores and technologies.

use crate::cli;
use crate::failure::Failure;
use crate::{document, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::area::{self, Area, Complexity};
use srp_archdesc::chip::{self, Chip, SrpArea};
use srp_archdesc::cost::special::Unit;
use srp_archdesc::datapath::{BOX_TEST, Intersection};
use srp_archdesc::system::{Pipeline, TniSpec};
use srp_toolchain::envelope::{About, Contents};
use std::fmt::Write as _;

/// The paper's figures, printed beside ours: area with a parallel and with a single pipeline, mm².
const PAPER_PARALLEL: f64 = 3.32;
const PAPER_SINGLE: f64 = 3.28;
/// Kilobytes of registers in traversal and intersection units.
const PAPER_REGISTERS: (f64, f64) = (49.0, 8.0);

/// Runs `srp area`.
pub(crate) fn run(args: &cli::Area) -> Result<(), Failure> {
    let arch = args.machine.read()?;
    if args.json {
        let json = document::json(About::machine(&arch), &Document::of(&arch))?;
        return Ok(talk::print(json)?);
    }
    let mut out = String::new();
    write_area(&mut out, &arch).expect("writing to a String does not fail");
    Ok(talk::print(out)?)
}

/// The paper's areas of one SRP and of four cores, mm² at 65 nm.
const PAPER_SRP: f64 = 2.9;
const PAPER_CHIP: f64 = 25.0;
const PAPER_CORES: u32 = 4;

/// The SRP by its parts, and the whole.
fn write_chip(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let srp = chip::srp(arch);
    writeln!(out, "\nSRP of `{}`, 65 nm", arch.name)?;
    writeln!(out, "{:28} {:>9} {:>7}  extent", "part", "mm²", "share")?;
    for item in &srp.items {
        let share = 100.0 * item.mm2 / srp.total_mm2;
        writeln!(
            out,
            "{:28} {:>9.4} {share:>5.1} %  {}",
            item.name, item.mm2, item.extent
        )?;
    }
    writeln!(
        out,
        "{:28} {:>9.4}          the paper {PAPER_SRP}: {:+.0} %",
        "total",
        srp.total_mm2,
        100.0 * (srp.total_mm2 / PAPER_SRP - 1.0)
    )?;
    write_specials(out, arch)?;
    let chip = Chip::of(arch);
    let deviation = match chip.cores {
        PAPER_CORES => format!(": {:+.0} %", 100.0 * (chip.total_mm2 / PAPER_CHIP - 1.0)),
        _ => String::new(),
    };
    writeln!(
        out,
        "\nchip: {} × (SRP {:.2} + T&I {:.2}) + bus {:.3} = {:.2} mm² (the paper's four cores {PAPER_CHIP}{deviation})",
        chip.cores, chip.srp_mm2, chip.tni_mm2, chip.bus_mm2, chip.total_mm2
    )?;
    for (technology, mm2) in &chip.scaled_mm2 {
        writeln!(out, "  {:>2} nm {mm2:>9.3} mm²", technology.nm)?;
    }
    writeln!(
        out,
        "The paper's figures are not used. Not counted: banks of caches, outstanding misses of\n\
         those that block and of the T&I unit's, control of several pipelines of a kind,\n\
         memory controller, pads, and what a floor plan leaves empty. `docs/costs.md` says where the deviation comes from"
    )
}

/// The units of special functions, each by itself.
fn write_specials(out: &mut String, arch: &Arch) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:9} {:>8} {:>9} {:>9} {:>9}  largest parts, µm²",
        "function", "latency", "interval", "mm²", "pJ"
    )?;
    for special in arch.precision.specials() {
        let unit = arch.special_unit(special);
        let cycles = |n: Option<u32>| n.map_or("class".to_owned(), |n| n.to_string());
        let mut parts: Vec<_> = unit.parts.iter().collect();
        parts.sort_by(|a, b| b.area_um2.total_cmp(&a.area_um2));
        let parts: Vec<String> = (parts.iter().take(3))
            .map(|part| format!("{} {:.0}", part.name, part.area_um2))
            .collect();
        writeln!(
            out,
            "{:9} {:>8} {:>9} {:>9.5} {:>9.2}  {}",
            special.name(),
            cycles(unit.latency),
            cycles(unit.interval),
            unit.area_um2 * 1e-6,
            unit.energy_pj,
            parts.join(", ")
        )?;
    }
    writeln!(
        out,
        "Each row is a unit of its own. Functions of a unit with a common datapath have it once, and units repeat, so that \
         these rows\nare no parts of the sum above"
    )
}

/// The chip of a machine by its parts, and what each operation takes.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Document {
    /// All of the chip.
    chip: Chip,
    /// The SRP by its parts.
    srp: SrpArea,
    /// The units of special functions.
    special: Vec<(&'static str, Unit)>,
    /// The T&I unit by its parts.
    tni: Area,
    /// The T&I unit with traversal units of parallel pipelines.
    parallel_mm2: f64,
    /// The same with single pipelines.
    single_mm2: f64,
    /// Energy of single operations of the T&I unit.
    energy_nj: OperationEnergy,
}

impl Contents for Document {
    const FORMAT: &'static str = "srp-area";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp area --json`";
}

/// Energy of operations of the T&I unit, nJ.
#[derive(Serialize, JsonSchema)]
struct OperationEnergy {
    /// A test of a ray and a box.
    box_test: f64,
    /// A test of a ray and a triangle.
    triangle_test: f64,
    /// An access to the first cache of nodes.
    trv_l1: f64,
    /// An access to the second cache of nodes.
    trv_l2: f64,
    /// An access to the cache of triangles.
    ist_l1: f64,
}

impl Document {
    fn of(arch: &Arch) -> Document {
        let tni = &arch.system.tni;
        let specials = arch.precision.specials();
        Document {
            chip: Chip::of(arch),
            srp: chip::srp(arch),
            special: specials.map(|s| (s.name(), arch.special_unit(s))).collect(),
            tni: area::area(tni, &arch.system.buffers, arch.system.tni_mhz_at_65nm()),
            parallel_mm2: form(arch, Pipeline::Parallel),
            single_mm2: form(arch, Pipeline::Single),
            energy_nj: OperationEnergy {
                box_test: area::operations_energy(BOX_TEST),
                triangle_test: area::triangle_energy(tni),
                trv_l1: area::cache_energy(tni.trv_l1.bytes),
                trv_l2: area::cache_energy(tni.trv_l2.bytes),
                ist_l1: area::cache_energy(tni.ist_l1.bytes),
            },
        }
    }
}

/// Area in mm² with traversal units of this form.
fn form(arch: &Arch, pipeline: Pipeline) -> f64 {
    let tni = TniSpec {
        pipeline,
        ..arch.system.tni
    };
    area::area(&tni, &arch.system.buffers, arch.system.tni_mhz_at_65nm()).total
}

fn write_area(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let tni = &arch.system.tni;
    let costs = area::area(tni, &arch.system.buffers, arch.system.tni_mhz_at_65nm());
    writeln!(out, "T&I unit of `{}`, 65 nm", arch.name)?;
    complexity(out, tni, &costs)?;
    items(out, &costs)?;
    forms(out, arch)?;
    deviations(out, tni, &costs)?;
    tests(out, arch)?;
    energy(out, tni)?;
    write_chip(out, arch)
}

/// Table 1.
fn complexity(out: &mut String, tni: &TniSpec, costs: &Area) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:10} {:>5} {:>5} {:>5} {:>5} {:>9} {:>9} {:>9}",
        "unit", "ADD", "MUL", "RCP", "CMP", "RF KiB", "L1 KiB", "L2 KiB"
    )?;
    let mut row = |name: &str, c: &Complexity| {
        let kib = |bytes: u32| f64::from(bytes) / 1024.0;
        let o = c.operations;
        writeln!(
            out,
            "{name:10} {:>5} {:>5} {:>5} {:>5} {:>9.1} {:>9.0} {:>9.0}",
            o.add,
            o.mul,
            o.rcp,
            o.cmp,
            kib(c.registers),
            kib(c.level1),
            kib(c.level2)
        )
    };
    let (trv, ist) = (&costs.trv, &costs.ist);
    row(&format!("TRV × {}", tni.trvs), trv)?;
    row(&format!("IST × {}", tni.ists), ist)?;
    row(
        "total",
        &Complexity {
            operations: trv.operations.plus(ist.operations),
            registers: trv.registers + ist.registers,
            level1: trv.level1 + ist.level1,
            level2: trv.level2,
        },
    )
}

/// Table 2.
fn items(out: &mut String, costs: &Area) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:20} {:>9} {:>6} {:>9}",
        "part", "mm² each", "count", "mm²"
    )?;
    for item in &costs.items {
        match item.unit {
            Some(unit) => writeln!(
                out,
                "{:20} {unit:>9.5} {:>6} {:>9.3}",
                item.name,
                (10.0 * item.count).round() / 10.0,
                item.total
            )?,
            None => writeln!(
                out,
                "{:20} {:>9} {:>6} {:>9.3}",
                item.name, "", "", item.total
            )?,
        }
    }
    writeln!(
        out,
        "{:20} {:>9} {:>6} {:>9.3}",
        "total", "", "", costs.total
    )
}

/// Both forms of the traversal unit.
fn forms(out: &mut String, arch: &Arch) -> std::fmt::Result {
    let (single, parallel) = (form(arch, Pipeline::Single), form(arch, Pipeline::Parallel));
    writeln!(
        out,
        "\nparallel pipelines {parallel:.2} mm² (the paper {PAPER_PARALLEL}), single pipeline \
         {single:.2} mm² (the paper {PAPER_SINGLE}): {:+.1} % for two FIFOs a TRV (the paper {:+.1} % \
         by these figures, 3.6 % in its text)",
        100.0 * (parallel / single - 1.0),
        100.0 * (PAPER_PARALLEL / PAPER_SINGLE - 1.0)
    )
}

/// Why it is not what the paper has.
fn deviations(out: &mut String, tni: &TniSpec, costs: &Area) -> std::fmt::Result {
    let kib = |bytes: u32| f64::from(bytes) / 1024.0;
    writeln!(out, "\nAgainst the paper's unit:")?;
    let wired = |mm2: f64| mm2 * (1.0 + area::WIRING);
    let wald = Intersection::Wald.operations(srp_archdesc::arch::Approx::Exact);
    let test = tni.intersection.operations(tni.rcp);
    let rcp = area::rcp_area(tni);
    let price = |o: srp_archdesc::datapath::Operations| {
        (f64::from(o.add) * area::FP_ADD
            + f64::from(o.mul) * area::FP_MUL
            + f64::from(o.rcp) * rcp
            + f64::from(o.cmp) * area::FP_CMP)
            * (1.0 + area::CONTROL)
    };
    writeln!(
        out,
        "  the test `{}` takes {:+} ADD, {:+} MUL, {:+} CMP against Wald's: {:+.3} mm² an IST",
        tni.intersection.name(),
        i64::from(test.add) - i64::from(wald.add),
        i64::from(test.mul) - i64::from(wald.mul),
        i64::from(test.cmp) - i64::from(wald.cmp),
        wired(price(test) - price(wald))
    )?;
    writeln!(
        out,
        "  registers: {:.1} KiB in TRVs (the paper {}), {:.1} in ISTs (the paper {}): {:+.3} mm². \
         Counted are rays, hits, stacks of {} entries, FIFOs, pipelines and accumulation units; the paper \
         does not say what its are",
        kib(costs.trv.registers),
        PAPER_REGISTERS.0,
        kib(costs.ist.registers),
        PAPER_REGISTERS.1,
        wired(
            area::RF_4K
                * (kib(costs.trv.registers + costs.ist.registers)
                    - PAPER_REGISTERS.0
                    - PAPER_REGISTERS.1)
                / 4.0
        ),
        tni.stack_depth
    )?;
    writeln!(
        out,
        "  the paper's text gives a TRV 4 adders and 4 multipliers, its Table 1 six of each; one \
         box test a cycle takes {} and {}",
        BOX_TEST.add, BOX_TEST.mul
    )
}

/// Writes the cost of each ray-triangle test.
fn tests(out: &mut String, arch: &Arch) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:20} {:>5} {:>5} {:>5} {:>5} {:>9} {:>9}",
        "triangle test", "ADD", "MUL", "RCP", "CMP", "mm² T&I", "nJ each"
    )?;
    for test in Intersection::ALL {
        let tni = TniSpec {
            intersection: test,
            ..arch.system.tni
        };
        let o = test.operations(tni.rcp);
        writeln!(
            out,
            "{:20} {:>5} {:>5} {:>5} {:>5} {:>9.3} {:>9.3}",
            test.name(),
            o.add,
            o.mul,
            o.rcp,
            o.cmp,
            area::area(&tni, &arch.system.buffers, arch.system.tni_mhz_at_65nm()).total,
            area::triangle_energy(&tni)
        )?;
    }
    writeln!(
        out,
        "(operators of binary32; what has 53 digits counts as so many of these as are as large)"
    )
}

fn energy(out: &mut String, tni: &TniSpec) -> std::fmt::Result {
    writeln!(
        out,
        "\nenergy, nJ: box test {:.3}, triangle test {:.3}, access to TRV L1 {:.3}, TRV L2 {:.3}, \
         IST L1 {:.3}\n(`srp tni` multiplies them by what it counts)",
        area::operations_energy(BOX_TEST),
        area::triangle_energy(tni),
        area::cache_energy(tni.trv_l1.bytes),
        area::cache_energy(tni.trv_l2.bytes),
        area::cache_energy(tni.ist_l1.bytes)
    )
}
