//! Any bytes are a scene, a library of materials and a picture, or are refused with messages that can be shown. Lines of
//! hyphens stand between the three.

use srp_runtime::scene::read;
use std::io;
use std::path::Path;

/// The line between two files.
const BETWEEN: &[u8] = b"\n---\n";

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let mut rest = data;
    let mut files = Vec::new();
    while let Some(at) = rest.windows(BETWEEN.len()).position(|w| w == BETWEEN) {
        files.push(&rest[..at]);
        rest = &rest[at + BETWEEN.len()..];
    }
    files.push(rest);
    let loaded = read(Path::new("fuzz.obj"), None, &mut |path, _| {
        let number = match path.extension().and_then(|e| e.to_str()) {
            Some("obj") => 0,
            Some("mtl") => 1,
            _ => 2,
        };
        let found = files.get(number).map(|bytes| bytes.to_vec());
        found.ok_or_else(|| io::ErrorKind::NotFound.into())
    });
    let messages = match loaded {
        Ok(loaded) => loaded.warnings,
        Err(messages) => messages,
    };
    messages.render(false);
}
