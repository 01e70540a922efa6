//! Energy of what the SRP does: operations, registers, wires, contexts and its memory.

use super::operators::{depth, operators};
use super::{BANKS, choice};
use crate::arch::{Arch, FileSpec, Fu, FuSpec, Input, LinkSpec, Srp, Wire};
use crate::cost::memory::{REGISTER_PJ, file_energy, read_energy};
use crate::cost::operator::{
    compare, convert, float_add, float_fma, float_mul, integer_add, integer_mul, product_energy,
};
use crate::cost::pipeline::stage_bits;
use crate::format::Format;
use crate::isa::{Class, Opcode};
use crate::structure::Special;
use crate::system::BankSpec;

/// Energy of a bit through a level of a multiplexer, pJ.
const MULTIPLEXER_PJ: f64 = 0.001;

/// Energy of a bit along a millimetre of wire, pJ.
pub const WIRE_PJ: f64 = 0.12;

/// Energy of a bit of context that is read, pJ: 1.5 pJ for 64 of them.
const CONTEXT_PJ: f64 = 0.0234;

/// Energy of an operation itself, pJ: its operators, or its special function. None of registers,
/// wires and memories.
pub fn operation_energy(op: Opcode, arch: &Arch) -> f64 {
    if let Some(special) = Special::of(op) {
        return arch.special_unit(special).energy_pj;
    }
    let o = operators(op.class());
    let times = |n: u32, each: f64| f64::from(n) * each;
    let digits = arch.precision.formats.of(op).significand;
    let (haste, pipeline) = pipeline_energy(op, digits, arch);
    let (add, mul) = (
        float_add(digits).energy_pj * haste[0],
        float_mul(digits).energy_pj * haste[1],
    );
    let fused = o.add.min(o.mul);
    let floats = match op.class() {
        Class::Fma | Class::Vfma => times(fused, add + mul),
        // What compares does not add.
        Class::Fadd | Class::Vfadd if !adds(op) => times(o.cmp, compare(32).energy_pj),
        _ => times(o.add, add) + times(o.mul, mul),
    };
    floats
        + pipeline
        + times(o.int, integer_add(32).energy_pj * haste[0])
        + times(o.imul, integer_mul(32).energy_pj * haste[1])
        + match op.class() {
            Class::Cvt => convert().energy_pj,
            Class::Pair => pair_energy(op),
            Class::Vpair => 4.0 * pair_energy(op),
            Class::Idiv => 0.223 * 34.0 * 35.0,
            Class::Tex => {
                let weight = f64::from(2 * arch.precision.texture_weight_bits).max(1.0);
                16.0 * product_energy(24.0, weight) + 12.0 * read_energy(256.0 * 24.0, 24.0)
            }
            _ => 0.0,
        }
}

/// The factors of the energy of adders and of multipliers for haste, and the energy of registers beyond those of the priced
/// pipeline, pJ: the mean of the units that run an operation.
fn pipeline_energy(op: Opcode, digits: u32, arch: &Arch) -> ([f64; 2], f64) {
    let bits = stage_bits(op.class(), digits);
    let units = arch.srp.fus.values().filter_map(|fu| fu.op(op.class()));
    let each: Vec<_> = units.map(|how| depth(op, how, arch)).collect();
    let number = each.len().max(1) as f64;
    let (mut haste, mut registers) = ([0.0; 2], 0.0);
    for depth in &each {
        let [add, mul] = depth.energy();
        haste[0] += add / number;
        haste[1] += mul / number;
        registers += depth.registers_pj(bits) / number;
    }
    if each.is_empty() {
        haste = [1.0; 2];
    }
    (haste, registers)
}

fn adds(op: Opcode) -> bool {
    matches!(
        op,
        Opcode::Fadd | Opcode::Fsub | Opcode::Vfadd | Opcode::Vfsub
    )
}

/// Energy of a read or a write of a file, pJ.
pub fn register_energy(file: &FileSpec) -> f64 {
    file_energy(file.size, file.width, file.read_ports + file.write_ports)
}

/// Energy of so many bits through the operand multiplexer of a unit that reads so many places, pJ.
pub fn multiplexer_energy(bits: u32, places: usize) -> f64 {
    MULTIPLEXER_PJ * f64::from(bits * choice(places).max(1))
}

/// Energy of so many bits along a link, pJ: past as many units as it spans, each 0.3 mm wide, and its
/// registers.
pub fn link_energy(srp: &Srp, link: &LinkSpec, bits: u32) -> f64 {
    let (from, to) = (&srp.fus[link.from], &srp.fus[link.to]);
    let cells = from.row.abs_diff(to.row) + from.col.abs_diff(to.col);
    carrier_energy(cells, link.delay, bits)
}

/// Width of a unit, mm.
const UNIT_MM: f64 = 0.3;

/// Energy of so many bits past so many units and through so many registers, pJ.
fn carrier_energy(cells: u32, delay: u32, bits: u32) -> f64 {
    let wire = WIRE_PJ * UNIT_MM * f64::from(cells.max(1));
    f64::from(bits) * (wire + REGISTER_PJ * f64::from(delay))
}

/// Energy of so many bits along a wire with so many inputs, pJ: through its multiplexer, and past as many units
/// as the rectangle of those at its ends is wide and high, for all of the wire swings.
pub fn wire_energy(srp: &Srp, wire: Wire, inputs: u32, bits: u32) -> f64 {
    let spec = &srp.wires[wire];
    let units = |input: &Input| match *input {
        Input::Unit(fu) => vec![fu],
        Input::Wire(before) => srp.wires[before].to.clone(),
    };
    let ends = spec
        .from
        .iter()
        .filter(|input| matches!(input, Input::Unit(_)));
    let mut ends: Vec<Fu> = ends.flat_map(units).collect();
    if ends.is_empty() {
        ends = spec.from.iter().flat_map(units).collect();
    }
    ends.extend(&spec.to);
    let across = |at: fn(&FuSpec) -> u32| {
        let all = ends.iter().map(|&fu| at(&srp.fus[fu]));
        all.clone().max().unwrap_or(0) - all.min().unwrap_or(0)
    };
    let cells = across(|fu| fu.row) + across(|fu| fu.col);
    multiplexer_energy(bits, inputs as usize) + carrier_energy(cells, spec.delay, bits)
}

/// Energy of an access of so many bytes to the SRAM, pJ: of each bank that it takes.
pub fn sram_energy(arch: &Arch, bytes: u32) -> f64 {
    let BankSpec { count, width, .. } = arch.system.sram_banks.unwrap_or(BANKS);
    let bank = f64::from(arch.system.sram_bytes) * 8.0 / f64::from(count);
    let words = bytes.div_ceil(width);
    f64::from(words) * read_energy(bank, f64::from(bytes.min(width) * 8))
}

/// Energy of an operation on two halves, pJ.
fn pair_energy(op: Opcode) -> f64 {
    use Opcode::{Hadd, Hfma, Hmul, Hsub, Vhadd, Vhfma, Vhmul, Vhsub};
    let half = Format::HALF.significand;
    let each = match op {
        Hadd | Hsub | Vhadd | Vhsub => float_add(half),
        Hmul | Vhmul => float_mul(half),
        Hfma | Vhfma => float_fma(half),
        _ => compare(16),
    };
    2.0 * each.energy_pj
}

/// Energy of reading contexts of so many bits, pJ.
pub fn context_energy(bits: u32) -> f64 {
    CONTEXT_PJ * f64::from(bits)
}
