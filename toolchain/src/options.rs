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
pub struct Warnings(Vec<Wish>);

/// A wish about the warning of a name, or about all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
struct Wish {
    change: Change,
    of: Option<&'static str>,
}

/// The change that a wish asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
enum Change {
    Show,
    Hide,
    Refuse,
    Tolerate,
}

/// The treatment of a warning.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Level {
    Off,
    Warn,
    Error,
}

impl Wish {
    fn parse(text: &str) -> Option<Wish> {
        let general = match text {
            "all" | "extra" => Some(Change::Show),
            "none" => Some(Change::Hide),
            "error" => Some(Change::Refuse),
            "no-error" => Some(Change::Tolerate),
            _ => None,
        };
        if let Some(change) = general {
            return Some(Wish { change, of: None });
        }
        let ways = [
            ("no-error=", Change::Tolerate),
            ("error=", Change::Refuse),
            ("no-", Change::Hide),
            ("", Change::Show),
        ];
        let mut ways = ways.iter();
        ways.find_map(|&(before, change)| {
            let rest = text.strip_prefix(before)?;
            let of = Some(warning_names().find(|name| *name == rest)?);
            Some(Wish { change, of })
        })
    }

    /// The level of a warning after this wish, which is about it.
    fn after(self, level: Level, usual: Level) -> Level {
        match (self.change, self.of, level) {
            (Change::Hide, ..) => Level::Off,
            (Change::Show, _, Level::Off) => usual,
            (Change::Refuse, Some(_), _) | (Change::Refuse, None, Level::Warn) => Level::Error,
            (Change::Tolerate, Some(_), _) | (Change::Tolerate, None, Level::Error) => Level::Warn,
            _ => level,
        }
    }
}

impl Warnings {
    /// These wishes: `NAME`, `no-NAME`, `error`, `error=NAME`, `no-error`, `no-error=NAME`, `all`,
    /// `extra`, `none`.
    ///
    /// # Errors
    ///
    /// A sentence about a wish that names no warning.
    pub fn parse(wishes: &[String]) -> Result<Warnings, String> {
        let wish = |text: &String| {
            Wish::parse(text).ok_or_else(|| {
                let names: Vec<_> = warning_names().collect();
                format!(
                    "`-W {text}` names no warning; there are all, none, error and {}",
                    names.join(", ")
                )
            })
        };
        Ok(Warnings(wishes.iter().map(wish).collect::<Result<_, _>>()?))
    }

    /// The messages that are wanted, some of the warnings as errors.
    pub(crate) fn choose(&self, messages: Vec<Diagnostic>) -> Vec<Diagnostic> {
        let mut chosen = Vec::new();
        for mut message in messages {
            let name = warning_name(message.code);
            if let (true, Some(name)) = (message.severity != Severity::Error, name) {
                match self.level(name, Level::Warn) {
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

    /// True if a loop under `#pragma srp kernel` that is not on the array is an error, which it is unless a wish says
    /// otherwise.
    pub fn refuses_kernels(&self) -> bool {
        self.level("kernel", Level::Error) == Level::Error
    }

    fn level(&self, name: &str, usual: Level) -> Level {
        let wishes = self.0.iter();
        let about = wishes.filter(|wish| wish.of.is_none_or(|of| of == name));
        about.fold(usual, |level, wish| wish.after(level, usual))
    }
}
