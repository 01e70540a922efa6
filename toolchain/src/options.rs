//! Options of a compilation.

use crate::files::Outside;
use serde::Serialize;
use srp_archdesc::diagnostic::{Diagnostic, Severity};
use srp_frontend::message::{warning_name, warning_names};
use srp_ir::pass::{FastMath, Rewrite};
use srp_scheduler::modulo;
use std::path::PathBuf;
use std::time::Duration;

/// How a program is compiled. The default is what C allows, with innermost loops on the array.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Options {
    /// Folders to look for included files in, after that of the including file.
    pub include: Vec<PathBuf>,
    /// What is done about included files outside these folders and those of the sources.
    pub outside: Outside,
    /// Macros: names and bodies.
    pub defines: Vec<(String, String)>,
    /// Innermost loops become kernels where no pragma says so.
    pub auto_kernel: bool,
    /// `double` is `float`; a message marks each place.
    pub double_is_float: bool,
    /// Floating constants without suffix are floats; a message marks each.
    pub single_constants: bool,
    /// Permissions to change results of floating-point arithmetic.
    pub fast_math: FastMath,
    /// Loops on the array ask for lines of system memory ahead.
    pub prefetch: bool,
    /// Reciprocals, roots and quotients may be off by so many units in the last place: the cheapest unit
    /// that is within them computes each.
    pub max_ulp: Option<f64>,
    /// Expressions that are to be rewritten.
    pub rewrites: Vec<Rewrite>,
    /// Which warnings there are, and which are errors.
    pub warnings: Warnings,
    /// How long loops are scheduled.
    pub effort: Effort,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            include: Vec::new(),
            outside: Outside::default(),
            defines: Vec::new(),
            auto_kernel: true,
            double_is_float: false,
            single_constants: false,
            fast_math: FastMath::default(),
            prefetch: false,
            max_ulp: None,
            rewrites: Vec::new(),
            warnings: Warnings::default(),
            effort: Effort::default(),
        }
    }
}

/// How long the best schedule of a loop is looked for. The default is a number of steps that takes about a
/// second at most for the loops of a shader, the same on every host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Effort {
    /// Hundredths of these steps.
    pub percent: u32,
    /// For so much processor time beyond them, for each loop that has not reached its bound.
    pub beyond: Option<Duration>,
    /// The SAT solver that takes part.
    pub solver: modulo::Solver,
}

impl Default for Effort {
    fn default() -> Effort {
        Effort {
            percent: 100,
            beyond: None,
            solver: modulo::Solver::default(),
        }
    }
}

impl Effort {
    /// This effort in the words of the scheduler.
    pub fn modulo(self) -> modulo::Options {
        let usual = modulo::Options::default();
        let times = |steps: u64| steps.saturating_mul(u64::from(self.percent)) / 100;
        modulo::Options {
            effort: times(usual.effort),
            exact_effort: times(usual.exact_effort),
            compaction: times(usual.compaction),
            beyond: self.beyond,
            solver: self.solver,
            ..usual
        }
    }
}

/// Wishes about warnings, the later before the earlier, as `-W` has them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Warnings(Vec<String>);

/// The treatment of a warning.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Level {
    Off,
    Warn,
    Error,
}

impl Warnings {
    /// These wishes: `NAME`, `no-NAME`, `error`, `error=NAME`, `no-error`, `no-error=NAME`, `all`,
    /// `extra`, `none`.
    ///
    /// # Errors
    ///
    /// A sentence about a wish that names no warning.
    pub fn parse(wishes: &[String]) -> Result<Warnings, String> {
        for wish in wishes {
            let general = ["all", "extra", "none", "error", "no-error"];
            let bare = wish.strip_prefix("no-").unwrap_or(wish);
            let bare = bare.strip_prefix("error=").unwrap_or(bare);
            if !general.contains(&wish.as_str()) && !warning_names().any(|name| name == bare) {
                let names: Vec<_> = warning_names().collect();
                return Err(format!(
                    "`-W {wish}` names no warning; there are all, none, error and {}",
                    names.join(", ")
                ));
            }
        }
        Ok(Warnings(wishes.to_vec()))
    }

    /// The messages that are wanted, some of the warnings as errors.
    pub(crate) fn choose(&self, messages: Vec<Diagnostic>) -> Vec<Diagnostic> {
        let mut chosen = Vec::new();
        for mut message in messages {
            let name = warning_name(message.code);
            if let (true, Some(name)) = (message.severity != Severity::Error, name) {
                match self.level(name) {
                    Level::Off => continue,
                    Level::Error if message.severity == Severity::Warning => {
                        message.severity = Severity::Error;
                    }
                    _ => {}
                }
            }
            chosen.push(message);
        }
        chosen
    }

    /// True if a loop under `#pragma srp kernel` that is not on the array is an error: always, but with
    /// `no-error=kernel`, `no-error` or `no-kernel`.
    pub fn refuses_kernels(&self) -> bool {
        let mut refuses = true;
        for wish in &self.0 {
            match wish.as_str() {
                "no-error" | "no-error=kernel" | "no-kernel" | "none" => refuses = false,
                "error" | "error=kernel" | "kernel" => refuses = true,
                _ => {}
            }
        }
        refuses
    }

    fn level(&self, name: &str) -> Level {
        let mut level = Level::Warn;
        for wish in &self.0 {
            match wish.as_str() {
                "none" => level = Level::Off,
                "all" | "extra" if level == Level::Off => level = Level::Warn,
                "error" if level == Level::Warn => level = Level::Error,
                "no-error" if level == Level::Error => level = Level::Warn,
                wish if wish == name && level == Level::Off => level = Level::Warn,
                wish if wish.strip_prefix("no-error=") == Some(name) => level = Level::Warn,
                wish if wish.strip_prefix("no-") == Some(name) => level = Level::Off,
                wish if wish.strip_prefix("error=") == Some(name) => level = Level::Error,
                _ => {}
            }
        }
        level
    }
}
