//! [`link`]: a scheduled program and a machine to the tables of a simulator.
//!
//! A schedule is data that anybody may have made, so everything is looked up with care here, and
//! nowhere later. What is checked is whether the machine *has* what the program names; whether the
//! schedule computes what the program means is the business of [`srp_ir::check`].

mod control;
mod flow;
mod kernel;
mod order;

use crate::spec::{Cell, Operand, Position, Role, SimSpec, Store};
use srp_archdesc::arch::{Arch, FileKind, Fu, RegFile};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::{Place, PlaceKind, ResourceGraph};
use srp_ir::dre::scheduled::{Reg, RegAt, ScheduledDre};
use srp_ir::layout::FIRST_ADDRESS;
use srp_ir::program::{Bits, Pos};
use std::collections::BTreeMap;

/// Why a scheduled program cannot run on a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkError {
    /// The place in the source, `file:line:column`, if it has one.
    pub at: Option<String>,
    /// The place in the schedule: a bundle, or an operation of a kernel.
    pub scope: String,
    /// What is wrong.
    pub message: String,
}

impl std::fmt::Display for LinkError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(at) = &self.at {
            write!(f, "{at}: ")?;
        }
        write!(f, "{}: {}", self.scope, self.message)
    }
}

impl std::error::Error for LinkError {}

/// Links `program` for `arch`.
///
/// # Errors
///
/// The first thing the program asks for that the machine does not have: an operation that the unit
/// does not run, a register out of range, a link that does not lead there, a value wider than its
/// register, more contexts than the configuration memory holds, and the like.
pub fn link(program: &ScheduledDre, arch: &Arch) -> Result<SimSpec, LinkError> {
    let mut linker = Linker::new(program, arch);
    let bundles = control::bundles(&mut linker)?;
    let kernels = program
        .kernels
        .keys()
        .map(|k| kernel::kernel(&mut linker, k))
        .collect::<Result<Vec<_>, _>>()?;
    let mut functions = Vec::new();
    for entry in &program.functions {
        let bundle = linker.bundle(entry.bundle, &format!("function `{}`", entry.name))?;
        functions.push((entry.name.clone(), bundle));
    }
    let start = linker.bundle(program.start, "the start")?;
    if program.image.len() as u64 > u64::from(arch.system.sram_bytes) {
        return Err(linker.error(
            "the initial data",
            Pos::nowhere(),
            format!(
                "{} bytes do not fit in an SRAM of {}",
                program.image.len(),
                arch.system.sram_bytes
            ),
        ));
    }
    Ok(SimSpec {
        machine: arch.name.clone(),
        cells: linker.cells,
        stores: linker.stores,
        precision: arch.precision,
        first_address: FIRST_ADDRESS,
        sram_bytes: arch.system.sram_bytes,
        image: program.image.clone(),
        branch_delay: arch.srp.branch_delay,
        max_latency: linker.max_latency,
        bundles,
        functions,
        start,
        kernels,
        positions: linker.positions,
    })
}

/// What both halves of the linker look things up in.
struct Linker<'a> {
    program: &'a ScheduledDre,
    arch: &'a Arch,
    graph: ResourceGraph,
    stores: Vec<Store>,
    cells: u32,
    positions: Vec<String>,
    numbers: BTreeMap<Pos, Position>,
    max_latency: u32,
}

impl<'a> Linker<'a> {
    fn new(program: &'a ScheduledDre, arch: &'a Arch) -> Linker<'a> {
        let graph = ResourceGraph::of(&arch.srp);
        let mut linker = Linker {
            program,
            arch,
            stores: Vec::new(),
            cells: 0,
            positions: vec![String::new()],
            numbers: BTreeMap::new(),
            max_latency: 1,
            graph,
        };
        // The stores of the machine are its places, with the same numbers.
        for place in linker.graph.places.keys().collect::<Vec<_>>() {
            let spec = linker.graph.places[place];
            let role = match spec.kind {
                PlaceKind::Out(_) | PlaceKind::PredOut(_) => Role::Output,
                PlaceKind::File(file) if arch.srp.files[file].kind == FileKind::Rotating => {
                    Role::Rotating
                }
                PlaceKind::File(_) => Role::File,
            };
            let name = linker.graph.name(&arch.srp, place);
            linker.add_store(name, narrowest(spec.width), spec.capacity, role);
        }
        linker
    }

    fn add_store(&mut self, name: String, ty: Ty, size: u32, role: Role) -> u32 {
        let mut name = identifier(&name);
        let kernel = |role| matches!(role, Role::Flight(_)).then_some(role);
        while self
            .stores
            .iter()
            .any(|s| s.name == name && kernel(s.role) == kernel(role))
        {
            name.push('_');
        }
        self.stores.push(Store {
            name,
            ty,
            size,
            base: self.cells,
            role,
        });
        self.cells += size;
        self.stores.len() as u32 - 1
    }

    fn position(&mut self, pos: Pos) -> Position {
        if pos.line == 0 {
            return 0;
        }
        let next = self.positions.len() as Position;
        let number = *self.numbers.entry(pos).or_insert(next);
        if number == next {
            let text = show(self.program, pos).unwrap_or_default();
            self.positions.push(text);
        }
        number
    }

    fn error(&self, scope: &str, pos: Pos, message: impl Into<String>) -> LinkError {
        LinkError {
            at: show(self.program, pos),
            scope: scope.to_owned(),
            message: message.into(),
        }
    }

    fn bundle(
        &self,
        bundle: srp_ir::dre::scheduled::Bundle,
        scope: &str,
    ) -> Result<u32, LinkError> {
        if bundle.index() >= self.program.bundles.len() {
            let message = format!("there is no bundle {bundle}");
            return Err(self.error(scope, Pos::nowhere(), message));
        }
        Ok(bundle.index() as u32)
    }

    fn place_cell(&self, place: Place, index: u32) -> Cell {
        Cell::new(place.index() as u32, index)
    }

    /// The register that `reg` names in the iteration `back` before the one begun last, in a file
    /// that holds values of type `ty`.
    fn register(&self, reg: RegAt, back: i64, ty: Ty, site: &Site) -> Result<Cell, LinkError> {
        let file = self.file(reg.file, ty, site)?;
        let spec = &self.arch.srp.files[file];
        let rotating = spec.kind == FileKind::Rotating;
        let last = if rotating {
            u64::from(reg.index)
        } else {
            u64::from(reg.index) + u64::from(reg.ring.max(1)) - 1
        };
        if last >= u64::from(spec.size) {
            let name = &spec.name;
            return Err(site.error(
                self,
                format!("{name}[{last}] is beyond its {} registers", spec.size),
            ));
        }
        let place = self.graph.file[file];
        if rotating || reg.ring == 1 {
            return Ok(self.place_cell(place, reg.physical(-back, rotating, spec.size)));
        }
        let phase = (-back).rem_euclid(i64::from(reg.ring.max(1)));
        Ok(Cell {
            ring: reg.ring.max(1),
            phase: u32::try_from(phase).expect("a remainder is smaller than its modulus"),
            ..self.place_cell(place, reg.index)
        })
    }

    /// A plain register that holds values of type `ty`.
    fn plain(&self, reg: Reg, ty: Ty, site: &Site) -> Result<Cell, LinkError> {
        let at = RegAt {
            file: reg.file,
            index: reg.index,
            ring: 1,
        };
        self.register(at, 0, ty, site)
    }

    fn file(&self, file: RegFile, ty: Ty, site: &Site) -> Result<RegFile, LinkError> {
        let Some(spec) = self.arch.srp.files.get(file) else {
            return Err(site.error(self, format!("there is no register file {file}")));
        };
        if !spec.holds(ty) {
            let message = format!(
                "a register of {} is too narrow for a {}",
                spec.name,
                name(ty)
            );
            return Err(site.error(self, message));
        }
        Ok(file)
    }

    /// Checks that `fu` can read registers of `file`.
    fn reads(&self, fu: Fu, file: RegFile, site: &Site) -> Result<(), LinkError> {
        let spec = self.arch.srp.files.get(file);
        if spec.is_some_and(|f| !f.readers.contains(&fu)) {
            return Err(site.error(self, self.apart(fu, file, "read")));
        }
        Ok(())
    }

    /// Checks that results of `fu` can be written into registers of `file`.
    fn writes(&self, fu: Fu, file: RegFile, site: &Site) -> Result<(), LinkError> {
        let spec = self.arch.srp.files.get(file);
        if spec.is_some_and(|f| !f.writers.contains(&fu)) {
            return Err(site.error(self, self.apart(fu, file, "write")));
        }
        Ok(())
    }

    fn apart(&self, fu: Fu, file: RegFile, verb: &str) -> String {
        let (unit, file) = (&self.arch.srp.fus[fu].name, &self.arch.srp.files[file].name);
        format!("unit {unit} cannot {verb} registers of {file}")
    }

    /// The latency of `op` on `fu`.
    fn latency(&self, fu: Fu, op: Opcode, site: &Site) -> Result<u32, LinkError> {
        let Some(spec) = self.arch.srp.fus.get(fu) else {
            return Err(site.error(self, format!("there is no unit {fu}")));
        };
        let Some(run) = spec.runs(op) else {
            let message = format!("unit {} does not run `{op}` ({})", spec.name, op.class());
            return Err(site.error(self, message));
        };
        Ok(run.latency.max(1))
    }

    /// Where results of type `ty` of `fu` stand.
    fn output_place(&self, fu: Fu, ty: Ty) -> Place {
        match ty {
            Ty::Pred => self.graph.pred_out[fu],
            Ty::Word | Ty::Vec => self.graph.out[fu],
        }
    }

    /// The output of `fu` for results of type `ty`.
    fn output(&self, fu: Fu, ty: Ty) -> Cell {
        self.place_cell(self.output_place(fu, ty), 0)
    }

    /// Checks that a cell holds values of type `ty`.
    fn holds(&self, cell: Cell, ty: Ty, site: &Site) -> Result<(), LinkError> {
        let store = &self.stores[cell.store as usize];
        if store.ty < ty {
            let message = format!("{} is too narrow for a {}", store.name, name(ty));
            return Err(site.error(self, message));
        }
        Ok(())
    }

    /// A constant operand of type `ty`.
    fn constant(&self, bits: Bits, ty: Ty, site: &Site) -> Result<Operand, LinkError> {
        if bits.ty() != ty {
            let message = format!("the constant {bits} is no {}", name(ty));
            return Err(site.error(self, message));
        }
        Ok(Operand::Const(bits))
    }
}

/// Where in the schedule something is, for messages.
struct Site {
    scope: String,
    pos: Pos,
}

impl Site {
    fn error(&self, linker: &Linker, message: impl Into<String>) -> LinkError {
        linker.error(&self.scope, self.pos, message)
    }
}

fn show(program: &ScheduledDre, pos: Pos) -> Option<String> {
    let file = program.files.get(pos.file)?;
    (pos.line > 0).then(|| format!("{file}:{}:{}", pos.line, pos.column))
}

/// The narrowest type whose cells hold values of `width` bits.
fn narrowest(width: u32) -> Ty {
    match width {
        0..=1 => Ty::Pred,
        2..=32 => Ty::Word,
        _ => Ty::Vec,
    }
}

fn name(ty: Ty) -> &'static str {
    match ty {
        Ty::Pred => "predicate",
        Ty::Word => "word",
        Ty::Vec => "vector",
    }
}

/// `name` as an identifier of Rust: lower case, and in no keyword's way.
pub(crate) fn identifier(name: &str) -> String {
    let mut text: String = name
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '_'
            }
        })
        .collect();
    if !text.starts_with(|c: char| c.is_ascii_lowercase() || c == '_') {
        text.insert(0, '_');
    }
    if KEYWORDS.contains(&text.as_str()) {
        text.push('_');
    }
    text
}

/// Words that no field may be called.
const KEYWORDS: &[&str] = &[
    "_", "abstract", "as", "async", "await", "become", "box", "break", "const", "continue",
    "crate", "do", "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if",
    "impl", "in", "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub",
    "ref", "return", "self", "static", "struct", "super", "trait", "true", "try", "type", "typeof",
    "union", "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];
