//! Graphs in JSON. The text is read by hand, for messages need the place of every value.

mod value;

use super::raw::{Lines, Raw, RawEdge, shortened};
use super::{At, Found, Graph, Options};
use crate::dfg::Node;
use crate::program::SourceFile;
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::entity::Entity;
use srp_archdesc::nearest::nearest;
use value::{Json, Value};

/// Members of a graph; names that begin with `x-` are free for other uses.
const GRAPH: &[&str] = &["name", "nodes", "edges"];
const NODE: &[&str] = &["id", "op", "label"];
const EDGE: &[&str] = &["from", "to", "operand", "distance", "latency", "kind"];

pub(super) fn read(source: &Source, options: &Options, found: &mut Found) -> Option<Graph> {
    let lines = || Lines::of(source, SourceFile::new(0));
    let mut reader = Reader {
        raw: Raw::new(super::stem(&source.name), lines(), lines()),
        file: &source.name,
        found,
    };
    match value::parse(&source.text) {
        Ok(root) => reader.graph(&root),
        Err((span, message)) => reader.error("G0106", span, message),
    }
    // What is missing because of a mistake is no further mistake.
    if !reader.found.list.is_empty() {
        return None;
    }
    reader.raw.build(options, found)
}

struct Reader<'a, 'f> {
    raw: Raw<'a>,
    file: &'a str,
    found: &'f mut Found,
}

impl Reader<'_, '_> {
    fn error(&mut self, code: &'static str, span: Span, message: impl Into<String>) {
        let file = self.file;
        self.found.error(code, &At { file, span }, message);
    }

    fn graph(&mut self, root: &Json<'_>) {
        let Some(members) = self.members(root, "a graph", GRAPH) else {
            return;
        };
        if let Some(name) = self.text(members.get("name")) {
            self.raw.name = name;
        }
        for (list, what) in [("nodes", "node"), ("edges", "edge")] {
            match members.get(list).map(|m| (&m.value, m)) {
                Some((Value::Array(items), _)) => {
                    for item in items {
                        let done = match what {
                            "node" => self.node(item),
                            _ => self.edge(item),
                        };
                        if done.is_none() {
                            break;
                        }
                    }
                }
                Some((_, other)) => {
                    let message = format!("`{list}` is a list of {what}s");
                    self.error("G0107", other.span, message);
                }
                None if list == "nodes" => {
                    self.error("G0108", root.span, "a graph needs the member `nodes`");
                }
                None => {}
            }
        }
    }

    /// Reads a node; `None` beyond a limit.
    fn node(&mut self, json: &Json<'_>) -> Option<()> {
        let Some(members) = self.members(json, "a node", NODE) else {
            return Some(());
        };
        let (Some(id), Some(op)) = (members.get("id"), members.get("op")) else {
            self.error("G0108", json.span, "a node needs the members `id` and `op`");
            return Some(());
        };
        let (Some(name), Some(text)) = (self.id(id), self.text(Some(op))) else {
            return Some(());
        };
        let node = self.raw.node(&name, id.span, false, self.found)?;
        match self.raw.op_of(node) {
            Some(first) => {
                let message = format!("a second node `{}`", shortened(&name));
                let mistake = self.raw.node_file.at(id.span).error("G0104", message);
                self.found.push(mistake.also(first, "the first"));
            }
            None => self.raw.set_op(node, &text, op.span),
        }
        Some(())
    }

    fn edge(&mut self, json: &Json<'_>) -> Option<()> {
        let Some(members) = self.members(json, "an edge", EDGE) else {
            return Some(());
        };
        let (Some(from), Some(to)) = (members.get("from"), members.get("to")) else {
            self.error(
                "G0108",
                json.span,
                "an edge needs the members `from` and `to`",
            );
            return Some(());
        };
        let mut order = false;
        if let Some(kind) = members.get("kind") {
            match &kind.value {
                Value::Text(text) if text == "order" => order = true,
                Value::Text(text) if text == "value" => {}
                _ => self.error("G0107", kind.span, "a kind is \"value\" or \"order\""),
            }
        }
        let edge = RawEdge {
            from: self.end(from)?,
            to: self.end(to)?,
            operand: self.number(members.get("operand")),
            distance: self.number(members.get("distance")).unwrap_or(0),
            latency: self.number(members.get("latency")),
            order,
            span: json.span,
        };
        self.raw.edge(edge, self.found);
        Some(())
    }

    /// The node that an end of an edge names.
    fn end(&mut self, json: &Json<'_>) -> Option<Node> {
        let name = self.id(json).unwrap_or_default();
        self.raw.node(&name, json.span, true, self.found)
    }

    /// A name: text, or a number as it is written.
    fn id(&mut self, json: &Json<'_>) -> Option<String> {
        match &json.value {
            Value::Text(text) => Some(text.clone()),
            Value::Number(number) => Some((*number).to_owned()),
            _ => {
                self.error("G0107", json.span, "a node's name is text or a number");
                None
            }
        }
    }

    fn text(&mut self, json: Option<&Json<'_>>) -> Option<String> {
        let json = json?;
        if let Value::Text(text) = &json.value {
            return Some(text.clone());
        }
        self.error("G0107", json.span, "text is expected");
        None
    }

    fn number(&mut self, json: Option<&Json<'_>>) -> Option<u32> {
        let json = json?;
        let number = match &json.value {
            Value::Number(text) => text.parse().ok(),
            _ => None,
        };
        if number.is_none() {
            self.error("G0105", json.span, "a whole number below 2^32 is expected");
        }
        number
    }

    /// The members of an object, all of which are known.
    fn members<'j, 't>(
        &mut self,
        json: &'j Json<'t>,
        what: &str,
        known: &[&str],
    ) -> Option<Members<'j, 't>> {
        let Value::Object(members) = &json.value else {
            self.error(
                "G0107",
                json.span,
                format!("{what} is an object, `{{ … }}`"),
            );
            return None;
        };
        for (i, (name, span, _)) in members.iter().enumerate() {
            if members[..i].iter().any(|(other, _, _)| other == name) {
                self.error(
                    "G0104",
                    *span,
                    format!("a second member `{}`", shortened(name)),
                );
            } else if !known.contains(&name.as_str()) && !name.starts_with("x-") {
                let near = nearest(name, known.iter().copied());
                let hint = match near {
                    Some(near) => format!("; did you mean `{near}`?"),
                    None => format!("; it has {}", known.join(", ")),
                };
                let message = format!("{what} has no member `{}`{hint}", shortened(name));
                self.error("G0109", *span, message);
            }
        }
        Some(Members(members))
    }
}

/// The members of an object.
struct Members<'j, 't>(&'j [value::Member<'t>]);

impl<'j, 't> Members<'j, 't> {
    fn get(&self, name: &str) -> Option<&'j Json<'t>> {
        let member = self.0.iter().find(|(n, _, _)| n == name);
        member.map(|(_, _, value)| value)
    }
}
