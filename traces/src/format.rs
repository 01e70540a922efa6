//! The forms of files.

use crate::fst;
use crate::konata;
use crate::perfetto;
use crate::trace::Trace;

/// The form of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Waves.
    Fst,
    /// Operations on their way, one line each.
    Konata,
    /// A timeline.
    Perfetto,
}

impl Format {
    /// Most bytes that a step takes in a file, texts, values and changes of registers included.
    pub(crate) fn bytes_of_step(self) -> u64 {
        match self {
            Format::Fst => 96,
            Format::Konata => 320,
            Format::Perfetto => 128,
        }
    }

    /// The bytes of a trace in this form.
    ///
    /// # Errors
    ///
    /// The writer of waves refuses a name or a value.
    pub fn write(self, trace: &Trace) -> Result<Vec<u8>, fst::FstError> {
        match self {
            Format::Fst => fst::write(trace),
            Format::Konata => Ok(konata::write(trace)),
            Format::Perfetto => Ok(perfetto::write(trace)),
        }
    }
}
