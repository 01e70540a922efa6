//! The command line of `srp cache`.

use clap::{Args, Subcommand};

/// `srp cache`
#[derive(Args)]
#[command(after_help = "\
Schedules, compiled simulators, frames and trials are kept in SRP_CACHE, else in the user's cache
folder, up to SRP_CACHE_LIMIT bytes (1G; K, M and G are understood), those used least recently going
first. Each entry is checked before it is used; it may be deleted at any time.

Examples:
  srp cache show
  srp cache clean
  SRP_CACHE=/tmp/mine srp cache verify

Exit status of verify: 0 all entries are whole, 1 some were damaged, and removed.")]
pub(crate) struct Cache {
    #[command(subcommand)]
    pub(crate) action: CacheAction,
}

/// What to do with it.
#[derive(Clone, Copy, Subcommand)]
pub(crate) enum CacheAction {
    /// Say where it is and what is in it.
    Show {
        /// Print JSON instead of text
        #[arg(long)]
        json: bool,
    },
    /// Remove all entries.
    Clean,
    /// Check all entries, and remove those that are damaged.
    Verify,
}
