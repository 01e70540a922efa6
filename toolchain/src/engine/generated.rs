//! Generated simulators: how the cache keeps them, and how they are compiled.

use crate::Session;
use crate::cache::{Cache, Key, Kind, Place};
use serde::{Deserialize, Serialize};
use srp_archdesc::watch::{Stage, Unwatched, Watch};
use srp_csimgen::compile::flags;
use srp_csimgen::emit::machinery;
use srp_csimgen::emit_on_machinery;
use srp_csimgen::{CompileError, Compiler, LoadError, SimSource, SimSpec, Simulator};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{self, Read};

/// The source of a simulator, and the key of its library. Only the text decides: neither the names of
/// the program's files nor the compiler's version is in the key, because neither changes what a
/// simulator does.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Source {
    files: BTreeMap<String, String>,
}

/// Why there is no simulator.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoSimulator {
    #[error(transparent)]
    Compile(#[from] CompileError),
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error("there is no folder to compile a simulator in: {0}")]
    Folder(#[from] io::Error),
    #[error("the simulator cannot be kept in a file, from which it is loaded")]
    NotKept,
}

impl Source {
    pub(super) fn of(spec: &SimSpec) -> Source {
        Source {
            files: emit_on_machinery(spec).files,
        }
    }

    fn key(&self) -> Key {
        let key = Key::of(Kind::Simulators).value(&machinery().files);
        let key = flags().fold(key, |key, flag| key.text(flag));
        key.value(&self.files).finish()
    }

    /// The simulator of `spec`, whose source this is, if it was compiled before. Needs no compiler.
    pub(super) fn kept(&self, spec: &SimSpec, session: &Session<'_>) -> Option<Simulator> {
        load(&session.cache, self.key(), spec, session.watch)?.ok()
    }

    /// The simulator as far as another process has made it.
    pub(super) fn kept_by_another(&self, spec: &SimSpec, cache: &Cache) -> Option<Simulator> {
        load(cache, self.key(), spec, &Unwatched)?.ok()
    }

    /// Compiles the simulator and loads it.
    pub(super) fn made(
        &self,
        spec: &SimSpec,
        session: &Session<'_>,
    ) -> Result<Simulator, NoSimulator> {
        let _stage = Stage::unknown(session.watch, "compiling the simulator");
        self.compile(&session.cache, session.watch)?;
        let loaded = load(&session.cache, self.key(), spec, session.watch);
        Ok(loaded.ok_or(NoSimulator::NotKept)??)
    }

    /// Compiles the simulator into a cache.
    fn compile(&self, cache: &Cache, watch: &dyn Watch) -> Result<(), NoSimulator> {
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let compiler = Compiler {
            rustc: rustc.into(),
        };
        let place = cache.workplace(watch)?;
        let shared = machinery();
        // A compiler reads only what it has made itself.
        let key = Key::of(Kind::Simulators)
            .text("machinery")
            .text(&compiler.version(place.path())?)
            .value(&shared.files);
        let key = flags().fold(key, |key, flag| key.text(flag)).finish();
        let library = match cache.bytes(key, watch) {
            Some(library) => library,
            None => {
                let place = cache.workplace(watch)?;
                let library = compiler.machinery(&shared, place.path())?;
                cache.put_bytes(key, library.as_slice().into(), watch);
                library.into()
            }
        };
        let source = SimSource {
            files: self.files.clone(),
        };
        let simulator = compiler.compile(&source, &library, place.path())?;
        cache.put_bytes(self.key(), simulator.into(), watch);
        Ok(())
    }

    /// The source as the request of a build in another process.
    pub(super) fn request(&self) -> Vec<u8> {
        postcard::to_allocvec(self).unwrap_or_default()
    }
}

/// Loads the library of a key, if it is there.
fn load(
    cache: &Cache,
    key: Key,
    spec: &SimSpec,
    watch: &dyn Watch,
) -> Option<Result<Simulator, LoadError>> {
    let path = cache.file(key, watch)?;
    Some(Simulator::load(&path, spec))
}

/// The argument by which a process is asked to [`build`].
const BUILD: &str = "--build-simulator";

/// True if a process is asked to do nothing but [`build`].
pub fn is_build_request(argument: &OsStr) -> bool {
    argument == BUILD
}

/// How another process is asked to build a simulator: a program, which calls [`build`] where its first
/// argument [asks for that](is_build_request).
pub(super) fn ask(program: &std::path::Path) -> std::process::Command {
    let mut command = std::process::Command::new(program);
    command.arg(BUILD);
    command
}

/// Builds the simulator whose source comes over standard input, into the user's cache. The builder of a
/// [`Session`] does this beside the work that waits for it, and longer if need be.
///
/// # Errors
///
/// A sentence that says why there is no simulator.
pub fn build() -> Result<(), String> {
    let mut request = Vec::new();
    let read = io::stdin().read_to_end(&mut request);
    read.map_err(|error| error.to_string())?;
    let source: Source = postcard::from_bytes(&request).map_err(|error| error.to_string())?;
    let cache = Cache::at(Place::of_user());
    let built = source.compile(&cache, &Unwatched);
    built.map_err(|error| error.to_string())
}
