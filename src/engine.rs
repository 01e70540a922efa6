//! The engines: simulators generated and compiled, or the interpreter of the same tables.

use crate::cli::Engine;
use crate::failure::Failure;
use crate::files;
use crate::talk::{self, Progress};
use srp_archdesc::arch::Arch;
use srp_csimgen::{CompileError, CompileOptions, Interpreter, SimSpec, Simulator, emit, link};
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::core::Core;

/// Makes cores at the start of a program, as often as they are wanted.
pub(crate) enum Factory {
    /// Those of a simulator that was generated.
    Generated(Simulator),
    /// Interpreters of the tables.
    Tables(Box<Interpreter>),
}

impl Factory {
    /// What makes cores of a program.
    pub(crate) fn of(
        program: &ScheduledDre,
        arch: &Arch,
        engine: Engine,
    ) -> Result<Factory, Failure> {
        let spec = link(program, arch).map_err(Failure::message)?;
        if engine == Engine::Csim
            && let Some(simulator) = generated(&spec)?
        {
            return Ok(Factory::Generated(simulator));
        }
        Ok(Factory::Tables(Box::new(Interpreter::new(&spec))))
    }

    /// So many cores.
    pub(crate) fn cores(&self, count: u32) -> Vec<Box<dyn Core>> {
        let core = |_| match self {
            Factory::Generated(simulator) => Box::new(simulator.core()) as Box<dyn Core>,
            Factory::Tables(interpreter) => interpreter.clone(),
        };
        (0..count).map(core).collect()
    }
}

/// A number of cores at the start of a program.
pub(crate) fn cores(
    program: &ScheduledDre,
    arch: &Arch,
    engine: Engine,
    count: u32,
) -> Result<Vec<Box<dyn Core>>, Failure> {
    Ok(Factory::of(program, arch, engine)?.cores(count))
}

/// The generated simulator; `None`, and a word about it, where there is no compiler.
fn generated(spec: &SimSpec) -> Result<Option<Simulator>, Failure> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let options = CompileOptions {
        rustc: rustc.into(),
        cache: files::cache_folder(),
    };
    let mut spinner = None;
    let mut progress = |step| {
        if let srp_csimgen::compile::Progress::Compiling(_) = step {
            spinner = Some(Progress::spinner("compiling the simulator"));
        }
    };
    let compiled = srp_csimgen::compile(&emit(spec), &options, &mut progress);
    drop(spinner);
    match compiled {
        Ok(library) => Simulator::load(&library, spec)
            .map(Some)
            .map_err(Failure::message),
        Err(error @ CompileError::NoRustc(_)) => {
            talk::say(format_args!(
                "note: {error}; the interpreter simulates instead (slower, same cycles)"
            ));
            Ok(None)
        }
        Err(error) => Err(Failure::message(error)),
    }
}
