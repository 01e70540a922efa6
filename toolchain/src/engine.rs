//! What simulates an SRP: a generated simulator, or the interpreter of the same tables.

use crate::{Error, Session, files};
use srp_archdesc::watch::{Event, Stage};
use srp_csimgen::{CompileError, CompileOptions, Interpreter, SimSpec, Simulator, emit, link};
use srp_ir::check::Checked;
use srp_runtime::core::Core;

/// What simulates an SRP. Pictures and cycles are the same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// A simulator generated for the program and compiled by rustc.
    Generated,
    /// The interpreter of the same tables.
    Interpreter,
}

/// Makes cores at the start of a program, as often as they are wanted.
pub enum Engines {
    /// Those of a simulator that was generated.
    Generated(Simulator),
    /// Interpreters of the tables.
    Interpreters(Box<Interpreter>),
}

impl Engines {
    /// What makes cores of a program, on the machine that it was checked for. Where there is no
    /// compiler, the interpreter takes the place of a generated simulator, and a note says so.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels, or the simulator cannot be made.
    pub fn of(program: &Checked, engine: Engine, session: &Session<'_>) -> Result<Engines, Error> {
        let spec = link(program)?;
        if engine == Engine::Generated
            && let Some(simulator) = generated(&spec, session)?
        {
            return Ok(Engines::Generated(simulator));
        }
        Ok(Engines::Interpreters(Box::new(Interpreter::new(&spec))))
    }

    /// One core.
    pub fn core(&self) -> Box<dyn Core> {
        match self {
            Engines::Generated(simulator) => Box::new(simulator.core()),
            Engines::Interpreters(interpreter) => interpreter.clone(),
        }
    }

    /// So many cores.
    pub fn cores(&self, count: u32) -> Vec<Box<dyn Core>> {
        (0..count).map(|_| self.core()).collect()
    }
}

/// The generated simulator; `None`, and a note about it, where there is no compiler.
fn generated(spec: &SimSpec, session: &Session<'_>) -> Result<Option<Simulator>, Error> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let options = CompileOptions {
        rustc: rustc.into(),
        cache: files::cache_folder(),
    };
    let mut stage = None;
    let mut progress = |step| {
        if let srp_csimgen::compile::Progress::Compiling(_) = step {
            stage = Some(Stage::unknown(session.watch, "compiling the simulator"));
        }
    };
    let compiled = srp_csimgen::compile(&emit(spec), &options, &mut progress);
    drop(stage);
    match compiled {
        Ok(library) => Ok(Some(Simulator::load(&library, spec)?)),
        Err(error @ CompileError::NoRustc(_)) => {
            let note =
                format!("note: {error}; the interpreter simulates instead (slower, same cycles)");
            session.watch.tell(Event::Note(&note));
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}
