//! `srp new`: commented starting points.

use crate::cli::{New, StartKind};
use crate::failure::Failure;
use crate::talk;
use srp_archdesc::machines;
use srp_toolchain::files::{self, FileError};
use std::path::Path;

/// What stands for the path of the new file in a starting point, where it stands for nothing else.
const PATH: char = '@';

/// Runs `srp new`.
pub(crate) fn run(args: &New) -> Result<(), Failure> {
    let path = &args.path;
    if path.symlink_metadata().is_ok() {
        let path = path.display();
        return Err(Failure::message(format_args!(
            "{path} exists; name a file or folder that does not"
        )));
    }
    let (text, again) = match args.kind {
        StartKind::Kernels => return kernels(path),
        StartKind::Program => (include_str!("program.c").to_owned(), "run"),
        StartKind::Sweep => (include_str!("plan.toml").to_owned(), "sweep"),
        StartKind::Cases => (include_str!("cases.cases").to_owned(), "hard-cases --cases"),
        StartKind::Machine => {
            let head = include_str!("machine.txt");
            (
                format!("{head}{}", machines::SGRT.xml),
                "report --frame --machine",
            )
        }
    };
    let name = path.display().to_string();
    files::write(path, text.replace(PATH, in_comment(&name)).as_bytes())?;
    talk::say(format_args!("wrote {name}\ntry: srp {again} {name}"));
    Ok(())
}

/// A path as it can stand in a command and in a comment of C, XML and TOML.
fn in_comment(path: &str) -> &str {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_./-".contains(c);
    match path.chars().all(is_plain) && !path.contains("--") {
        true => path,
        false => "FILE",
    }
}

fn kernels(folder: &Path) -> Result<(), Failure> {
    let wrong = |error| FileError::writing(folder, error);
    std::fs::create_dir_all(folder).map_err(wrong)?;
    for file in srp_kernels::SOURCES.iter().chain(srp_kernels::HEADERS) {
        files::write(&folder.join(file.name), file.text.as_bytes())?;
    }
    let folder = folder.display();
    talk::say(format_args!(
        "wrote the kernels to {folder}; what makes colours is in shade.c and light.c\n\
         try: srp render --kernels {folder}"
    ));
    Ok(())
}
