//! The engines: simulators generated and compiled, or the interpreter of the same tables.

use crate::cli::Engine;
use crate::failure::Failure;
use crate::files;
use crate::talk::{self, Progress};
use srp_archdesc::arch::Arch;
use srp_csimgen::{CompileError, CompileOptions, Interpreter, SimSpec, Simulator, emit, link};
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::core::Core;

/// A number of cores at the start of a program.
pub(crate) fn cores(
    program: &ScheduledDre,
    arch: &Arch,
    engine: Engine,
    count: u32,
) -> Result<Vec<Box<dyn Core>>, Failure> {
    let spec = link(program, arch).map_err(Failure::message)?;
    if engine == Engine::Csim
        && let Some(simulator) = generated(&spec)?
    {
        return Ok((0..count)
            .map(|_| Box::new(simulator.core()) as Box<dyn Core>)
            .collect());
    }
    let interpreter = Interpreter::new(&spec);
    Ok((0..count)
        .map(|_| Box::new(interpreter.clone()) as Box<dyn Core>)
        .collect())
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
