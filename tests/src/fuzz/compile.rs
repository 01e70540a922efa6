//! Any text either compiles to a program that is in order, or is refused with messages that can be
//! shown.

use srp_archdesc::diagnostic::Source;
use srp_frontend::message::render_all;
use srp_frontend::{Include, Options, compile, library};

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let text = String::from_utf8_lossy(data).into_owned();
    let includes_itself = |include: &Include<'_>| {
        (include.name == "fuzz.c").then(|| Source::new("fuzz.c", text.clone()))
    };
    let options = Options {
        resolve: &|include| includes_itself(include).into(),
        ..Options::default()
    };
    match compile(&[Source::new("fuzz.c", text.clone())], &options) {
        Ok((program, _)) => assert_eq!(srp_ir::verify(&program), Ok(())),
        Err(messages) => {
            let of = |name: &str| match name {
                "fuzz.c" => Some(text.clone()),
                _ => library::text(name).map(str::to_owned),
            };
            render_all(&messages, &of, false);
        }
    }
}
