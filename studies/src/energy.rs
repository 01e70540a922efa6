//! Where the energy of a frame goes: the counts of the units, times the energy of each event.
//!
//! The schedule of a kernel gives the work of an iteration: its operations, and the places that they take operands
//! from and write to. The counters give the operations, and with them the iterations, and the cycles, each of which
//! reads a context. For control code they know operations and bundles: each is charged with the mean of the program's.
//! Prices are those of [`srp_archdesc::cost`] at 65 nm; they leave out the clock tree and the leakage of logic.

use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::ResourceGraph;
use srp_archdesc::arch::{Arch, Carrier, RegFile, Wire};
use srp_archdesc::area::{cache_energy, operations_energy, triangle_energy};
use srp_archdesc::chip;
use srp_archdesc::cost::Technology;
use srp_archdesc::datapath::BOX_TEST;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Space, Ty};
use srp_archdesc::structure::Special;
use srp_archdesc::system::CacheSpec;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::{BundleData, ModuloSchedule, ScheduledDre, Source, Src};
use srp_ir::program::Pos;
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::system::Report;
use std::collections::BTreeMap;

/// Energy of a bit to or from system memory, pJ: 100 mW for a GB/s, Arm's rule for mobile memories.
const MEMORY_BIT_PJ: f64 = 12.5;

/// Millimetres of a bus between cores and memory.
const BUS_MM: f64 = 5.0;

/// Energy of a bit that a pipeline of the T&I unit hands on, pJ: a register's clock and its data.
const PIPELINE_BIT_PJ: f64 = 0.004;

/// Leakage of memories, W a byte: 6.2 mW for 240 KB of CACTI's LOP cells.
const LEAKAGE: f64 = 6.2e-3 / (240.0 * 1024.0);

/// Parts of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// Adders, multipliers, and what else operations on the array compute with.
    ArrayOperators,
    /// Special functions and divisions on the array.
    ArraySpecial,
    /// Register files that kernels read and write.
    ArrayRegisters,
    /// Operand multiplexers, output registers, links, switches and buses.
    ArrayLinks,
    /// Contexts of kernels.
    Configuration,
    /// Control code: operations, registers, bundles.
    Vliw,
    /// SRAM of the cores.
    Sram,
    /// Data caches.
    DataCache,
    /// Texture caches.
    TextureCache,
    /// Instruction caches.
    InstructionCache,
    /// Ray–box tests.
    BoxTests,
    /// Ray–triangle tests.
    TriangleTests,
    /// Caches of the T&I units.
    TniCaches,
    /// Rays in the pipelines of the T&I units.
    TniPipelines,
    /// The bus.
    Bus,
    /// System memory.
    Memory,
    /// Leakage of SRAM and caches.
    Leakage,
}

impl Part {
    /// Its name in listings.
    pub const fn name(self) -> &'static str {
        match self {
            Part::ArrayOperators => "array: operators",
            Part::ArraySpecial => "array: special functions",
            Part::ArrayRegisters => "array: register files",
            Part::ArrayLinks => "array: multiplexers, links",
            Part::Configuration => "configuration memory",
            Part::Vliw => "VLIW",
            Part::Sram => "SRAM",
            Part::DataCache => "data cache",
            Part::TextureCache => "texture cache",
            Part::InstructionCache => "instruction cache",
            Part::BoxTests => "T&I: box tests",
            Part::TriangleTests => "T&I: triangle tests",
            Part::TniCaches => "T&I: caches",
            Part::TniPipelines => "T&I: rays in pipelines",
            Part::Bus => "bus",
            Part::Memory => "system memory",
            Part::Leakage => "leakage of memories",
        }
    }
}

/// Energy of one part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Share {
    /// The part.
    pub part: Part,
    /// mJ at 65 nm.
    pub mj: f64,
}

/// Energy of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Energy {
    /// By part, of all cores together.
    pub parts: Vec<Share>,
    /// mJ at 65 nm, all parts.
    pub total_mj: f64,
    /// mJ of all but system memory, at each technology that is known.
    pub chip_mj: Vec<(Technology, f64)>,
    /// pJ for each ray that was traced, all parts at 65 nm.
    pub pj_per_ray: f64,
    /// Mean power, W at 65 nm.
    pub watts: f64,
}

impl Energy {
    /// The energy of a part, mJ.
    pub fn of_part(&self, part: Part) -> f64 {
        let share = self.parts.iter().find(|share| share.part == part);
        share.map_or(0.0, |share| share.mj)
    }
}

/// Energy of one iteration of a kernel, or of one bundle; pJ.
#[derive(Clone, Copy, Default)]
struct Activity {
    operators: f64,
    special: f64,
    registers: f64,
    links: f64,
    contexts: f64,
    sram: f64,
}

impl Activity {
    fn add(&mut self, other: Activity, times: f64) {
        self.operators += other.operators * times;
        self.special += other.special * times;
        self.registers += other.registers * times;
        self.links += other.links * times;
        self.contexts += other.contexts * times;
        self.sram += other.sram * times;
    }

    fn total(&self) -> f64 {
        self.operators + self.special + self.registers + self.links + self.contexts + self.sram
    }

    fn operation(&mut self, op: Opcode, prices: &Prices<'_>) {
        let energy = prices.operations[op as usize];
        match Special::of(op) {
            Some(_) => self.special += energy,
            None => self.operators += energy,
        }
        if op.space() == Some(Space::Sram) {
            self.sram += chip::sram_energy(prices.arch, op.access_bytes().unwrap_or(4));
        }
    }
}

/// Energies of events on a machine.
struct Prices<'a> {
    arch: &'a Arch,
    graph: ResourceGraph,
    operations: Vec<f64>,
    contexts: f64,
    /// The context of a bundle: of all slots together.
    bundle_context: f64,
    /// The inputs of each wire's multiplexer.
    inputs: EntityMap<Wire, (u32, u32)>,
}

impl Prices<'_> {
    fn of(arch: &Arch) -> Prices<'_> {
        let energy = |&op: &Opcode| chip::operation_energy(op, arch);
        let graph = ResourceGraph::of(&arch.srp);
        let slots = arch.srp.slots();
        let bits = chip::context_bits(&arch.srp, &graph);
        let bundle_context = chip::context_energy(slots.iter().map(|&fu| bits[fu]).sum());
        let contexts = chip::context_energy(chip::all_context_bits(&arch.srp, &graph));
        Prices {
            arch,
            inputs: chip::wire_inputs(&arch.srp, &graph),
            graph,
            operations: Opcode::ALL.iter().map(energy).collect(),
            contexts,
            bundle_context,
        }
    }

    fn register(&self, file: RegFile) -> f64 {
        chip::register_energy(&self.arch.srp.files[file])
    }

    /// One iteration of a kernel.
    fn iteration(&self, kernel: &ModuloSchedule) -> Activity {
        let mut sum = Activity::default();
        let nodes = self.nodes(kernel);
        nodes.values().for_each(|&node| sum.add(node, 1.0));
        sum
    }

    /// One iteration of a kernel by node: its operation with the moves, registers and links that its operands and its
    /// value take. Operations and moves have even parts of the contexts.
    fn nodes(&self, kernel: &ModuloSchedule) -> EntityMap<Node, Activity> {
        let srp = &self.arch.srp;
        let contexts = self.contexts * f64::from(kernel.ii) / kernel.ops.len().max(1) as f64;
        let mut nodes: EntityMap<Node, Activity> = kernel
            .dfg
            .nodes
            .keys()
            .map(|_| Activity::default())
            .collect();
        for placed in kernel.ops.values() {
            let node = kernel.dfg.nodes[placed.node].op;
            let sum = &mut nodes[placed.node];
            sum.contexts += contexts;
            let op = match node.result() {
                Some(ty) if placed.is_move => Opcode::mov(ty),
                _ => node,
            };
            sum.operation(op, self);
            let places = self.graph.reads[placed.fu].len();
            for (source, kind) in placed.operands.iter().zip(op.info().operands) {
                let bits = kind.ty().bits();
                sum.links += chip::multiplexer_energy(bits, places);
                match *source {
                    Source::Reg { reg, .. } => sum.registers += self.register(reg.file),
                    Source::Out(Some(link)) => {
                        sum.links += chip::link_energy(srp, &srp.links[link], bits);
                    }
                    // A wire swings once for all that read it.
                    Source::Out(None) | Source::Wire(_) | Source::Const(_) => {}
                }
            }
            let result = op.result().map_or(0, Ty::bits);
            sum.links += PIPELINE_BIT_PJ * f64::from(result);
            let written = placed.writes.iter().map(|at| self.register(at.file));
            sum.registers += written.sum::<f64>();
        }
        for transfer in &kernel.transfers {
            let sum = &mut nodes[transfer.node];
            let bits = kernel.dfg.ty(transfer.node).map_or(0, Ty::bits);
            if let Carrier::Link(link) = transfer.over {
                sum.links += chip::link_energy(srp, &srp.links[link], bits);
            }
            sum.registers += self.register(transfer.to.file);
        }
        for hop in &kernel.hops {
            let bits = kernel.dfg.ty(hop.node).map_or(0, Ty::bits);
            let (inputs, _) = self.inputs[hop.wire];
            nodes[hop.node].links += chip::wire_energy(srp, hop.wire, inputs, bits);
        }
        nodes
    }

    /// One bundle of control code.
    fn bundle(&self, bundle: &BundleData) -> Activity {
        let mut sum = Activity {
            contexts: self.bundle_context,
            ..Activity::default()
        };
        for op in &bundle.ops {
            sum.operation(op.op, self);
            for src in &op.srcs {
                if let Src::Reg(reg) = src {
                    sum.registers += self.register(reg.file);
                }
            }
            sum.registers += op.dst.map_or(0.0, |reg| self.register(reg.file));
        }
        sum
    }
}

/// The energy of a frame of this program on this machine.
pub fn energy(report: &Report, program: &ScheduledDre, arch: &Arch) -> Energy {
    let prices = Prices::of(arch);
    let mut kernels = Activity::default();
    for kernel in program.kernels.values() {
        kernels.add(of_kernel(kernel, report, &prices), 1.0);
    }
    let control = of_control(report, program, &prices);
    let mut parts = vec![
        (Part::ArrayOperators, kernels.operators),
        (Part::ArraySpecial, kernels.special),
        (Part::ArrayRegisters, kernels.registers),
        (Part::ArrayLinks, kernels.links),
        (Part::Configuration, kernels.contexts),
        (
            Part::Vliw,
            control.operators + control.special + control.registers + control.contexts,
        ),
        (Part::Sram, kernels.sram + control.sram),
    ];
    parts.extend(counted(report, arch));
    let parts: Vec<Share> = (parts.into_iter())
        .map(|(part, pj)| Share {
            part,
            mj: pj * 1e-9,
        })
        .collect();
    let total_mj: f64 = parts.iter().map(|share| share.mj).sum();
    let outside: f64 = (parts.iter().filter(|share| share.part == Part::Memory))
        .map(|share| share.mj)
        .sum();
    let chip = |t: Technology| (t, (total_mj - outside) * t.energy);
    Energy {
        parts,
        total_mj,
        chip_mj: Technology::ALL.map(chip).to_vec(),
        pj_per_ray: 1e9 * total_mj / report.rays.max(1) as f64,
        watts: match report.milliseconds > 0.0 {
            true => total_mj / report.milliseconds,
            false => 0.0,
        },
    }
}

/// The energy of all that the array did for a kernel.
fn of_kernel(kernel: &ModuloSchedule, report: &Report, prices: &Prices<'_>) -> Activity {
    Turns::of(kernel, report).times(prices.iteration(kernel))
}

/// How often a part of a program had its turn.
struct Turns {
    /// Its operations.
    work: f64,
    /// The contexts or bundles that were read for it.
    contexts: f64,
}

impl Turns {
    /// Of the iterations of a kernel. Prologues and epilogues read contexts, and have less work.
    fn of(kernel: &ModuloSchedule, report: &Report) -> Turns {
        let runs = report.cores.iter().flat_map(|core| &core.array);
        let runs = runs.filter(|run| run.kernel == kernel.dfg.name);
        let (cycles, operations) = runs.fold((0, 0), |(cycles, operations), run| {
            (cycles + run.cycles, operations + run.operations)
        });
        Turns {
            work: operations as f64 / kernel.dfg.nodes.len().max(1) as f64,
            contexts: cycles as f64 / f64::from(kernel.ii),
        }
    }

    /// Of all bundles of control code.
    fn of_bundles(report: &Report, program: &ScheduledDre) -> Turns {
        let operations =
            |bundle: &BundleData| bundle.ops.len() + usize::from(bundle.control.is_some());
        let all: usize = program.bundles.values().map(operations).sum();
        let (bundles, issued) = report.cores.iter().fold((0, 0), |(bundles, issued), core| {
            (bundles + core.vliw, issued + core.vliw_operations)
        });
        Turns {
            work: issued as f64 / all.max(1) as f64,
            contexts: bundles as f64 / program.bundles.len().max(1) as f64,
        }
    }

    /// The energy of all turns of what takes this in one.
    fn times(&self, one: Activity) -> Activity {
        let mut all = Activity::default();
        all.add(one, self.work);
        all.contexts = one.contexts * self.contexts;
        all
    }
}

/// The energy of control code.
fn of_control(report: &Report, program: &ScheduledDre, prices: &Prices<'_>) -> Activity {
    let mut once = Activity::default();
    for bundle in program.bundles.values() {
        once.add(prices.bundle(bundle), 1.0);
    }
    Turns::of_bundles(report, program).times(once)
}

/// The energy that a frame takes for something, mJ at 65 nm.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Use {
    /// A loop on the array, an object in system memory, or a part of the machine.
    pub of: String,
    /// mJ at 65 nm.
    pub mj: f64,
}

/// The energy of a frame by what took it: loops on the array and control code, each with the SRAM that it reads and
/// writes, and parts of the machine. Memory and bus are left out, as [`moved`] has their energy for any bytes.
pub fn uses(report: &Report, program: &ScheduledDre, arch: &Arch) -> Vec<Use> {
    let prices = Prices::of(arch);
    let kernels = program.kernels.values().map(|kernel| {
        let energy = of_kernel(kernel, report, &prices).total();
        (kernel.dfg.name.clone(), energy)
    });
    let control = of_control(report, program, &prices).total();
    let parts = counted(report, arch).into_iter();
    let parts = parts.filter(|(part, _)| !matches!(part, Part::Bus | Part::Memory));
    let parts = parts.map(|(part, pj)| (part.name().to_owned(), pj));
    let code = kernels.chain([("VLIW code".to_owned(), control)]);
    let all = code.chain(parts).map(|(of, pj)| Use { of, mj: pj * 1e-9 });
    all.collect()
}

/// The energy of the loops on the array by the source positions of their operations, mJ at 65 nm: what [`uses`] has of
/// them.
pub fn of_loops(report: &Report, program: &ScheduledDre, arch: &Arch) -> BTreeMap<Pos, f64> {
    let prices = Prices::of(arch);
    let mut places: BTreeMap<Pos, f64> = BTreeMap::new();
    for kernel in program.kernels.values() {
        let turns = Turns::of(kernel, report);
        for (node, of) in prices.nodes(kernel).iter() {
            let place = places.entry(kernel.dfg.nodes[node].pos).or_default();
            *place += turns.times(*of).total() * 1e-9;
        }
    }
    places
}

/// The energy of control code, mJ at 65 nm: what [`uses`] has of it.
pub fn of_vliw_code(report: &Report, program: &ScheduledDre, arch: &Arch) -> f64 {
    of_control(report, program, &Prices::of(arch)).total() * 1e-9
}

/// The energy of so many bytes that go between cores and memory, mJ at 65 nm.
pub fn moved(bytes: u64) -> f64 {
    8.0 * bytes as f64 * (chip::WIRE_PJ * BUS_MM + MEMORY_BIT_PJ) * 1e-9
}

/// Parts whose uses the system counts; pJ.
fn counted(report: &Report, arch: &Arch) -> Vec<(Part, f64)> {
    let (system, tni) = (&arch.system, report.tni());
    let spec = &system.tni;
    // A miss looks for the line, and writes it when it comes.
    let cache = |spec: &CacheSpec, c: &CacheCounters| {
        (c.hits + c.joined + 2 * (c.misses + c.prefetches)) as f64 * 1e3 * cache_energy(spec.bytes)
    };
    let of_cores = |spec: &CacheSpec,
                    of: fn(&srp_runtime::system::CoreReport) -> &CacheCounters| {
        report
            .cores
            .iter()
            .map(|core| cache(spec, of(core)))
            .sum::<f64>()
    };
    let passes = tni.pre.passes + tni.aabb.passes + tni.post.passes + tni.ist.passes;
    let ray_bits = 8 * (system.buffers.ray_bytes + system.buffers.hit_bytes);
    let memory = &report.dram.counters;
    let bits = 8.0 * (memory.bytes_read + memory.bytes_written) as f64;
    let bytes = system.sram_bytes
        + system.data_cache.bytes
        + system.texture_cache.bytes
        + system.instruction_cache.map_or(0, |cache| cache.bytes)
        + spec.trvs * spec.trv_l1.bytes
        + spec.trv_l2.bytes
        + spec.ists * spec.ist_l1.bytes;
    let leakage = LEAKAGE * f64::from(bytes) * f64::from(system.cores);
    let instructions = system.instruction_cache.map(|spec| {
        let of_cores = report.cores.iter().filter_map(|c| c.instruction_cache);
        let energy = of_cores.map(|counters| cache(&spec, &counters));
        (Part::InstructionCache, energy.sum())
    });
    let mut parts = vec![
        (
            Part::DataCache,
            of_cores(&system.data_cache, |core| &core.data_cache),
        ),
        (
            Part::TextureCache,
            of_cores(&system.texture_cache, |core| &core.texture_cache),
        ),
        (
            Part::BoxTests,
            tni.box_tests as f64 * 1e3 * operations_energy(BOX_TEST),
        ),
        (
            Part::TriangleTests,
            tni.triangle_tests as f64 * 1e3 * triangle_energy(spec),
        ),
        (
            Part::TniCaches,
            cache(&spec.trv_l1, &tni.trv_l1)
                + cache(&spec.trv_l2, &tni.trv_l2)
                + cache(&spec.ist_l1, &tni.ist_l1),
        ),
        (
            Part::TniPipelines,
            passes as f64 * f64::from(ray_bits) * PIPELINE_BIT_PJ,
        ),
        (Part::Bus, bits * chip::WIRE_PJ * BUS_MM),
        (Part::Memory, bits * MEMORY_BIT_PJ),
        (Part::Leakage, leakage * report.milliseconds * 1e9),
    ];
    parts.extend(instructions);
    parts
}
