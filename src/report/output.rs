//! Writing the report of a program's loops, for every command that compiles one.

use super::{html, text};
use crate::failure::Failure;
use crate::{document, files};
use srp_archdesc::arch::Arch;
use srp_studies::loops::{self, Options, Report, Subject};
use srp_toolchain::envelope::About;
use srp_toolchain::{Compiled, Session};
use std::path::{Path, PathBuf};

/// The files that a report of the loops is written to.
pub(crate) struct Loops<'a>(&'a [PathBuf]);

impl<'a> Loops<'a> {
    /// These files; fails now if one cannot be written later.
    pub(crate) fn to(paths: &'a [PathBuf]) -> Result<Loops<'a>, Failure> {
        for path in paths {
            files::check_writable(path)?;
        }
        Ok(Loops(paths))
    }

    /// Writes the report of a program.
    pub(crate) fn write(
        &self,
        compiled: &Compiled,
        arch: &Arch,
        session: &Session<'_>,
    ) -> Result<(), Failure> {
        if self.0.is_empty() {
            return Ok(());
        }
        let subject = Subject::of_program(compiled);
        let report = loops::report(&subject, arch, &Options::default(), session)?;
        self.0
            .iter()
            .try_for_each(|path| write(path, &report, arch))
    }
}

/// Writes a report in the form that the name of its file asks for.
fn write(path: &Path, report: &Report, arch: &Arch) -> Result<(), Failure> {
    let ending = path.extension().and_then(|e| e.to_str());
    let contents = match ending {
        Some("html" | "htm") => html::page(report),
        Some("txt") => text::text(report),
        _ => document::json(About::machine(arch), report)?,
    };
    files::write(path, contents.as_bytes())?;
    Ok(())
}
