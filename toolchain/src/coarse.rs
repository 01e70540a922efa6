//! Reciprocals, roots and quotients that no unit of a machine computes within the error that a program may have.

use srp_archdesc::choice::Choices;
use srp_archdesc::diagnostic::{Diagnostic, Span};
use srp_archdesc::structure::Special;
use srp_ir::program::{InstKind, Program};
use std::collections::{BTreeMap, BTreeSet};

/// The code of these errors: that of a pragma that asks for more than the machine has.
const CODE: &str = "C0602";

/// An error for each place of a program's own texts at which an operation is off by more than so many units in the last
/// place on any unit. `texts` are those by their names; functions of the library rely on the units that they were written
/// for, and are left out.
pub(crate) fn errors(
    program: &Program,
    max_ulp: f64,
    choices: &Choices,
    texts: &BTreeMap<String, String>,
) -> Vec<Diagnostic> {
    let error = max_ulp / f64::from(1 << 24);
    let insts = program.funcs.values().flat_map(|func| func.insts.values());
    let coarse = insts.filter_map(|inst| {
        let InstKind::Op { op, .. } = &inst.kind else {
            return None;
        };
        // What names a fast unit is meant so.
        let special = Special::of(*op).filter(|special| !special.is_fast())?;
        let units = choices.of_function(special);
        let none = !units.is_empty() && choices.within(special, error).is_none();
        none.then_some((inst.pos, special))
    });
    let coarse: BTreeSet<_> = coarse.collect();
    let own = |name: &str| srp_frontend::library::text(name).is_none();
    let message = |(pos, special): (srp_ir::program::Pos, Special)| {
        let file = program.files.get(pos.file).filter(|file| own(file))?;
        let units = choices.of_function(special).iter();
        let units: Vec<String> = units
            .map(|unit| {
                let ulps = unit.error * f64::from(1 << 24);
                format!("`{}` to {ulps:.0}", unit.op)
            })
            .collect();
        let text = texts.get(file).map_or("", String::as_str);
        let what = format!(
            "no unit of the machine computes `{}` to {max_ulp} units in the last place, as --max-ulp asks",
            special.name()
        );
        let place = Span::of_word(text, pos.line, pos.column);
        let message = Diagnostic::error(CODE, file, what).at(place, "computed here");
        Some(message.help(format!("it has {}", units.join(" and "))))
    };
    coarse.into_iter().filter_map(message).collect()
}
