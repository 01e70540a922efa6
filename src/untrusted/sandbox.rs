//! What a confined process gives up: rights to files, calls of the kernel, memory and time without bounds.

use super::{Rooms, calls};
use crate::failure::Failure;
use crate::limits::Limits;
use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, PathBeneath, PathFd,
    Ruleset, RulesetAttr, RulesetCreated, RulesetCreatedAttr, RulesetError, RulesetStatus, Scope,
};
use rustix::process::{Resource, Rlimit, Signal, setrlimit};
use seccompiler::BpfProgram;
use srp_toolchain::cache::Place;
use std::path::Path;

/// Confines this process, which has no other thread yet.
///
/// # Errors
///
/// The kernel does not have what it takes; then nothing has been read.
pub(super) fn enter(limits: &Limits, rooms: &Rooms) -> Result<(), Failure> {
    let failed = |what: &str, why: &dyn std::fmt::Display| {
        Failure::message(format_args!("--untrusted cannot {what}: {why}"))
    };
    // A panic of any thread is the end of the process: half of the work is no result.
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        tell(panic);
        std::process::exit(1);
    }));
    let with_guard = rustix::process::set_parent_process_death_signal(Some(Signal::KILL));
    with_guard.map_err(|why| failed("end with its guard", &why))?;
    if limits.landlock {
        let status = close_files(rooms).map_err(|why| no_landlock(&why))?;
        if status == RulesetStatus::NotEnforced {
            return Err(no_landlock(&"it is off"));
        }
    }
    bound(limits).map_err(|why| failed("set limits", &why))?;
    let filter = calls::filter(std::process::id());
    let program = filter.and_then(BpfProgram::try_from);
    let program = program.map_err(|why| failed("filter calls of the kernel", &why))?;
    seccompiler::apply_filter(&program)
        .map_err(|why| failed("filter calls of the kernel (seccomp)", &why))
}

fn no_landlock(why: &dyn std::fmt::Display) -> Failure {
    Failure::message(format_args!(
        "--untrusted needs Landlock (Linux 5.13 and later), which keeps the work from all other files, and this \
         kernel does not have it: {why}; --untrusted=no-landlock does without"
    ))
}

/// Takes all rights to files, to the network and to other processes, but those to the rooms.
fn close_files(rooms: &Rooms) -> Result<RulesetStatus, RulesetError> {
    let read = AccessFs::ReadFile | AccessFs::ReadDir;
    let write = AccessFs::WriteFile | AccessFs::MakeReg | AccessFs::MakeDir | AccessFs::RemoveFile;
    let ruleset = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_all(ABI::V1))?
        .set_compatibility(CompatLevel::BestEffort)
        .handle_access(AccessFs::from_all(ABI::V5))?
        .handle_access(AccessNet::from_all(ABI::V4))?
        .scope(Scope::from_all(ABI::V6))?;
    let mut ruleset = ruleset.create()?;
    for place in &rooms.read {
        ruleset = open(ruleset, place, read)?;
    }
    for place in &rooms.write {
        ruleset = open(ruleset, place, read | write | AccessFs::Truncate)?;
    }
    if let Place::Folder(cache) = Place::of_user() {
        ruleset = open(ruleset, &cache, read)?;
    }
    Ok(ruleset.restrict_self()?.ruleset)
}

/// Gives rights to a file, or to a folder and all below it, if it is there.
fn open(
    ruleset: RulesetCreated,
    place: &Path,
    rights: BitFlags<AccessFs>,
) -> Result<RulesetCreated, RulesetError> {
    let Ok(found) = PathFd::new(place) else {
        return Ok(ruleset);
    };
    let rights = match place.is_dir() {
        true => rights,
        false => rights & AccessFs::from_file(ABI::V5),
    };
    ruleset.add_rule(PathBeneath::new(found, rights))
}

/// Sets the limits that the kernel counts, for good.
fn bound(limits: &Limits) -> rustix::io::Result<()> {
    let both = |limit: u64| Rlimit {
        current: Some(limit),
        maximum: Some(limit),
    };
    // The program itself does not count, however large it is.
    let memory = limits.memory.saturating_add(own_memory());
    setrlimit(Resource::As, both(memory))?;
    setrlimit(Resource::Core, both(0))?;
    setrlimit(Resource::Nofile, both(256))?;
    setrlimit(Resource::Fsize, both(limits.written))?;
    // The signal of the first can be told from others; a process that does not heed it meets the second.
    let time = Rlimit {
        current: Some(limits.seconds),
        maximum: Some(limits.seconds + 2),
    };
    setrlimit(Resource::Cpu, time)
}

/// Bytes of addresses that this process takes by now.
fn own_memory() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = pages.split_whitespace().next().and_then(|n| n.parse().ok());
    pages.unwrap_or(0) * rustix::param::page_size() as u64
}
