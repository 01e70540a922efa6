//! Engines, which simulate an SRP: a generated simulator, the interpreter of the same tables, or the one
//! after the other.

mod generated;
mod takeover;

pub use generated::{build, is_build_request};
pub use takeover::Shares;

use crate::{Error, Session};
use generated::Source;
use srp_archdesc::watch::Event;
use srp_csimgen::{Interpreter, Simulator, link};
use srp_ir::check::Checked;
use srp_runtime::core::Core;
use std::sync::Arc;
use takeover::Takeover;

/// An engine, which simulates an SRP. All give the same pictures and cycles to the bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// A simulator generated for the program, where it was compiled before; else the interpreter
    /// begins, and a simulator that is compiled meanwhile takes over.
    #[default]
    Auto,
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
    /// Interpreters, from which a simulator takes over.
    Takeover(Arc<Takeover>),
}

impl Engines {
    /// Prepares an engine for a program, on the machine that it was checked for. If no simulator can be
    /// compiled, the interpreter takes its place, and a note says so.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels.
    pub fn of(program: &Checked, engine: Engine, session: &Session<'_>) -> Result<Engines, Error> {
        let spec = link(program)?;
        let interpreters = || Engines::Interpreters(Box::new(Interpreter::new(&spec)));
        if engine == Engine::Interpreter {
            return Ok(interpreters());
        }
        let source = Source::of(&spec);
        if let Some(simulator) = source.kept(&spec, session) {
            return Ok(Engines::Generated(simulator));
        }
        if engine == Engine::Auto {
            return Ok(match &session.builder {
                Some(builder) => {
                    let cache = Arc::clone(&session.cache);
                    let takeover = Takeover::new(spec, source, builder.clone(), cache);
                    Engines::Takeover(Arc::new(takeover))
                }
                None => interpreters(),
            });
        }
        if !session.compiles {
            session.watch.tell(Event::Note(
                "note: the cache has no simulator of it and none is compiled here: the interpreter simulates \
                 (slower, same cycles)",
            ));
            return Ok(interpreters());
        }
        match source.made(&spec, session) {
            Ok(simulator) => Ok(Engines::Generated(simulator)),
            Err(error) => {
                let note = format!(
                    "note: {error}\nnote: the interpreter simulates instead (slower, same cycles)"
                );
                session.watch.tell(Event::Note(&note));
                Ok(interpreters())
            }
        }
    }

    /// One core.
    pub fn core(&self) -> Box<dyn Core> {
        match self {
            Engines::Generated(simulator) => Box::new(simulator.core()),
            Engines::Interpreters(interpreter) => interpreter.clone(),
            Engines::Takeover(takeover) => Box::new(Takeover::core(takeover)),
        }
    }

    /// So many cores.
    pub fn cores(&self, count: u32) -> Vec<Box<dyn Core>> {
        (0..count).map(|_| self.core()).collect()
    }

    /// Cycles of all cores by the engine that simulated them, where that may have been several.
    pub fn shares(&self) -> Option<Shares> {
        match self {
            Engines::Takeover(takeover) => Some(takeover.shares()),
            Engines::Generated(_) | Engines::Interpreters(_) => None,
        }
    }
}
