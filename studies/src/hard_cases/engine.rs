//! Where the kernels' functions are run: on the host, by its C compiler, and on the simulated SRP.

use super::call::Calls;
use crate::Error;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::isa::Class;
use srp_csimgen::{Interpreter, link};
use srp_ir::check::Checked;
use srp_runtime::effect::{Effect, Effects};
use srp_runtime::solo::{self, Finish, Solo, SoloError};
use srp_toolchain::cache::Workplace;
use srp_toolchain::files::{self, FileError, Kind};
use srp_toolchain::{Effort, Input, Options, Session, compile, input};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The driver's text.
const DRIVER: &str = include_str!("driver.c");

/// Where it is.
const FOLDER: &str = "studies/src/hard_cases";

/// The effects that the kernels are built for: surfaces that mirror, bend and scatter light and have shadows.
const EFFECTS: &str = "normals,texture,light,lights,highlight,shadow,reflection,transparency,\
                       refraction,fresnel,inter_reflection";

/// Cycles after which the driver is said not to end.
const MOST_CYCLES: u64 = 2_000_000_000;

/// Bytes of system memory that the driver has on the host.
pub(super) const HOST_MEMORY: usize = 8 << 20;

/// True if a machine samples textures.
pub(super) fn has_textures(arch: &Arch) -> bool {
    arch.srp.fus.values().any(|fu| fu.op(Class::Tex).is_some())
}

fn defines(textures: bool) -> Vec<(String, String)> {
    let effects = Effects::NONE.parse(EFFECTS);
    let (effects, _) = effects.expect("they are names of effects");
    let effects = match textures {
        true => effects,
        false => effects.without(Effect::Texture),
    };
    effects.defines().collect()
}

/// The C that is tried: the driver, and the kernels of the frame but for its queue of jobs.
pub(super) struct Kernels {
    sources: Vec<Source>,
    /// Headers in it come before those that come along.
    folder: Option<PathBuf>,
}

impl Kernels {
    /// The kernels that come along, or all C files of a folder.
    pub(super) fn of(folder: Option<&Path>) -> Result<Kernels, Error> {
        let kernels = match folder {
            None => input::kernels(),
            Some(folder) => input::kernels_in(folder)?,
        };
        let is_queue = |s: &Source| Path::new(&s.name).ends_with("frame.c");
        let driver = Source::new(format!("{FOLDER}/driver.c"), DRIVER);
        let kernels = kernels.into_iter().filter(|s| !is_queue(s));
        Ok(Kernels {
            sources: [driver].into_iter().chain(kernels).collect(),
            folder: folder.map(Path::to_owned),
        })
    }

    /// The C files.
    pub(super) fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// The same, to be compiled.
    pub(super) fn input(&self) -> Input {
        Input::C(self.sources.clone())
    }

    /// All texts that a driver is compiled from.
    pub(super) fn all(&self) -> Result<Vec<Source>, Error> {
        let mut all = self.headers()?;
        all.extend(self.sources.iter().cloned());
        Ok(all)
    }

    /// Every header by its name; of two with one name the later counts.
    fn headers(&self) -> Result<Vec<Source>, Error> {
        let mut headers: Vec<Source> = srp_kernels::HEADERS.iter().map(input::source).collect();
        let Some(folder) = &self.folder else {
            return Ok(headers);
        };
        let wrong = |e| FileError::reading(folder, e);
        for entry in std::fs::read_dir(folder).map_err(wrong)? {
            let path = entry.map_err(wrong)?.path();
            if path.extension().is_some_and(|e| e == "h") {
                headers.push(files::read_source(&path, Kind::Source)?);
            }
        }
        Ok(headers)
    }
}

/// The driver as the host's C compiler has made it.
pub(super) struct Host {
    folder: Workplace,
}

impl Host {
    /// Compiles the driver; `None` where there is no C compiler `cc`.
    pub(super) fn compile(kernels: &Kernels, session: &Session<'_>) -> Result<Option<Host>, Error> {
        let folder = session.cache.workplace(session.watch);
        let folder = folder.map_err(|e| FileError::writing(&std::env::temp_dir(), e))?;
        let host = Host { folder };
        let mut command = Command::new("cc");
        command.args([
            "-std=gnu11",
            "-O1",
            "-ffp-contract=off",
            "-fwrapv",
            "-w",
            "-I",
        ]);
        command.arg(host.folder.path());
        command.args(defines(true).iter().map(|(n, v)| format!("-D{n}={v}")));
        for source in kernels.sources.iter().chain(&kernels.headers()?) {
            let name = Path::new(&source.name).file_name().unwrap_or_default();
            let path = host.folder.path().join(name);
            files::write(&path, source.text.as_bytes())?;
            if source.name.ends_with(".c") {
                command.arg(path);
            }
        }
        command.arg("-lm").arg("-o").arg(host.program());
        match command.output() {
            Err(_) => Ok(None),
            Ok(output) if output.status.success() => Ok(Some(host)),
            Ok(output) => Err(Error::invalid(format_args!(
                "the host's C compiler refuses the driver: {}",
                String::from_utf8_lossy(&output.stderr)
            ))),
        }
    }

    fn program(&self) -> PathBuf {
        self.folder.path().join("driver")
    }

    /// System memory after the driver has run.
    pub(super) fn run(&self, memory: &[u8]) -> Result<Vec<u8>, Error> {
        let failed =
            |e: std::io::Error| Error::invalid(format_args!("the driver on the host: {e}"));
        let mut child = Command::new(self.program())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let mut whole = memory.to_vec();
        whole.resize(HOST_MEMORY.max(memory.len()), 0);
        let mut input = child.stdin.take();
        // The driver reads everything before it writes.
        let written = input.as_mut().map(|input| input.write_all(&whole));
        drop(input);
        let output = child.wait_with_output().map_err(failed)?;
        match (written, output.status.success()) {
            (Some(Ok(())), true) => Ok(output.stdout),
            _ => Err(Error::invalid("the driver on the host fails")),
        }
    }
}

/// How the driver is compiled for some calls.
pub(super) fn options(kernels: &Kernels, calls: &Calls, arch: &Arch) -> Options {
    Options {
        include: kernels.folder.iter().cloned().collect(),
        defines: [defines(has_textures(arch)), calls.defines().to_vec()].concat(),
        auto_kernel: false,
        // Verdicts are of values, not of cycles.
        effort: Effort {
            percent: 2,
            ..Effort::default()
        },
        ..Options::default()
    }
}

/// The driver scheduled for a machine.
pub(super) struct Srp {
    program: Checked,
}

impl Srp {
    /// Compiles the driver for some calls; loops that are known are not scheduled again.
    pub(super) fn compile(
        kernels: &Kernels,
        calls: &Calls,
        arch: &Arch,
        session: &Session<'_>,
    ) -> Result<Srp, Error> {
        let options = options(kernels, calls, arch);
        let compiled = compile(kernels.input(), arch, &options, session)?;
        session.check()?;
        Ok(Srp {
            program: compiled.runnable()?.clone(),
        })
    }

    /// System memory after the driver has run.
    pub(super) fn run(&self, memory: Vec<u8>, session: &Session<'_>) -> Result<Vec<u8>, Error> {
        let spec = link(&self.program).map_err(srp_toolchain::Error::from)?;
        let mut bus = Solo::new(&self.program.image, self.program.arch().system.sram_bytes);
        bus.memory = memory;
        let mut finish = Finish::default();
        let mut core = Interpreter::new(&spec);
        let ended = solo::run_until(&mut core, &mut bus, MOST_CYCLES, session.watch, &mut finish);
        match ended {
            Ok(()) => Ok(bus.memory),
            Err(SoloError::Stopped) => Err(srp_toolchain::Error::Cancelled.into()),
            Err(error) => Err(Error::invalid(format_args!(
                "the driver on the SRP: {error}"
            ))),
        }
    }
}
