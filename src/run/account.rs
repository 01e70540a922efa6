//! What a run took, as words and as JSON.

use crate::cli::Run;
use crate::count::count;
use crate::failure::Failure;
use crate::{document, files, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::Entity;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_ir::program::Kernel;
use srp_runtime::solo::Finish;
use srp_toolchain::envelope::{About, Contents};

/// What a run of a program took.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Account {
    /// The program's exit status, of which the command's has the low eight bits.
    status: i32,
    /// True if the program ended; else it was interrupted.
    complete: bool,
    /// Cycles of the SRP; null without a machine (`--engine ir`).
    cycles: Option<Cycles>,
    /// Operations of the intermediate form; null with a machine.
    steps: Option<u64>,
}

impl Contents for Account {
    const FORMAT: &'static str = "srp-run";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp run --json` and `--report FILE.json`";
}

/// Cycles of a run.
#[derive(Serialize, JsonSchema)]
struct Cycles {
    /// All of them.
    all: u64,
    /// Of VLIW code.
    vliw: u64,
    /// Of changes between VLIW engine and array.
    switch: u64,
    /// Of standing still because accesses met in a bank of the SRAM.
    sram_stall: u64,
    /// Of loops on the array.
    kernels: Vec<KernelCycles>,
}

/// Cycles of a loop on the array.
#[derive(Serialize, JsonSchema)]
struct KernelCycles {
    /// Its kernel.
    kernel: String,
    /// The cycles.
    cycles: u64,
}

impl Account {
    /// That of a scheduled program.
    pub(super) fn of(finish: &Finish, program: &ScheduledDre, complete: bool) -> Account {
        let kernels = finish.kernels.iter().map(|(&kernel, &cycles)| {
            let kernel = program.kernels.get(Kernel::new(kernel as usize));
            let kernel = kernel
                .map_or("a kernel", |k| k.dfg.name.as_str())
                .to_owned();
            KernelCycles { kernel, cycles }
        });
        Account {
            status: finish.status,
            complete,
            cycles: Some(Cycles {
                all: finish.cycles(),
                vliw: finish.vliw,
                switch: finish.switch,
                sram_stall: finish.sram_stall,
                kernels: kernels.collect(),
            }),
            steps: None,
        }
    }

    /// That of the intermediate form.
    pub(super) fn of_steps(status: i32, steps: u64) -> Account {
        Account {
            status,
            complete: true,
            cycles: None,
            steps: Some(steps),
        }
    }

    /// Says it on standard error.
    pub(super) fn say(&self) {
        if let Some(steps) = self.steps {
            talk::say(format_args!("{steps} steps"));
        }
        let Some(cycles) = &self.cycles else {
            return;
        };
        talk::say(format_args!(
            "{}: {} VLIW, {} switching",
            count(cycles.all, "cycle"),
            cycles.vliw,
            cycles.switch
        ));
        for KernelCycles { kernel, cycles } in &cycles.kernels {
            talk::say(format_args!("  {cycles} in {kernel}"));
        }
        if cycles.sram_stall > 0 {
            talk::say(format_args!("  {} for SRAM banks", cycles.sram_stall));
        }
    }

    /// Writes it where the command line wants it.
    pub(super) fn write(&self, args: &Run, arch: &Arch) -> Result<(), Failure> {
        if args.report.is_none() && !args.json {
            return Ok(());
        }
        let json = document::json(About::machine(arch), self)?;
        if let Some(path) = &args.report {
            files::write(path, json.as_bytes())?;
        }
        if args.json {
            talk::print(json)?;
        }
        Ok(())
    }
}
