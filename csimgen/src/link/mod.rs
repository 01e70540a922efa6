//! [`link`]: a checked program, with its machine, to the tables of a simulator.
//!
//! The checker has seen that the machine *has* everything that the program names, that values fit where
//! they go, and that the schedule keeps the rules of time. So everything is simply looked up here.

mod control;
mod flow;
mod kernel;
mod order;

use crate::preamble::border::{Banks, MAX_BANKS};
use crate::spec::{Cell, MAX_STAGES, Position, Role, SimSpec, Store};
use srp_archdesc::arch::{Arch, FileKind, Fu};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::{Place, PlaceKind, ResourceGraph};
use srp_archdesc::system::MAX_SRAM_BANKS;
use srp_ir::check::Checked;
use srp_ir::dre::scheduled::{FunctionEntry, Reg, RegAt, ScheduledDre};
use srp_ir::layout::FIRST_ADDRESS;
use srp_ir::program::Pos;
use std::collections::BTreeMap;

// Simulators have room for the banks of every machine.
const _: () = assert!(MAX_SRAM_BANKS as usize <= MAX_BANKS);

/// A kernel that the machine could run, but that simulators have no room for: too many of its
/// iterations overlap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TooManyStages {
    /// The loop's place in the source, `file:line:column`, if it has one.
    pub at: Option<String>,
    /// The kernel's name.
    pub kernel: String,
    /// Its stages, which are more than [`MAX_STAGES`].
    pub stages: u32,
}

impl std::fmt::Display for TooManyStages {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let TooManyStages { at, kernel, stages } = self;
        if let Some(at) = at {
            write!(f, "{at}: ")?;
        }
        write!(
            f,
            "{stages} iterations of kernel `{kernel}` overlap; simulators have room for {MAX_STAGES}"
        )
    }
}

impl std::error::Error for TooManyStages {}

/// Links `program` for the machine that it was checked for.
///
/// # Errors
///
/// The first kernel with more than [`MAX_STAGES`] stages.
pub fn link(program: &Checked) -> Result<SimSpec, TooManyStages> {
    if let Some(kernel) = program.kernels.values().find(|k| k.stages() > MAX_STAGES) {
        return Err(TooManyStages {
            at: show(program, kernel.dfg.pos),
            kernel: kernel.dfg.name.clone(),
            stages: kernel.stages(),
        });
    }
    let arch = program.arch();
    let mut linker = Linker::new(program, arch);
    let bundles = control::bundles(&mut linker);
    let kernels = program.kernels.keys();
    let kernels = kernels.map(|k| kernel::kernel(&mut linker, k)).collect();
    let entries = program.functions.iter();
    let entry = |e: &FunctionEntry| (e.name.clone(), e.bundle.index() as u32);
    Ok(SimSpec {
        machine: arch.name.clone(),
        cells: linker.cells,
        stores: linker.stores,
        precision: arch.precision,
        first_address: FIRST_ADDRESS,
        banks: (arch.system.sram_banks).map_or(Banks::default(), |banks| Banks {
            count: banks.count,
            width: banks.width,
        }),
        sram_bytes: arch.system.sram_bytes,
        image: program.image.clone(),
        branch_delay: arch.srp.branch_delay,
        max_latency: linker.max_latency,
        bundles,
        functions: entries.map(entry).collect(),
        start: program.start.index() as u32,
        kernels,
        positions: linker.positions,
    })
}

/// The tables in which both halves of the linker look things up.
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
        // The stores of the machine are its places, with the same numbers. Wires, which come last, keep nothing.
        for place in linker.graph.places.keys().collect::<Vec<_>>() {
            let spec = linker.graph.places[place];
            let role = match spec.kind {
                PlaceKind::Out(_) | PlaceKind::PredOut(_) => Role::Output,
                PlaceKind::File(file) if arch.srp.files[file].kind == FileKind::Rotating => {
                    Role::Rotating
                }
                PlaceKind::File(_) => Role::File,
                PlaceKind::Wire { .. } => continue,
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

    fn place_cell(&self, place: Place, index: u32) -> Cell {
        Cell::new(place.index() as u32, index)
    }

    /// The register that `reg` names in the iteration `back` before the one begun last.
    fn register(&self, reg: RegAt, back: i64) -> Cell {
        let spec = &self.arch.srp.files[reg.file];
        let rotating = spec.kind == FileKind::Rotating;
        let place = self.graph.file[reg.file];
        if rotating || reg.ring == 1 {
            return self.place_cell(place, reg.physical(-back, rotating, spec.size));
        }
        let phase = (-back).rem_euclid(i64::from(reg.ring));
        Cell {
            ring: reg.ring,
            phase: u32::try_from(phase).expect("a remainder is smaller than its modulus"),
            ..self.place_cell(place, reg.index)
        }
    }

    /// A register that has the same name in every iteration.
    fn plain(&self, reg: Reg) -> Cell {
        self.place_cell(self.graph.file[reg.file], reg.index)
    }

    /// The latency of `op` on `fu`.
    fn latency(&self, fu: Fu, op: Opcode) -> u32 {
        let run = self.arch.srp.fus[fu].timing(op);
        run.expect("units were checked to run their operations")
            .latency
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

/// Letters of an [`identifier`] at most: it becomes a file's name, too.
const LONGEST_NAME: usize = 80;

/// `name` as an identifier of Rust: lower case, not long, and in no keyword's way.
pub(crate) fn identifier(name: &str) -> String {
    let mut text: String = name
        .chars()
        .take(LONGEST_NAME)
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
