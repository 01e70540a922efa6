//! Loading a compiled simulator. Here this crate leaves what the compiler can
//! check: functions of a library are called through pointers, as [`abi`](crate::preamble::abi) has
//! them. A simulator that is linked into a program is called in the same way, so that tools which look at a whole
//! program, such as Miri, see both sides.

#![allow(
    unsafe_code,
    reason = "a library's functions can be reached in no other way"
)]

use crate::preamble::abi::{HostBus, Outcome, Sram, VERSION};
use crate::spec::SimSpec;
use libloading::Library;
use srp_runtime::core::{Bus, Core, CoreState, Lanes, Run, Trap};
use std::ffi::c_void;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A compiled simulator, loaded.
#[derive(Clone, Debug)]
pub struct Simulator {
    functions: Functions,
    positions: Arc<[String]>,
    /// The library of the functions, without which their pointers mean nothing.
    _library: Option<Arc<Library>>,
}

/// The functions of a simulator, by the names that [`emit`](crate::emit()) gives them.
#[derive(Clone, Copy, Debug)]
pub struct Functions {
    /// `srp_new`: a core at the start of its program.
    pub new: extern "C" fn() -> *mut c_void,
    /// `srp_run`: runs a core for so many cycles at most.
    pub run: unsafe extern "C" fn(*mut c_void, &mut HostBus, u64, &mut Outcome),
    /// `srp_save`: writes the state of a core where there is room for it.
    pub save: unsafe extern "C" fn(*const c_void, *mut u32, usize) -> usize,
    /// `srp_restore`: sets the state of a core.
    pub restore: unsafe extern "C" fn(*mut c_void, *const u32, usize) -> u32,
    /// `srp_free`: ends a core.
    pub free: unsafe extern "C" fn(*mut c_void),
}

/// Why a library cannot be used.
#[derive(Debug)]
pub enum LoadError {
    /// It cannot be loaded, or lacks a function.
    Library {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: libloading::Error,
    },
    /// It was made for another version of this crate.
    Version {
        /// The file.
        path: PathBuf,
        /// Its version of the interface.
        found: u32,
    },
}

impl std::fmt::Display for LoadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            LoadError::Library { path, source } => {
                write!(f, "cannot load the simulator {}: {source}", path.display())
            }
            LoadError::Version { path, found } => write!(
                f,
                "the simulator {} has version {found} of the interface, not {VERSION}",
                path.display()
            ),
        }
    }
}

impl std::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            LoadError::Library { source, .. } => Some(source),
            LoadError::Version { .. } => None,
        }
    }
}

impl Simulator {
    /// Loads the library at `path`, which [`Compiler::compile`](crate::Compiler::compile) has made of the source of
    /// `spec`.
    ///
    /// # Errors
    ///
    /// If the file is no library with a simulator, or one of another version of the interface.
    pub fn load(path: &Path, spec: &SimSpec) -> Result<Simulator, LoadError> {
        let failed = |source| LoadError::Library {
            path: path.to_owned(),
            source,
        };
        // SAFETY: a simulator's library has no code that runs when it is loaded. The types are
        // those that `emit` gives the functions of these names; the version is asked first.
        let (functions, library) = unsafe {
            let library = Library::new(path).map_err(failed)?;
            let version = library
                .get::<extern "C" fn() -> u32>(b"srp_abi_version\0")
                .map_err(failed)?;
            let found = version();
            if found != VERSION {
                let path = path.to_owned();
                return Err(LoadError::Version { path, found });
            }
            let functions = Functions {
                new: *library.get(b"srp_new\0").map_err(failed)?,
                run: *library.get(b"srp_run\0").map_err(failed)?,
                save: *library.get(b"srp_save\0").map_err(failed)?,
                restore: *library.get(b"srp_restore\0").map_err(failed)?,
                free: *library.get(b"srp_free\0").map_err(failed)?,
            };
            (functions, library)
        };
        Ok(Simulator {
            functions,
            positions: spec.positions.clone().into(),
            _library: Some(Arc::new(library)),
        })
    }

    /// The simulator that is part of this program.
    ///
    /// # Safety
    ///
    /// The functions are those of one source that [`emit`](crate::emit()) of this version has written, of `spec`.
    pub unsafe fn linked(functions: Functions, spec: &SimSpec) -> Simulator {
        Simulator {
            functions,
            positions: spec.positions.clone().into(),
            _library: None,
        }
    }

    /// A core at the start of its program, all registers zero.
    pub fn core(&self) -> GeneratedCore {
        GeneratedCore {
            core: (self.functions.new)(),
            simulator: self.clone(),
        }
    }
}

/// A simulated SRP that runs generated code.
#[derive(Debug)]
pub struct GeneratedCore {
    core: *mut c_void,
    simulator: Simulator,
}

// SAFETY: the core is a heap object of the library that nothing else points to, made of plain data.
unsafe impl Send for GeneratedCore {}

impl Drop for GeneratedCore {
    fn drop(&mut self) {
        // SAFETY: it is from `srp_new` and this is its end.
        unsafe { (self.simulator.functions.free)(self.core) }
    }
}

impl Core for GeneratedCore {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let mut bus: &mut dyn Bus = bus;
        // SAFETY: the bus is borrowed here until the library's call returns, and `with_bus`, through which alone it is
        // used meanwhile, lends its SRAM anew.
        let sram = unsafe { Sram::lent(bus.sram()) };
        let mut host = HostBus {
            sram,
            stalled: 0,
            host: (&raw mut bus).cast(),
            cached_load,
            cached_store,
            prefetch,
            conflict,
            texture_descriptor,
            texels,
            fetch,
            launch,
            port_in,
            port_out,
        };
        let mut outcome = Outcome::default();
        // SAFETY: `core` is from `srp_new` of the same library; `host` keeps the promise of
        // `HostBus`, as the bus is borrowed here until the call returns.
        unsafe { (self.simulator.functions.run)(self.core, &mut host, budget, &mut outcome) };
        match outcome.read() {
            Some(Ok(run)) => Ok(run),
            Some(Err((kind, at, calls))) => {
                let positions = &self.simulator.positions;
                Err(crate::interp::trap(kind, at, calls.into_iter(), positions))
            }
            None => unreachable!("the library has the same list of outcomes"),
        }
    }

    fn save(&self) -> Option<CoreState> {
        let save = self.simulator.functions.save;
        let mut words = Vec::new();
        loop {
            // SAFETY: `core` is from `srp_new` of the same library, and `words` has this room.
            let count = unsafe { save(self.core, words.as_mut_ptr(), words.len()) };
            if count == 0 {
                return None;
            }
            if count <= words.len() {
                words.truncate(count);
                return Some(CoreState { words });
            }
            words.resize(count, 0);
        }
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        let (words, count) = (state.words.as_ptr(), state.words.len());
        // SAFETY: `core` is from `srp_new` of the same library, and these are all words.
        unsafe { (self.simulator.functions.restore)(self.core, words, count) != 0 }
    }
}

/// Calls `f` with the bus behind `host` and brings what the library knows of it up to date.
fn with_bus<T>(host: &mut HostBus, f: impl FnOnce(&mut dyn Bus) -> T) -> T {
    // SAFETY: `run` has put a pointer to its `&mut dyn Bus` there, which lives until its call of
    // the library returns, and nobody else uses it meanwhile.
    let bus = unsafe { &mut *host.host.cast::<&mut dyn Bus>() };
    let result = f(*bus);
    host.stalled = u32::from(bus.stalled());
    // SAFETY: as in `run`, whose borrow of the bus goes on.
    host.sram = unsafe { Sram::lent(bus.sram()) };
    result
}

extern "C" fn cached_load(host: &mut HostBus, address: u32, bytes: u32, value: &mut Lanes) -> u32 {
    match with_bus(host, |bus| bus.cached_load(address, bytes)) {
        Some(lanes) => {
            *value = lanes;
            1
        }
        None => 0,
    }
}

extern "C" fn cached_store(host: &mut HostBus, address: u32, bytes: u32, value: &Lanes) -> u32 {
    u32::from(with_bus(host, |bus| bus.cached_store(address, bytes, *value)).is_some())
}

extern "C" fn prefetch(host: &mut HostBus, address: u32) {
    with_bus(host, |bus| bus.prefetch(address));
}

extern "C" fn conflict(host: &mut HostBus, cycles: u32) {
    with_bus(host, |bus| bus.conflict(cycles));
}

extern "C" fn texture_descriptor(host: &mut HostBus, address: u32, value: &mut Lanes) -> u32 {
    match with_bus(host, |bus| bus.texture_descriptor(address)) {
        Some(words) => {
            *value = words;
            1
        }
        None => 0,
    }
}

extern "C" fn texels(host: &mut HostBus, lanes: &mut Lanes) -> u32 {
    match with_bus(host, |bus| bus.texels(*lanes)) {
        Ok(texels) => {
            *lanes = texels;
            1
        }
        Err(address) => {
            lanes[0] = address;
            0
        }
    }
}

extern "C" fn fetch(host: &mut HostBus, bundle: u32, there: &mut [u32; 2]) {
    let bundles = with_bus(host, |bus| bus.fetch(bundle));
    *there = [bundles.start, bundles.end];
}

extern "C" fn launch(host: &mut HostBus, kernel: u32) {
    with_bus(host, |bus| bus.launch(kernel));
}

extern "C" fn port_in(host: &mut HostBus, port: u32, value: &mut u32) -> u32 {
    match with_bus(host, |bus| bus.port_in(port)) {
        Some(word) => {
            *value = word;
            1
        }
        None => 0,
    }
}

extern "C" fn port_out(host: &mut HostBus, port: u32, value: u32) -> u32 {
    u32::from(with_bus(host, |bus| bus.port_out(port, value)))
}
