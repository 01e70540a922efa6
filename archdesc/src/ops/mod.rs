//! The function of each opcode, written once.
//!
//! [`semantics`] has one plain function per opcode, named as in the opcode table. Everything that
//! gives a program meaning calls them: the constant folder and the interpreters through [`eval`],
//! generated simulators by their text ([`SOURCE`], [`call`]). Memory and ports are not computation;
//! [`loaded`] turns the bytes of a load into its result.

use crate::format::Format;
use crate::isa::{Class, Kind, Opcode};
use crate::precision::{Approx, Precision, Subnormals};
use crate::structure::Special;

pub use semantics::lanes::V4;

/// One function per opcode. Depends on nothing but `std`, so that it can be part of a generated
/// program as it stands.
pub mod semantics {
    pub mod approximation;
    pub mod elementary;
    pub mod lanes;
    pub mod texture;
    pub mod word;
}

/// The text of [`semantics`], as the content of a module: the modules `word`, `lanes`, `approximation`
/// and `elementary`, and all their public items by name. `V4` is there the same type as here, word by
/// word.
pub const SOURCE: &str = concat!(
    "pub mod word {\n",
    include_str!("semantics/word.rs"),
    "}\n\npub mod lanes {\n",
    include_str!("semantics/lanes.rs"),
    "}\n\npub mod approximation {\n",
    include_str!("semantics/approximation.rs"),
    "}\n\npub mod elementary {\n",
    include_str!("semantics/elementary.rs"),
    "}\n\npub mod texture {\n",
    include_str!("semantics/texture.rs"),
    "}\n\npub use elementary::*;\npub use lanes::*;\npub use word::*;\n",
);

/// A value of any type: a word in lane 0, a predicate as 0 or 1 in lane 0, a vector in all lanes.
pub type Value = V4;

/// Why an operation has no result.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fault {
    /// An integer division by zero under a true guard.
    DivisionByZero,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::DivisionByZero => f.write_str("integer division by zero"),
        }
    }
}

impl std::error::Error for Fault {}

/// True if an operation computes with floats, and so takes part where subnormal floats are flushed.
/// Operations that look at signs alone, convert or move do not.
pub fn flushes(op: Opcode) -> bool {
    let info = op.info();
    let is_float = |kind: &Kind| matches!(kind, Kind::F | Kind::F4);
    let signs = matches!(
        op,
        Opcode::Fneg | Opcode::Fabs | Opcode::Vfneg | Opcode::Vfabs
    );
    let converts = info.class == Class::Cvt || matches!(op, Opcode::Vitof | Opcode::Vftoi);
    op.is_pure() && info.operands.iter().all(is_float) && !signs && !converts
}

/// True if the result of an operation is a float, or four.
pub fn gives_float(op: Opcode) -> bool {
    matches!(op.info().result, Some(Kind::F | Kind::F4))
}

/// The format to which operands and results of an operation are [rounded](semantics::word::narrow); `None` for operations
/// in binary32.
pub fn narrows(op: Opcode, precision: &Precision) -> Option<u32> {
    let format = precision.formats.of(op);
    let flushes = u32::from(precision.subnormals == Subnormals::Flush);
    (format != Format::SINGLE).then_some(format.exponent | format.significand << 8 | flushes << 16)
}

/// Returns the result of `op` for its operands, its immediate (ignored where it has none), and the machine's
/// precision. `Ok(None)` for loads, stores and ports.
///
/// # Panics
///
/// If there are fewer operands than the opcode has.
pub fn eval(
    op: Opcode,
    args: &[Value],
    imm: i32,
    precision: &Precision,
) -> Result<Option<Value>, Fault> {
    if let Some(format) = narrows(op, precision) {
        let mut narrow = [Value::default(); 3];
        for (to, &arg) in narrow.iter_mut().zip(args) {
            *to = semantics::lanes::vnarrow(arg, format);
        }
        let result = compute(op, &narrow[..args.len().min(3)], imm, precision)?;
        return Ok(result.map(|value| semantics::lanes::vnarrow(value, format)));
    }
    if precision.subnormals == Subnormals::Keep || !flushes(op) {
        return compute(op, args, imm, precision);
    }
    let mut flushed = [Value::default(); 3];
    for (to, &arg) in flushed.iter_mut().zip(args) {
        *to = semantics::lanes::vflush(arg);
    }
    let result = compute(op, &flushed[..args.len().min(3)], imm, precision)?;
    Ok(match gives_float(op) {
        true => result.map(semantics::lanes::vflush),
        false => result,
    })
}

/// The arguments of a function of [`semantics`] after the opcode's operands.
#[derive(Clone, Copy, Debug)]
pub enum Extra {
    /// Nothing.
    Nothing,
    /// The immediate, as a `u32`.
    Immediate,
    /// Unit word and Newton steps, two `u32`, as [`Approx::arguments`] has them.
    Steps(fn(&Precision) -> Approx),
    /// Unit word, a `u32`; 0 for the exact function.
    Bits(fn(&Precision) -> Approx),
}

/// How to call the function of an opcode.
#[derive(Clone, Copy, Debug)]
pub struct Call {
    /// Its name in [`semantics`], and in the module made of [`SOURCE`].
    pub function: &'static str,
    /// Its arguments after the operands.
    pub extra: Extra,
    /// True if it returns an `Option`, `None` meaning [`Fault::DivisionByZero`].
    pub fallible: bool,
}

impl Call {
    /// The arguments after the operands, each as Rust text.
    pub fn extra_arguments(&self, imm: i32, precision: &Precision) -> Vec<String> {
        match self.extra {
            Extra::Nothing => vec![],
            Extra::Immediate => vec![(imm as u32).to_string()],
            Extra::Steps(of) => {
                let (bits, steps) = of(precision).arguments();
                vec![bits.to_string(), steps.to_string()]
            }
            Extra::Bits(of) => vec![of(precision).arguments().0.to_string()],
        }
    }
}

/// A type that functions of [`semantics`] take.
trait Operand {
    fn of(value: Value) -> Self;
}

impl Operand for bool {
    fn of(value: Value) -> bool {
        value.as_pred()
    }
}

impl Operand for u32 {
    fn of(value: Value) -> u32 {
        value.as_word()
    }
}

impl Operand for V4 {
    fn of(value: Value) -> V4 {
        value
    }
}

/// A type that functions of [`semantics`] give.
trait Outcome {
    fn value(self) -> Result<Value, Fault>;
}

impl Outcome for bool {
    fn value(self) -> Result<Value, Fault> {
        Ok(V4::pred(self))
    }
}

impl Outcome for u32 {
    fn value(self) -> Result<Value, Fault> {
        Ok(V4::word(self))
    }
}

impl Outcome for V4 {
    fn value(self) -> Result<Value, Fault> {
        Ok(self)
    }
}

impl Outcome for Option<u32> {
    fn value(self) -> Result<Value, Fault> {
        self.map(V4::word).ok_or(Fault::DivisionByZero)
    }
}

/// Every opcode that computes: the module of its function, the function, its operands, and what
/// it takes after them.
macro_rules! operations {
    ($($module:ident {
        $($op:ident $function:ident ($($operand:literal)* $(; $extra:ident $($unit:ident)?)?);)*
    })*) => {
        /// [`eval`] of operands as they are.
        fn compute(
            op: Opcode,
            args: &[Value],
            imm: i32,
            precision: &Precision,
        ) -> Result<Option<Value>, Fault> {
            let result = match op {
                $($(Opcode::$op => operations!(
                    @apply (args imm precision) $module $function ($($operand)*)
                    $($extra $($unit)?)?
                ).value(),)*)*
                _ => return Ok(None),
            };
            result.map(Some)
        }

        /// How to call the function of `op`; `None` for loads, stores and ports.
        pub fn call(op: Opcode) -> Option<Call> {
            let (function, extra) = match op {
                $($(Opcode::$op => (
                    stringify!($function),
                    operations!(@extra $($extra $($unit)?)?),
                ),)*)*
                _ => return None,
            };
            Some(Call {
                function,
                extra,
                fallible: op.class() == Class::Idiv,
            })
        }
    };
    (@apply ($args:ident $imm:ident $precision:ident) $module:ident $function:ident
        ($($operand:literal)*)) => {
        semantics::$module::$function($(Operand::of($args[$operand])),*)
    };
    (@apply ($args:ident $imm:ident $precision:ident) $module:ident $function:ident
        ($($operand:literal)*) immediate) => {
        semantics::$module::$function($(Operand::of($args[$operand]),)* $imm as u32)
    };
    (@apply ($args:ident $imm:ident $precision:ident) $module:ident $function:ident
        ($($operand:literal)*) steps $unit:ident) => {{
        let (bits, steps) = $precision.of(Special::$unit).arguments();
        semantics::$module::$function($(Operand::of($args[$operand]),)* bits, steps)
    }};
    (@apply ($args:ident $imm:ident $precision:ident) $module:ident $function:ident
        ($($operand:literal)*) bits $unit:ident) => {
        semantics::$module::$function(
            $(Operand::of($args[$operand]),)*
            $precision.of(Special::$unit).arguments().0,
        )
    };
    (@extra) => { Extra::Nothing };
    (@extra immediate) => { Extra::Immediate };
    (@extra steps $unit:ident) => { Extra::Steps(|precision| precision.of(Special::$unit)) };
    (@extra bits $unit:ident) => { Extra::Bits(|precision| precision.of(Special::$unit)) };
}

/// Expands the macro `$expand` with the table of operations: for each module of [`semantics`] its
/// opcodes, each with its function, the numbers of its operands, and what it takes after them:
/// nothing, `immediate`, or the unit word (`bits`), or that and Newton `steps`, of a [`Special`].
#[macro_export]
macro_rules! with_operations {
    ($expand:ident) => {
        $expand! {
            word {
                Mov mov (0);
                Pmov pmov (0);
                Sel sel (0 1 2);
                Psel psel (0 1 2);
                Add add (0 1);
                Sub sub (0 1);
                And and (0 1);
                Or or (0 1);
                Xor xor (0 1);
                Shl shl (0 1);
                Shr shr (0 1);
                Sar sar (0 1);
                Min min (0 1);
                Max max (0 1);
                Minu minu (0 1);
                Maxu maxu (0 1);
                Eq eq (0 1);
                Ne ne (0 1);
                Lt lt (0 1);
                Le le (0 1);
                Ltu ltu (0 1);
                Leu leu (0 1);
                Mul mul (0 1);
                Mulhs mulhs (0 1);
                Mulhu mulhu (0 1);
                Div div (0 1 2);
                Divu divu (0 1 2);
                Rem rem (0 1 2);
                Remu remu (0 1 2);
                Pand pand (0 1);
                Por por (0 1);
                Pxor pxor (0 1);
                Pnot pnot (0);
                Ptoi ptoi (0);
                Fadd fadd (0 1);
                Fsub fsub (0 1);
                Fmin fmin (0 1);
                Fmax fmax (0 1);
                Fneg fneg (0);
                Fabs fabs (0);
                Ffloor ffloor (0);
                Feq feq (0 1);
                Fne fne (0 1);
                Flt flt (0 1);
                Fle fle (0 1);
                Fmul fmul (0 1);
                Fma fma (0 1 2);
                Itof itof (0);
                Utof utof (0);
                Ftoi ftoi (0);
                Ftou ftou (0);
                Hpack hpack (0 1);
                Hlow hlow (0);
                Hhigh hhigh (0);
                Hadd hadd (0 1);
                Hsub hsub (0 1);
                Hmul hmul (0 1);
                Hfma hfma (0 1 2);
                Hmin hmin (0 1);
                Hmax hmax (0 1);
            }
            lanes {
                Vmov vmov (0);
                Vsel vsel (0 1 2);
                Vsplat vsplat (0);
                Vext vext (0; immediate);
                Vins vins (0 1; immediate);
                Swz swz (0; immediate);
                Vblend vblend (0 1 2);
                Vadd vadd (0 1);
                Vsub vsub (0 1);
                Vand vand (0 1);
                Vor vor (0 1);
                Vxor vxor (0 1);
                Vshl vshl (0 1);
                Vshr vshr (0 1);
                Vsar vsar (0 1);
                Vmin vmin (0 1);
                Vmax vmax (0 1);
                Veq veq (0 1);
                Vlt vlt (0 1);
                Vltu vltu (0 1);
                Vmul vmul (0 1);
                Vfadd vfadd (0 1);
                Vfsub vfsub (0 1);
                Vfmin vfmin (0 1);
                Vfmax vfmax (0 1);
                Vfneg vfneg (0);
                Vfabs vfabs (0);
                Vffloor vffloor (0);
                Vfeq vfeq (0 1);
                Vfne vfne (0 1);
                Vflt vflt (0 1);
                Vfle vfle (0 1);
                Vitof vitof (0);
                Vftoi vftoi (0);
                Vfmul vfmul (0 1);
                Vfma vfma (0 1 2);
                Dot3 dot3 (0 1);
                Dot4 dot4 (0 1);
                Vhpack vhpack (0 1);
                Vhlow vhlow (0);
                Vhhigh vhhigh (0);
                Vhadd vhadd (0 1);
                Vhsub vhsub (0 1);
                Vhmul vhmul (0 1);
                Vhfma vhfma (0 1 2);
                Vhmin vhmin (0 1);
                Vhmax vhmax (0 1);
            }
            elementary {
                Fdiv fdiv (0 1; steps Div);
                Rcp rcp (0; steps Rcp);
                Rsqrt rsqrt (0; steps Rsqrt);
                Sqrt sqrt (0; steps Sqrt);
                Exp2 exp2 (0; bits Exp2);
                Log2 log2 (0; bits Log2);
                Sin sin (0; bits Sincos);
                Cos cos (0; bits Sincos);
                RcpFast rcp_fast (0; steps RcpFast);
                RsqrtFast rsqrt_fast (0; steps RsqrtFast);
                SqrtFast sqrt_fast (0; steps SqrtFast);
                FdivFast fdiv_fast (0 1; steps DivFast);
            }
        }
    };
}

with_operations!(operations);

/// Returns the result of the load `op` from the bytes it has read, zero-extended.
pub fn loaded(op: Opcode, bytes: Value) -> Value {
    match op {
        Opcode::Lb | Opcode::Glb => V4::word(semantics::word::extend_byte(bytes.as_word())),
        Opcode::Lh | Opcode::Glh => V4::word(semantics::word::extend_half(bytes.as_word())),
        _ => bytes,
    }
}
