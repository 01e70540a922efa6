//! The program that is damaged, scheduled for a machine, and what it does.

use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_csimgen::{Interpreter, link};
use srp_ir::check::{self, sequence::Stretch};
use srp_ir::dre;
use srp_ir::dre::Dre;
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledDre};
use srp_ir::interp::{FlatWorld, Options};
use srp_ir::layout::Layout;
use srp_ir::program::{Kernel, Program};
use srp_runtime::solo::{self, Solo};
use srp_tests::{compiled, machine, root, session};
use srp_toolchain::{Effort, schedule};
use std::sync::OnceLock;

/// The machines that the program is scheduled for.
pub(crate) const MACHINES: [&str; 4] = ["sgrt", "tiny", "wide", WIRED];

/// The tiny machine as an array of nine units with switches, a bus with registers, and no links.
pub(crate) const WIRED: &str = "wired";

fn wired() -> Arch {
    let array = "rows=\"3\" cols=\"3\" topology=\"none\" wires=\"mesh\" hops=\"3\"";
    let bus = "<wire name=\"bus\" from=\"all mesh_0_0_0_1\" to=\"all\" delay=\"1\"/>\n  </array>";
    let xml = srp_archdesc::machines::TINY.xml;
    let xml = xml.replace("rows=\"2\" cols=\"2\" topology=\"mesh\"", array);
    let xml = xml.replace("</array>", bus);
    srp_archdesc::parse(WIRED, &xml).expect("it is a machine")
}

/// A program that is right.
pub(crate) struct Case {
    pub(crate) arch: Arch,
    dre: Dre,
    layout: Layout,
    pub(crate) right: ScheduledDre,
    pub(crate) sequence: Vec<Stretch>,
    effect: Effect,
}

/// The effects of a program: its exit status and its globals.
#[derive(Debug, PartialEq)]
struct Effect {
    status: i32,
    globals: Vec<u8>,
}

/// Cycles after which a damaged program is said not to end. The program takes about 40,000.
const LIMIT: u64 = 1_000_000;

impl Case {
    /// The program on one of [`MACHINES`], scheduled once.
    pub(crate) fn on(index: usize) -> &'static Case {
        static CASES: [OnceLock<Case>; 4] = [const { OnceLock::new() }; 4];
        CASES[index].get_or_init(|| Case::new(MACHINES[index]))
    }

    /// The control code that the bundles come from.
    pub(crate) fn control(&self) -> &Program {
        &self.dre.control
    }

    fn new(name: &str) -> Case {
        let arch = match name {
            WIRED => wired(),
            name => machine(name),
        };
        let source = root().join("tests/tests/check/loops.c");
        let program = compiled(&[source], &arch).unwrap_or_else(|messages| panic!("{messages}"));
        let compiled = schedule(program, &arch, Effort::default(), &session());
        let compiled = compiled.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(compiled.not_pipelined, [], "every kernel runs on the array");
        let dre = compiled.dre.expect("it was divided here");
        let layout = Layout::of(&dre.control, arch.system.sram_bytes).expect("it is small");
        let right = compiled.schedule.program.into_inner();
        let code = srp_scheduler::vliw::emit(&dre.control, &right.kernels, &arch.srp, &layout);
        let sequence = code.expect("it was scheduled before").sequence;
        let effect = meaning(&dre, &arch, &layout);
        let case = Case {
            arch,
            dre,
            layout,
            right,
            sequence,
            effect,
        };
        assert_eq!(case.difference(&case.right), None, "on {name}");
        case
    }

    /// Describes how a program's effect differs from this one's; `None` where it does not.
    pub(crate) fn difference(&self, program: &ScheduledDre) -> Option<String> {
        let spec = match check::check(program.clone(), &self.arch) {
            Ok(checked) => link(&checked).expect("its kernels are short"),
            Err(refused) => return Some(refused.to_string()),
        };
        let mut bus = Solo::new(&program.image, self.arch.system.sram_bytes);
        let finish = match solo::run(&mut Interpreter::new(&spec), &mut bus, LIMIT) {
            Ok(finish) => finish,
            Err(e) => return Some(e.to_string()),
        };
        let got = Effect {
            status: finish.status,
            globals: bus.sram[..self.layout.image.len()].to_vec(),
        };
        if got.status != self.effect.status {
            return Some(format!(
                "the status is {}, not {}",
                got.status, self.effect.status
            ));
        }
        let mut bytes = got.globals.iter().zip(&self.effect.globals);
        let at = bytes.position(|(a, b)| a != b)?;
        let symbols = program.symbols.iter();
        let symbol = symbols.rev().find(|s| s.address as usize <= at);
        let name = symbol.map_or("", |s| &s.name);
        Some(format!("byte {at:#x}, of `{name}`, differs"))
    }

    /// The same with other schedules of the kernels, and control code for them.
    pub(crate) fn difference_with(
        &self,
        kernels: EntityMap<Kernel, ModuloSchedule>,
    ) -> Option<String> {
        let (control, layout) = (&self.dre.control, &self.layout);
        let code = match srp_scheduler::vliw::emit(control, &kernels, &self.arch.srp, layout) {
            Ok(code) => code,
            Err(e) => return Some(e.to_string()),
        };
        self.difference(&ScheduledDre {
            bundles: code.bundles,
            functions: code.functions,
            start: code.start,
            kernels,
            ..self.right.clone()
        })
    }
}

/// Returns the effects of a program by its meaning.
fn meaning(dre: &Dre, arch: &Arch, layout: &Layout) -> Effect {
    let mut world = FlatWorld::new(layout, arch.system.sram_bytes);
    let options = Options {
        precision: arch.precision,
        ..Options::new(layout)
    };
    let main = dre.control.main.expect("there is a main");
    let outcome = dre::run(dre, main, &[], &mut world, &options);
    let outcome = outcome.unwrap_or_else(|trap| panic!("{}", trap.show(&dre.control)));
    world.sram.truncate(layout.image.len());
    Effect {
        status: outcome.status(),
        globals: world.sram,
    }
}
