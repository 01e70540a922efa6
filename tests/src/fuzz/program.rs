//! Any text is a program in the intermediate form, or a divided one, which is the same when it is written and read again;
//! or it is refused.

use srp_ir::{dre, text};
use std::fmt::{Debug, Display};

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let given = String::from_utf8_lossy(data);
    written_and_read(&given, text::read, text::write);
    written_and_read(&given, dre::read, dre::write);
}

fn written_and_read<P, E: Debug + Display>(
    given: &str,
    read: impl Fn(&str) -> Result<P, E>,
    write: impl Fn(&P) -> String,
) {
    match read(given) {
        Ok(program) => {
            let written = write(&program);
            let again = read(&written).unwrap_or_else(|e| panic!("{e}: {written}"));
            assert_eq!(write(&again), written);
        }
        Err(error) => drop(error.to_string()),
    }
}
