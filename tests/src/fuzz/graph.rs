//! Any text is a dataflow graph in one of its forms, or is refused with messages that can be shown. The first byte says
//! the form.

use srp_archdesc::diagnostic::{Source, render_all};
use srp_ir::graph::{Options, read_dot, read_edges, read_json};

/// Tries any bytes.
///
/// # Panics
///
/// If what the module says does not hold of them.
pub fn any(data: &[u8]) {
    let Some((form, data)) = data.split_first() else {
        return;
    };
    let text = String::from_utf8_lossy(data).into_owned();
    let options = Options::default();
    let source = Source::new("fuzz", text.clone());
    let read = match form % 3 {
        0 => read_dot(&source, &options),
        1 => read_json(&source, &options),
        _ => {
            // Edges and operations, with a line of hyphens between.
            let (edges, ops) = text.split_once("\n---\n").unwrap_or((&text, ""));
            let ops = Source::new("fuzz.ops", ops);
            match read_edges(&Source::new("fuzz.edges", edges), &ops, &options) {
                // Messages are of one of the two.
                Err(_) => return,
                read => read,
            }
        }
    };
    if let Err(messages) = read {
        render_all(&messages, &text, false);
    }
}
