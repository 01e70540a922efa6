//! Functional units of the file: the op-class table, shared resources, and what a `<fu-type>` or an
//! `<fu>` says a unit is.

use std::collections::BTreeMap;

use super::de::Spanned;
use super::findings::Findings;
use super::limits;
use super::raw::{self, Text};
use super::values;
use crate::arch::{FileKind, FuOp, Resource, ResourceSpec};
use crate::diagnostic::Span;
use crate::entity::EntityMap;
use crate::isa::Class;

/// How classes run, by class.
pub(super) type Ops = BTreeMap<Class, FuOp>;

/// The properties of a unit, position apart.
#[derive(Clone, Default)]
pub(super) struct Body {
    pub(super) width: u32,
    pub(super) pred_out: bool,
    pub(super) constants: u32,
    pub(super) ops: Ops,
    /// Where the file gives the unit each class.
    pub(super) mentions: BTreeMap<Class, Span>,
    pub(super) files: Vec<LocalFile>,
}

/// A register file of a unit's own.
#[derive(Clone)]
pub(super) struct LocalFile {
    pub(super) name: String,
    pub(super) span: Span,
    pub(super) kind: FileKind,
    /// `None`: as wide as the unit.
    pub(super) width: Option<u32>,
    pub(super) size: u32,
    pub(super) read_ports: u32,
    pub(super) write_ports: u32,
    pub(super) from_links: bool,
}

/// The parts of a `<fu-type>` or an `<fu>` that say what the unit is.
pub(super) struct BodyParts<'r> {
    width: &'r Option<Text>,
    pred_out: &'r Option<Text>,
    constants: &'r Option<Text>,
    classes: &'r Option<Text>,
    ops: &'r [Spanned<raw::Op>],
    files: &'r [Spanned<raw::LocalFile>],
}

macro_rules! body_parts {
    ($($raw:ident)*) => {$(
        impl<'r> From<&'r raw::$raw> for BodyParts<'r> {
            fn from(raw: &'r raw::$raw) -> Self {
                BodyParts {
                    width: &raw.width,
                    pred_out: &raw.pred_out,
                    constants: &raw.constants,
                    classes: &raw.classes,
                    ops: &raw.op,
                    files: &raw.file,
                }
            }
        }
    )*};
}

body_parts! { FuType Fu }

/// The parts of the machine that operations need.
pub(super) struct OpContext<'m> {
    pub(super) found: &'m Findings,
    pub(super) resources: &'m EntityMap<Resource, ResourceSpec>,
    /// The machine's table, every class in it.
    pub(super) table: Ops,
}

/// The `<resource>`s of the machine.
pub(super) fn resources(
    found: &Findings,
    raw: &[Spanned<raw::Resource>],
) -> EntityMap<Resource, ResourceSpec> {
    let mut resources: EntityMap<Resource, ResourceSpec> = EntityMap::new();
    let mut seen = BTreeMap::new();
    for r in raw {
        let name = values::required_identifier(found, &r.name, "resource", r.span);
        let limit = limits::RESOURCE_COUNT;
        let count = values::required_number(found, &r.count, limit, "resource", r.span);
        let (Some(name), Some(text)) = (name, &r.name) else {
            found.suspect(r.span, "resource");
            continue;
        };
        if resources.len() == limits::MAX_RESOURCES {
            let message = format!("there are more than {} resources", limits::MAX_RESOURCES);
            found.push(found.error("A0410", text.span, message, "too many"));
            break;
        }
        if unique(found, &mut seen, &name, text.span, "resource") {
            resources.push(ResourceSpec { name, count });
        }
    }
    resources
}

/// True if `name` is new; reports it where it is not.
pub(super) fn unique(
    found: &Findings,
    seen: &mut BTreeMap<String, Span>,
    name: &str,
    span: Span,
    what: &str,
) -> bool {
    if let Some(&first) = seen.get(name) {
        let message = format!("{what} `{name}` is given twice");
        found.push(
            found
                .error("A0405", span, message, "given again")
                .also(first, "first given here"),
        );
        return false;
    }
    seen.insert(name.to_owned(), span);
    true
}

/// The machine's op-class table: what its `<op>`s say.
pub(super) fn op_context<'m>(
    found: &'m Findings,
    raw: &[Spanned<raw::Op>],
    resources: &'m EntityMap<Resource, ResourceSpec>,
) -> OpContext<'m> {
    // Cycles that no `<op>` gives follow from the clock when all of the machine is known.
    let table = Class::ALL
        .iter()
        .map(|&class| (class, FuOp::new(class, 1, 1)));
    let mut cx = OpContext {
        found,
        resources,
        table: table.collect(),
    };
    let mut seen = BTreeMap::new();
    for op in raw {
        if let Some((class, _)) = op_class(&cx, op, &mut seen) {
            let changed = changed_op(&cx, &cx.table[&class], op);
            cx.table.insert(class, changed);
        }
    }
    cx
}

/// The class an `<op>` is about, unless it has none or had an `<op>` before.
fn op_class(
    cx: &OpContext<'_>,
    op: &Spanned<raw::Op>,
    seen: &mut BTreeMap<String, Span>,
) -> Option<(Class, Span)> {
    let Some(text) = &op.class else {
        values::missing(cx.found, "class", "op", op.span);
        cx.found.suspect(op.span, "class");
        return None;
    };
    let class = parse_class(cx.found, text)?;
    unique(cx.found, seen, class.name(), text.span, "`op` of class").then_some((class, text.span))
}

fn parse_class(found: &Findings, text: &Text) -> Option<Class> {
    let class = Class::parse(text);
    if class.is_none() {
        let known = Class::ALL.iter().map(|c| c.name());
        values::unknown(found, "A0403", text, "op class", known);
        found.suspect(text.span, "class");
    }
    class
}

/// `base` with what the `<op>` says.
fn changed_op(cx: &OpContext<'_>, base: &FuOp, op: &raw::Op) -> FuOp {
    let uses = match &op.uses {
        None => base.uses.clone(),
        Some(text) => uses(cx, text),
    };
    let given = [
        base.given[0] || op.latency.is_some(),
        base.given[1] || op.interval.is_some(),
    ];
    FuOp {
        latency: values::number(cx.found, &op.latency, limits::LATENCY, base.latency),
        interval: values::number(cx.found, &op.interval, limits::INTERVAL, base.interval),
        uses,
        given,
        ..FuOp::new(base.class, 1, 1)
    }
}

fn uses(cx: &OpContext<'_>, text: &Text) -> Vec<Resource> {
    let mut seen = BTreeMap::new();
    let mut uses = Vec::new();
    for word in values::words(text) {
        match cx.resources.iter().find(|(_, r)| r.name == word.value) {
            Some((resource, _)) => {
                if unique(cx.found, &mut seen, &word, word.span, "resource") {
                    uses.push(resource);
                }
            }
            None if cx.found.suspects_any(&["resource"]) => {}
            None => {
                let known = cx.resources.values().map(|r| r.name.as_str());
                values::unknown(cx.found, "A0404", &word, "resource", known);
            }
        }
    }
    uses
}

/// Returns the properties of a unit: `base` (a unit of no class where there is none), changed as `parts` say.
pub(super) fn body(cx: &OpContext<'_>, base: Option<&Body>, parts: &BodyParts<'_>) -> Body {
    let found = cx.found;
    let mut body = base.cloned().unwrap_or(Body {
        width: 32,
        pred_out: true,
        constants: 1,
        ..Body::default()
    });
    if parts.width.is_some() {
        // Nothing is too wide for a unit whose width cannot be read.
        body.width = values::width(found, parts.width, "width", &[32, 128]).unwrap_or(128);
    }
    body.pred_out = values::flag(found, parts.pred_out, "pred-out", body.pred_out);
    body.constants = values::number(found, parts.constants, limits::CONSTANTS, body.constants);
    if let Some(text) = parts.classes {
        body.ops.clear();
        body.mentions.clear();
        let mut seen = BTreeMap::new();
        for word in values::words(text) {
            if let Some(class) = parse_class(found, &word)
                && unique(found, &mut seen, &word, word.span, "class")
            {
                body.ops.insert(class, cx.table[&class].clone());
                body.mentions.insert(class, word.span);
            }
        }
    }
    let mut seen = BTreeMap::new();
    for op in parts.ops {
        if let Some((class, span)) = op_class(cx, op, &mut seen) {
            let base = body.ops.get(&class).unwrap_or(&cx.table[&class]);
            let changed = changed_op(cx, base, op);
            body.ops.insert(class, changed);
            body.mentions.entry(class).or_insert(span);
        }
    }
    if !parts.files.is_empty() {
        body.files = local_files(found, parts.files);
    }
    body
}

fn local_files(found: &Findings, raw: &[Spanned<raw::LocalFile>]) -> Vec<LocalFile> {
    const KINDS: [(&str, FileKind); 2] = [
        ("rotating", FileKind::Rotating),
        ("static", FileKind::Static),
    ];
    let mut seen = BTreeMap::new();
    let mut files = Vec::new();
    for file in raw {
        if files.len() == limits::MAX_LOCAL_FILES {
            let message = format!("a unit has more than {} files", limits::MAX_LOCAL_FILES);
            found.push(found.error("A0410", file.span, message, "too many"));
            break;
        }
        let number = |text, limit, default| values::number(found, text, limit, default);
        let name = values::required_identifier(found, &file.name, "file", file.span);
        let limit = limits::FILE_SIZE;
        let size = values::required_number(found, &file.size, limit, "file", file.span);
        if file.kind.is_none() {
            values::missing(found, "kind", "file", file.span);
        }
        let kind = values::word(found, &file.kind, "kind", &KINDS).unwrap_or(FileKind::Static);
        let local = LocalFile {
            span: file.span,
            kind,
            width: values::width(found, &file.width, "width", &[1, 32, 128]),
            size,
            read_ports: number(&file.read_ports, limits::READ_PORTS, 2),
            write_ports: number(&file.write_ports, limits::WRITE_PORTS, 1),
            from_links: values::flag(found, &file.from_links, "from-links", false),
            name: name.clone().unwrap_or_default(),
        };
        if let Some(name) = name
            && unique(found, &mut seen, &name, file.span, "file")
        {
            files.push(local);
        }
    }
    files
}
