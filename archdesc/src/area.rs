//! Costs of a T&I unit: operators, register files, caches, and from them area and energy, as in
//! Tables 1 and 2 of the SGRT paper.
//!
//! Areas of single parts are the paper's, which come from 65 nm synthesis and CACTI. Caches of
//! other sizes lie on the curve through the two sizes that it gives, and everything is counted from
//! the machine; nothing is taken over but prices. Energies are those of the same synthesis, which
//! SimTRaX (Spjut et al., 2009) ships: the paper prints the areas of that source.

use schemars::JsonSchema;
use serde::Serialize;

use crate::cost::cache::ways_area;
use crate::cost::memory::ports_factor;
use crate::cost::pipeline::haste_area;
use crate::cost::special::{self as cost, Build};
use crate::datapath::{BOX_TEST, Operations};
use crate::haste::{Haste, OperatorHaste};
use crate::precision::Approx;
use crate::structure::Special;
use crate::system::{BufferSpec, CacheSpec, Pipeline, TniSpec};

/// Area in mm² of an operator.
pub const FP_ADD: f64 = 0.003;
/// Of a multiplier.
pub const FP_MUL: f64 = 0.01;
/// Of a reciprocal or divider.
pub const FP_RCP: f64 = 0.11;
/// Of a comparator.
pub const FP_CMP: f64 = 0.00072;
/// Of an integer adder.
pub const INT_ADD: f64 = 0.00066;
/// Of 4 KiB of registers.
pub const RF_4K: f64 = 0.019;
/// Control logic, as a part of the operators' area.
pub const CONTROL: f64 = 0.233;
/// Wiring, as a part of everything else.
pub const WIRING: f64 = 0.30;
/// Integer adders of each traversal and each intersection unit, for addresses and counters: the
/// paper has 20 in its five units.
pub const INT_ADDERS: u32 = 4;

/// A cache of 16 KiB and one of 128 KiB: kibibytes and mm².
const CACHES: [(f64, f64); 2] = [(16.0, 0.06), (128.0, 0.64)];

/// Bytes of a stack entry: a node and where the ray enters it.
const STACK_ENTRY: u32 = 8;

/// Bytes that a ray's number takes in a row of an accumulation unit.
const RAY_NUMBER: u32 = 2;

/// One kind of unit of the T&I unit, all of the kind together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Complexity {
    /// Operators.
    pub operations: Operations,
    /// Bytes of registers.
    pub registers: u32,
    /// Bytes of level-1 caches.
    pub level1: u32,
    /// Bytes of level-2 cache.
    pub level2: u32,
}

/// A line of Table 2.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Item {
    /// Its name in listings.
    pub name: &'static str,
    /// Area of one, mm²; `None` where it is a part of others' area.
    pub unit: Option<f64>,
    /// Their number, whole but for what is measured: of registers, KiB.
    pub count: f64,
    /// Area of all, mm².
    pub total: f64,
}

/// The parts of a T&I unit, with their areas.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Area {
    /// Traversal units.
    pub trv: Complexity,
    /// Intersection units.
    pub ist: Complexity,
    /// The lines of Table 2.
    pub items: Vec<Item>,
    /// Area of the unit, mm².
    pub total: f64,
}

/// Area in mm² of a cache of so many bytes.
pub fn cache_area(bytes: u32) -> f64 {
    let [(size, area), (larger, more)] = CACHES;
    let power = (more / area).ln() / (larger / size).ln();
    area * (f64::from(bytes) / 1024.0 / size).powf(power)
}

/// Area in mm² of a cache with its ways, of which so many are usual for its kind and the curve is of these, and with ports of
/// so many bits.
pub fn cache_area_of(cache: &CacheSpec, usual: u32, read: u32, ports: u32) -> f64 {
    let ways = |ways| ways_area(cache.bytes, cache.line, ways, read);
    let more = f64::from(ports) * (ways(cache.ways) - ways(usual));
    cache_area(cache.bytes) * ports_factor(ports) + more * 1e-6
}

/// Ways of the caches of a machine that does not say: those of its traversal units at both levels, and of its intersection
/// units.
const WAYS: [u32; 3] = [2, 2, 4];

/// Bytes between two stages of TRV_PRE: the address of a node and the ray's number; of TRV_AABB: the distances of six
/// planes; of TRV_POST: two children with their distances.
const FETCH: u32 = 8;
const BOX: u32 = 24;
const CHILDREN: u32 = 16;

/// Registers of one traversal unit: each resident ray with its hit and stack, the FIFOs of rays in
/// front of its sub-pipelines, what is between the stages of these, and the rows of the accumulation unit with line, address and rays.
fn trv_registers(tni: &TniSpec, buffers: &BufferSpec) -> u32 {
    let ray = buffers.ray_bytes + buffers.hit_bytes + STACK_ENTRY * tni.stack_depth;
    let fifos = match tni.pipeline {
        Pipeline::Single => 1,
        Pipeline::Parallel => 3,
    };
    let fifo = fifos * tni.fifo * buffers.ray_bytes;
    let stages = tni.pres * tni.pre_latency * FETCH
        + tni.aabbs * tni.aabb_latency * BOX
        + tni.posts * tni.post_latency * CHILDREN;
    tni.stacks * ray + fifo + stages + rau_registers(tni, tni.trv_l1.line)
}

/// Registers of one intersection unit: the FIFO of rays with their hits in front, the rays in its
/// pipeline, and the accumulation unit.
fn ist_registers(tni: &TniSpec, buffers: &BufferSpec) -> u32 {
    let ray = buffers.ray_bytes + buffers.hit_bytes;
    (tni.fifo + tni.ist_latency) * ray + rau_registers(tni, tni.ist_l1.line)
}

fn rau_registers(tni: &TniSpec, line: u32) -> u32 {
    tni.rau_rows * (line + 4 + RAY_NUMBER * tni.rau_rays)
}

/// The reciprocal of a T&I unit: what its structure costs. An exact one of which nothing is said is the
/// paper's.
fn rcp_unit(tni: &TniSpec) -> Option<cost::Unit> {
    let said = tni.rcp != Approx::Exact || tni.rcp_build != Build::default();
    // Area and energy do not depend on the clock but for the registers of the pipeline.
    said.then(|| cost::unit(Special::Rcp, tni.rcp, &tni.rcp_build, RCP_MHZ))
}

/// The clock for which pipelines of reciprocals are priced, the paper's.
const RCP_MHZ: u32 = 500;

/// Area in mm² of the reciprocal of a T&I unit.
pub fn rcp_area(tni: &TniSpec) -> f64 {
    rcp_unit(tni).map_or(FP_RCP, |unit| unit.area_um2 * 1e-6)
}

/// Energy in nJ of a ray-triangle test.
pub fn triangle_energy(tni: &TniSpec) -> f64 {
    let operations = tni.intersection.operations(tni.rcp);
    let others = Operations {
        rcp: 0,
        ..operations
    };
    let rcp = rcp_unit(tni).map_or(ENERGY[2], |unit| unit.energy_pj * 1e-3);
    operations_energy(others) + f64::from(operations.rcp) * rcp
}

/// Returns the parts of a machine's T&I unit at a clock, in the gates of 65 nm.
pub fn area(tni: &TniSpec, buffers: &BufferSpec, mhz: u32) -> Area {
    let trv = Complexity {
        operations: BOX_TEST.times(tni.trvs * tni.aabbs),
        registers: tni.trvs * trv_registers(tni, buffers),
        level1: tni.trvs * tni.trv_l1.bytes,
        level2: tni.trv_l2.bytes,
    };
    let ist = Complexity {
        operations: tni.intersection.operations(tni.rcp).times(tni.ists),
        registers: tni.ists * ist_registers(tni, buffers),
        level1: tni.ists * tni.ist_l1.bytes,
        level2: 0,
    };
    let items = items(tni, &Haste::of(tni, mhz), trv, ist);
    let total = items.iter().map(|item| item.total).sum();
    Area {
        trv,
        ist,
        items,
        total,
    }
}

/// The factor by which operators of a kind are larger by haste, in the mean of both tests.
fn larger(haste: &Haste, of: fn(&OperatorHaste) -> f64, [boxes, triangles]: [u32; 2]) -> f64 {
    let [boxes, triangles] = [boxes, triangles].map(f64::from);
    let all = boxes * haste_area(of(&haste.aabb)) + triangles * haste_area(of(&haste.ist));
    match boxes + triangles {
        0.0 => 1.0,
        number => all / number,
    }
}

fn items(tni: &TniSpec, haste: &Haste, trv: Complexity, ist: Complexity) -> Vec<Item> {
    let item = |name, unit: f64, count: u32| Item {
        name,
        unit: Some(unit),
        count: f64::from(count),
        total: unit * f64::from(count),
    };
    let (boxes, triangles) = (trv.operations, ist.operations);
    let operator = |name, unit: f64, of: fn(&OperatorHaste) -> f64, both: [u32; 2]| {
        let count = both.iter().sum();
        item(name, unit * larger(haste, of, both), count)
    };
    // Addresses of nodes are summed in TRV_PRE.
    let addresses = [tni.trvs, tni.ists].map(|units| INT_ADDERS * units);
    let pre = Haste {
        aabb: OperatorHaste::all(haste.pre),
        ist: OperatorHaste::all(1.0),
        ..*haste
    };
    let mut items = vec![
        operator("FP adder", FP_ADD, |h| h.add, [boxes.add, triangles.add]),
        operator(
            "FP multiplier",
            FP_MUL,
            |h| h.mul,
            [boxes.mul, triangles.mul],
        ),
        operator(
            "FP reciprocal",
            rcp_area(tni),
            |h| h.rcp,
            [boxes.rcp, triangles.rcp],
        ),
        operator(
            "FP comparator",
            FP_CMP,
            |h| h.cmp,
            [boxes.cmp, triangles.cmp],
        ),
        item(
            "integer adder",
            INT_ADD * larger(&pre, |h| h.add, addresses),
            addresses.iter().sum(),
        ),
    ];
    let sum = |items: &[Item]| items.iter().map(|item| item.total).sum::<f64>();
    items.push(Item {
        name: "control",
        unit: None,
        count: 1.0,
        total: CONTROL * sum(&items),
    });
    let registers = trv.registers + ist.registers;
    for (name, spec, usual, count) in [
        ("TRV L1", &tni.trv_l1, WAYS[0], tni.trvs),
        ("TRV L2", &tni.trv_l2, WAYS[1], 1),
        ("IST L1", &tni.ist_l1, WAYS[2], tni.ists),
    ] {
        // A line is read at once.
        let each = cache_area_of(spec, usual, 8 * spec.line, 1);
        items.push(item(name, each, count));
    }
    let kib = f64::from(registers) / 1024.0;
    items.push(Item {
        name: "KiB of registers",
        unit: Some(RF_4K / 4.0),
        count: kib,
        total: RF_4K / 4.0 * kib,
    });
    items.push(Item {
        name: "wiring",
        unit: None,
        count: 1.0,
        total: WIRING * sum(&items),
    });
    items
}

/// Energy in nJ of an addition, a multiplication, a reciprocal, a comparison.
const ENERGY: [f64; 4] = [0.0074, 0.0142, 0.1563, 0.000_536];

/// Energy in nJ of an access to a cache of so many KiB, lines of 64 bytes, one bank.
const CACHE_ENERGY: [(f64, f64); 10] = [
    (1.0, 0.057_617),
    (2.0, 0.062_554),
    (4.0, 0.072_368),
    (8.0, 0.091_666),
    (16.0, 0.126_381),
    (32.0, 0.168_217),
    (64.0, 0.235_799),
    (128.0, 0.321_923),
    (256.0, 0.457_809),
    (1024.0, 0.904_345),
];

/// Energy in nJ of so many operations.
pub fn operations_energy(operations: Operations) -> f64 {
    let Operations { add, mul, rcp, cmp } = operations;
    [add, mul, rcp, cmp]
        .iter()
        .zip(ENERGY)
        .map(|(&count, each)| f64::from(count) * each)
        .sum()
}

/// Energy in nJ of one access to a cache of so many bytes, between the sizes that are known on a
/// straight line, outside them as at the nearest.
pub fn cache_energy(bytes: u32) -> f64 {
    let kib = f64::from(bytes) / 1024.0;
    let above = CACHE_ENERGY.iter().position(|(size, _)| *size >= kib);
    match above {
        Some(0) => CACHE_ENERGY[0].1,
        None => CACHE_ENERGY[CACHE_ENERGY.len() - 1].1,
        Some(i) => {
            let ((small, less), (large, more)) = (CACHE_ENERGY[i - 1], CACHE_ENERGY[i]);
            less + (more - less) * (kib - small) / (large - small)
        }
    }
}
