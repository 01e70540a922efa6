//! The VLIW code: one function per bundle.

use super::expr::{block, number, read};
use super::{comment, line};
use crate::spec::{BundleSpec, Control, Position, SimSpec};
use srp_archdesc::isa::Ty;
use std::fmt::Write;

/// `control.rs`.
pub(super) fn emit(spec: &SimSpec) -> String {
    let mut text = String::new();
    let out = &mut text;
    line(
        out,
        format_args!("//! The VLIW code: what issues in one cycle is one function.\n"),
    );
    line(
        out,
        format_args!("use super::border::{{Fault, Stop, divided}};"),
    );
    line(out, format_args!("use super::ops::{{self, V4}};"));
    line(
        out,
        format_args!("use super::sequencer::{{Issue, callee}};\nuse super::state::*;\n"),
    );
    line(
        out,
        format_args!("/// The entries of the functions, in the order of their addresses."),
    );
    let entries: Vec<String> = spec.functions.iter().map(|(_, b)| b.to_string()).collect();
    line(
        out,
        format_args!(
            "const FUNCTIONS: [u32; {}] = [{}];\n",
            entries.len(),
            entries.join(", ")
        ),
    );
    line(out, format_args!("/// The bundles, by number."));
    line(
        out,
        format_args!(
            "pub(crate) static BUNDLES: [Bundle; {}] = [",
            spec.bundles.len()
        ),
    );
    for chunk in (0..spec.bundles.len()).collect::<Vec<_>>().chunks(16) {
        let names = chunk
            .iter()
            .map(|&number| name(&spec.bundles[number], number));
        line(
            out,
            format_args!("    {},", names.collect::<Vec<_>>().join(", ")),
        );
    }
    line(
        out,
        format_args!(
            "];\n\nfn nop(_: &mut Srp, _: &mut Issue, _: &mut Bus<'_>) -> Result<(), Stop> {{\n    Ok(())\n}}"
        ),
    );
    for (index, bundle) in spec.bundles.iter().enumerate() {
        for (function, _) in spec.functions.iter().filter(|(_, b)| *b as usize == index) {
            line(out, format_args!("\n// {}", comment(function)));
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
    line(
        out,
        format_args!(
            "\nfn b{index}(srp: &mut Srp, issue: &mut Issue, bus: &mut Bus<'_>) -> Result<(), Stop> {{"
        ),
    );
    let (port, steps) = bundle.steps.split_at(usize::from(bundle.talks()));
    for step in port {
        line(out, format_args!("    issue.meet_bus()?;"));
        block(spec, out, std::slice::from_ref(step));
    }
    if let Some((control, at)) = &bundle.control {
        if let Control::Launch(kernel) = control {
            let name = comment(&spec.kernels[*kernel as usize].name);
            line(out, format_args!("    // {name}"));
        }
        let text = transfer(spec, control, *at);
        let place = spec.position(*at).map(|p| format!(" // {}", comment(p)));
        line(out, format_args!("    {text}{}", place.unwrap_or_default()));
        if matches!(control, Control::Unreachable | Control::StackOverflow) {
            line(out, format_args!("}}"));
            return;
        }
    }
    block(spec, out, steps);
    line(out, format_args!("    Ok(())\n}}"));
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
                "issue.land({latency}, {link}, {back}); issue.jump({target});"
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
                "issue.jump(callee(&FUNCTIONS, super::FUNC_BASE, {address}, {at})?); \
                 issue.land({latency}, {link}, {back});"
            )
        }
        Control::Return(cell) => write!(out, "issue.jump({});", word(cell)),
        Control::Launch(kernel) => write!(out, "issue.launch({kernel});"),
        Control::Halt(cell) => write!(out, "issue.halt({});", word(cell)),
        Control::Unreachable => write!(out, "Err(Fault::unreachable({at}).into())"),
        Control::StackOverflow => write!(out, "Err(Fault::stack_overflow({at}).into())"),
    };
    written.expect("a string takes all that is written");
    text
}
