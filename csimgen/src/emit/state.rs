//! The structure of a machine's registers.

use super::{comment, kernel_module};
use crate::spec::{Role, SimSpec, Store};
use srp_archdesc::isa::Ty;

/// `state.rs`.
pub(super) fn emit(spec: &SimSpec) -> String {
    let mut text = String::new();
    let out = &mut text;
    put!(
        out,
        "//! The registers of machine `{}`, by the machine's own names.\n",
        comment(&spec.machine)
    );
    put!(
        out,
        "use super::abi::HostBus;\nuse super::border::{{Border, Fault, Stop}};"
    );
    put!(
        out,
        "use super::issue::Issue;\nuse super::ops::V4;\nuse super::registers::Rotating;\nuse super::saved::{{Saved, Words}};\n"
    );
    put!(out, "/// The world as a bundle or a context sees it.");
    put!(out, "pub(crate) type Bus<'a> = Border<'a, HostBus>;");
    put!(out, "/// A bundle.");
    put!(
        out,
        "pub(crate) type Bundle = fn(&mut Srp, &mut Issue, &mut Bus<'_>) -> Result<(), Stop>;"
    );
    put!(out, "/// One cycle of a kernel.");
    put!(
        out,
        "pub(crate) type Context = fn(&mut Srp, &mut Bus<'_>, u64) -> Result<(), Box<Fault>>;\n"
    );
    let files = || spec.stores.iter().filter(|s| s.role == Role::File);
    put!(
        out,
        "// The first register of each plain file, among all registers."
    );
    for store in files() {
        put!(
            out,
            "pub(crate) const {}: u32 = {};",
            constant(store),
            store.base
        );
    }
    put!(
        out,
        "\n/// All registers, and what is in flight in kernels."
    );
    put!(out, "#[repr(C)]\npub(crate) struct Srp {{");
    for store in machine(spec) {
        put!(out, "    pub(crate) {}: {},", store.name, field_type(store));
    }
    for number in 0..spec.kernels.len() {
        let module = kernel_module(spec, number);
        put!(out, "    pub(crate) {module}: super::{module}::Flight,");
    }
    put!(
        out,
        "    /// The iteration of a kernel that has begun last."
    );
    put!(out, "    pub(crate) iteration: usize,");
    put!(out, "}}\n\nimpl Srp {{");
    put!(out, "    /// All of it zero.");
    put!(out, "    pub(crate) fn new() -> Srp {{\n        Srp {{");
    for store in machine(spec) {
        put!(out, "            {}: {},", store.name, zero(store));
    }
    for number in 0..spec.kernels.len() {
        let module = kernel_module(spec, number);
        put!(out, "            {module}: super::{module}::Flight::new(),");
    }
    put!(out, "            iteration: 0,");
    put!(out, "        }}\n    }}\n");
    writer(out, "write_word", "u32", files());
    writer(
        out,
        "write_lanes",
        "V4",
        files().filter(|s| s.ty == Ty::Vec),
    );
    put!(out, "}}\n");
    let kernels = (0..spec.kernels.len()).map(|number| kernel_module(spec, number));
    let fields = machine(spec).map(|store| store.name.clone()).chain(kernels);
    saved(out, "Srp", &fields.collect::<Vec<_>>());
    text
}

/// Writes the code that saves and restores a structure, field by field.
pub(super) fn saved(out: &mut String, name: &str, fields: &[String]) {
    put!(out, "impl Saved for {name} {{");
    put!(out, "    fn save(&self, out: &mut Vec<u32>) {{");
    for field in fields {
        put!(out, "        self.{field}.save(out);");
    }
    put!(out, "    }}\n");
    put!(
        out,
        "    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {{"
    );
    for field in fields {
        put!(out, "        self.{field}.restore(words)?;");
    }
    put!(out, "        Some(())\n    }}\n}}");
}

/// A function that writes a register by its number.
fn writer<'a>(out: &mut String, name: &str, ty: &str, stores: impl Iterator<Item = &'a Store>) {
    put!(
        out,
        "    pub(crate) fn {name}(&mut self, register: u32, value: {ty}) {{"
    );
    put!(out, "        match register {{");
    for store in stores {
        let (first, end) = (store.base, store.base + store.size);
        let place = format!("self.{}[(register - {first}) as usize]", store.name);
        let statement = match (store.ty, ty) {
            (Ty::Pred, _) => format!("{place} = value != 0"),
            (Ty::Word, _) | (Ty::Vec, "V4") => format!("{place} = value"),
            (Ty::Vec, _) => format!("{place}.0[0] = value"),
        };
        put!(out, "            {first}..{end} => {statement},");
    }
    put!(
        out,
        "            _ => unreachable!(\"VLIW code writes plain files only\"),"
    );
    put!(out, "        }}\n    }}");
}

/// The stores that are not a kernel's.
fn machine(spec: &SimSpec) -> impl Iterator<Item = &Store> {
    spec.stores
        .iter()
        .filter(|s| !matches!(s.role, Role::Flight(_)))
}

/// The constant with the number of a file's first register.
pub(super) fn constant(store: &Store) -> String {
    store.name.to_ascii_uppercase()
}

fn cell_type(ty: Ty) -> &'static str {
    match ty {
        Ty::Pred => "bool",
        Ty::Word => "u32",
        Ty::Vec => "V4",
    }
}

/// The type of a store's field.
pub(super) fn field_type(store: &Store) -> String {
    let cell = cell_type(store.ty);
    match store.role {
        Role::Rotating => format!("Rotating<{cell}, {}>", store.size),
        _ if is_single(store) => cell.to_owned(),
        _ => format!("[{cell}; {}]", store.size),
    }
}

/// True if a store's field is its only cell.
pub(super) fn is_single(store: &Store) -> bool {
    store.size == 1 && matches!(store.role, Role::Output | Role::Flight(_))
}

/// The initial value of a store's field.
pub(super) fn zero(store: &Store) -> String {
    let cell = match store.ty {
        Ty::Pred => "false",
        Ty::Word => "0",
        Ty::Vec => "V4([0; 4])",
    };
    match store.role {
        Role::Rotating => "Rotating::default()".to_owned(),
        _ if is_single(store) => cell.to_owned(),
        _ => format!("[{cell}; {}]", store.size),
    }
}
