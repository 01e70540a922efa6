//! The report of initiation intervals: text, JSON and one self-contained page of what
//! [`srp_studies::loops`] finds.

mod command;
mod diff;
mod html;
mod output;
mod text;
pub(crate) mod watch;

pub(crate) use command::{compare, run};
pub(crate) use diff::in_words as machines_in_words;
pub(crate) use output::Loops;
pub(crate) use text::{MOST_ORDERED, not_pipelined};
