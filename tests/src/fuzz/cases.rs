//! Any text is hard cases, which are the same when they are written and read again, or is refused with messages that can
//! be shown; so are rays and requests to a memory.

use srp_archdesc::diagnostic::{Source, render_all};
use srp_runtime::memory::dram::trace;
use srp_studies::hard_cases::{self, export};
use srp_studies::rays;

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let text = String::from_utf8_lossy(data).into_owned();
    let read = |text: &str| hard_cases::cases(Some(&[Source::new("fuzz.cases", text)]), "");
    match read(&text) {
        Ok(cases) => {
            let written = export::text(&cases);
            let again = read(&written).unwrap_or_else(|e| panic!("{e}: {written}"));
            assert_eq!(export::text(&again), written);
            export::c(&cases);
        }
        Err(error) => drop(error.to_string()),
    }
    if let Err(message) = rays::read("fuzz.rays", &text) {
        render_all(&[*message], &text, false);
    }
    if let Err(messages) = trace::parse("fuzz.trace", &text, 64) {
        render_all(&messages, &text, false);
    }
}
