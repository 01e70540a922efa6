//! Scheduled programs as XML: bundles of the VLIW engine, modulo schedules of the array.

use super::element::{Element, ElementExt, Read};
use super::kernel;
use super::machine::{Machine, ids};
use super::scheduled::*;
use super::terms::{self, Files, Names};
use crate::dfg::Initial;
use crate::program::Kernel;
use srp_archdesc::arch::Carrier;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::xml::tree::{Tag, Writer};

pub(super) fn write_scheduled(xml: &mut Writer, dre: &ScheduledDre, machine: &Machine<'_>) {
    xml.open(
        Tag::new("scheduled-dre")
            .attr("version", super::VERSION)
            .attr("machine", &dre.machine)
            .attr("start", dre.start),
    );
    terms::write_files(xml, &dre.files);
    xml.open(Tag::new("image"));
    terms::write_bytes(xml, &dre.image);
    xml.close();
    for symbol in &dre.symbols {
        xml.leaf(
            Tag::new("symbol")
                .attr("name", &symbol.name)
                .attr("address", format!("{:#x}", symbol.address))
                .attr("size", symbol.size),
        );
    }
    for function in &dre.functions {
        xml.leaf(
            Tag::new("function")
                .attr("name", &function.name)
                .attr("bundle", function.bundle),
        );
    }
    for (bundle, data) in dre.bundles.iter() {
        write_bundle(xml, dre, machine, bundle, data);
    }
    for schedule in dre.kernels.values() {
        kernel::open(xml, &schedule.dfg);
        write_schedule(xml, schedule, machine);
        xml.close();
    }
    xml.close();
}

pub(super) fn write_loops(xml: &mut Writer, scheduled: &ScheduledLoops, machine: &Machine<'_>) {
    xml.open(
        Tag::new(LOOPS)
            .attr("version", super::VERSION)
            .attr("machine", &scheduled.machine),
    );
    terms::write_files(xml, &scheduled.files);
    for schedule in &scheduled.loops {
        kernel::open(xml, &schedule.dfg);
        write_schedule(xml, schedule, machine);
        xml.close();
    }
    xml.close();
}

/// What a transfer comes over.
const LINK: &str = "link";
const WIRE: &str = "wire";

/// The root element of modulo schedules by themselves.
pub(super) const LOOPS: &str = "scheduled-loops";

fn write_bundle(
    xml: &mut Writer,
    dre: &ScheduledDre,
    machine: &Machine<'_>,
    bundle: Bundle,
    data: &BundleData,
) {
    let tag = Tag::new("bundle").attr("id", bundle);
    if data.ops.is_empty() && data.control.is_none() {
        xml.leaf(tag);
        return;
    }
    xml.open(tag);
    for op in &data.ops {
        xml.leaf(
            Tag::new("op")
                .attr("fu", machine.fu(op.fu))
                .attr("op", op.op)
                .list("args", op.srcs.iter().map(|s| machine.src(*s)))
                .attr_if("imm", terms::imm(op.op, op.imm))
                .attr_if("to", op.dst.map(|r| machine.reg(r)))
                .attr_if("at", terms::pos(op.pos)),
        );
    }
    if let Some((control, pos)) = &data.control {
        let tag = match control {
            Control::Jump(target) => Tag::new("jump").attr("to", target),
            Control::Branch {
                cond,
                sense,
                target,
            } => Tag::new("branch")
                .attr(if *sense { "if" } else { "unless" }, machine.reg(*cond))
                .attr("to", target),
            Control::Call { target, link } => Tag::new("call")
                .attr("to", target)
                .attr("link", machine.reg(*link)),
            Control::CallReg { target, link } => Tag::new("call-register")
                .attr("to", machine.reg(*target))
                .attr("link", machine.reg(*link)),
            Control::Return(link) => Tag::new("return").attr("link", machine.reg(*link)),
            Control::Launch(kernel) => {
                Tag::new("launch").attr("kernel", &dre.kernels[*kernel].dfg.name)
            }
            Control::Halt(status) => Tag::new("halt").attr("status", machine.reg(*status)),
            Control::Unreachable => Tag::new("unreachable"),
            Control::StackOverflow => Tag::new("stack-overflow"),
        };
        xml.leaf(tag.attr_if("at", terms::pos(*pos)));
    }
    xml.close();
}

fn write_schedule(xml: &mut Writer, schedule: &ModuloSchedule, machine: &Machine<'_>) {
    let regs = |regs: &[Reg]| -> Vec<String> { regs.iter().map(|r| machine.reg(*r)).collect() };
    xml.open(
        Tag::new("schedule")
            .attr("ii", schedule.ii)
            .attr("length", schedule.length)
            .list("live-ins", regs(&schedule.live_in_regs))
            .list("live-outs", regs(&schedule.live_out_regs)),
    );
    for op in schedule.ops.values() {
        let tag = Tag::new(if op.is_move { "move" } else { "place" });
        xml.leaf(
            tag.attr("node", op.node)
                .attr("fu", machine.fu(op.fu))
                .attr("time", op.time)
                .list("from", op.operands.iter().map(|s| machine.source(*s)))
                .list("to", op.writes.iter().map(|r| machine.reg_at(*r))),
        );
    }
    for hop in &schedule.hops {
        xml.leaf(
            Tag::new("hop")
                .attr("node", hop.node)
                .attr("wire", machine.wire(hop.wire))
                .attr("from", machine.input(hop.from))
                .attr("time", hop.time),
        );
    }
    for transfer in &schedule.transfers {
        let (kind, name) = match transfer.over {
            Carrier::Link(link) => (LINK, machine.link(link)),
            Carrier::Wire(wire) => (WIRE, machine.wire(wire)),
        };
        xml.leaf(
            Tag::new("transfer")
                .attr("node", transfer.node)
                .attr(kind, name)
                .attr("time", transfer.time)
                .attr("to", machine.reg_at(transfer.to)),
        );
    }
    for preload in &schedule.preloads {
        let reg = Reg {
            file: preload.file,
            index: preload.index,
        };
        xml.leaf(
            Tag::new("preload")
                .attr("to", machine.reg(reg))
                .attr("type", preload.ty)
                .attr("value", kernel::initial(preload.value)),
        );
    }
    xml.close();
}

pub(super) fn read_scheduled(root: &Element<'_>, machine: &Machine<'_>) -> Read<ScheduledDre> {
    root.only(&["version", "machine", "start"])?;
    let name = machine_name(root, machine)?;
    const CHILDREN: [&str; 6] = ["file", "image", "symbol", "function", "bundle", "kernel"];
    if let Some(other) = root.children.iter().find(|c| !CHILDREN.contains(&c.name)) {
        return other.misplaced(&CHILDREN);
    }
    let files = terms::read_files(root)?;
    let bundles: Names<Bundle> = ids("bundle", &root.children, "bundle", "id")?;
    let kernels: Names<Kernel> = ids("kernel", &root.children, "kernel", "name")?;
    let reader = Reader {
        machine,
        files: &files,
        bundles: &bundles,
        kernels: &kernels,
    };
    let mut dre = ScheduledDre {
        machine: name,
        files: Files::new(),
        image: Vec::new(),
        symbols: Vec::new(),
        bundles: EntityMap::new(),
        functions: Vec::new(),
        start: bundles.get(root.required("start")?)?,
        kernels: EntityMap::new(),
    };
    for child in &root.children {
        match child.name {
            "image" => read_image(child, &mut dre.image)?,
            "symbol" => dre.symbols.push(read_symbol(child)?),
            "function" => dre.functions.push(reader.function(child)?),
            "bundle" => drop(dre.bundles.push(reader.bundle(child)?)),
            "kernel" => {
                kernel::launchable(child)?;
                dre.kernels.push(read_kernel(child, machine, &files)?);
            }
            _ => {}
        }
    }
    dre.files = files;
    Ok(dre)
}

pub(super) fn read_loops(root: &Element<'_>, machine: &Machine<'_>) -> Read<ScheduledLoops> {
    root.only(&["version", "machine"])?;
    let name = machine_name(root, machine)?;
    const CHILDREN: [&str; 2] = ["file", "kernel"];
    if let Some(other) = root.children.iter().find(|c| !CHILDREN.contains(&c.name)) {
        return other.misplaced(&CHILDREN);
    }
    let files = terms::read_files(root)?;
    let kernels = root.children.iter().filter(|c| c.name == "kernel");
    let loops: Read<Vec<ModuloSchedule>> = kernels
        .map(|kernel| read_kernel(kernel, machine, &files))
        .collect();
    Ok(ScheduledLoops {
        machine: name,
        loops: loops?,
        files,
    })
}

/// The machine that a schedule is for, which must be this one.
fn machine_name(root: &Element<'_>, machine: &Machine<'_>) -> Read<String> {
    let name = root.required("machine")?;
    if name.text != machine.arch.name {
        return name.fault(format!(
            "this schedule is for machine `{}`, not for `{}`",
            name.text, machine.arch.name
        ));
    }
    Ok(name.text.to_owned())
}

fn read_image(element: &Element<'_>, image: &mut Vec<u8>) -> Read<()> {
    element.only(&[])?;
    for child in &element.children {
        if !terms::read_bytes(child, image)? {
            return child.misplaced(&["bytes", "zeros"]);
        }
    }
    Ok(())
}

fn read_symbol(element: &Element<'_>) -> Read<DataSymbol> {
    element.only(&["name", "address", "size"])?;
    Ok(DataSymbol {
        name: element.required("name")?.text.to_owned(),
        address: element.required("address")?.u32()?,
        size: element.required("size")?.u32()?,
    })
}

/// The meaning of names in a scheduled program.
struct Reader<'a> {
    machine: &'a Machine<'a>,
    files: &'a Files,
    bundles: &'a Names<Bundle>,
    kernels: &'a Names<Kernel>,
}

impl Reader<'_> {
    fn function(&self, element: &Element<'_>) -> Read<FunctionEntry> {
        element.only(&["name", "bundle"])?;
        Ok(FunctionEntry {
            name: element.required("name")?.text.to_owned(),
            bundle: self.bundles.get(element.required("bundle")?)?,
        })
    }

    fn bundle(&self, element: &Element<'_>) -> Read<BundleData> {
        element.only(&["id"])?;
        let mut data = BundleData::default();
        for child in &element.children {
            if child.name == "op" {
                data.ops.push(self.slot_op(child)?);
            } else if data.control.is_some() {
                return child.fault("a second control transfer in one bundle");
            } else {
                let pos = terms::read_pos(child, "at", self.files)?;
                data.control = Some((self.control(child)?, pos));
            }
        }
        Ok(data)
    }

    fn slot_op(&self, element: &Element<'_>) -> Read<SlotOp> {
        element.only(&["fu", "op", "args", "imm", "to", "at"])?;
        let srcs: Read<Vec<Src>> = element
            .words("args")
            .map(|a| self.machine.read_src(a))
            .collect();
        let dst = element.optional("to");
        Ok(SlotOp {
            fu: self.machine.read_fu(element.required("fu")?)?,
            op: terms::read_op(element.required("op")?)?,
            srcs: srcs?,
            imm: terms::read_imm(element)?,
            dst: dst.map(|d| self.machine.read_reg(d)).transpose()?,
            pos: terms::read_pos(element, "at", self.files)?,
        })
    }

    fn control(&self, element: &Element<'_>) -> Read<Control> {
        let reg = |name: &str| self.machine.read_reg(element.required(name)?);
        let bundle = |name: &str| self.bundles.get(element.required(name)?);
        let (allowed, control): (&[&str], Control) = match element.name {
            "jump" => (&["to"], Control::Jump(bundle("to")?)),
            "branch" => {
                let sense = element.optional("if").is_some();
                let control = Control::Branch {
                    cond: reg(if sense { "if" } else { "unless" })?,
                    sense,
                    target: bundle("to")?,
                };
                (
                    if sense {
                        &["if", "to"]
                    } else {
                        &["unless", "to"]
                    },
                    control,
                )
            }
            "call" => {
                let (target, link) = (bundle("to")?, reg("link")?);
                (&["to", "link"], Control::Call { target, link })
            }
            "call-register" => {
                let (target, link) = (reg("to")?, reg("link")?);
                (&["to", "link"], Control::CallReg { target, link })
            }
            "return" => (&["link"], Control::Return(reg("link")?)),
            "launch" => {
                let kernel = self.kernels.get(element.required("kernel")?)?;
                (&["kernel"], Control::Launch(kernel))
            }
            "halt" => (&["status"], Control::Halt(reg("status")?)),
            "unreachable" => (&[], Control::Unreachable),
            "stack-overflow" => (&[], Control::StackOverflow),
            _ => {
                return element.misplaced(&[
                    "op",
                    "jump",
                    "branch",
                    "call",
                    "call-register",
                    "return",
                    "launch",
                    "halt",
                    "unreachable",
                    "stack-overflow",
                ]);
            }
        };
        let with_pos: Vec<&str> = allowed.iter().copied().chain(["at"]).collect();
        element.only(&with_pos)?;
        Ok(control)
    }
}

/// A kernel with its schedule.
fn read_kernel(
    element: &Element<'_>,
    machine: &Machine<'_>,
    files: &Files,
) -> Read<ModuloSchedule> {
    let (dfg, names) = kernel::read(element, files)?;
    let mut schedules = element.children.iter().filter(|c| c.name == "schedule");
    let (Some(schedule), None) = (schedules.next(), schedules.next()) else {
        return element.fault("a scheduled kernel needs one `<schedule>`");
    };
    let known = |c: &&Element<'_>| kernel::CHILDREN.contains(&c.name) || c.name == "schedule";
    if let Some(other) = element.children.iter().find(|c| !known(c)) {
        return other.misplaced(&["live-in", "node", "order", "live-out", "schedule"]);
    }
    schedule.only(&["ii", "length", "live-ins", "live-outs"])?;
    let ii = schedule.required("ii")?;
    if ii.u32()? == 0 {
        return ii.fault("the initiation interval is at least 1");
    }
    let regs = |name: &str| -> Read<Vec<Reg>> {
        let words = schedule.words(name);
        words.map(|r| machine.read_reg(r)).collect()
    };
    let mut result = ModuloSchedule {
        dfg,
        ii: ii.u32()?,
        length: schedule.required("length")?.u32()?,
        ops: EntityMap::new(),
        transfers: Vec::new(),
        hops: Vec::new(),
        preloads: Vec::new(),
        live_in_regs: regs("live-ins")?,
        live_out_regs: regs("live-outs")?,
    };
    for child in &schedule.children {
        match child.name {
            "place" | "move" => drop(result.ops.push(read_placed(child, machine, &names)?)),
            "transfer" => result
                .transfers
                .push(read_transfer(child, machine, &names)?),
            "hop" => result.hops.push(read_hop(child, machine, &names)?),
            "preload" => result.preloads.push(read_preload(child, machine, &names)?),
            _ => return child.misplaced(&["place", "move", "hop", "transfer", "preload"]),
        }
    }
    Ok(result)
}

fn read_placed(
    element: &Element<'_>,
    machine: &Machine<'_>,
    names: &kernel::KernelNames,
) -> Read<PlacedOp> {
    element.only(&["node", "fu", "time", "from", "to"])?;
    let operands: Read<Vec<Source>> = element
        .words("from")
        .map(|s| machine.read_source(s))
        .collect();
    let writes: Read<Vec<RegAt>> = element
        .words("to")
        .map(|r| machine.read_reg_at(r))
        .collect();
    Ok(PlacedOp {
        node: names.nodes.get(element.required("node")?)?,
        is_move: element.name == "move",
        fu: machine.read_fu(element.required("fu")?)?,
        time: element.required("time")?.u32()?,
        operands: operands?,
        writes: writes?,
    })
}

fn read_transfer(
    element: &Element<'_>,
    machine: &Machine<'_>,
    names: &kernel::KernelNames,
) -> Read<PlacedTransfer> {
    let over = match element.optional(WIRE) {
        Some(wire) => {
            element.only(&["node", WIRE, "time", "to"])?;
            Carrier::Wire(machine.read_wire(wire)?)
        }
        None => {
            element.only(&["node", LINK, WIRE, "time", "to"])?;
            Carrier::Link(machine.read_link(element.required(LINK)?)?)
        }
    };
    Ok(PlacedTransfer {
        node: names.nodes.get(element.required("node")?)?,
        over,
        time: element.required("time")?.u32()?,
        to: machine.read_reg_at(element.required("to")?)?,
    })
}

fn read_hop(
    element: &Element<'_>,
    machine: &Machine<'_>,
    names: &kernel::KernelNames,
) -> Read<PlacedHop> {
    element.only(&["node", "wire", "from", "time"])?;
    Ok(PlacedHop {
        node: names.nodes.get(element.required("node")?)?,
        wire: machine.read_wire(element.required("wire")?)?,
        from: machine.read_input(element.required("from")?)?,
        time: element.required("time")?.u32()?,
    })
}

fn read_preload(
    element: &Element<'_>,
    machine: &Machine<'_>,
    names: &kernel::KernelNames,
) -> Read<Preload> {
    element.only(&["to", "type", "value"])?;
    let Reg { file, index } = machine.read_reg(element.required("to")?)?;
    let value = element.required("value")?;
    let ty: Ty = terms::read_ty(element.required("type")?)?;
    let initial = names.initial(value)?;
    if initial == Initial::Any {
        return value.fault("a register is set to a value; leave it out where any will do");
    }
    Ok(Preload {
        file,
        index,
        value: initial,
        ty,
    })
}
