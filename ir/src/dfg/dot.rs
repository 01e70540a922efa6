//! A [`Dfg`] drawn by Graphviz, with all that it takes to read it back.

use super::{Dep, DepKind, Dfg, Initial, NodeData, Operand};
use crate::dre;
use crate::program::{Pos, SourceFile};
use srp_archdesc::entity::EntityMap;
use std::fmt::Write;

/// The graph in the language of Graphviz: operations with their source lines, constants and
/// live-ins; edges with their distances, and dashed where they are orders. Live-outs have a double
/// border.
///
/// Further attributes, which Graphviz ignores, hold the rest: [`graph::read_dot`] restores the
/// graph from them.
///
/// [`graph::read_dot`]: crate::graph::read_dot
pub fn dot(dfg: &Dfg, files: &EntityMap<SourceFile, String>) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    line(format!("digraph {} {{", quoted(&dfg.name)));
    line(format!("  graph [{}];", whole(dfg, files)));
    line("  node [shape=box, fontname=\"monospace\"];".to_owned());
    line("  edge [fontname=\"monospace\"];".to_owned());
    for (node, data) in dfg.nodes.iter() {
        let border = if dfg.live_outs.contains(&node) {
            ", peripheries=2"
        } else {
            ""
        };
        let label = quoted(&format!("{node} {}", label(data, files)));
        line(format!("  {node} [{}, label={label}{border}];", said(data)));
    }
    for (from, to, dep) in dfg.deps() {
        line(format!("  {from} -> {to}{};", attributes(dep)));
    }
    line("}".to_owned());
    out
}

/// The attributes of the graph itself.
fn whole(dfg: &Dfg, files: &EntityMap<SourceFile, String>) -> String {
    let mut list = Vec::new();
    if let Some(trip) = dfg.trip {
        list.push(format!("trip=\"in{trip}\""));
    }
    list.extend(dre::pos_text(dfg.pos).map(|at| format!("at=\"{at}\"")));
    let live_in = |(i, live_in): (usize, &super::LiveIn)| {
        let at = dre::pos_text(live_in.pos).map_or(String::new(), |at| format!("@{at}"));
        format!("in{i}@{}{at}", live_in.ty)
    };
    let live_ins: Vec<String> = dfg.live_ins.iter().enumerate().map(live_in).collect();
    list.push(format!("live_ins=\"{}\"", live_ins.join(" ")));
    let live_outs: Vec<String> = dfg.live_outs.iter().map(|n| n.to_string()).collect();
    list.push(format!("live_outs=\"{}\"", live_outs.join(" ")));
    let name = |(i, name): (usize, &String)| format!("file{i}={}", quoted(name));
    list.extend(files.values().enumerate().map(name));
    list.join(", ")
}

/// Returns a node's attributes for readers.
fn said(data: &NodeData) -> String {
    let args: Vec<String> = data.operands.iter().map(dre::operand_text).collect();
    let mut list = vec![
        format!("op=\"{}\"", data.op),
        format!("args=\"{}\"", args.join(" ")),
    ];
    if data.op.info().immediate || data.imm != 0 {
        list.push(format!("imm=\"{}\"", data.imm));
    }
    list.extend(dre::pos_text(data.pos).map(|at| format!("at=\"{at}\"")));
    list.join(", ")
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
    match dep.kind {
        DepKind::Operand(operand) => list.push(format!("operand={operand}")),
        DepKind::Order => list.push("kind=order".to_owned()),
    }
    if dep.distance > 0 {
        list.push(format!("distance={}", dep.distance));
        list.push(format!("label=\"{}\"", dep.distance));
        list.push("constraint=false".to_owned());
    }
    if dep.kind == DepKind::Order {
        list.push("style=dashed".to_owned());
    }
    format!(" [{}]", list.join(", "))
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
