//! JSON documents: the envelope of this run around what a command found.

use crate::failure::Failure;
use clap::{ArgMatches, Command};
use srp_toolchain::envelope::{About, Asked, Contents, Envelope, Setting};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Arguments that only say where results go, how they look, and how many threads compute them, so that documents of the
/// same question are the same.
const NOT_OF_THE_QUESTION: &[&str] = &[
    "all",
    "build",
    "checkpoint",
    "checkpoint_at",
    "color",
    "engine",
    "error_format",
    "export",
    "heat",
    "hits",
    "html",
    "jobs",
    "jobs_on",
    "json",
    "loops",
    "output",
    "profile",
    "proof",
    "quiet",
    "registers",
    "report",
    "restore",
    "shard",
    "share",
    "table_form",
    "threads",
    "trace_format",
    "trace_output",
    "untrusted",
    "verbose",
];

/// What the command line asks for.
static ASKED: OnceLock<Asked> = OnceLock::new();

/// Remembers what the command line asks for; documents tell it.
pub(crate) fn remember(command: &Command, matches: &ArgMatches) {
    let mut names = Vec::new();
    let mut options = BTreeMap::new();
    let (mut command, mut matches) = (command, matches);
    while let Some((name, inner)) = matches.subcommand() {
        let Some(found) = command.find_subcommand(name) else {
            break;
        };
        (command, matches) = (found, inner);
        names.push(name);
        let arguments = command.get_arguments();
        let arguments = arguments.filter(|a| !NOT_OF_THE_QUESTION.contains(&a.get_id().as_str()));
        options.extend(arguments.filter_map(|argument| {
            let name = argument.get_long().map_or_else(
                || argument.get_id().as_str().replace('_', "-"),
                str::to_owned,
            );
            Some((name, setting(argument, matches)?))
        }));
    }
    let command = names.join(" ");
    // There is one command line, and it is read once.
    let _ = ASKED.set(Asked { command, options });
}

/// The value of an argument; none where it has none.
fn setting(argument: &clap::Arg, matches: &ArgMatches) -> Option<Setting> {
    let id = argument.get_id().as_str();
    if !argument.get_action().takes_values() {
        let given = matches.try_get_one::<bool>(id).ok()??;
        return Some(Setting::Flag(*given));
    }
    let raw = matches.try_get_raw(id).ok()??;
    let mut values = raw.map(|value| value.to_string_lossy().into_owned());
    let several = argument.get_num_args().is_some_and(|n| n.max_values() > 1)
        || matches!(argument.get_action(), clap::ArgAction::Append);
    match several {
        true => Some(Setting::Values(values.collect())),
        false => values.next().map(Setting::Value),
    }
}

/// The document of what a command found.
pub(crate) fn json<T: Contents>(about: About, contents: &T) -> Result<String, Failure> {
    let asked = ASKED.get().cloned().unwrap_or_default();
    Ok(Envelope::new(asked, about, contents).text()?)
}
