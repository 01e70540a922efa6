//! The names of operations: our own opcodes, and those of other mappers and of LLVM.
//!
//! In a bare graph, only an operation's class matters, and that it has a result. So every name
//! stands for the opcode of its class, with a word as its result, that is nearest in meaning: a
//! comparison is a subtraction, a predicate a word.

use srp_archdesc::isa::{Class, Effect, Opcode, Ty};

/// Names that stand for one opcode.
pub struct Aliases {
    /// The opcode.
    pub op: Opcode,
    /// The names, in lower case; capitals do not matter.
    pub names: &'static [&'static str],
}

/// All names that are not opcodes, or stand for another one than they name. `docs/graphs.md` has
/// the same table.
pub fn aliases() -> &'static [Aliases] {
    TABLE
}

const fn names(op: Opcode, names: &'static [&'static str]) -> Aliases {
    Aliases { op, names }
}

static TABLE: &[Aliases] = &[
    names(
        Opcode::Add,
        &["addi", "addu", "iadd", "getelementptr", "gep", "inc", "rec"],
    ),
    names(
        Opcode::Sub,
        &[
            "subi", "subu", "isub", "neg", "dec", "abs", "cmp", "icmp", "cgt", "cge", "clt", "cle",
            "ceq", "cne", "eq", "ne", "lt", "le", "gt", "ge", "ltu", "leu", "gtu", "geu", "slt",
            "sle", "sgt", "sge", "ult", "ule", "ugt", "uge", "seteq", "setne", "setlt", "setle",
            "setgt", "setge", "sltu", "slti",
        ],
    ),
    names(Opcode::And, &["andi", "pand", "band"]),
    names(Opcode::Or, &["ori", "por", "bor"]),
    names(Opcode::Xor, &["xori", "pxor", "bxor", "not", "pnot", "inv"]),
    names(
        Opcode::Shl,
        &["sll", "slli", "lsl", "ls", "lshift", "lshl", "rol", "rotl"],
    ),
    names(
        Opcode::Shr,
        &[
            "srl", "srli", "lsr", "rs", "rshift", "lshr", "shru", "ror", "rotr",
        ],
    ),
    names(
        Opcode::Sar,
        &["sra", "srai", "asr", "ars", "arshift", "ashr"],
    ),
    names(Opcode::Min, &["smin", "imin"]),
    names(Opcode::Max, &["smax", "imax"]),
    names(Opcode::Minu, &["umin"]),
    names(Opcode::Maxu, &["umax"]),
    names(
        Opcode::Sel,
        &["select", "psel", "mux", "cmux", "phi", "merge", "cmerge"],
    ),
    names(
        Opcode::Mov,
        &[
            "movc",
            "move",
            "pmov",
            "copy",
            "route",
            "pass",
            "nop",
            "noop",
            "const",
            "constant",
            "input",
            "output",
            "in",
            "out",
            "arg",
            "ret",
            "return",
            "br",
            "branch",
            "jump",
            "jmp",
            "brt",
            "brf",
            "cbr",
            "switch",
            "sext",
            "zext",
            "trunc",
            "ext",
            "bitcast",
            "cast",
            "inttoptr",
            "ptrtoint",
            "freeze",
            "loopstart",
            "loopend",
            "exit",
        ],
    ),
    names(
        Opcode::Mul,
        &[
            "muli", "mulu", "imul", "mult", "multiply", "mac", "mad", "muladd", "madd",
        ],
    ),
    names(
        Opcode::Div,
        &[
            "divi", "idiv", "sdiv", "udiv", "srem", "urem", "mod", "divide",
        ],
    ),
    names(Opcode::Fadd, &["addf"]),
    names(
        Opcode::Fsub,
        &["subf", "fcmp", "feq", "fne", "flt", "fle", "fgt", "fge"],
    ),
    names(Opcode::Fmin, &["fminimum", "minnum"]),
    names(Opcode::Fmax, &["fmaximum", "maxnum"]),
    names(
        Opcode::Ffloor,
        &["floor", "ceil", "fceil", "fround", "ftrunc"],
    ),
    names(Opcode::Fmul, &["mulf", "fmult"]),
    names(Opcode::Fma, &["fmac", "fmad", "fmuladd", "ffma"]),
    names(Opcode::Fdiv, &["divf", "frem"]),
    names(Opcode::Sqrt, &["fsqrt"]),
    names(Opcode::Exp2, &["exp", "fexp", "pow", "fpow"]),
    names(Opcode::Log2, &["log", "flog"]),
    names(Opcode::Sin, &["fsin", "tan"]),
    names(Opcode::Cos, &["fcos"]),
    names(Opcode::Itof, &["sitofp", "i2f"]),
    names(Opcode::Utof, &["uitofp", "u2f"]),
    names(Opcode::Ftoi, &["fptosi", "f2i", "fpext", "fptrunc"]),
    names(Opcode::Ftou, &["fptoui", "f2u"]),
    names(
        Opcode::Lw,
        &[
            "load", "ld", "ldw", "ldr", "loadw", "loadb", "loadh", "oload", "oloadb", "oloadh",
            "oloadw", "memread", "read", "lwi",
        ],
    ),
    names(
        Opcode::Sw,
        &[
            "store", "st", "stw", "str", "storew", "storeb", "storeh", "ostore", "ostoreb",
            "ostoreh", "ostorew", "memwrite", "write", "swi",
        ],
    ),
];

/// The opcode that an operation of this name is in a bare graph: capitals do not matter, nor does a
/// type behind a point (`add.i32`).
pub(super) fn opcode(name: &str) -> Option<Opcode> {
    let lower = name.to_ascii_lowercase();
    let plain = lower.split('.').next().unwrap_or_default();
    let exact = |name: &str| {
        let alias = TABLE.iter().find(|a| a.names.contains(&name));
        let own = || Opcode::parse(name).filter(|op| fits(*op));
        alias.map(|a| a.op).or_else(own)
    };
    exact(&lower).or_else(|| exact(plain))
}

/// True if an opcode can occur in a bare graph: no ports, and predicates are words.
fn fits(op: Opcode) -> bool {
    op.info().effect != Effect::Io && op.result() != Some(Ty::Pred)
}

/// The opcode that stands for operations of a class in a bare graph; `None` for those that units of
/// the array do not run.
pub fn stands_for(class: Class) -> Option<Opcode> {
    match class {
        Class::Pred => Some(Opcode::And),
        _ => Opcode::ALL
            .iter()
            .copied()
            .find(|op| op.class() == class && fits(*op)),
    }
}

/// All names that are understood.
pub(super) fn known() -> impl Iterator<Item = &'static str> {
    let own = Opcode::ALL.iter().filter(|op| fits(**op));
    let other = TABLE.iter().flat_map(|a| a.names.iter().copied());
    own.map(|op| op.name()).chain(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_name_stands_for_one_opcode_that_fits() {
        let mut seen = BTreeSet::new();
        for alias in TABLE {
            assert!(fits(alias.op), "{}", alias.op);
            for name in alias.names {
                assert!(seen.insert(name), "{name} is listed twice");
                assert_eq!(*name, name.to_ascii_lowercase());
                assert_eq!(opcode(&name.to_uppercase()), Some(alias.op));
            }
        }
        for op in Opcode::ALL.iter().copied() {
            let found = opcode(op.name()).expect("every opcode is understood");
            assert!(fits(found), "{op}");
            assert!(found == op || !fits(op), "{op} stands for {found}");
        }
    }

    #[test]
    fn classes_have_an_opcode_unless_they_are_for_control_code() {
        for &class in Class::ALL {
            let is_control = matches!(class, Class::Io | Class::Branch);
            assert_eq!(stands_for(class).is_none(), is_control, "{class}");
        }
    }

    #[test]
    fn the_reference_lists_the_same_names() {
        let text = include_str!("../../../docs/graphs.md");
        for alias in TABLE {
            for name in alias.names {
                assert!(text.contains(&format!("`{name}`")), "{name}");
            }
        }
    }
}
