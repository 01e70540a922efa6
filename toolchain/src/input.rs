//! The input of a compilation: C files, or one file of a later form.

use crate::Error;
use crate::files::{self, Kind};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Diagnostic, Messages, Source};
use srp_ir::dre::scheduled::ScheduledDre;
use srp_ir::dre::{self, Dre};
use srp_ir::program::Program;
use srp_kernels::File;
use std::path::{Path, PathBuf};

/// Most messages about one file.
const MOST: usize = 20;

/// The input of a compilation, by the stage that it has reached.
#[derive(Clone)]
pub enum Input {
    /// C sources.
    C(Vec<Source>),
    /// A program in the intermediate form.
    Ir(Box<Program>),
    /// A divided program.
    Dre(Box<Dre>),
    /// A scheduled program that no checker has seen yet.
    Scheduled {
        /// Its file, for messages.
        file: Source,
        /// The program.
        program: Box<ScheduledDre>,
    },
}

/// A file that comes along, as a source.
pub fn source(file: &File) -> Source {
    Source::new(file.path, file.text)
}

/// The kernels of a frame that come along.
pub fn kernels() -> Vec<Source> {
    srp_kernels::SOURCES.iter().map(source).collect()
}

/// The kernels of a frame that come along, where files take the place of those of the same name, and
/// others are added.
///
/// # Errors
///
/// A file cannot be read.
pub fn kernels_with(paths: &[PathBuf]) -> Result<Vec<Source>, Error> {
    let name = |path: &str| Path::new(path).file_name().map(ToOwned::to_owned);
    let mut sources = kernels();
    for path in paths {
        let source = files::read_source(path, Kind::Source)?;
        match sources
            .iter_mut()
            .find(|s| name(&s.name) == name(&source.name))
        {
            Some(replaced) => *replaced = source,
            None => sources.push(source),
        }
    }
    Ok(sources)
}

/// All C files of a folder, in place of the kernels that come along.
///
/// # Errors
///
/// The folder or a file cannot be read, or there is no C file.
pub fn kernels_in(folder: &Path) -> Result<Vec<Source>, Error> {
    let read = |path: &PathBuf| Ok(files::read_source(path, Kind::Source)?);
    c_files(folder)?.iter().map(read).collect()
}

/// Most files of a folder of kernels, with those in folders of it.
const MOST_FILES: usize = 10_000;

/// The names and bytes of all files of a folder and of the folders in it that a C file can include: not those that are larger than
/// a source may be, and not those that begin with a dot.
///
/// # Errors
///
/// The folder or a file cannot be read, or there are more than 10,000.
pub fn all_in(folder: &Path) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut open = vec![folder.to_owned()];
    let mut paths = Vec::new();
    while let Some(folder) = open.pop() {
        let error = |e: std::io::Error| {
            Error::Invalid(format!("cannot read the folder {}: {e}", folder.display()))
        };
        for entry in std::fs::read_dir(&folder).map_err(error)? {
            let entry = entry.map_err(error)?;
            if entry.file_name().as_encoded_bytes().starts_with(b".") {
                continue;
            }
            match entry.file_type().map_err(error)? {
                kind if kind.is_dir() => open.push(entry.path()),
                _ => paths.push(entry.path()),
            }
            if open.len() + paths.len() > MOST_FILES {
                return Err(Error::Invalid(format!(
                    "{} has more than {MOST_FILES} files: kernels stand in a folder of their own",
                    folder.display()
                )));
            }
        }
    }
    paths.sort();
    let small = |path: &PathBuf| {
        std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() <= Kind::Source.limit())
    };
    paths.retain(small);
    let read = |path: PathBuf| {
        let name = path
            .strip_prefix(folder)
            .unwrap_or(&path)
            .display()
            .to_string();
        Ok((name, files::read_bytes(&path, Kind::Source)?))
    };
    paths.into_iter().map(read).collect()
}

/// The files of a folder with this ending, by name.
fn files_in(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, Error> {
    let error = |e: std::io::Error| {
        Error::Invalid(format!("cannot read the folder {}: {e}", folder.display()))
    };
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(error)?.collect();
    let mut paths: Vec<PathBuf> = entries.map_err(error)?.iter().map(|e| e.path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == ending));
    paths.sort();
    Ok(paths)
}

/// The C files of a folder, by name.
///
/// # Errors
///
/// The folder cannot be read, or has no C file.
pub fn c_files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let paths = files_in(folder, "c")?;
    match paths.is_empty() {
        true => Err(Error::Invalid(format!(
            "there is no C file in {}",
            folder.display()
        ))),
        false => Ok(paths),
    }
}

/// Reads C files, or one file of a later form.
///
/// # Errors
///
/// A file cannot be read, is wrong, or is of a later form and not alone.
pub fn read(paths: &[PathBuf], arch: &Arch) -> Result<Input, Error> {
    let form = |p: &Path| match p.display().to_string() {
        n if n.ends_with(".ir") => Some(Kind::Program),
        n if n.ends_with(".dre.xml") => Some(Kind::Divided),
        n if n.ends_with(".sched.xml") => Some(Kind::Scheduled),
        _ => None,
    };
    let later = paths.iter().find_map(|path| Some((path, form(path)?)));
    let Some((path, kind)) = later else {
        let sources: Result<Vec<_>, _> = paths
            .iter()
            .map(|p| files::read_source(p, Kind::Source))
            .collect();
        return Ok(Input::C(sources?));
    };
    if paths.len() > 1 {
        return Err(Error::Invalid(format!(
            "{} is compiled further than C: give it alone",
            path.display()
        )));
    }
    let text = files::read_text(path, kind)?;
    let file = Source::new(path.display().to_string(), text);
    let (name, text) = (&file.name, &file.text);
    let at = |diagnostics: Vec<Diagnostic>| {
        let sources = vec![file.clone()];
        Error::Messages(Messages {
            diagnostics,
            sources,
        })
    };
    Ok(match kind {
        Kind::Program => {
            let program =
                srp_ir::text::read(text).map_err(|e| at(vec![e.diagnostic(name, text)]))?;
            if let Err(violations) = srp_ir::verify(&program) {
                let message = |broken| {
                    let span = srp_ir::text::place(text, &program, broken);
                    Diagnostic::error("D0004", name, broken.to_string()).at(span, "")
                };
                return Err(at(violations.iter().take(MOST).map(message).collect()));
            }
            Input::Ir(Box::new(program))
        }
        Kind::Divided => {
            let dre = dre::read(text).map_err(|e| at(vec![e.diagnostic(name)]))?;
            Input::Dre(Box::new(dre))
        }
        _ => {
            let program =
                dre::read_scheduled(text, arch).map_err(|e| at(vec![e.diagnostic(name)]))?;
            Input::Scheduled {
                program: Box::new(program),
                file,
            }
        }
    })
}
