//! Any text is a machine, which is the same when it is written out and read again, or is refused with messages that can
//! be shown.

use srp_archdesc::diagnostic::render_all;

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    match srp_archdesc::parse("fuzz.xml", &text) {
        Ok(arch) => {
            let written = srp_archdesc::xml::write(&arch);
            let again = srp_archdesc::parse("again.xml", &written);
            assert!(again.is_ok_and(|again| again == arch), "{written}");
        }
        Err(messages) => drop(render_all(&messages, &text, false)),
    }
}
