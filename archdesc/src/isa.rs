//! The one opcode table: the operations, their operands and results, and the class of functional unit that
//! runs each. [`ops`](crate::ops) has their functions.
//!
//! The SRP knows three kinds of storage: 32-bit words, 128-bit vectors of four words, and one-bit
//! predicates ([`Ty`]). Whether a word holds an integer or a float is the business of the
//! operation, as on every real machine; [`Kind`] says it, for listings and for constants.
//!
//! Every memory access and every integer division takes a *guard* as its first operand: where it
//! is false nothing is accessed, nothing traps, and the result is zero. If-conversion relies on
//! it; unguarded accesses pass the constant *true*.

use serde::{Deserialize, Serialize};
use std::fmt;

/// The storage a value takes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
pub enum Ty {
    /// One bit.
    Pred,
    /// 32 bits.
    Word,
    /// 128 bits: four words, lane 0 first.
    Vec,
}

impl Ty {
    /// All of them.
    pub const ALL: [Ty; 3] = [Ty::Pred, Ty::Word, Ty::Vec];

    /// Width in bits.
    pub const fn bits(self) -> u32 {
        match self {
            Ty::Pred => 1,
            Ty::Word => 32,
            Ty::Vec => 128,
        }
    }

    /// The name in listings and files: `p`, `w`, `v`.
    pub const fn name(self) -> &'static str {
        match self {
            Ty::Pred => "p",
            Ty::Word => "w",
            Ty::Vec => "v",
        }
    }

    /// The type with this [`name`](Self::name).
    pub fn parse(name: &str) -> Option<Ty> {
        Ty::ALL.into_iter().find(|t| t.name() == name)
    }
}

impl fmt::Display for Ty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How an operation reads the bits of an operand or of its result.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Kind {
    /// A predicate.
    P,
    /// A 32-bit integer.
    I,
    /// A binary32 float.
    F,
    /// A word, never looked into.
    W,
    /// Four 32-bit integers (a comparison mask is −1 or 0 in each lane).
    I4,
    /// Four binary32 floats.
    F4,
    /// A vector, never looked into.
    V,
}

impl Kind {
    /// The storage of this kind.
    pub const fn ty(self) -> Ty {
        match self {
            Kind::P => Ty::Pred,
            Kind::I | Kind::F | Kind::W => Ty::Word,
            Kind::I4 | Kind::F4 | Kind::V => Ty::Vec,
        }
    }
}

/// An effect of an operation besides computing its result from its operands.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Effect {
    /// Nothing: it may be moved, repeated and dropped.
    Pure,
    /// Reads memory.
    Load,
    /// Writes memory.
    Store,
    /// Brings memory nearer: it changes when later accesses are over, and no value. It traps nowhere and has no order
    /// among accesses.
    Prefetch,
    /// Talks to the outside through a port, possibly waiting for it; never moved against another.
    Io,
}

/// Which of the two memories an access goes to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Space {
    /// The core's own SRAM: fixed latency.
    Sram,
    /// System memory, through the data cache or the texture cache: a miss stalls the core.
    Cached,
}

macro_rules! classes {
    ($($(#[$doc:meta])* $name:ident = $text:literal;)*) => {
        /// Classes of operations: what a machine file gives latencies to and units for.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
        pub enum Class { $($(#[$doc])* $name,)* }

        impl Class {
            /// All of them, in table order.
            pub const ALL: &'static [Class] = &[$(Class::$name,)*];

            /// The name in machine files.
            pub const fn name(self) -> &'static str {
                match self { $(Class::$name => $text,)* }
            }
        }
    };
}

classes! {
    /// Word moves, selection and integer arithmetic but multiplication and division.
    Alu = "alu";
    /// Integer multiplication.
    Imul = "imul";
    /// Integer division and remainder.
    Idiv = "idiv";
    /// Predicate logic.
    Pred = "pred";
    /// Float addition, subtraction, minimum, maximum, sign, comparison, rounding.
    Fadd = "fadd";
    /// Float multiplication.
    Fmul = "fmul";
    /// Float fused multiply-add.
    Fma = "fma";
    /// Float division, correctly rounded.
    Fdiv = "fdiv";
    /// Special functions: reciprocal, roots, exponential, logarithm, sine, cosine.
    Sfu = "sfu";
    /// The same functions again, on units of another precision beside them: reciprocal, roots, quotient.
    Fast = "fast";
    /// Conversions between integer and float, scalar.
    Cvt = "cvt";
    /// Lane traffic: splat, extract, insert, swizzle, vector moves and selection.
    Lane = "lane";
    /// 4-lane integer arithmetic, logic and relations.
    Valu = "valu";
    /// 4-lane integer multiplication.
    Vmul = "vmul";
    /// 4-lane float addition, minimum, maximum, relations, conversions.
    Vfadd = "vfadd";
    /// 4-lane float multiplication.
    Vfmul = "vfmul";
    /// 4-lane float fused multiply-add.
    Vfma = "vfma";
    /// Dot products of 3 and 4 lanes.
    Vdot = "vdot";
    /// Two halves (binary16) in a word, computed with side by side.
    Pair = "pair";
    /// Eight halves in a vector.
    Vpair = "vpair";
    /// SRAM loads.
    Load = "load";
    /// SRAM stores.
    Store = "store";
    /// Loads through the data cache, and prefetches.
    Cload = "cload";
    /// Stores through the data cache.
    Cstore = "cstore";
    /// The texture unit: bilinear filtered texels through the texture cache.
    Tex = "tex";
    /// Ports to the outside.
    Io = "io";
    /// Control transfer of the VLIW engine; no opcode of the table has it.
    Branch = "branch";
}

impl Class {
    /// True for a class that a machine may lack: what needs its operations computes them in software.
    pub fn has_software(self) -> bool {
        use Class::*;
        matches!(
            self,
            Idiv | Fadd | Fmul | Fma | Fdiv | Sfu | Cvt | Valu | Vmul | Vfadd | Vfmul | Vfma | Vdot
        )
    }

    /// The class with this [`name`](Self::name).
    pub fn parse(name: &str) -> Option<Class> {
        Class::ALL.iter().copied().find(|c| c.name() == name)
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One line of the opcode table.
#[derive(Clone, Copy, Debug)]
pub struct OpInfo {
    /// The name in listings and files.
    pub name: &'static str,
    /// Operands in order.
    pub operands: &'static [Kind],
    /// The result, if any.
    pub result: Option<Kind>,
    /// Which units run it.
    pub class: Class,
    /// Its effect besides.
    pub effect: Effect,
    /// Its first two operands may change places.
    pub commutative: bool,
    /// It carries an immediate (lane number, swizzle, address offset, port).
    pub immediate: bool,
}

macro_rules! opcodes {
    ($($name:ident $text:literal ($($arg:ident)*) $(-> $res:ident)? : $class:ident $($flag:ident)*;)*) => {
        /// The operations of the SRP. See the table for operands, results and classes.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[repr(u8)]
        pub enum Opcode { $(#[doc = concat!("`", $text, "`")] $name,)* }

        impl Opcode {
            /// All opcodes, in table order.
            pub const ALL: &'static [Opcode] = &[$(Opcode::$name,)*];
        }

        const TABLE: &[OpInfo] = &[$({
            #[allow(unused_mut)]
            let mut info = OpInfo {
                name: $text,
                operands: &[$(Kind::$arg,)*],
                result: opcodes!(@result $($res)?),
                class: Class::$class,
                effect: Effect::Pure,
                commutative: false,
                immediate: false,
            };
            $(opcodes!(@flag info $flag);)*
            info
        },)*];
    };
    (@result) => { None };
    (@result $res:ident) => { Some(Kind::$res) };
    (@flag $info:ident comm) => { $info.commutative = true; };
    (@flag $info:ident imm) => { $info.immediate = true; };
    (@flag $info:ident load) => { $info.effect = Effect::Load; };
    (@flag $info:ident store) => { $info.effect = Effect::Store; };
    (@flag $info:ident prefetch) => { $info.effect = Effect::Prefetch; };
    (@flag $info:ident io) => { $info.effect = Effect::Io; };
}

opcodes! {
    // Moves and selection.
    Mov "mov" (W) -> W: Alu;
    Pmov "pmov" (P) -> P: Pred;
    Vmov "vmov" (V) -> V: Lane;
    Sel "sel" (P W W) -> W: Alu;
    Psel "psel" (P P P) -> P: Pred;
    Vsel "vsel" (P V V) -> V: Lane;

    // Integers, two's complement, wrapping. Shift counts are taken modulo 32.
    Add "add" (I I) -> I: Alu comm;
    Sub "sub" (I I) -> I: Alu;
    And "and" (I I) -> I: Alu comm;
    Or "or" (I I) -> I: Alu comm;
    Xor "xor" (I I) -> I: Alu comm;
    Shl "shl" (I I) -> I: Alu;
    Shr "shr" (I I) -> I: Alu;
    Sar "sar" (I I) -> I: Alu;
    Min "min" (I I) -> I: Alu comm;
    Max "max" (I I) -> I: Alu comm;
    Minu "minu" (I I) -> I: Alu comm;
    Maxu "maxu" (I I) -> I: Alu comm;
    Eq "eq" (I I) -> P: Alu comm;
    Ne "ne" (I I) -> P: Alu comm;
    Lt "lt" (I I) -> P: Alu;
    Le "le" (I I) -> P: Alu;
    Ltu "ltu" (I I) -> P: Alu;
    Leu "leu" (I I) -> P: Alu;
    Mul "mul" (I I) -> I: Imul comm;
    Mulhs "mulhs" (I I) -> I: Imul comm;
    Mulhu "mulhu" (I I) -> I: Imul comm;
    // Guarded: a division by zero under a true guard traps.
    Div "div" (P I I) -> I: Idiv;
    Divu "divu" (P I I) -> I: Idiv;
    Rem "rem" (P I I) -> I: Idiv;
    Remu "remu" (P I I) -> I: Idiv;

    // Predicates.
    Pand "pand" (P P) -> P: Pred comm;
    Por "por" (P P) -> P: Pred comm;
    Pxor "pxor" (P P) -> P: Pred comm;
    Pnot "pnot" (P) -> P: Pred;
    Ptoi "ptoi" (P) -> I: Alu;

    // Floats, binary32, round to nearest even, denormals kept, results that are NaN canonical.
    Fadd "fadd" (F F) -> F: Fadd comm;
    Fsub "fsub" (F F) -> F: Fadd;
    Fmin "fmin" (F F) -> F: Fadd comm;
    Fmax "fmax" (F F) -> F: Fadd comm;
    Fneg "fneg" (F) -> F: Fadd;
    Fabs "fabs" (F) -> F: Fadd;
    Ffloor "ffloor" (F) -> F: Fadd;
    Feq "feq" (F F) -> P: Fadd comm;
    Fne "fne" (F F) -> P: Fadd comm;
    Flt "flt" (F F) -> P: Fadd;
    Fle "fle" (F F) -> P: Fadd;
    Fmul "fmul" (F F) -> F: Fmul comm;
    Fma "fma" (F F F) -> F: Fma comm;
    Fdiv "fdiv" (F F) -> F: Fdiv;
    Rcp "rcp" (F) -> F: Sfu;
    Rsqrt "rsqrt" (F) -> F: Sfu;
    Sqrt "sqrt" (F) -> F: Sfu;
    Exp2 "exp2" (F) -> F: Sfu;
    Log2 "log2" (F) -> F: Sfu;
    Sin "sin" (F) -> F: Sfu;
    Cos "cos" (F) -> F: Sfu;
    // The same on the machine's fast units, whose precision is their own.
    RcpFast "rcp_fast" (F) -> F: Fast;
    RsqrtFast "rsqrt_fast" (F) -> F: Fast;
    SqrtFast "sqrt_fast" (F) -> F: Fast;
    FdivFast "fdiv_fast" (F F) -> F: Fast;
    // To integers: toward zero, saturating, NaN gives 0.
    Itof "itof" (I) -> F: Cvt;
    Utof "utof" (I) -> F: Cvt;
    Ftoi "ftoi" (F) -> I: Cvt;
    Ftou "ftou" (F) -> I: Cvt;

    // Lanes. `swz` picks lane (imm >> 2k) & 3 for lane k; `vext`, `vins` take the lane number.
    Vsplat "vsplat" (W) -> V: Lane;
    Vext "vext" (V) -> W: Lane imm;
    Vins "vins" (V W) -> V: Lane imm;
    Swz "swz" (V) -> V: Lane imm;
    // Bitwise: lane bits of the second operand where the mask is 1, of the third where it is 0.
    Vblend "vblend" (I4 V V) -> V: Lane;

    Vadd "vadd" (I4 I4) -> I4: Valu comm;
    Vsub "vsub" (I4 I4) -> I4: Valu;
    Vand "vand" (I4 I4) -> I4: Valu comm;
    Vor "vor" (I4 I4) -> I4: Valu comm;
    Vxor "vxor" (I4 I4) -> I4: Valu comm;
    Vshl "vshl" (I4 I4) -> I4: Valu;
    Vshr "vshr" (I4 I4) -> I4: Valu;
    Vsar "vsar" (I4 I4) -> I4: Valu;
    Vmin "vmin" (I4 I4) -> I4: Valu comm;
    Vmax "vmax" (I4 I4) -> I4: Valu comm;
    Veq "veq" (I4 I4) -> I4: Valu comm;
    Vlt "vlt" (I4 I4) -> I4: Valu;
    Vltu "vltu" (I4 I4) -> I4: Valu;
    Vmul "vmul" (I4 I4) -> I4: Vmul comm;

    Vfadd "vfadd" (F4 F4) -> F4: Vfadd comm;
    Vfsub "vfsub" (F4 F4) -> F4: Vfadd;
    Vfmin "vfmin" (F4 F4) -> F4: Vfadd comm;
    Vfmax "vfmax" (F4 F4) -> F4: Vfadd comm;
    Vfneg "vfneg" (F4) -> F4: Vfadd;
    Vfabs "vfabs" (F4) -> F4: Vfadd;
    Vffloor "vffloor" (F4) -> F4: Vfadd;
    Vfeq "vfeq" (F4 F4) -> I4: Vfadd comm;
    Vfne "vfne" (F4 F4) -> I4: Vfadd comm;
    Vflt "vflt" (F4 F4) -> I4: Vfadd;
    Vfle "vfle" (F4 F4) -> I4: Vfadd;
    Vitof "vitof" (I4) -> F4: Vfadd;
    Vftoi "vftoi" (F4) -> I4: Vfadd;
    Vfmul "vfmul" (F4 F4) -> F4: Vfmul comm;
    Vfma "vfma" (F4 F4 F4) -> F4: Vfma comm;
    // ((x·x' + y·y') + z·z') (+ w·w'), each step rounded.
    Dot3 "dot3" (F4 F4) -> F: Vdot comm;
    Dot4 "dot4" (F4 F4) -> F: Vdot comm;

    // Pairs of halves, the first in the lower bits; each result is rounded once, to nearest even, denormals kept.
    Hpack "hpack" (F F) -> I: Pair;
    Hlow "hlow" (I) -> F: Pair;
    Hhigh "hhigh" (I) -> F: Pair;
    Hadd "hadd" (I I) -> I: Pair comm;
    Hsub "hsub" (I I) -> I: Pair;
    Hmul "hmul" (I I) -> I: Pair comm;
    Hfma "hfma" (I I I) -> I: Pair comm;
    Hmin "hmin" (I I) -> I: Pair comm;
    Hmax "hmax" (I I) -> I: Pair comm;
    Vhpack "vhpack" (F4 F4) -> I4: Vpair;
    Vhlow "vhlow" (I4) -> F4: Vpair;
    Vhhigh "vhhigh" (I4) -> F4: Vpair;
    Vhadd "vhadd" (I4 I4) -> I4: Vpair comm;
    Vhsub "vhsub" (I4 I4) -> I4: Vpair;
    Vhmul "vhmul" (I4 I4) -> I4: Vpair comm;
    Vhfma "vhfma" (I4 I4 I4) -> I4: Vpair comm;
    Vhmin "vhmin" (I4 I4) -> I4: Vpair comm;
    Vhmax "vhmax" (I4 I4) -> I4: Vpair comm;

    // SRAM: guard, address in bytes, value; the immediate is added to the address. Little endian.
    Lb "lb" (P I) -> I: Load imm load;
    Lbu "lbu" (P I) -> I: Load imm load;
    Lh "lh" (P I) -> I: Load imm load;
    Lhu "lhu" (P I) -> I: Load imm load;
    Lw "lw" (P I) -> W: Load imm load;
    Lv "lv" (P I) -> V: Load imm load;
    Sb "sb" (P I I): Store imm store;
    Sh "sh" (P I I): Store imm store;
    Sw "sw" (P I W): Store imm store;
    Sv "sv" (P I V): Store imm store;

    // System memory through the data cache, the same shapes.
    Glb "glb" (P I) -> I: Cload imm load;
    Glbu "glbu" (P I) -> I: Cload imm load;
    Glh "glh" (P I) -> I: Cload imm load;
    Glhu "glhu" (P I) -> I: Cload imm load;
    Glw "glw" (P I) -> W: Cload imm load;
    Glv "glv" (P I) -> V: Cload imm load;
    Gsb "gsb" (P I I): Cstore imm store;
    Gsh "gsh" (P I I): Cstore imm store;
    Gsw "gsw" (P I W): Cstore imm store;
    Gsv "gsv" (P I V): Cstore imm store;

    // Brings the line of an address into the data cache, if it can, and waits for nothing.
    Prefetch "prefetch" (P I): Cload prefetch;

    // The texture unit: guard, address of a descriptor, u and v in lanes 0 and 1. See
    // `ops::semantics::texture`.
    Tex "tex" (P I F4) -> F4: Tex load;

    // Ports: `in` waits until the port has a word, `out` until it takes one. VLIW only.
    In "in" () -> W: Io imm io;
    Out "out" (W): Io imm io;
}

impl Opcode {
    /// This opcode's line of the table.
    pub const fn info(self) -> &'static OpInfo {
        &TABLE[self as usize]
    }

    /// The name in listings and files.
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// The function of the library that computes it where no unit runs its class; `None` for operations on
    /// vectors, which are computed lane by lane, and for those that every machine has.
    pub fn software(self) -> Option<String> {
        let kinds = self.info().operands.iter().chain(&self.info().result);
        let is_scalar = kinds.map(|kind| kind.ty()).all(|ty| ty != Ty::Vec);
        (self.class().has_software() && is_scalar).then(|| format!("__srp_soft_{}", self.name()))
    }

    /// The class of units that run it.
    pub fn class(self) -> Class {
        self.info().class
    }

    /// The storage of its result, if it has one.
    pub fn result(self) -> Option<Ty> {
        self.info().result.map(Kind::ty)
    }

    /// True if it does nothing but compute its result from its operands.
    pub fn is_pure(self) -> bool {
        self.info().effect == Effect::Pure
    }

    /// True if its first operand is a guard: nothing happens, and the result is zero, where false.
    pub fn is_guarded(self) -> bool {
        let effect = self.info().effect;
        matches!(effect, Effect::Load | Effect::Store | Effect::Prefetch)
            || self.class() == Class::Idiv
    }

    /// Which memory it reads or writes, if any.
    pub fn space(self) -> Option<Space> {
        match self.class() {
            _ if self.info().effect == Effect::Prefetch => None,
            Class::Load | Class::Store => Some(Space::Sram),
            Class::Cload | Class::Cstore | Class::Tex => Some(Space::Cached),
            _ => None,
        }
    }

    /// How many bytes it reads or writes at its second operand plus its immediate; `None` for what
    /// accesses no memory, and for the texture unit, which reads where a descriptor says.
    pub fn access_bytes(self) -> Option<u32> {
        use Opcode::*;
        Some(match self {
            Lb | Lbu | Sb | Glb | Glbu | Gsb => 1,
            Lh | Lhu | Sh | Glh | Glhu | Gsh => 2,
            Lw | Sw | Glw | Gsw => 4,
            Lv | Sv | Glv | Gsv => 16,
            _ => return None,
        })
    }

    /// The move of a value of this type.
    pub fn mov(ty: Ty) -> Opcode {
        match ty {
            Ty::Pred => Opcode::Pmov,
            Ty::Word => Opcode::Mov,
            Ty::Vec => Opcode::Vmov,
        }
    }

    /// The selection between two values of this type by a predicate.
    pub fn select(ty: Ty) -> Opcode {
        match ty {
            Ty::Pred => Opcode::Psel,
            Ty::Word => Opcode::Sel,
            Ty::Vec => Opcode::Vsel,
        }
    }

    /// The opcode with this name.
    pub fn parse(name: &str) -> Option<Opcode> {
        Opcode::ALL.iter().copied().find(|op| op.name() == name)
    }
}

impl fmt::Display for Opcode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Debug for Opcode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_parse_back() {
        for &op in Opcode::ALL {
            assert_eq!(Opcode::parse(op.name()), Some(op));
        }
        for &class in Class::ALL {
            assert_eq!(Class::parse(class.name()), Some(class));
        }
    }

    #[test]
    fn guarded_opcodes_start_with_a_predicate() {
        for &op in Opcode::ALL {
            let first = op.info().operands.first();
            assert!(!op.is_guarded() || first == Some(&Kind::P), "{op}");
            let addressed = op.space().is_some() && op.class() != Class::Tex;
            assert_eq!(op.access_bytes().is_some(), addressed, "{op}");
            assert!(
                !op.info().commutative || op.info().operands[0] == op.info().operands[1],
                "{op}"
            );
        }
    }
}
