//! Precision in the file: `<special>` of a machine and of its T&I unit, `<float>`.

use std::collections::BTreeMap;

use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::raw::{self, Text};
use super::units::unique;
use super::values;
use crate::diagnostic::Span;
use crate::precision::{Approx, Precision, Refine, Subnormals};

/// A special function.
pub(super) struct Function {
    /// Its name in the file.
    pub(super) name: &'static str,
    /// Whether it has Newton–Raphson steps.
    pub(super) newton: bool,
    /// Whether the program can take them.
    in_code: bool,
    /// Its precision.
    pub(super) field: fn(&mut Precision) -> &mut Approx,
}

const fn function(
    name: &'static str,
    newton: bool,
    in_code: bool,
    field: fn(&mut Precision) -> &mut Approx,
) -> Function {
    Function {
        name,
        newton,
        in_code,
        field,
    }
}

/// All special functions.
pub(super) const FUNCTIONS: [Function; 7] = [
    function("rcp", true, true, |p| &mut p.rcp),
    function("rsqrt", true, true, |p| &mut p.rsqrt),
    function("sqrt", true, true, |p| &mut p.sqrt),
    function("div", true, false, |p| &mut p.div),
    function("exp2", false, false, |p| &mut p.exp2),
    function("log2", false, false, |p| &mut p.log2),
    function("sincos", false, false, |p| &mut p.sincos),
];

/// The precision of a machine: of its special functions, exact where the file says nothing, of its
/// floats and of the texture unit.
pub(super) fn precision(found: &Findings, machine: &raw::Machine) -> Precision {
    let (raw, system) = (&machine.special, &machine.system);
    let (mut precision, places) = specials(found, raw, &FUNCTIONS.map(|f| f.name), true);
    let in_code = |approx| {
        matches!(
            approx,
            Approx::Table {
                refine: Refine::Code,
                ..
            }
        )
    };
    if let Some(&place) = places.get("sqrt").filter(|_| in_code(precision.sqrt))
        && precision.rsqrt != precision.sqrt
    {
        let message = "a square root is refined in code as x · 1/√x, by the machine's `rsqrt`";
        let label = "is not what `rsqrt` has";
        found.push(
            found
                .error("A0305", place, message, label)
                .help("give both functions the same `bits`, `steps`, `fused` and `refine`"),
        );
    }
    if let Some(float) = &machine.float {
        let words = Subnormals::ALL.map(|s| (s.name(), s));
        let subnormals = values::word(found, &float.value.subnormals, "subnormals", &words);
        precision.subnormals = subnormals.unwrap_or(precision.subnormals);
    }
    let texture = system.as_ref().and_then(|s| s.value.texture.as_ref());
    if let Some(texture) = texture {
        let bits = &mut precision.texture_weight_bits;
        *bits = values::number(
            found,
            &texture.value.weight_bits,
            limits::WEIGHT_BITS,
            *bits,
        );
    }
    precision
}

/// The precision of the reciprocal in the T&I unit, which has no other special function and runs no
/// program.
pub(super) fn tni_rcp(found: &Findings, raw: &[Spanned<raw::Special>]) -> Approx {
    specials(found, raw, &["rcp"], false).0.rcp
}

/// What the elements say, and where each function stands in the file.
fn specials(
    found: &Findings,
    raw: &[Spanned<raw::Special>],
    allowed: &[&str],
    programmable: bool,
) -> (Precision, BTreeMap<&'static str, Span>) {
    let mut precision = Precision::EXACT;
    let (mut seen, mut places) = (BTreeMap::new(), BTreeMap::new());
    for special in raw {
        let approx = |newton, in_code| approx(found, special, newton, in_code && programmable);
        let Some(text) = &special.function else {
            values::missing(found, "function", "special", special.span);
            approx(true, true);
            continue;
        };
        let function = FUNCTIONS
            .iter()
            .find(|f| f.name == text.value && allowed.contains(&f.name));
        match function {
            None => {
                values::unknown(found, "A0412", text, "function", allowed.iter().copied());
                approx(true, true);
            }
            Some(function) => {
                if unique(found, &mut seen, function.name, text.span, "function") {
                    places.insert(function.name, text.span);
                    *(function.field)(&mut precision) = approx(function.newton, function.in_code);
                }
            }
        }
    }
    (precision, places)
}

fn approx(
    found: &Findings,
    special: &Spanned<raw::Special>,
    newton: bool,
    in_code: bool,
) -> Approx {
    let exact = match &special.bits {
        Some(bits) => bits.value == "exact",
        None => true,
    };
    let steps = values::number(found, &special.steps, limits::APPROX_STEPS, 0);
    let fused = values::flag(found, &special.fused, "fused", true);
    let refine = Refine::ALL.map(|r| (r.name(), r));
    let refine = values::word(found, &special.refine, "refine", &refine).unwrap_or(Refine::Unit);
    let given: [(&str, &Option<Text>); 3] = [
        ("steps", &special.steps),
        ("fused", &special.fused),
        ("refine", &special.refine),
    ];
    let mut given = given
        .iter()
        .filter_map(|(name, t)| Some((*name, t.as_ref()?)));
    let complaint = match (given.next(), &special.steps, &special.refine) {
        (Some((_, text)), _, _) if exact => {
            Some((text, "an exact function takes no steps", "without `bits`"))
        }
        (_, Some(text), _) if !newton && steps > 0 => Some((
            text,
            "only reciprocal, roots and division have Newton–Raphson steps",
            "must be 0 here",
        )),
        (_, _, Some(text)) if !in_code && refine == Refine::Code => Some((
            text,
            "only `rcp`, `rsqrt` and `sqrt` of the SRP are refined in code",
            "must be `unit` here",
        )),
        _ => None,
    };
    if let Some((text, message, label)) = complaint {
        found.push(found.error("A0305", text.span, message, label));
        return Approx::Exact;
    }
    if exact {
        return Approx::Exact;
    }
    let limit = limits::APPROX_BITS;
    let bits = values::number(found, &special.bits, limit, limit.max);
    Approx::Table {
        bits,
        steps,
        fused,
        refine,
    }
}
