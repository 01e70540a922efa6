//! Any text is a program in the intermediate form, or a divided one, which is the same when it is written and read again;
//! or it is refused.

use srp_ir::{dre, text};

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let given = String::from_utf8_lossy(data);
    match text::read(&given) {
        Ok(program) => {
            let written = text::write(&program);
            let again = text::read(&written).expect("what is written can be read");
            assert_eq!(text::write(&again), written);
        }
        Err(error) => drop(error.to_string()),
    }
    match dre::read(&given) {
        Ok(divided) => {
            let written = dre::write(&divided);
            let again = dre::read(&written).expect("what is written can be read");
            assert_eq!(dre::write(&again), written);
        }
        Err(error) => drop(error.to_string()),
    }
}
