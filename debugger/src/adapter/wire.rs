//! Messages of the Debug Adapter Protocol on the wire: a length, an empty line, JSON.

use serde_json::Value;
use std::io::{self, BufRead, Read, Write};

/// Most bytes of a message.
const MOST_BYTES: usize = 1 << 24;

/// Reads a message; `None` at the end.
///
/// # Errors
///
/// It cannot be read, or is none.
pub fn read(from: &mut impl BufRead) -> io::Result<Option<Value>> {
    let wrong = |why: &str| io::Error::new(io::ErrorKind::InvalidData, why.to_owned());
    let mut length = None;
    loop {
        let mut line = String::new();
        // A header is short; one that is not is none.
        if from.by_ref().take(1 << 10).read_line(&mut line)? == 0 {
            return Ok(None);
        }
        let line = line.trim_end();
        if line.is_empty() && length.is_some() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("content-length")
        {
            let value: usize = value
                .trim()
                .parse()
                .map_err(|_| wrong("a length is no number"))?;
            length = Some(value);
        }
    }
    let length = length.filter(|&length| length <= MOST_BYTES);
    let length = length.ok_or_else(|| wrong("a message is too long"))?;
    let mut bytes = vec![0; length];
    from.read_exact(&mut bytes)?;
    serde_json::from_slice(&bytes)
        .map(Some)
        .map_err(|error| wrong(&error.to_string()))
}

/// Writes a message.
///
/// # Errors
///
/// It cannot be written.
pub fn write(to: &mut dyn Write, message: &Value) -> io::Result<()> {
    let text = message.to_string();
    write!(to, "Content-Length: {}\r\n\r\n{text}", text.len())?;
    to.flush()
}
