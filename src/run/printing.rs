//! Programs that print while they run.

use crate::talk;
use srp_archdesc::watch::Watch;
use srp_toolchain::files::FileError;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Watches a program that prints: its text appears as it runs, and it ends where that cannot be written.
#[derive(Default)]
pub(super) struct Printing {
    /// True if standard output is for a document: the program prints to standard error.
    to_errors: bool,
    failed: Mutex<Option<io::Error>>,
}

impl Printing {
    pub(super) fn to(to_errors: bool) -> Printing {
        Printing {
            to_errors,
            ..Printing::default()
        }
    }

    fn print(&self, bytes: &[u8]) -> io::Result<()> {
        match self.to_errors {
            true => io::stderr().write_all(bytes),
            false => talk::print_part(bytes),
        }
    }

    fn failure(&self) -> MutexGuard<'_, Option<io::Error>> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// True when the reader of the text has gone away.
    pub(super) fn is_unread(&self) -> bool {
        let failure = self.failure();
        (failure.as_ref()).is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
    }

    /// Writes the rest.
    pub(super) fn end(&self, rest: &[u8]) -> Result<(), FileError> {
        let failed = self.failure().take();
        match failed {
            None => match self.print(rest) {
                Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
                    Err(FileError::writing(Path::new("standard output"), e))
                }
                _ => Ok(()),
            },
            Some(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                *self.failure() = Some(error);
                Ok(())
            }
            Some(error) => Err(FileError::writing(Path::new("standard output"), error)),
        }
    }
}

impl Watch for Printing {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(&talk::CONSOLE)
    }

    fn cancelled(&self) -> bool {
        self.failure().is_some() || talk::CONSOLE.cancelled()
    }

    fn printed(&self, bytes: &[u8]) -> bool {
        if let Err(error) = self.print(bytes) {
            *self.failure() = Some(error);
        }
        true
    }
}
