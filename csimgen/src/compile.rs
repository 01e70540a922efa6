//! [`Compiler`]: rustc makes a library of a simulator's source.
//!
//! It runs in a folder that the caller gives, with only those variables of the environment that a compiler
//! and its linker need: the toolchain file, flags and wrappers in the user's folder or environment are not
//! meant for the simulator.

use crate::emit::SimSource;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs, io};

/// Arguments of rustc, beside the names of files and [`features`]. Simulators are many small
/// functions: higher levels of optimisation take several times as long and gain nothing but
/// vectors, which the one pass brings.
const FLAGS: &[&str] = &[
    "--edition=2024",
    "--cap-lints=allow",
    "-Copt-level=1",
    "-Ccodegen-units=1",
    "-Cpanic=abort",
    "-Cpasses=slp-vectorizer",
];

/// The variables of the environment that a compiler gets: where programs, toolchains and the user's files are.
const ENVIRONMENT: &[&str] = &[
    "PATH",
    "HOME",
    "CARGO_HOME",
    "RUSTUP_HOME",
    "RUSTUP_TOOLCHAIN",
    "LD_LIBRARY_PATH",
    "SystemRoot",
    "USERPROFILE",
];

/// Features of the host beyond the least of its kind that are worth using: fused multiply-add, which
/// takes a dozen instructions otherwise. Results are the same with them and without.
fn features() -> &'static [&'static str] {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("fma") {
        return &["-Ctarget-feature=+fma"];
    }
    &[]
}

/// Everything that a library depends on beside its source: the flags, the host's kind and the features used of it.
/// The compiler is not among it: the source means the same to all of them, and the interface is C's.
pub fn flags() -> impl Iterator<Item = &'static str> {
    let host = [env::consts::ARCH, env::consts::OS];
    FLAGS.iter().chain(features()).copied().chain(host)
}

/// Why there is no library.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// There is no compiler of this name, or it does not run. The interpreter needs none.
    #[error("there is no Rust compiler `{}`", .0.display())]
    NoRustc(PathBuf),
    /// The compiler failed; so it does where there is no linker.
    #[error("`{}` failed on the simulator:\n{messages}", .rustc.display())]
    Rustc {
        /// The compiler.
        rustc: PathBuf,
        /// Its messages.
        messages: String,
    },
    /// A file of the folder cannot be used.
    #[error("cannot compile the simulator in {}: {source}", .path.display())]
    Folder {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// A Rust compiler, in an environment of its own.
pub struct Compiler {
    /// The compiler: a path, or a name that is searched for as commands are.
    pub rustc: PathBuf,
}

impl Compiler {
    /// Asks the compiler for its version, in the folder in which it will run, since a proxy may choose the
    /// compiler by that.
    ///
    /// # Errors
    ///
    /// There is no rustc, or it fails.
    pub fn version(&self, folder: &Path) -> Result<String, CompileError> {
        let output = self.run(folder, &["-vV"])?;
        Ok(String::from_utf8_lossy(&output).into_owned())
    }

    /// Compiles the part that all simulators share, in a folder. Returns the library for
    /// [`compile`](Self::compile).
    ///
    /// # Errors
    ///
    /// There is no rustc, it fails, or the folder cannot be written.
    pub fn machinery(&self, source: &SimSource, folder: &Path) -> Result<Vec<u8>, CompileError> {
        self.build(
            source,
            folder,
            "libsrp_machinery.rlib",
            &["--crate-type=rlib"],
        )
    }

    /// Compiles a simulator in a folder, on the machinery that this compiler has made; gives the
    /// library that is loaded.
    ///
    /// # Errors
    ///
    /// There is no rustc, it fails (it needs the system's linker), or the folder cannot be written.
    pub fn compile(
        &self,
        source: &SimSource,
        machinery: &[u8],
        folder: &Path,
    ) -> Result<Vec<u8>, CompileError> {
        let name = "libsrp_machinery.rlib";
        write(&folder.join(name), machinery)?;
        let external = format!("srp_machinery={name}");
        let flags = [
            "--crate-type=cdylib",
            "-Cstrip=symbols",
            "--extern",
            &external,
        ];
        self.build(source, folder, "simulator.so", &flags)
    }

    fn build(
        &self,
        source: &SimSource,
        folder: &Path,
        library: &str,
        flags: &[&str],
    ) -> Result<Vec<u8>, CompileError> {
        for (name, text) in &source.files {
            write(&folder.join(name), text.as_bytes())?;
        }
        let name = match library.ends_with(".rlib") {
            true => "--crate-name=srp_machinery",
            false => "--crate-name=srp_simulator",
        };
        let own = [name, "lib.rs", "-o", library];
        let arguments = FLAGS.iter().chain(features()).chain(flags).chain(&own);
        let arguments: Vec<&str> = arguments.copied().collect();
        self.run(folder, &arguments)?;
        let path = folder.join(library);
        fs::read(&path).map_err(|source| CompileError::Folder { path, source })
    }

    /// Runs the compiler and returns its output.
    fn run(&self, folder: &Path, arguments: &[&str]) -> Result<Vec<u8>, CompileError> {
        let output = Command::new(&self.rustc)
            .env_clear()
            .envs((ENVIRONMENT.iter()).filter_map(|name| Some((name, env::var_os(name)?))))
            .env("TMPDIR", folder)
            .args(arguments)
            .current_dir(folder)
            .stdin(Stdio::null())
            .output()
            .map_err(|_| CompileError::NoRustc(self.rustc.clone()))?;
        match output.status.success() {
            true => Ok(output.stdout),
            false => Err(CompileError::Rustc {
                rustc: self.rustc.clone(),
                messages: String::from_utf8_lossy(&output.stderr).into_owned(),
            }),
        }
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CompileError> {
    fs::write(path, bytes).map_err(|source| CompileError::Folder {
        path: path.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_compiler_is_an_error_of_its_own() {
        let compiler = Compiler {
            rustc: PathBuf::from("no-such-rustc"),
        };
        let error = compiler.version(Path::new(".")).expect_err("there is none");
        assert!(matches!(error, CompileError::NoRustc(_)), "{error}");
    }
}
