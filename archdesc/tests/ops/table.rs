//! The table of operations beside their text: signatures, values of the right type, loads.

use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::ops::{Extra, SOURCE, V4, call, eval, loaded};
use srp_archdesc::precision::Precision;
use std::collections::BTreeSet;

#[test]
fn every_pure_opcode_computes_a_value_of_its_type() {
    let mut names = BTreeSet::new();
    for &op in Opcode::ALL {
        let args = vec![V4::word(1); op.info().operands.len()];
        let value = eval(op, &args, 0, &Precision::EXACT).expect("no operand is zero");
        let Some(call) = call(op) else {
            assert!(!op.is_pure(), "{op} is not covered");
            assert_eq!(value, None, "{op}");
            continue;
        };
        assert!(op.is_pure() && value.is_some(), "{op}");
        assert_eq!(call.function, op.name());
        assert!(names.insert(call.function), "{op} is another's");
        assert_eq!(matches!(call.extra, Extra::Immediate), op.info().immediate);
    }
}

/// The signature in the text must be the one that the table's operands call for.
#[test]
fn text_and_table_agree_on_signatures() {
    let rust = |ty| match ty {
        Ty::Pred => "bool",
        Ty::Word => "u32",
        Ty::Vec => "V4",
    };
    for &op in Opcode::ALL {
        let Some(call) = call(op) else { continue };
        let head = format!("pub fn {}(", call.function);
        let at = SOURCE.find(&head).expect("a function of the opcode's name");
        let signature = SOURCE[at + head.len()..].split('{').next().unwrap_or("");
        let types: Vec<&str> = signature
            .split([',', ')', '>'])
            .filter_map(|part| part.split(": ").nth(1))
            .collect();
        let operands = op.info().operands.iter().map(|k| rust(k.ty()));
        let extra = call.extra_arguments(0, &Precision::EXACT).len();
        let expected: Vec<&str> = operands.chain(std::iter::repeat_n("u32", extra)).collect();
        assert_eq!(types, expected, "{op}");
        let result = op.result().map_or("", rust);
        let result = if call.fallible {
            format!("-> Option<{result}>")
        } else {
            format!("-> {result}")
        };
        assert!(signature.contains(&result), "{op}: {signature}");
    }
}

#[test]
fn signed_loads_extend_the_sign() {
    for (op, byte, half) in [(Opcode::Lb, 0xffff_ff80, 0x80), (Opcode::Glbu, 0x80, 0x80)] {
        assert_eq!(loaded(op, V4::word(half)).as_word(), byte);
    }
    assert_eq!(loaded(Opcode::Glh, V4::word(0x8001)).as_word(), 0xffff_8001);
    let lanes = V4([1, 2, 3, 0x80]);
    assert_eq!(loaded(Opcode::Lv, lanes), lanes);
}
