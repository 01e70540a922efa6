//! The operations that an obstacle names. The scheduler says in words what was in the way, each
//! operation as `` `op` of line n ``; here are the nodes that such words mean.

use srp_ir::dfg::{Dfg, Node};

/// The nodes that a text names, in its order. Where several of one kind come from one line, it may be
/// any of them: all are given.
pub(super) fn named(dfg: &Dfg, text: &str) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::new();
    let mut parts = text.split('`').skip(1);
    while let (Some(op), Some(rest)) = (parts.next(), parts.next()) {
        let Some(line) = rest.strip_prefix(" of line ").and_then(number) else {
            continue;
        };
        let meant = dfg.nodes.iter().filter(|(node, data)| {
            data.op.name() == op && data.pos.line == line && !nodes.contains(node)
        });
        let meant: Vec<Node> = meant.map(|(node, _)| node).collect();
        nodes.extend(meant);
    }
    nodes
}

/// The number that a text begins with.
fn number(text: &str) -> Option<u32> {
    let digits = text.find(|c: char| !c.is_ascii_digit());
    text[..digits.unwrap_or(text.len())].parse().ok()
}
