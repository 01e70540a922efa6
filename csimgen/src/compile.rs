//! [`compile()`]: rustc makes a library of a simulator's source, once: the result is kept in a
//! folder that the caller names, under a hash of everything that it depends on.
//!
//! Any number of processes may use the folder at once. Each makes its library in a folder of its
//! own name and then renames that; whoever comes second finds the name taken and uses what is
//! there. Entries are never changed, and may be deleted at any time while nobody compiles.

use crate::emit::SimSource;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{fs, io};

/// What rustc is called with, beside the names of files and [`features`]. Simulators are many small
/// functions: higher levels of optimisation take several times as long and gain nothing but
/// vectors, which the one pass brings.
const FLAGS: &[&str] = &[
    "--edition=2024",
    "--crate-type=cdylib",
    "--crate-name=srp_simulator",
    "--cap-lints=allow",
    "-Copt-level=1",
    "-Ccodegen-units=1",
    "-Cpanic=abort",
    "-Cstrip=symbols",
    "-Cpasses=slp-vectorizer",
];

/// What the host has beyond the least of its kind that is worth using: fused multiply-add, which
/// takes a dozen instructions otherwise. Results are the same with it and without.
fn features() -> &'static [&'static str] {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("fma") {
        return &["-Ctarget-feature=+fma"];
    }
    &[]
}

/// Where things are.
#[derive(Clone, Debug)]
pub struct CompileOptions {
    /// The compiler: a path, or a name that is searched for as commands are.
    pub rustc: PathBuf,
    /// The folder of compiled simulators; made if it is not there.
    pub cache: PathBuf,
}

/// What [`compile()`] is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The simulator was compiled before: there is nothing to do.
    Cached,
    /// rustc runs now, on this many bytes of source.
    Compiling(usize),
}

/// Why there is no library.
#[derive(Debug)]
pub enum CompileError {
    /// There is no compiler of this name. The interpreter needs none.
    NoRustc(PathBuf),
    /// The compiler failed.
    Rustc {
        /// What it was.
        rustc: PathBuf,
        /// What it said.
        messages: String,
    },
    /// A file or folder of the cache cannot be used.
    Cache {
        /// Which.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl std::fmt::Display for CompileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            CompileError::NoRustc(rustc) => {
                write!(f, "there is no Rust compiler `{}`", rustc.display())
            }
            CompileError::Rustc { rustc, messages } => {
                let rustc = rustc.display();
                write!(f, "`{rustc}` failed on the simulator:\n{messages}")
            }
            CompileError::Cache { path, source } => {
                let path = path.display();
                write!(f, "cannot keep the simulator in {path}: {source}")
            }
        }
    }
}

impl std::error::Error for CompileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            CompileError::Cache { source, .. } => Some(source),
            CompileError::NoRustc(_) | CompileError::Rustc { .. } => None,
        }
    }
}

/// Compiles a simulator, unless that was done before, and gives the path of the library.
///
/// # Errors
///
/// If there is no rustc, if it fails (it needs the system's linker), or if the cache cannot be
/// written.
pub fn compile(
    source: &SimSource,
    options: &CompileOptions,
    progress: &mut dyn FnMut(Progress),
) -> Result<PathBuf, CompileError> {
    let version = rustc_version(&options.rustc)?;
    let key = key(source, &version);
    let entry = options.cache.join(&key);
    let library = entry.join(library_name());
    if library.is_file() {
        progress(Progress::Cached);
        return Ok(library);
    }
    progress(Progress::Compiling(
        source.files.values().map(String::len).sum(),
    ));
    let attempt = Attempt::begin(&options.cache, &key)?;
    build(source, &options.rustc, &attempt.path)?;
    match fs::rename(&attempt.path, &entry) {
        Ok(()) => Ok(library),
        // Somebody else was faster.
        Err(_) if library.is_file() => Ok(library),
        Err(source) => Err(CompileError::Cache {
            path: entry,
            source,
        }),
    }
}

/// What the compiler says that it is.
fn rustc_version(rustc: &Path) -> Result<String, CompileError> {
    let output = Command::new(rustc).arg("-vV").output();
    let output = output.map_err(|_| CompileError::NoRustc(rustc.to_owned()))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(CompileError::Rustc {
        rustc: rustc.to_owned(),
        messages: String::from_utf8_lossy(&output.stderr).into_owned(),
    })
}

fn library_name() -> String {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    format!("{DLL_PREFIX}srp_simulator{DLL_SUFFIX}")
}

/// A folder in the making; it goes when this does, unless it was renamed.
struct Attempt {
    path: PathBuf,
}

impl Attempt {
    fn begin(cache: &Path, key: &str) -> Result<Attempt, CompileError> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = cache.join(format!("{key}.{}.{count}", std::process::id()));
        fs::create_dir_all(&path).map_err(|source| CompileError::Cache {
            path: path.clone(),
            source,
        })?;
        Ok(Attempt { path })
    }
}

impl Drop for Attempt {
    fn drop(&mut self) {
        // It is no longer there if all went well, and only takes up room if this fails.
        let _ = fs::remove_dir_all(&self.path);
    }
}

/// Writes the source into `folder` and compiles it there.
fn build(source: &SimSource, rustc: &Path, folder: &Path) -> Result<(), CompileError> {
    for (name, text) in &source.files {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|source| CompileError::Cache { path, source })?;
    }
    let output = Command::new(rustc)
        .args(FLAGS)
        .args(features())
        .args(["lib.rs", "-o", &library_name()])
        .current_dir(folder)
        .output()
        .map_err(|_| CompileError::NoRustc(rustc.to_owned()))?;
    if output.status.success() {
        return Ok(());
    }
    Err(CompileError::Rustc {
        rustc: rustc.to_owned(),
        messages: String::from_utf8_lossy(&output.stderr).into_owned(),
    })
}

/// The name of a simulator in the cache: a hash of source, compiler and flags.
fn key(source: &SimSource, version: &str) -> String {
    let mut hash = Fnv::new();
    hash.text(version);
    for flag in FLAGS.iter().chain(features()) {
        hash.text(flag);
    }
    for (name, text) in &source.files {
        hash.text(name);
        hash.text(text);
    }
    format!("{:032x}", hash.0)
}

/// FNV-1a with 128 bits: fixed for all time, unlike the hashes of the standard library. Nobody
/// gains by a collision, so it need not withstand attack.
struct Fnv(u128);

impl Fnv {
    fn new() -> Fnv {
        Fnv(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 ^= u128::from(byte);
            self.0 = self.0.wrapping_mul(0x0100_0000_0000_0000_0000_013b);
        }
    }

    /// A text with its length, so that no two lists of texts look the same.
    fn text(&mut self, text: &str) {
        self.bytes(&(text.len() as u64).to_le_bytes());
        self.bytes(text.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of the FNV authors' reference.
    #[test]
    fn fnv_is_fnv() {
        let hash = |text: &str| {
            let mut hash = Fnv::new();
            hash.bytes(text.as_bytes());
            hash.0
        };
        assert_eq!(hash(""), 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        assert_eq!(hash("a"), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
        assert_eq!(hash("foobar"), 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18);
    }

    #[test]
    fn no_compiler_is_an_error_of_its_own() {
        let options = CompileOptions {
            rustc: PathBuf::from("no-such-rustc"),
            cache: PathBuf::from("unused"),
        };
        let source = SimSource {
            files: Default::default(),
        };
        let error = compile(&source, &options, &mut |_| {}).expect_err("there is no compiler");
        assert!(matches!(error, CompileError::NoRustc(_)), "{error}");
    }
}
