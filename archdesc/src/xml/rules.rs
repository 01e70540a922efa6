//! Rules about a machine as a whole: what the invariants of [`Arch`] ask for beyond values and
//! names.

use std::collections::{BTreeMap, BTreeSet};

use super::array::{Origin, Units};
use super::findings::Findings;
use crate::arch::{Approx, Arch, FileKind, FileSpec, Fu, FuSpec, RegFile};
use crate::diagnostic::Span;
use crate::entity::EntityMap;
use crate::isa::{Class, Kind, Opcode, Ty};
use crate::structure::Special;

/// Where the parts of the machine stand in the file.
pub(super) struct Places<'p> {
    /// The `<array>`.
    pub(super) array: Span,
    /// The units, with the elements that each was made from.
    pub(super) units: &'p Units,
    /// Each register file.
    pub(super) files: &'p EntityMap<RegFile, Span>,
    /// The file has a `<vliw>`.
    pub(super) has_vliw: bool,
}

/// Reports every rule that the machine breaks, leaving out those about things that the file
/// misspells elsewhere.
pub(super) fn check(found: &Findings, arch: &Arch, places: &Places<'_>) {
    widths(found, arch, places);
    names(found, arch, places);
    let parts = [
        "array", "rows", "cols", "vliw", "slots", "slot", "row", "units", "fu",
    ];
    if found.suspects_any(&parts) {
        return;
    }
    if is_array_alone(found, arch, places) {
        return;
    }
    slots(found, arch, places);
    if !found.suspects_any(&["fu-type", "type", "op", "class", "classes", "width"]) {
        classes(found, arch, places);
        branches(found, arch, places);
    }
    if arch.srp.fus.values().any(|unit| unit.slot.is_some()) {
        for ty in Ty::ALL {
            central_file(found, arch, places, ty);
        }
    }
}

/// True, and reported, if all that control code needs is missing: `<vliw>`, and every central file. Then an array alone
/// is meant, and what its slots lack is not worth a list.
fn is_array_alone(found: &Findings, arch: &Arch, places: &Places<'_>) -> bool {
    let is_central = |file: &FileSpec| file.kind == FileKind::Central;
    let is_meant = !places.has_vliw
        && !arch.srp.slots().is_empty()
        && !arch.srp.files.values().any(is_central)
        && !found.suspects_any(&["file", "kind"]);
    if is_meant {
        let message = "there are VLIW slots, and no central register file for their code";
        let label = "without a `<vliw>`, the units of its first row are slots";
        let help = "add `<vliw slots=\"0\"/>` to the machine: it is an array alone then, for `srp map`; or add central files \
                    of widths 1, 32 and 128 to the array, for programs";
        found.push(
            found
                .error("A0509", places.array, message, label)
                .help(help),
        );
    }
    is_meant
}

/// Checks that a unit runs no class whose operations are all wider than the unit.
fn widths(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let mut reported = BTreeSet::new();
    for (fu, unit) in arch.srp.fus.iter().filter(|(_, unit)| unit.width < 128) {
        for op in unit.ops.iter().filter(|op| is_wide(op.class)) {
            let origin = &places.units.origins[fu];
            let span = origin.mentions.get(&op.class).copied();
            let span = span.unwrap_or(origin.span);
            if reported.insert(span) {
                let message = format!(
                    "a unit of {} bits cannot run class `{}`",
                    unit.width, op.class
                );
                found.push(
                    found
                        .error("A0501", span, message, "its operations take vectors")
                        .also(origin.span, "this unit")
                        .help("give the unit `width=\"128\"`, or take the class from it"),
                );
            }
        }
    }
}

/// True if all operations of a class take or give vectors.
fn is_wide(class: Class) -> bool {
    let wide = |kind: &Kind| kind.ty() == Ty::Vec;
    let mut ops = operations(class).peekable();
    ops.peek().is_some()
        && ops.all(|op| op.info().operands.iter().any(wide) || op.result() == Some(Ty::Vec))
}

fn operations(class: Class) -> impl Iterator<Item = Opcode> {
    let all = Opcode::ALL.iter().copied();
    all.filter(move |op| op.class() == class)
}

/// Names of places, which generated code derives from those of units and files, are unique.
fn names(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let mut outputs: BTreeMap<String, Fu> = BTreeMap::new();
    for (fu, unit) in arch.srp.fus.iter() {
        outputs.insert(format!("{}_out", unit.name), fu);
        outputs.insert(format!("{}_p", unit.name), fu);
    }
    for (file, spec) in arch.srp.files.iter() {
        if let Some(&fu) = outputs.get(&spec.name) {
            let message = format!(
                "`{}` is the name of an output of unit `{}`",
                spec.name, arch.srp.fus[fu].name
            );
            let label = "a file needs another name";
            found.push(found.error("A0405", places.files[file], message, label));
        }
    }
}

/// Slots are numbered from 0 without gaps or repetitions.
fn slots(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let mut slots: BTreeMap<u32, Fu> = BTreeMap::new();
    for (fu, unit) in arch.srp.fus.iter() {
        let Some(slot) = unit.slot else { continue };
        if let Some(&first) = slots.get(&slot) {
            let message = format!("two units are VLIW slot {slot}");
            found.push(
                found
                    .error(
                        "A0502",
                        places.units.origins[fu].span,
                        message,
                        "the second",
                    )
                    .also(places.units.origins[first].span, "the first"),
            );
        } else {
            slots.insert(slot, fu);
        }
    }
    if let Some((gap, (_, &fu))) = (0..).zip(&slots).find(|&(n, (&slot, _))| n != slot) {
        let message = format!("there is no VLIW slot {gap}");
        let label = format!("this unit is slot {}", arch.srp.fus[fu].slot.unwrap_or(gap));
        found.push(found.error("A0502", places.units.origins[fu].span, message, label));
    }
}

/// Any C code may become control code, so between them the VLIW slots run every operation that the machine has and
/// that no software stands in for.
fn classes(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let slots = arch.srp.slots();
    if slots.is_empty() {
        return;
    }
    let fast = arch.precision.specials().any(Special::is_fast);
    if !fast {
        unused_fast(found, arch, places);
    }
    missing_specials(found, arch, places);
    // Not every machine has a texture unit or units for pairs of halves, and code that needs one is refused when it is
    // compiled; nor has every machine fast units, which code does without.
    let has = |class| arch.srp.fus.values().any(|fu| fu.op(class).is_some());
    // Newton's steps in code are operations that are made late, and so are products for quotients by powers of two.
    let steps = arch.precision != arch.precision.in_units();
    let needed = |&&class: &&Class| match class {
        Class::Fadd | Class::Fma if steps => true,
        Class::Fmul if steps || has(Class::Fdiv) => true,
        Class::Tex => false,
        Class::Fast => fast,
        Class::Pair | Class::Vpair => has(class),
        _ if class.has_software() => has(class),
        _ => true,
    };
    for &class in Class::ALL.iter().filter(needed) {
        let runs = |fu: &Fu| arch.srp.fus[*fu].op(class).is_some();
        let narrow = operations(class)
            .filter(|&op| Special::of(op).is_none_or(|special| arch.precision.has(special)))
            .find(|&op| !slots.iter().any(|&fu| arch.srp.fus[fu].runs(op).is_some()));
        let wide = narrow.is_some_and(|op| {
            let kinds = op.info().operands.iter().chain(&op.info().result);
            kinds.map(|kind| kind.ty()).any(|ty| ty == Ty::Vec)
        });
        let (code, message, label) = if !arch.srp.fus.keys().any(|fu| runs(&fu)) {
            let message = format!("no unit runs class `{class}`");
            ("A0503", message, "the array lacks it")
        } else if !slots.iter().any(runs) {
            let message = format!("no VLIW slot runs class `{class}`, which control code may need");
            ("A0504", message, "its VLIW slots lack it")
        } else if let Some(op) = narrow {
            let message =
                format!("no VLIW slot that runs class `{class}` is wide enough for `{op}`");
            ("A0504", message, "its VLIW slots lack it")
        } else {
            continue;
        };
        let help = match taker(arch, &places.units.origins, &slots, class, wide) {
            Some(taker) => format!("add `{class}` to {taker}"),
            None => "make a slot 128 bits wide and add the class to it".to_owned(),
        };
        found.push(found.error(code, places.array, message, label).help(help));
    }
}

/// A branch issues again before the next one can: there is one at most in each bundle, and its delay is over then.
fn branches(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let most = arch.srp.branch_delay + 1;
    for fu in arch.srp.slots() {
        let Some(how) = arch.srp.fus[fu].op(Class::Branch) else {
            continue;
        };
        if how.interval <= most {
            continue;
        }
        let origin = &places.units.origins[fu];
        let span = origin.mentions.get(&Class::Branch).copied();
        let message = format!(
            "slot `{}` takes a branch every {} cycles, and control code has one every {most} (branch delay + 1)",
            arch.srp.fus[fu].name, how.interval
        );
        let span = span.unwrap_or(origin.span);
        let error = found.error("A0508", span, message, "runs class `branch`");
        let help = format!("give `<op class=\"branch\">` an interval of {most} at most");
        found.push(error.help(help));
        return;
    }
}

/// Reports a function that is said to be built somehow, and that no unit runs.
fn missing_specials(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let missing = arch.srp.in_software();
    let specials = Opcode::ALL.iter().filter_map(|&op| {
        let special = Special::of(op).filter(|_| missing.contains(&op.class()))?;
        (arch.precision.of(special) != Approx::Exact).then_some((special, op.class()))
    });
    for (special, class) in BTreeSet::from_iter(specials) {
        let name = special.name();
        let message = format!("`{name}` has a `<special>`, and no unit runs class `{class}`");
        let label = "the array lacks it";
        let error = found.error("A0507", places.array, message, label);
        let help =
            format!("add `{class}` to a unit, or take the `<special>` out: software is exact");
        found.push(error.help(help));
    }
}

/// Reports a unit that runs class `fast` of a machine without fast functions.
fn unused_fast(found: &Findings, arch: &Arch, places: &Places<'_>) {
    let runs = |(_, unit): &(Fu, &FuSpec)| unit.op(Class::Fast).is_some();
    if let Some((fu, _)) = arch.srp.fus.iter().find(runs)
        && !found.suspects_any(&["special", "function"])
    {
        let origin = &places.units.origins[fu];
        let span = origin.mentions.get(&Class::Fast).copied();
        let message = "a unit runs class `fast`, and the machine describes no fast function";
        found.push(
            found
                .error(
                    "A0507",
                    span.unwrap_or(origin.span),
                    message,
                    "has nothing to run",
                )
                .help(
                    "add `<special function=\"rcp_fast\" bits=\"…\"/>` or another to the machine",
                ),
        );
    }
}

/// Which slot's unit could best take a class: one that is wide enough and runs the class nearest
/// to it in the table, where related classes stand together.
fn taker(
    arch: &Arch,
    origins: &EntityMap<Fu, Origin>,
    slots: &[Fu],
    class: Class,
    wide: bool,
) -> Option<String> {
    let distance = |fu: Fu| {
        let classes = arch.srp.fus[fu].ops.iter().map(|op| op.class as usize);
        classes.map(|c| c.abs_diff(class as usize)).min()
    };
    let fu = slots
        .iter()
        .copied()
        .filter(|&fu| !wide || arch.srp.fus[fu].width == 128)
        .filter(|&fu| arch.srp.fus[fu].op(class).is_none())
        .min_by_key(|&fu| distance(fu).unwrap_or(usize::MAX))?;
    let name = &arch.srp.fus[fu].name;
    let slot = arch.srp.fus[fu].slot?;
    Some(match &origins[fu].fu_type {
        Some(fu_type) => format!("the classes of fu-type `{fu_type}`, which is VLIW slot {slot}"),
        None => format!("the classes of `{name}`, which is VLIW slot {slot}"),
    })
}

/// For each type of values there is a central file of its width that every slot reads and writes.
fn central_file(found: &Findings, arch: &Arch, places: &Places<'_>, ty: Ty) {
    let width = ty.bits();
    let file = arch.srp.central(ty);
    let Some(file) = file.filter(|&file| arch.srp.files[file].width == width) else {
        if !found.suspects_any(&["file", "kind", "width"]) {
            let message = format!("there is no central register file of width {width}");
            let help = format!(
                "add `<file name=\"…\" kind=\"central\" width=\"{width}\" size=\"…\"/>` to the array"
            );
            let label = "VLIW code needs one";
            found.push(
                found
                    .error("A0505", places.array, message, label)
                    .help(help),
            );
        }
        return;
    };
    let spec = &arch.srp.files[file];
    let users = [
        (&spec.readers, "read", "readers"),
        (&spec.writers, "write", "writers"),
    ];
    for (users, verb, attribute) in users {
        let users: BTreeSet<Fu> = users.iter().copied().collect();
        let lacking = arch.srp.slots().into_iter().find(|fu| !users.contains(fu));
        if let Some(fu) = lacking.filter(|_| !found.suspects_any(&[attribute])) {
            let message = format!(
                "VLIW slot `{}` cannot {verb} central file `{}`",
                arch.srp.fus[fu].name, spec.name
            );
            found.push(
                found
                    .error("A0506", places.files[file], message, "every slot must")
                    .help(format!("leave `{attribute}` out, or name `slots` in it")),
            );
        }
    }
}
