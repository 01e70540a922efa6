//! Kernels as XML: live-ins, nodes, orders, live-outs.

use super::element::{self, Element, ElementExt, Read, Text};
use super::terms::{self, Files, Names};
use crate::dfg::{Assumed, Dfg, Initial, LiveIn, Node, NodeData, Operand, Order};
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::xml::tree::{Tag, Writer};

entity! {
    /// A live-in, by number.
    Input = "in";
}

/// The element of a kernel, still open.
pub(super) fn open(xml: &mut Writer, dfg: &Dfg) {
    xml.open(
        Tag::new("kernel")
            .attr("name", &dfg.name)
            .attr_if("trip", dfg.trip.map(|trip| format!("in{trip}")))
            .attr_if("at", terms::pos(dfg.pos)),
    );
    for (i, live_in) in dfg.live_ins.iter().enumerate() {
        xml.leaf(
            Tag::new("live-in")
                .attr("id", format!("in{i}"))
                .attr("type", live_in.ty)
                .attr_if("at", terms::pos(live_in.pos)),
        );
    }
    for (node, data) in dfg.nodes.iter() {
        xml.leaf(
            Tag::new("node")
                .attr("id", node)
                .attr("op", data.op)
                .list("args", data.operands.iter().map(operand))
                .attr_if("imm", terms::imm(data.op, data.imm))
                .attr_if("at", terms::pos(data.pos)),
        );
    }
    for order in &dfg.order {
        xml.leaf(
            Tag::new("order")
                .attr("from", order.from)
                .attr("to", order.to)
                .attr("distance", order.distance),
        );
    }
    for assumed in &dfg.assumed {
        xml.leaf(
            Tag::new("assumed")
                .attr("first", assumed.first)
                .attr("second", assumed.second)
                .attr("together", assumed.together),
        );
    }
    for node in &dfg.live_outs {
        xml.leaf(Tag::new("live-out").attr("node", node));
    }
}

pub(crate) fn operand(operand: &Operand) -> String {
    match operand {
        Operand::Const(bits) => bits.to_string(),
        Operand::LiveIn(i) => format!("in{i}"),
        Operand::Node { node, init } if init.is_empty() => node.to_string(),
        Operand::Node { node, init } => {
            let init: Vec<String> = init.iter().map(|i| initial(*i)).collect();
            format!("{node}@{}[{}]", init.len(), init.join(","))
        }
    }
}

pub(super) fn initial(initial: Initial) -> String {
    match initial {
        Initial::Const(bits) => bits.to_string(),
        Initial::LiveIn(i) => format!("in{i}"),
        Initial::Any => ANY.to_owned(),
    }
}

/// An initial value on which nothing depends.
const ANY: &str = "any";

/// Names that hold in one kernel.
pub(super) struct KernelNames {
    pub(super) inputs: Names<Input>,
    pub(super) nodes: Names<Node>,
}

impl KernelNames {
    fn operand(&self, text: Text<'_>) -> Read<Operand> {
        if terms::is_bits(text) {
            return Ok(Operand::Const(terms::read_bits(text)?));
        }
        if text.text.starts_with("in") {
            return Ok(Operand::LiveIn(self.input(text)?));
        }
        let Some((node, rest)) = text.split_once('@') else {
            let (node, init) = (self.nodes.get(text)?, Vec::new());
            return Ok(Operand::Node { node, init });
        };
        let parts = rest.strip_suffix(']').and_then(|r| r.split_once('['));
        let Some((distance, list)) = parts else {
            return text.fault(format!(
                "`{}` is not `node@distance[first values]`",
                text.text
            ));
        };
        let init: Read<Vec<Initial>> = list.split(|c| c == ',').map(|i| self.initial(i)).collect();
        let init = init?;
        if distance.u32()? as usize != init.len() {
            return distance.fault(format!(
                "a value of {} iterations ago needs as many first values, not {}",
                distance.text,
                init.len()
            ));
        }
        let node = self.nodes.get(node)?;
        Ok(Operand::Node { node, init })
    }

    pub(super) fn initial(&self, text: Text<'_>) -> Read<Initial> {
        if text.text == ANY {
            Ok(Initial::Any)
        } else if terms::is_bits(text) {
            Ok(Initial::Const(terms::read_bits(text)?))
        } else {
            Ok(Initial::LiveIn(self.input(text)?))
        }
    }

    fn input(&self, text: Text<'_>) -> Read<u32> {
        use srp_archdesc::entity::Entity;
        Ok(self.inputs.get(text)?.index() as u32)
    }
}

/// An element's content that was written in another form.
pub(crate) struct Part<'x> {
    name: &'static str,
    span: Span,
    /// Names, values and the places of these.
    pub(crate) attributes: Vec<(&'static str, &'x str, Span)>,
}

impl<'x> Part<'x> {
    pub(crate) fn new(name: &'static str, span: Span) -> Part<'x> {
        let attributes = Vec::new();
        Part {
            name,
            span,
            attributes,
        }
    }

    fn element(self) -> Element<'x> {
        element::made(self.name, self.span, self.attributes)
    }
}

/// A kernel whose elements stand in another form; a mistake with its place.
pub(crate) fn read_parts(
    kernel: Part<'_>,
    children: Vec<Part<'_>>,
    files: &Files,
) -> Result<Dfg, (Span, String)> {
    let mut element = kernel.element();
    element.children = children.into_iter().map(Part::element).collect();
    match read(&element, files) {
        Ok((dfg, _)) => Ok(dfg),
        Err(fault) => Err((fault.span, fault.message)),
    }
}

/// The children of a kernel that describe its graph.
pub(super) const CHILDREN: [&str; 5] = ["live-in", "node", "order", "assumed", "live-out"];

pub(super) fn read(element: &Element<'_>, files: &Files) -> Read<(Dfg, KernelNames)> {
    element.only(&["name", "trip", "at"])?;
    let mut names = KernelNames {
        inputs: Names::new("live-in"),
        nodes: Names::new("node"),
    };
    let named = |name| element.children.iter().filter(move |c| c.name == name);
    let mut live_ins = Vec::new();
    for child in named("live-in") {
        child.only(&["id", "type", "at"])?;
        names.inputs.define(child.required("id")?)?;
        live_ins.push(LiveIn {
            ty: terms::read_ty(child.required("type")?)?,
            pos: terms::read_pos(child, "at", files)?,
        });
    }
    for child in named("node") {
        names.nodes.define(child.required("id")?)?;
    }
    let mut nodes = EntityMap::new();
    for child in named("node") {
        child.only(&["id", "op", "args", "imm", "at"])?;
        let operands: Read<Vec<Operand>> = child.words("args").map(|a| names.operand(a)).collect();
        nodes.push(NodeData {
            op: terms::read_op(child.required("op")?)?,
            operands: operands?,
            imm: terms::read_imm(child)?,
            pos: terms::read_pos(child, "at", files)?,
        });
    }
    let mut order = Vec::new();
    for child in named("order") {
        child.only(&["from", "to", "distance"])?;
        order.push(Order {
            from: names.nodes.get(child.required("from")?)?,
            to: names.nodes.get(child.required("to")?)?,
            distance: child.required("distance")?.u32()?,
        });
    }
    let mut assumed = Vec::new();
    for child in named("assumed") {
        child.only(&["first", "second", "together"])?;
        assumed.push(Assumed {
            first: names.nodes.get(child.required("first")?)?,
            second: names.nodes.get(child.required("second")?)?,
            together: child.required("together")?.bool()?,
        });
    }
    let mut live_outs = Vec::new();
    for child in named("live-out") {
        child.only(&["node"])?;
        live_outs.push(names.nodes.get(child.required("node")?)?);
    }
    let dfg = Dfg {
        name: element.required("name")?.text.to_owned(),
        pos: terms::read_pos(element, "at", files)?,
        trip: (element.optional("trip").map(|t| names.input(t))).transpose()?,
        live_ins,
        nodes,
        order,
        assumed,
        live_outs,
    };
    check(element, &dfg)?;
    Ok((dfg, names))
}

/// Refuses a bare graph, which nothing can launch.
pub(super) fn launchable(element: &Element<'_>) -> Read<()> {
    element.required("trip").map(|_| ())
}

/// Refuses a graph that breaks its rules, at the element of the first that does.
fn check(element: &Element<'_>, dfg: &Dfg) -> Read<()> {
    use srp_archdesc::entity::Entity;
    let Err(violations) = dfg.verify() else {
        return Ok(());
    };
    let first = &violations[0];
    let mut nodes = element.children.iter().filter(|c| c.name == "node");
    let at = first.node.and_then(|n| nodes.nth(n.index()));
    at.unwrap_or(element).fault(first.to_string())
}
