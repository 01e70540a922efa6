//! A kernel: one function per context.

use super::expr::{block, operand, read, write};
use super::state::{field_type, zero};
use super::{comment, line};
use crate::spec::{Role, SimSpec, Store};
use srp_archdesc::isa::Ty;

/// The file of kernel `number`.
pub(super) fn emit(spec: &SimSpec, number: usize) -> String {
    let kernel = &spec.kernels[number];
    let mut text = String::new();
    let out = &mut text;
    let at = spec.position(kernel.at).unwrap_or("-");
    line(
        out,
        format_args!(
            "//! Kernel `{}`, II = {}.  {}\n",
            comment(&kernel.name),
            kernel.ii,
            comment(at)
        ),
    );
    line(out, format_args!("use super::border::{{Fault, divided}};"));
    line(
        out,
        format_args!("use super::ops::{{self, V4}};\nuse super::state::*;\n"),
    );
    flight(spec, out, number);
    line(
        out,
        format_args!("/// The registers that the kernel finds set; gives its trip count."),
    );
    line(
        out,
        format_args!("pub(crate) fn enter(srp: &mut Srp) -> u32 {{"),
    );
    for store in spec.stores.iter().filter(|s| s.role == Role::Rotating) {
        line(out, format_args!("    srp.{}.reset();", store.name));
    }
    line(
        out,
        format_args!("    let trip = {};", read(spec, kernel.trip, Ty::Word)),
    );
    for preset in &kernel.preloads {
        let value = operand(spec, preset.value, preset.ty);
        line(
            out,
            format_args!("    {}", write(spec, preset.cell, preset.ty, &value)),
        );
    }
    line(out, format_args!("    trip\n}}\n"));
    line(out, format_args!("/// An iteration begins."));
    line(out, format_args!("pub(crate) fn rotate(srp: &mut Srp) {{"));
    let used = kernel.stores();
    let used = used.iter().map(|&store| &spec.stores[store as usize]);
    for store in used.filter(|store| store.role == Role::Rotating) {
        line(out, format_args!("    srp.{}.rotate();", store.name));
    }
    line(out, format_args!("}}\n"));
    let names: Vec<String> = (0..kernel.contexts.len())
        .map(|c| context_name(kernel.ii, c))
        .collect();
    line(out, format_args!("/// The contexts, in order."));
    line(
        out,
        format_args!(
            "pub(crate) static CONTEXTS: [Context; {}] = [{}];",
            names.len(),
            names.join(", ")
        ),
    );
    for (steps, name) in kernel.contexts.iter().zip(&names) {
        line(
            out,
            format_args!(
                "\nfn {name}(srp: &mut Srp, bus: &mut Bus<'_>, stages: u64) -> Result<(), Box<Fault>> {{"
            ),
        );
        block(spec, out, steps);
        line(out, format_args!("    Ok(())\n}}"));
    }
    text
}

/// `slot_2`, or, where registers are renamed from iteration to iteration, `slot_2_of_1`.
fn context_name(ii: u32, context: usize) -> String {
    let (block, slot) = (context / ii as usize, context % ii as usize);
    match block {
        0 => format!("slot_{slot}"),
        _ => format!("slot_{slot}_of_{block}"),
    }
}

/// The structure of what is in flight.
fn flight(spec: &SimSpec, out: &mut String, number: usize) {
    let role = Role::Flight(number as u32);
    let stores: Vec<&Store> = spec.stores.iter().filter(|s| s.role == role).collect();
    line(out, format_args!("/// Results on their way, newest first."));
    line(out, format_args!("#[repr(C)]\npub(crate) struct Flight {{"));
    for store in &stores {
        line(
            out,
            format_args!("    pub(crate) {}: {},", store.name, field_type(store)),
        );
    }
    line(
        out,
        format_args!("}}\n\nimpl Flight {{\n    pub(crate) const fn new() -> Flight {{"),
    );
    line(out, format_args!("        Flight {{"));
    for store in &stores {
        line(
            out,
            format_args!("            {}: {},", store.name, zero(store)),
        );
    }
    line(out, format_args!("        }}\n    }}\n}}\n"));
}
