//! The content of a Graphviz file: nodes and edges with their attributes, subgraphs dissolved.

use super::lex::{Kind, Token, tokens};
use crate::graph::raw::shortened;
use srp_archdesc::diagnostic::Span;
use std::collections::BTreeMap;

/// How deep subgraphs may stand in each other.
const MAX_DEPTH: usize = 64;

/// A file.
#[derive(Debug, Default)]
pub(in crate::graph) struct Tree {
    pub(in crate::graph) name: Option<String>,
    /// Where `digraph` stands.
    pub(in crate::graph) span: Span,
    /// Attributes of the graph itself.
    pub(in crate::graph) attributes: Attributes,
    /// Nodes in the order of their names' first appearance.
    pub(in crate::graph) nodes: Vec<DotNode>,
    pub(in crate::graph) edges: Vec<DotEdge>,
}

#[derive(Debug)]
pub(in crate::graph) struct DotNode {
    pub(in crate::graph) name: String,
    pub(in crate::graph) span: Span,
    /// True if it has a node statement of its own.
    pub(in crate::graph) stated: bool,
    pub(in crate::graph) attributes: Attributes,
}

#[derive(Debug)]
pub(in crate::graph) struct DotEdge {
    pub(in crate::graph) from: String,
    pub(in crate::graph) to: String,
    /// From the start of the one name to the end of the other.
    pub(in crate::graph) span: Span,
    pub(in crate::graph) attributes: Attributes,
}

/// Attributes by name, with the place of the value.
pub(in crate::graph) type Attributes = BTreeMap<String, (String, Span)>;

/// A mistake: the code, the place, and what it is.
pub(in crate::graph) type Fault = (&'static str, Span, String);

/// Reads a file up to its first mistake.
pub(in crate::graph) fn parse(text: &str) -> Result<Tree, Fault> {
    let tokens = tokens(text).map_err(|(span, message)| ("G0106", span, message))?;
    let mut parser = Parser {
        tokens,
        at: 0,
        tree: Tree::default(),
        by_name: BTreeMap::new(),
        defaults: vec![Defaults::default()],
    };
    parser.file()?;
    Ok(parser.tree)
}

/// Attributes of the nodes and edges to come.
#[derive(Clone, Default)]
struct Defaults {
    node: Attributes,
    edge: Attributes,
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    tree: Tree,
    by_name: BTreeMap<String, usize>,
    /// Of the subgraphs that are open.
    defaults: Vec<Defaults>,
}

impl Parser {
    fn peek(&self) -> &Token {
        &self.tokens[self.at]
    }

    fn next(&mut self) -> Token {
        let token = self.peek().clone();
        // The end stays.
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    fn takes(&mut self, mark: char) -> bool {
        let there = self.peek().kind == Kind::Mark(mark);
        if there {
            self.next();
        }
        there
    }

    /// Takes a keyword, in capitals or not.
    fn takes_word(&mut self, word: &str) -> bool {
        let there = matches!(&self.peek().kind,
            Kind::Id(text, false) if text.eq_ignore_ascii_case(word));
        if there {
            self.next();
        }
        there
    }

    fn fault<T>(&self, expected: &str) -> Result<T, Fault> {
        let token = self.peek();
        let what = match &token.kind {
            Kind::Id(text, _) => format!("`{}`", shortened(text).escape_debug()),
            Kind::Mark(mark) => format!("`{mark}`"),
            Kind::Arrow => "`->`".to_owned(),
            Kind::Line => "`--`".to_owned(),
            Kind::End => "the end of the file".to_owned(),
        };
        Err((
            "G0106",
            token.span,
            format!("{expected} is expected, not {what}"),
        ))
    }

    fn id(&mut self, what: &str) -> Result<(String, Span), Fault> {
        match &self.peek().kind {
            Kind::Id(..) => {}
            _ => return self.fault(what),
        }
        match self.next() {
            Token {
                kind: Kind::Id(text, _),
                span,
            } => Ok((text, span)),
            _ => self.fault(what),
        }
    }

    fn file(&mut self) -> Result<(), Fault> {
        self.takes_word("strict");
        self.tree.span = self.peek().span;
        if self.takes_word("graph") {
            let message = "edges without a direction; a dataflow graph is a `digraph`";
            return Err(("G0110", self.tree.span, message.to_owned()));
        }
        if !self.takes_word("digraph") {
            return self.fault("`digraph`");
        }
        if let Kind::Id(..) = self.peek().kind {
            self.tree.name = Some(self.id("a name")?.0);
        }
        if !self.takes('{') {
            return self.fault("`{`");
        }
        self.statements()?;
        match self.peek().kind {
            Kind::End => Ok(()),
            _ => self.fault("one graph a file; its end"),
        }
    }

    /// The statements up to the `}` of the graph, and those of the subgraphs.
    fn statements(&mut self) -> Result<(), Fault> {
        while !self.defaults.is_empty() {
            if self.takes('}') {
                self.defaults.pop();
            } else if !self.takes(';') && !self.takes(',') {
                self.statement()?;
            }
        }
        Ok(())
    }

    fn statement(&mut self) -> Result<(), Fault> {
        if self.takes_word("subgraph") {
            if let Kind::Id(..) = self.peek().kind {
                self.next();
            }
            if self.peek().kind != Kind::Mark('{') {
                return self.fault("`{`");
            }
        }
        if self.takes('{') {
            if self.defaults.len() > MAX_DEPTH {
                return self.fault("a graph of fewer levels");
            }
            let inner = self.defaults[self.defaults.len() - 1].clone();
            self.defaults.push(inner);
            return Ok(());
        }
        for kind in ["graph", "node", "edge"] {
            if self.takes_word(kind) {
                let said = self.attributes()?;
                let depth = self.defaults.len();
                let inner = &mut self.defaults[depth - 1];
                match kind {
                    "node" => inner.node.extend(said),
                    "edge" => inner.edge.extend(said),
                    _ if depth == 1 => self.tree.attributes.extend(said),
                    _ => {}
                }
                return Ok(());
            }
        }
        let (name, span) = self.id("a node, an edge or `}`")?;
        if self.takes('=') {
            let value = self.id("a value")?;
            if self.defaults.len() == 1 {
                self.tree.attributes.insert(name, value);
            }
            return Ok(());
        }
        self.node_or_edges(name, span)
    }

    fn node_or_edges(&mut self, name: String, span: Span) -> Result<(), Fault> {
        self.port()?;
        let mut chain = vec![(name, span)];
        loop {
            match self.peek().kind {
                Kind::Arrow => drop(self.next()),
                Kind::Line => {
                    let message = "an edge without a direction; `->` has one";
                    return Err(("G0110", self.peek().span, message.to_owned()));
                }
                _ => break,
            }
            if self.peek().kind == Kind::Mark('{') || self.takes_word("subgraph") {
                let message = "edges from and to whole subgraphs are not understood";
                return Err(("G0110", self.peek().span, message.to_owned()));
            }
            let end = self.id("a node")?;
            self.port()?;
            chain.push(end);
        }
        let said = self.attributes()?;
        let inner = self.defaults[self.defaults.len() - 1].clone();
        for (name, span) in &chain {
            self.named(name, *span, &inner);
        }
        if let [(name, span)] = &chain[..] {
            let node = &mut self.tree.nodes[self.by_name[name]];
            if !node.stated {
                (node.span, node.stated) = (*span, true);
            }
            node.attributes.extend(said);
            return Ok(());
        }
        let mut attributes = inner.edge;
        attributes.extend(said);
        for ends in chain.windows(2) {
            let [(from, start), (to, end)] = ends else {
                continue;
            };
            self.tree.edges.push(DotEdge {
                from: from.clone(),
                to: to.clone(),
                span: start.to(*end),
                attributes: attributes.clone(),
            });
        }
        Ok(())
    }

    /// Makes a node known where it is first named.
    fn named(&mut self, name: &str, span: Span, inner: &Defaults) {
        if self.by_name.contains_key(name) {
            return;
        }
        self.by_name.insert(name.to_owned(), self.tree.nodes.len());
        self.tree.nodes.push(DotNode {
            name: name.to_owned(),
            span,
            stated: false,
            attributes: inner.node.clone(),
        });
    }

    /// The port of a node, which says nothing here.
    fn port(&mut self) -> Result<(), Fault> {
        while self.takes(':') {
            self.id("a port")?;
        }
        Ok(())
    }

    /// Lists of attributes; none if there is no `[`.
    fn attributes(&mut self) -> Result<Attributes, Fault> {
        let mut all = Attributes::new();
        while self.takes('[') {
            while !self.takes(']') {
                let (name, span) = self.id("an attribute or `]`")?;
                let value = if self.takes('=') {
                    self.id("a value")?
                } else {
                    ("true".to_owned(), span)
                };
                all.insert(name, value);
                let _ = self.takes(',') || self.takes(';');
            }
        }
        Ok(all)
    }
}
