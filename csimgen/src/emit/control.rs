//! The VLIW code: one function per bundle.

use super::comment;
use super::expr::{block, number, read};
use crate::spec::{BundleSpec, Control, Position, SimSpec};
use srp_archdesc::isa::Ty;
use std::fmt::Write;

/// `control.rs`.
pub(super) fn emit(spec: &SimSpec) -> String {
    let mut text = String::new();
    let out = &mut text;
    put!(
        out,
        "//! The VLIW code: what issues in one cycle is one function.\n"
    );
    put!(out, "use super::border::{{Fault, Stop, divided}};");
    put!(out, "use super::issue::Issue;");
    put!(out, "use super::ops::{{self, V4}};");
    put!(out, "use super::sequencer::callee;\nuse super::state::*;\n");
    put!(
        out,
        "/// The entries of the functions, in the order of their addresses."
    );
    let entries: Vec<String> = spec.functions.iter().map(|(_, b)| b.to_string()).collect();
    put!(
        out,
        "const FUNCTIONS: [u32; {}] = [{}];\n",
        entries.len(),
        entries.join(", ")
    );
    put!(out, "/// The bundles, by number.");
    put!(
        out,
        "pub(crate) static BUNDLES: [Bundle; {}] = [",
        spec.bundles.len()
    );
    for chunk in (0..spec.bundles.len()).collect::<Vec<_>>().chunks(16) {
        let names = chunk
            .iter()
            .map(|&number| name(&spec.bundles[number], number));
        put!(out, "    {},", names.collect::<Vec<_>>().join(", "));
    }
    put!(out, "];\n");
    let operations = spec.bundles.iter().map(BundleSpec::operations);
    let operations: Vec<String> = operations.map(|count| count.to_string()).collect();
    put!(out, "/// The operations of each.");
    put!(
        out,
        "pub(crate) static OPERATIONS: [u16; {}] = [",
        operations.len()
    );
    for chunk in operations.chunks(32) {
        put!(out, "    {},", chunk.join(", "));
    }
    put!(
        out,
        "];\n\nfn nop(_: &mut Srp, _: &mut Issue, _: &mut Bus<'_>) -> Result<(), Stop> {{\n    Ok(())\n}}"
    );
    for (index, bundle) in spec.bundles.iter().enumerate() {
        for (function, _) in spec.functions.iter().filter(|(_, b)| *b as usize == index) {
            put!(out, "\n// {}", comment(function));
        }
        if !is_empty(bundle) {
            function(spec, out, index, bundle);
        }
    }
    text
}

fn is_empty(bundle: &BundleSpec) -> bool {
    bundle.steps.is_empty() && bundle.control.is_none()
}

fn name(bundle: &BundleSpec, number: usize) -> String {
    if is_empty(bundle) {
        "nop".to_owned()
    } else {
        format!("b{number}")
    }
}

fn function(spec: &SimSpec, out: &mut String, index: usize, bundle: &BundleSpec) {
    put!(
        out,
        "\nfn b{index}(srp: &mut Srp, issue: &mut Issue, bus: &mut Bus<'_>) -> Result<(), Stop> {{"
    );
    let (port, steps) = bundle.steps.split_at(usize::from(bundle.talks()));
    for step in port {
        put!(out, "    issue.meet_bus()?;");
        block(spec, out, std::slice::from_ref(step));
    }
    if let Some((control, at)) = &bundle.control {
        if let Control::Launch(kernel) = control {
            let name = comment(&spec.kernels[*kernel as usize].name);
            put!(out, "    // {name}");
        }
        let text = transfer(spec, control, *at);
        let place = spec.position(*at).map(|p| format!(" // {}", comment(p)));
        put!(out, "    {text}{}", place.unwrap_or_default());
        if matches!(control, Control::Unreachable | Control::StackOverflow) {
            put!(out, "}}");
            return;
        }
    }
    block(spec, out, steps);
    put!(out, "    Ok(())\n}}");
}

fn transfer(spec: &SimSpec, control: &Control, at: Position) -> String {
    let mut text = String::new();
    let out = &mut text;
    let word = |cell| read(spec, cell, Ty::Word);
    let written = match *control {
        Control::Jump(target) => write!(out, "issue.jump({target});"),
        Control::Branch {
            cond,
            sense,
            target,
        } => {
            let not = if sense { "" } else { "!" };
            let cond = read(spec, cond, Ty::Pred);
            write!(out, "if {not}{cond} {{ issue.jump({target}); }}")
        }
        Control::Call {
            target,
            link,
            back,
            latency,
        } => {
            let link = number(spec, link);
            write!(
                out,
                "issue.land({latency}, {link}, {back}); issue.call({target}, {at});"
            )
        }
        Control::CallReg {
            target,
            link,
            back,
            latency,
        } => {
            let (address, link) = (word(target), number(spec, link));
            write!(
                out,
                "issue.call(callee(&FUNCTIONS, super::FUNC_BASE, {address}, {at})?, {at}); \
                 issue.land({latency}, {link}, {back});"
            )
        }
        Control::Return(cell) => write!(out, "issue.give_back({});", word(cell)),
        Control::Launch(kernel) => write!(out, "issue.launch({kernel});"),
        Control::Halt(cell) => write!(out, "issue.halt({});", word(cell)),
        Control::Unreachable => write!(out, "Err(Fault::unreachable({at}).into())"),
        Control::StackOverflow => write!(out, "Err(Fault::stack_overflow({at}).into())"),
    };
    written.expect("a string takes all that is written");
    text
}
