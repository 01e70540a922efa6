//! A kernel: one function per context.

use super::comment;
use super::expr::{block, operand, read, write};
use super::state::{field_type, saved, zero};
use crate::spec::{KernelSpec, Role, SimSpec, Step, Store};
use srp_archdesc::isa::Ty;

/// The file of kernel `number`.
pub(super) fn emit(spec: &SimSpec, number: usize) -> String {
    let kernel = &spec.kernels[number];
    let mut text = String::new();
    let out = &mut text;
    let at = spec.position(kernel.at).unwrap_or("-");
    put!(
        out,
        "//! Kernel `{}`, II = {}.  {}\n",
        comment(&kernel.name),
        kernel.ii,
        comment(at)
    );
    put!(out, "use super::border::{{Fault, divided}};");
    put!(
        out,
        "use super::ops::{{self, V4}};\nuse super::saved::{{Saved, Words}};"
    );
    put!(out, "use super::state::*;\n");
    flight(spec, out, number);
    enter(spec, out, kernel);
    rotate(spec, out, kernel);
    let slots: Vec<String> = (0..kernel.ii).map(|slot| format!("slot_{slot}")).collect();
    let list = slots.join(", ");
    put!(
        out,
        "/// The steps of each cycle between the beginnings of two iterations."
    );
    put!(
        out,
        "pub(crate) static CONTEXTS: [Context; {}] = [{list}];",
        slots.len()
    );
    for (steps, slot) in kernel.contexts.iter().zip(&slots) {
        let arguments = "srp: &mut Srp, bus: &mut Bus<'_>, stages: u64";
        put!(out, "\nfn {slot}({arguments}) -> Result<(), Box<Fault>> {{");
        if has_rings(steps) {
            put!(out, "    let n = srp.iteration;");
        }
        block(spec, out, steps);
        put!(out, "    Ok(())\n}}");
    }
    text
}

fn has_rings(steps: &[Step]) -> bool {
    let mut cells = steps
        .iter()
        .flat_map(|s| s.reads().chain(s.dests.iter().copied()));
    cells.any(|cell| cell.ring > 1)
}

/// The function that sets the registers of a kernel.
fn enter(spec: &SimSpec, out: &mut String, kernel: &KernelSpec) {
    put!(
        out,
        "/// The registers that the kernel finds set; gives its trip count."
    );
    put!(out, "pub(crate) fn enter(srp: &mut Srp) -> u32 {{");
    put!(out, "    srp.iteration = 0;");
    for store in spec.stores.iter().filter(|s| s.role == Role::Rotating) {
        put!(out, "    srp.{}.reset();", store.name);
    }
    let trip = read(spec, kernel.trip, Ty::Word);
    put!(out, "    let trip = {trip};");
    for preset in &kernel.preloads {
        let value = operand(spec, preset.value, preset.ty);
        let statement = write(spec, preset.cell, preset.ty, &value);
        put!(out, "    {statement}");
    }
    put!(out, "    trip\n}}\n");
}

/// The function that makes rotating files and rings follow the iterations.
fn rotate(spec: &SimSpec, out: &mut String, kernel: &KernelSpec) {
    put!(out, "/// An iteration begins.");
    put!(out, "pub(crate) fn rotate(srp: &mut Srp) {{");
    put!(out, "    srp.iteration += 1;");
    let used = kernel.stores();
    let used = used.iter().map(|&store| &spec.stores[store as usize]);
    for store in used.filter(|store| store.role == Role::Rotating) {
        put!(out, "    srp.{}.rotate();", store.name);
    }
    put!(out, "}}\n");
}

/// The structure of the results in flight.
fn flight(spec: &SimSpec, out: &mut String, number: usize) {
    let role = Role::Flight(number as u32);
    let stores: Vec<&Store> = spec.stores.iter().filter(|s| s.role == role).collect();
    put!(out, "/// Results on their way, newest first.");
    put!(out, "#[repr(C)]\npub(crate) struct Flight {{");
    for store in &stores {
        put!(out, "    pub(crate) {}: {},", store.name, field_type(store));
    }
    put!(
        out,
        "}}\n\nimpl Flight {{\n    pub(crate) const fn new() -> Flight {{"
    );
    put!(out, "        Flight {{");
    for store in &stores {
        put!(out, "            {}: {},", store.name, zero(store));
    }
    put!(out, "        }}\n    }}\n}}\n");
    let fields: Vec<String> = stores.iter().map(|store| store.name.clone()).collect();
    saved(out, "Flight", &fields);
    put!(out, "");
}
