//! A [`Dfg`] drawn by Graphviz.

use super::{Dep, DepKind, Dfg, Initial, NodeData, Operand};
use crate::program::{Pos, SourceFile};
use srp_archdesc::entity::EntityMap;
use std::fmt::Write;

/// The graph in the language of Graphviz: operations with their source lines, constants and
/// live-ins; edges with their distances, and dashed where they are orders. Live-outs have a double
/// border.
pub fn dot(dfg: &Dfg, files: &EntityMap<SourceFile, String>) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    line(format!("digraph {} {{", quoted(&dfg.name)));
    line("  node [shape=box, fontname=\"monospace\"];".to_owned());
    line("  edge [fontname=\"monospace\"];".to_owned());
    for (node, data) in dfg.nodes.iter() {
        let border = if dfg.live_outs.contains(&node) {
            ", peripheries=2"
        } else {
            ""
        };
        let label = quoted(&format!("{node} {}", label(data, files)));
        line(format!("  {node} [label={label}{border}];"));
    }
    for (from, to, dep) in dfg.deps() {
        line(format!("  {from} -> {to}{};", attributes(dep)));
    }
    line("}".to_owned());
    out
}

fn label(data: &NodeData, files: &EntityMap<SourceFile, String>) -> String {
    let mut text = data.op.to_string();
    for operand in &data.operands {
        let _ = match operand {
            Operand::Const(bits) => write!(text, " {bits}"),
            Operand::LiveIn(i) => write!(text, " in{i}"),
            Operand::Node { init, .. } if init.is_empty() => write!(text, " ·"),
            Operand::Node { init, .. } => {
                let first: Vec<String> = init.iter().map(initial).collect();
                write!(text, " ·({})", first.join(" "))
            }
        };
    }
    if data.op.info().immediate {
        let _ = write!(text, " {:+}", data.imm);
    }
    format!("{text}\n{}", place(data.pos, files))
}

fn initial(initial: &Initial) -> String {
    match initial {
        Initial::Const(bits) => bits.to_string(),
        Initial::LiveIn(i) => format!("in{i}"),
        Initial::Any => "any".to_owned(),
    }
}

fn place(pos: Pos, files: &EntityMap<SourceFile, String>) -> String {
    match files.get(pos.file) {
        Some(file) if pos.line > 0 => format!("{file}:{}", pos.line),
        _ => "-".to_owned(),
    }
}

fn attributes(dep: Dep) -> String {
    let mut list = Vec::new();
    if dep.distance > 0 {
        list.push(format!("label=\"{}\"", dep.distance));
        list.push("constraint=false".to_owned());
    }
    if dep.kind == DepKind::Order {
        list.push("style=dashed".to_owned());
    }
    if list.is_empty() {
        String::new()
    } else {
        format!(" [{}]", list.join(", "))
    }
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
