//! What the SRP itself costs, at the prices of the T&I unit's operators.
//!
//! A unit of the array has the operators of the widest of its classes, once. An approximate function
//! of b bits is priced as one by a table of polynomials, whose multipliers grow with b²; Newton steps
//! in the unit take a multiplier and an adder each on top. Register files, configuration memory and
//! wires are not counted: what is compared are machines that differ in precision.

use super::{
    CONTROL, FP_ADD, FP_CMP, FP_MUL, FP_RCP, INT_ADD, WIRING, cache_area, operations_energy,
};
use crate::arch::Arch;
use crate::datapath::Operations;
use crate::isa::{Class, Opcode};
use crate::ops::{self, Extra};
use crate::precision::{Approx, Precision, Refine};

/// Bits of a first approximation that is priced as an exact unit.
const EXACT_BITS: f64 = 24.0;

/// The part of an exact unit's operators that an approximate one has.
fn share(approx: Approx) -> f64 {
    match approx {
        Approx::Exact => 1.0,
        Approx::Table { bits, .. } => {
            let part = f64::from(bits) / EXACT_BITS;
            part * part
        }
    }
}

/// Multiplications and additions of Newton steps: two of one and one of the other, each.
fn steps(approx: Approx) -> Operations {
    let count = match approx {
        Approx::Table {
            steps,
            refine: Refine::Unit,
            ..
        } => steps,
        // Those in code are operations of the array, like all others.
        _ => 0,
    };
    Operations {
        add: count,
        mul: 2 * count,
        ..Operations::default()
    }
}

/// Area in mm² of a unit for one special function.
pub fn function_area(approx: Approx) -> f64 {
    let stepped = f64::from(steps(approx).add.min(1));
    FP_RCP * share(approx) + stepped * (FP_ADD + FP_MUL)
}

/// Energy in nJ of one evaluation of a special function.
pub fn function_energy(approx: Approx) -> f64 {
    let whole = Operations {
        rcp: 1,
        ..Operations::default()
    };
    operations_energy(whole) * share(approx) + operations_energy(steps(approx))
}

/// Floating-point operators that one operation of a class keeps busy.
fn operators(class: Class) -> Operations {
    let (add, mul, rcp, cmp) = match class {
        Class::Fadd => (1, 0, 0, 1),
        Class::Fmul | Class::Imul => (0, 1, 0, 0),
        Class::Fma => (1, 1, 0, 0),
        Class::Fdiv => (0, 1, 1, 0),
        Class::Vfadd => (4, 0, 0, 4),
        Class::Vfmul | Class::Vmul => (0, 4, 0, 0),
        Class::Vfma => (4, 4, 0, 0),
        Class::Vdot => (3, 4, 0, 0),
        // Three weighted sums in each of four channels.
        Class::Tex => (12, 12, 0, 0),
        _ => (0, 0, 0, 0),
    };
    Operations { add, mul, rcp, cmp }
}

/// Energy in nJ of an operation; none of what is moved, compared or loaded.
pub fn operation_energy(op: Opcode, precision: &Precision) -> f64 {
    match ops::call(op).map(|call| call.extra) {
        Some(Extra::Steps(of)) if op == Opcode::Fdiv => {
            let product = operations_energy(operators(Class::Fmul));
            function_energy(of(precision)) + product
        }
        Some(Extra::Steps(of) | Extra::Bits(of)) => function_energy(of(precision)),
        _ => operations_energy(operators(op.class())),
    }
}

/// Area in mm² of one SRP: the operators of its units, its special functions, caches and SRAM.
pub fn srp_area(arch: &Arch) -> f64 {
    let p = &arch.precision;
    let functions = [p.rcp, p.rsqrt, p.sqrt, p.exp2, p.log2, p.sincos];
    let functions: f64 = functions.into_iter().map(function_area).sum();
    let mut operators_area = 0.0;
    for fu in arch.srp.fus.values() {
        let mut widest = Operations::default();
        for op in &fu.ops {
            let needed = operators(op.class);
            widest.add = widest.add.max(needed.add);
            widest.mul = widest.mul.max(needed.mul);
            widest.rcp = widest.rcp.max(needed.rcp);
            widest.cmp = widest.cmp.max(needed.cmp);
        }
        let lanes = f64::from(fu.width / 32).max(1.0);
        operators_area += f64::from(widest.add) * FP_ADD
            + f64::from(widest.mul) * FP_MUL
            + f64::from(widest.rcp) * function_area(p.div)
            + f64::from(widest.cmp) * FP_CMP
            + lanes * INT_ADD;
        if fu.op(Class::Sfu).is_some() {
            operators_area += functions;
        }
    }
    let system = &arch.system;
    let memories = [
        system.sram_bytes,
        system.data_cache.bytes,
        system.texture_cache.bytes,
    ];
    let memories: f64 = memories.into_iter().map(cache_area).sum();
    let logic = operators_area * (1.0 + CONTROL);
    (logic + memories) * (1.0 + WIRING)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_bits_cost_less_and_steps_cost_more() {
        let table = Approx::table;
        let area = [
            function_area(table(8, 0)),
            function_area(table(12, 0)),
            function_area(table(12, 1)),
            function_area(Approx::Exact),
        ];
        assert!(area.is_sorted_by(|a, b| a < b), "{area:?}");
        assert_eq!(function_area(Approx::Exact), FP_RCP);
        let file = crate::machines::SGRT;
        let mut arch = crate::parse(file.name, file.xml).expect("the shipped machine is valid");
        let exact = srp_area(&arch);
        arch.precision.rcp = table(12, 0);
        assert!(srp_area(&arch) < exact);
        let exact = operation_energy(Opcode::Rsqrt, &arch.precision);
        assert!(operation_energy(Opcode::Rcp, &arch.precision) < exact);
    }
}
