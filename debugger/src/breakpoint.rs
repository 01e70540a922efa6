//! Breakpoints: where a session stops.

use crate::code::Code;
use crate::expression::Expression;
use srp_csimgen::SimSpec;
use srp_ir::described::TypeRef;
use std::fmt;
use std::str::FromStr;

/// Where to stop.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Place {
    /// Where code of a line begins, or an iteration comes to it.
    Line(u32),
    /// Where a function begins.
    Function(u32),
    /// Where a launch of a kernel begins: which, on which core; each if nothing is said.
    Launch {
        kernel: u32,
        number: Option<u64>,
        core: Option<u32>,
    },
    /// A cycle.
    Cycle(u64),
}

/// A breakpoint.
#[derive(Clone, Debug)]
pub(crate) struct Breakpoint {
    pub(crate) id: u64,
    pub(crate) place: Place,
    pub(crate) condition: Option<Expression>,
    /// How often it has to be met before it stops.
    pub(crate) count: u64,
    pub(crate) met: u64,
}

/// A part of memory that an expression names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Where it begins.
    pub address: u32,
    /// Its bytes.
    pub bytes: u32,
    /// Its type, if it has one.
    pub ty: Option<TypeRef>,
}

/// Bytes that are watched.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    pub(crate) id: u64,
    pub(crate) core: u32,
    pub(crate) address: u32,
    pub(crate) bytes: u32,
    /// The expression that names it, and its type.
    pub(crate) name: String,
    pub(crate) ty: Option<TypeRef>,
    pub(crate) last: Vec<u8>,
}

/// Why there is no breakpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoBreakpoint {
    /// There is no code at the line or behind it.
    Line {
        /// The file.
        file: String,
        /// The line.
        line: u32,
    },
    /// Nothing has this name.
    Name {
        /// The name.
        name: String,
        /// The kernels that there are.
        kernels: String,
    },
    /// The machine has no core of this number.
    Core {
        /// The number.
        core: u32,
        /// The cores that there are.
        cores: u32,
    },
    /// A text that is no place.
    Text(String),
}

impl fmt::Display for NoBreakpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoBreakpoint::Line { file, line } => {
                write!(f, "no code comes of {file} from line {line} on")
            }
            NoBreakpoint::Name { name, kernels } => write!(
                f,
                "no function is named `{name}`, or all its calls were inlined, and no kernel on the array; kernels: {kernels}"
            ),
            NoBreakpoint::Core { core, cores: 1 } => {
                write!(f, "there is no core {core}: the only one is core 0")
            }
            NoBreakpoint::Core { core, cores } => {
                write!(
                    f,
                    "there is no core {core}: the last one is core {}",
                    cores - 1
                )
            }
            NoBreakpoint::Text(text) => write!(
                f,
                "`{text}` is no place: write FILE:LINE, a function, a kernel, KERNEL#N (its N-th launch), KERNEL#N@CORE \
                 or cycle:N"
            ),
        }
    }
}

impl std::error::Error for NoBreakpoint {}

/// A number that counts from 1, as lines and launches do.
fn number<N: FromStr + Default + PartialEq>(text: &str) -> Option<N> {
    text.parse().ok().filter(|number| *number != N::default())
}

impl Place {
    /// A line, or the next one with code.
    pub(crate) fn line(code: &Code, file: &str, line: u32) -> Result<Place, NoBreakpoint> {
        let found = code.find(file, line);
        found.map(Place::Line).ok_or_else(|| NoBreakpoint::Line {
            file: file.to_owned(),
            line,
        })
    }

    /// Reads `cycle:N`, `FILE:LINE`, `FUNCTION`, `KERNEL`, `kernel:KERNEL`, `KERNEL#N` or `KERNEL#N@CORE`. A function
    /// comes before a kernel of its name.
    pub(crate) fn parse(
        text: &str,
        spec: &SimSpec,
        code: &Code,
        cores: u32,
    ) -> Result<Place, NoBreakpoint> {
        let wrong = || NoBreakpoint::Text(text.to_owned());
        if let Some(cycle) = text.strip_prefix("cycle:") {
            let cycle = cycle.replace('_', "").parse();
            return cycle.map(Place::Cycle).map_err(|_| wrong());
        }
        if let Some((file, line)) = text.rsplit_once(':')
            && file != "kernel"
        {
            let line = number(line).ok_or_else(wrong)?;
            return Place::line(code, file, line);
        }
        let (name, core) = match text.split_once('@') {
            Some((name, core)) => (name, Some(core.parse().map_err(|_| wrong())?)),
            None => (text, None),
        };
        if let Some(core) = core.filter(|core| *core >= cores) {
            return Err(NoBreakpoint::Core { core, cores });
        }
        let (name, launch) = match name.split_once('#') {
            Some((name, count)) => (name, Some(number(count).ok_or_else(wrong)?)),
            None => (name, None),
        };
        let (name, of_kernel) = match name.strip_prefix("kernel:") {
            Some(name) => (name, true),
            None => (name, launch.is_some()),
        };
        let kernels = || (0..).zip(&spec.kernels);
        let function = spec.functions.iter().find(|(f, _)| f == name);
        let kernel = kernels().find(|(_, k)| k.name == name);
        match (function, kernel) {
            (Some(&(_, entry)), _) if !of_kernel => Ok(Place::Function(entry)),
            (_, Some((kernel, _))) => Ok(Place::Launch {
                kernel,
                number: launch,
                core,
            }),
            _ => Err(NoBreakpoint::Name {
                name: name.to_owned(),
                kernels: kernels()
                    .map(|(_, k)| k.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            }),
        }
    }
}
