//! Special functions in the file: `<special>` of a machine and of its T&I unit, `<float>`.

use std::collections::BTreeMap;

use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::raw::{self, Text};
use super::units::unique;
use super::values;
use crate::arch::Arch;
use crate::cost::special::{self as cost, Build, Builds, Unit};
use crate::diagnostic::Span;
use crate::format::Format;
use crate::precision::{Approx, Precision, Refine, Subnormals};
use crate::structure::{MAX_SEGMENTS, Special, Structure};

/// Structures that a `<special>` can name; `newton` is a table with at least one step.
const STRUCTURES: [&str; 7] = [
    "table",
    "bipartite",
    "multipartite",
    "polynomial",
    "newton",
    "srt",
    "cordic",
];

/// Where something does not go together.
type Complaint<'r> = (Span, String, &'r str);

/// Settings from the `<special>`s of a machine or of a T&I unit.
pub(super) struct Specials {
    pub(super) precision: Precision,
    pub(super) builds: Builds,
    places: BTreeMap<&'static str, Span>,
}

impl Specials {
    /// Cycles that follow from structure and precision are as few as cycles that are given.
    pub(super) fn check_cycles(&self, found: &Findings, arch: &Arch) {
        for special in arch.precision.specials() {
            let unit = arch.special_unit(special);
            if let Some(&place) = self.places.get(special.name()) {
                check_cycles(found, place, &unit, arch.system.srp_mhz_at_65nm());
            }
        }
    }
}

/// The special functions of a machine, exact where the file says nothing; its handling of subnormal floats;
/// and the precision of the texture unit.
pub(super) fn machine(found: &Findings, machine: &raw::Machine) -> Specials {
    let (raw, system) = (&machine.special, &machine.system);
    let mut specials = specials(found, raw, &Special::ALL.map(|f| f.name()), true);
    let precision = &mut specials.precision;
    let in_code = |approx| {
        matches!(
            approx,
            Approx::Table {
                refine: Refine::Code,
                ..
            }
        )
    };
    if let Some(&place) = (specials.places.get("sqrt")).filter(|_| in_code(precision.sqrt))
        && precision.rsqrt != precision.sqrt
    {
        let message = "a square root is refined in code as x · 1/√x, by the machine's `rsqrt`";
        let label = "is not what `rsqrt` has";
        found.push(
            found.error("A0305", place, message, label).help(
                "give both functions the same structure, `bits`, `steps`, `fused` and `refine`",
            ),
        );
    }
    if let Some(float) = &machine.float {
        let words = Subnormals::ALL.map(|s| (s.name(), s));
        let subnormals = values::word(found, &float.value.subnormals, "subnormals", &words);
        precision.subnormals = subnormals.unwrap_or(precision.subnormals);
        let float = &float.value;
        let own = &mut precision.formats;
        for (text, own) in [
            (&float.add, &mut own.add),
            (&float.multiply, &mut own.multiply),
            (&float.fused, &mut own.fused),
        ] {
            let format = text.as_ref().and_then(|text| format(found, text));
            *own = format.unwrap_or(*own);
        }
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
    specials
}

/// A format of floats.
fn format(found: &Findings, text: &Text) -> Option<Format> {
    let format = Format::parse(&text.value);
    if format.is_none() {
        let known = Format::NAMED.iter().map(|(name, _)| *name);
        values::unknown(found, "A0413", text, "format", known.chain(["e5m10"]));
    }
    format
}

/// The reciprocal of the T&I unit, which has no other special function and runs no program.
pub(super) fn tni_rcp(
    found: &Findings,
    raw: &[Spanned<raw::Special>],
    mhz: u32,
) -> (Approx, Build) {
    let specials = specials(found, raw, &["rcp"], false);
    let (rcp, build) = (specials.precision.rcp, *specials.builds.of(Special::Rcp));
    if let Some(&place) = specials.places.get("rcp") {
        let unit = cost::unit(Special::Rcp, rcp, &build, mhz);
        check_cycles(found, place, &unit, mhz);
    }
    (rcp, build)
}

/// Checks that a unit is as quick as a machine's units have to be.
pub(super) fn check_cycles(found: &Findings, place: Span, unit: &Unit, mhz: u32) {
    let latency = unit.latency.max(unit.interval).unwrap_or(0);
    let most = limits::LATENCY.max;
    if latency > most {
        let message =
            format!("at {mhz} MHz of 65 nm this unit takes {latency} cycles, more than {most}");
        found.push(
            found
                .error("A0307", place, message, "too slow")
                .help(format!(
                    "{}; have another structure, or give `latency`",
                    unit.why
                )),
        );
    }
}

fn specials(
    found: &Findings,
    raw: &[Spanned<raw::Special>],
    allowed: &[&str],
    programmable: bool,
) -> Specials {
    let mut specials = Specials {
        precision: Precision::EXACT,
        builds: Builds::default(),
        places: BTreeMap::new(),
    };
    let mut seen = BTreeMap::new();
    for special in raw {
        let Some(text) = &special.function else {
            values::missing(found, "function", "special", special.span);
            continue;
        };
        let function = Special::ALL
            .into_iter()
            .find(|f| f.name() == text.value && allowed.contains(&f.name()));
        let Some(function) = function else {
            values::unknown(found, "A0412", text, "function", allowed.iter().copied());
            continue;
        };
        if unique(found, &mut seen, function.name(), text.span, "function") {
            specials.places.insert(function.name(), text.span);
            let (approx, build) = unit(found, special, function, programmable);
            *specials.precision.of_mut(function) = approx;
            *specials.builds.of_mut(function) = build;
        }
    }
    specials
}

/// Reads one `<special>`.
fn unit(
    found: &Findings,
    special: &Spanned<raw::Special>,
    function: Special,
    programmable: bool,
) -> (Approx, Build) {
    let some = |text: &Option<Text>, limit| {
        text.as_ref()
            .map(|_| values::number(found, text, limit, limit.min))
    };
    let mut build = Build {
        exact: None,
        datapath: some(&special.datapath, limits::DATAPATH),
        latency: some(&special.latency, limits::LATENCY),
        interval: some(&special.interval, limits::INTERVAL),
        area_um2: some(&special.area_um2, limits::AREA),
        energy_fj: some(&special.energy_fj, limits::ENERGY),
    };
    let names = STRUCTURES.map(|name| (name, name));
    let named = values::word(found, &special.structure, "structure", &names);
    let exact = match (&special.bits, named) {
        (Some(bits), _) => bits.value == "exact",
        // A recurrence is exact where no bits are left out; segments say how many bits there are.
        (None, Some(name)) => name == "srt",
        (None, None) => true,
    };
    let steps = match (&special.steps, named) {
        (None, Some("newton")) => 1,
        _ => values::number(found, &special.steps, limits::APPROX_STEPS, 0),
    };
    let fused = values::flag(found, &special.fused, "fused", true);
    let refine = Refine::ALL.map(|r| (r.name(), r));
    let refine = values::word(found, &special.refine, "refine", &refine).unwrap_or(Refine::Unit);
    let limit = limits::APPROX_BITS;
    let asked = (special.bits.is_some() && !exact)
        .then(|| values::number(found, &special.bits, limit, limit.max));
    let before = found.len();
    let checked = mismatch(special, named, exact)
        .or_else(|| step_mismatch(special, function, named, exact, steps, refine, programmable));
    if let Some((span, message, label)) = checked {
        found.push(found.error("A0305", span, message, label));
        return (Approx::Exact, build);
    }
    let (structure, bits) = structure(found, special, function, named, asked);
    if found.len() > before {
        return (Approx::Exact, build);
    }
    if exact {
        build.exact = named.map(|_| structure);
        return (Approx::Exact, build);
    }
    let approx = Approx::Table {
        structure,
        bits,
        steps,
        fused,
        refine,
    };
    (approx, build)
}

/// An attribute that is of another structure, or a structure that is never exact.
fn mismatch<'r>(
    special: &'r Spanned<raw::Special>,
    named: Option<&str>,
    exact: bool,
) -> Option<Complaint<'r>> {
    if let (true, Some(name), Some(text)) = (exact, named, &special.structure)
        && name != "srt"
    {
        let message = format!("a unit by `{name}` is not exact");
        return Some((text.span, message, "needs `bits`"));
    }
    let of = [
        ("degree", &special.degree, "polynomial"),
        ("segments", &special.segments, "polynomial"),
        ("tables", &special.tables, "multipartite"),
        ("radix", &special.radix, "srt"),
        ("unrolled", &special.unrolled, "srt"),
    ];
    for (name, text, structure) in of {
        if let Some(text) = text
            && named != Some(structure)
        {
            let message = format!("`{name}` is of units with `structure=\"{structure}\"`");
            return Some((text.span, message, "not of this one"));
        }
    }
    None
}

/// Steps where there are none.
fn step_mismatch<'r>(
    special: &'r Spanned<raw::Special>,
    function: Special,
    named: Option<&str>,
    exact: bool,
    steps: u32,
    refine: Refine,
    programmable: bool,
) -> Option<Complaint<'r>> {
    let digits = matches!(named, Some("srt" | "cordic"));
    let given = [&special.steps, &special.fused, &special.refine];
    let mut given = given.into_iter().flatten();
    let newton = (special.steps.as_ref()).or(special.structure.as_ref());
    let of = |text: &'r Text, message: &str, label| (text.span, message.to_owned(), label);
    let steps_where_none = steps > 0 && !function.has_steps();
    match (given.next(), newton, &special.refine, &special.structure) {
        (Some(text), ..) if exact => Some(of(
            text,
            "an exact function takes no steps",
            "without `bits`",
        )),
        (_, Some(text), ..) if steps_where_none => Some(of(
            text,
            "only reciprocal, roots and division have Newton–Raphson steps",
            "must be 0 here",
        )),
        (_, Some(text), ..) if steps == 0 && named == Some("newton") => Some(of(
            text,
            "a unit by `newton` has at least one step",
            "must be 1 at least",
        )),
        (Some(text), ..) if digits => Some(of(
            text,
            "only tables and polynomials are improved by steps",
            "this unit gives all of its digits itself",
        )),
        (_, _, Some(text), _)
            if refine == Refine::Code && !(programmable && function.has_steps_in_code()) =>
        {
            Some(of(
                text,
                "only `rcp`, `rsqrt` and `sqrt` of the SRP are refined in code",
                "must be `unit` here",
            ))
        }
        (_, _, _, Some(text)) if named == Some("srt") && !function.has_steps() => Some(of(
            text,
            "digit recurrence is for reciprocal, roots and division",
            "not for this function",
        )),
        (_, _, _, Some(text)) if named == Some("cordic") && function == Special::Rsqrt => Some(of(
            text,
            "rotations give no inverse square root",
            "not for this function",
        )),
        _ => None,
    }
}

/// The structure, and the bits that it is good to.
fn structure(
    found: &Findings,
    special: &Spanned<raw::Special>,
    function: Special,
    named: Option<&str>,
    asked: Option<u32>,
) -> (Structure, u32) {
    let most = limits::APPROX_BITS.max;
    let bits = asked.unwrap_or(most);
    let needs_bits = !matches!(named, None | Some("srt" | "polynomial"));
    if special.bits.is_none() && needs_bits {
        values::missing(found, "bits", "special", special.span);
    }
    let structure = match named {
        None | Some("table" | "newton") => Structure::Table,
        Some("bipartite") => Structure::Offsets { tables: 1 },
        Some("multipartite") => Structure::Offsets {
            tables: values::number(found, &special.tables, limits::OFFSET_TABLES, 2),
        },
        Some("cordic") => Structure::Cordic,
        Some("polynomial") => return polynomial(found, special, function, asked),
        Some(_) => {
            let radix = values::power(found, &special.radix, limits::RADIX, 4);
            let unrolled = values::flag(found, &special.unrolled, "unrolled", false);
            Structure::Recurrence { radix, unrolled }
        }
    };
    (structure, bits)
}

/// Segments follow from bits, or bits from segments; given both, the segments must do.
fn polynomial(
    found: &Findings,
    special: &Spanned<raw::Special>,
    function: Special,
    asked: Option<u32>,
) -> (Structure, u32) {
    let limit = limits::APPROX_BITS;
    let degree = values::number(found, &special.degree, limits::DEGREE, 2);
    let given = (special.segments.as_ref())
        .map(|_| values::power(found, &special.segments, limits::SEGMENTS, 1).ilog2());
    if asked.is_none() && given.is_none() {
        values::missing(found, "bits", "special", special.span);
    }
    let needed = asked.map(|bits| function.segments(degree, bits));
    let reached = given.map(|k| function.bits_of(degree, k, limit.max));
    let at = [&special.segments, &special.bits, &special.structure];
    let at = at
        .into_iter()
        .flatten()
        .next()
        .map_or(special.span, |text| text.span);
    let too_few = match (asked, reached) {
        (Some(bits), Some(reached)) if reached < bits => Some((bits, reached)),
        (Some(bits), None) if function.bits_of(degree, MAX_SEGMENTS, limit.max) < bits => {
            Some((bits, function.bits_of(degree, MAX_SEGMENTS, limit.max)))
        }
        (None, Some(reached)) if reached < limit.min => Some((limit.min, reached)),
        _ => None,
    };
    if let Some((bits, reached)) = too_few {
        let message = format!(
            "polynomials of degree {degree} in so few segments are good to {reached} bits, not {bits}"
        );
        let enough = 1u32 << function.segments(degree, bits);
        found.push(found.error("A0306", at, message, "too few").help(format!(
            "{bits} bits of `{}` take {enough} segments",
            function.name()
        )));
    }
    let segments = given.or(needed).unwrap_or(0);
    let bits = asked.or(reached).unwrap_or(limit.max);
    (Structure::Polynomial { degree, segments }, bits)
}
