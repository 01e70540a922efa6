//! The history of a pixel as JSON.

use super::History;
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::isa::{Kind, Ty};
use srp_csimgen::preamble::ops::V4;
use srp_toolchain::envelope::Contents;
use srp_traces::history::{Made, MadeWhat, Operation, Place, TracedRay, Want};

/// All that a pixel was made of, in the order of time. Cycles are those of the SRP.
#[derive(Serialize, JsonSchema)]
pub(crate) struct HistoryDocument {
    /// The pixel's column.
    x: u32,
    /// The pixel's row.
    y: u32,
    /// Red, green and blue.
    colour: [u8; 3],
    /// Its tile.
    tile: u32,
    /// The core that took it.
    core: u32,
    /// The cycle in which the core took the tile, and the one by which the pixel was stored.
    cycles: [u64; 2],
    /// Operations and rays.
    made: Vec<MadeDocument>,
}

impl Contents for HistoryDocument {
    const FORMAT: &'static str = "srp-pixel-history";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp render --pixel X,Y --json`";
}

/// An operation or a ray.
#[derive(Serialize, JsonSchema)]
struct MadeDocument {
    id: u32,
    /// The cycle in which an operation is issued, or a ray is sent.
    cycle: u64,
    /// What it was made of, by `id`.
    from: Vec<u32>,
    /// True if it only says where, or whether, something is done.
    addresses: bool,
    #[serde(flatten)]
    what: WhatDocument,
}

/// What a pixel was made of.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum WhatDocument {
    Operation(OperationDocument),
    Ray(RayDocument),
}

/// An operation.
#[derive(Serialize, JsonSchema)]
struct OperationDocument {
    /// The loop on the array, if it is there.
    kernel: Option<String>,
    /// The core's launch of that loop, from 1.
    launch: Option<u64>,
    /// The iteration, from 0.
    iteration: Option<u64>,
    /// The function, in VLIW code.
    function: Option<String>,
    /// Its name in the table of operations.
    operation: &'static str,
    /// `file:line:column`.
    at: String,
    /// The variable that gets its result.
    variable: Option<String>,
    /// Its operands, each by lanes; constants among them.
    operands: Vec<ValueDocument>,
    result: Option<ValueDocument>,
    /// The address that it reads or writes; of a texture sample that of its descriptor.
    address: Option<u32>,
    /// What lies there.
    place: Option<String>,
}

/// A value: the bits of each lane, and what they are as numbers, where they are such.
#[derive(Serialize, JsonSchema)]
struct ValueDocument {
    bits: Vec<u32>,
    /// `null` for an infinity or a NaN.
    numbers: Option<Vec<Option<f32>>>,
}

/// A ray.
#[derive(Serialize, JsonSchema)]
struct RayDocument {
    /// Its packet, the core's first being 0.
    packet: u64,
    /// Its place in the ray buffer.
    index: u32,
    /// True for a shadow ray.
    shadow: bool,
    origin: [Option<f32>; 3],
    direction: [Option<f32>; 3],
    tmin: Option<f32>,
    tmax: Option<f32>,
    /// The triangle that it has hit, if it has.
    triangle: Option<u32>,
    t: Option<f32>,
    u: Option<f32>,
    v: Option<f32>,
    /// The cycle in which the T&I unit was done with it.
    done: Option<u64>,
    /// Nodes that it has visited, and triangles that were tested.
    visits: Option<u32>,
    tests: Option<u32>,
    /// The cycle in which the core took its packet back.
    returned: u64,
}

fn number(value: f32) -> Option<f32> {
    value.is_finite().then_some(value)
}

fn value((value, ty): (V4, Ty), kind: Option<Kind>) -> ValueDocument {
    let lanes = match ty {
        Ty::Vec => 4,
        Ty::Word | Ty::Pred => 1,
    };
    let bits = value.0[..lanes].to_vec();
    let is_number = matches!(kind, Some(Kind::F | Kind::F4));
    ValueDocument {
        numbers: is_number.then(|| bits.iter().map(|&b| number(f32::from_bits(b))).collect()),
        bits,
    }
}

impl History {
    pub(super) fn document(&self) -> HistoryDocument {
        let [red, green, blue, _] = self.bytes;
        let (cycles, core) = (&self.stored.cycles, self.stored.core);
        HistoryDocument {
            x: self.wanted.x,
            y: self.wanted.y,
            colour: [red, green, blue],
            tile: self.wanted.tile,
            core,
            cycles: [cycles.start, cycles.end],
            made: self.made.iter().map(|made| self.of_made(made)).collect(),
        }
    }

    fn of_made(&self, made: &Made) -> MadeDocument {
        MadeDocument {
            id: made.id,
            cycle: made.cycle,
            from: made.from.clone(),
            addresses: made.want == Want::Address,
            what: match &made.what {
                MadeWhat::Operation(operation) => {
                    WhatDocument::Operation(self.of_operation(operation))
                }
                MadeWhat::Ray(ray) => WhatDocument::Ray(of_ray(ray)),
            },
        }
    }

    fn of_operation(&self, operation: &Operation) -> OperationDocument {
        let info = operation.opcode.info();
        let spec = &self.trace.spec;
        let (kernel, function) = match operation.place {
            Place::Array {
                kernel,
                launch,
                iteration,
            } => (Some((kernel, launch, iteration)), None),
            Place::Bundle(bundle) => (None, spec.function_of(bundle).map(str::to_owned)),
        };
        let operands = operation.operands.iter().zip(info.operands);
        OperationDocument {
            kernel: kernel.map(|(kernel, ..)| spec.kernels[kernel as usize].name.clone()),
            launch: kernel.map(|(_, launch, _)| launch),
            iteration: kernel.map(|(.., iteration)| iteration),
            function,
            operation: operation.opcode.name(),
            at: spec.position(operation.at).unwrap_or_default().to_owned(),
            variable: self.variable(operation).map(str::to_owned),
            operands: operands.map(|(&of, &kind)| value(of, Some(kind))).collect(),
            result: operation.result.map(|of| value(of, info.result)),
            address: operation.address,
            place: self.place(operation),
        }
    }
}

fn of_ray(ray: &TracedRay) -> RayDocument {
    let hit = ray.hit.hit;
    let of_hit = |value: f32| number(value).filter(|_| hit.is_hit());
    RayDocument {
        packet: ray.packet,
        index: ray.index,
        shadow: ray.ray.flags & srp_runtime::tni::arithmetic::ANY_HIT != 0,
        origin: ray.ray.origin.map(number),
        direction: ray.ray.direction.map(number),
        tmin: number(ray.ray.tmin),
        tmax: number(ray.ray.tmax),
        triangle: hit.is_hit().then_some(hit.primitive),
        t: of_hit(hit.t),
        u: of_hit(hit.u),
        v: of_hit(hit.v),
        done: ray.cost.map(|(cycle, _)| cycle),
        visits: ray.cost.map(|(_, cost)| cost.visits),
        tests: ray.cost.map(|(_, cost)| cost.tests),
        returned: ray.returned,
    }
}
