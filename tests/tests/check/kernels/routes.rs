//! Damage to the ways that values take: links, moves, transfers, and the ports of files.

use super::super::tally::Harm;
use super::places::without;
use super::{Kind, Loop};
use srp_archdesc::arch::{Carrier, FileKind, Link, RegFile};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_ir::check::Rule;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::{PlacedOp, PlacedTransfer, RegAt, Source};

/// Rules that a wrong way may break.
const WAYS: &[Rule] = &[
    Rule::Dataflow,
    Rule::Routing,
    Rule::Width,
    Rule::LiveOut,
    Rule::Collision,
    Rule::ReadPorts,
    Rule::WritePorts,
    Rule::Contexts,
];

pub(super) const KINDS: &[Kind] = &[
    ("another link to the unit", Harm::Perhaps, WAYS, other_link),
    (
        "a link to another unit",
        Harm::Always,
        &[Rule::Routing],
        wrong_link,
    ),
    (
        "a link that does not exist",
        Harm::Always,
        &[Rule::Range],
        no_link,
    ),
    (
        "the unit's own output instead of a link",
        Harm::Perhaps,
        WAYS,
        own_output,
    ),
    (
        "a routing move that is gone",
        Harm::Perhaps,
        WAYS,
        move_gone,
    ),
    (
        "a routing move of something else",
        Harm::Perhaps,
        WAYS,
        move_redirected,
    ),
    (
        "a transfer that is gone",
        Harm::Perhaps,
        WAYS,
        transfer_gone,
    ),
    (
        "a transfer over another link or wire",
        Harm::Perhaps,
        WAYS,
        transfer_link,
    ),
    (
        "a transfer at another time",
        Harm::Perhaps,
        WAYS,
        transfer_time,
    ),
    (
        "a transfer of another value",
        Harm::Perhaps,
        WAYS,
        transfer_node,
    ),
    (
        "a file that the unit cannot write",
        Harm::Always,
        &[Rule::Routing],
        wrong_file,
    ),
    (
        "a file that the unit cannot read",
        Harm::Always,
        &[Rule::Routing],
        unreadable_file,
    ),
    (
        "a file that is too narrow",
        Harm::Always,
        &[Rule::Width],
        narrow_file,
    ),
    (
        "two registers of a file at once",
        Harm::Always,
        &[Rule::Routing],
        two_registers,
    ),
    (
        "read ports exceeded",
        Harm::Always,
        &[Rule::ReadPorts],
        read_ports,
    ),
    (
        "write ports exceeded",
        Harm::Always,
        &[Rule::WritePorts],
        write_ports,
    ),
];

fn is_linked(source: &Source) -> bool {
    matches!(source, Source::Out(Some(_)))
}

/// Changes the link that an operand comes over to one that is like this.
fn relink(broken: &mut Loop<'_>, leads_here: bool) -> Option<()> {
    let (op, i) = broken.operand_like(is_linked)?;
    let to = broken.schedule.ops[op].fu;
    let links = broken.arch.srp.links.iter();
    let links: Vec<Link> = links
        .filter(|(_, link)| (link.to == to) == leads_here)
        .map(|(link, _)| link)
        .collect();
    let link = broken.dice.pick(&links)?;
    broken.schedule.ops[op].operands[i] = Source::Out(Some(link));
    Some(())
}

fn other_link(broken: &mut Loop<'_>) -> Option<()> {
    relink(broken, true)
}

fn wrong_link(broken: &mut Loop<'_>) -> Option<()> {
    relink(broken, false)
}

fn no_link(broken: &mut Loop<'_>) -> Option<()> {
    let (op, i) = broken.operand_like(is_linked)?;
    let link = Link::new(broken.arch.srp.links.len() + broken.dice.below(9));
    broken.schedule.ops[op].operands[i] = Source::Out(Some(link));
    Some(())
}

fn own_output(broken: &mut Loop<'_>) -> Option<()> {
    let (op, i) = broken.operand_like(is_linked)?;
    broken.schedule.ops[op].operands[i] = Source::Out(None);
    Some(())
}

fn move_gone(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| op.is_move)?;
    without(broken, op);
    Some(())
}

fn move_redirected(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| op.is_move)?;
    let fu = broken.schedule.ops[op].fu;
    let links = broken
        .arch
        .srp
        .links
        .iter()
        .filter(|(_, link)| link.to == fu);
    let mut sources: Vec<Source> = links.map(|(link, _)| Source::Out(Some(link))).collect();
    sources.push(Source::Out(None));
    broken.schedule.ops[op].operands[0] = broken.dice.pick(&sources)?;
    Some(())
}

/// One of the transfers.
fn transfer<'a>(broken: &'a mut Loop<'_>) -> Option<&'a mut PlacedTransfer> {
    let at = broken.dice.below(broken.schedule.transfers.len());
    broken.schedule.transfers.get_mut(at)
}

fn transfer_gone(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.transfers.len());
    (at < broken.schedule.transfers.len()).then(|| broken.schedule.transfers.remove(at))?;
    Some(())
}

fn transfer_link(broken: &mut Loop<'_>) -> Option<()> {
    let links = broken.arch.srp.links.keys().map(Carrier::Link);
    let wires = broken.arch.srp.wires.keys().map(Carrier::Wire);
    let over = broken.dice.pick(&links.chain(wires).collect::<Vec<_>>())?;
    transfer(broken)?.over = over;
    Some(())
}

fn transfer_time(broken: &mut Loop<'_>) -> Option<()> {
    let late = broken.dice.chance();
    let ii = broken.schedule.ii;
    let by = if broken.dice.chance() { ii } else { 1 };
    let time = &mut transfer(broken)?.time;
    *time = if late {
        *time + by
    } else {
        time.checked_sub(by)?
    };
    Some(())
}

fn transfer_node(broken: &mut Loop<'_>) -> Option<()> {
    let dfg = &broken.schedule.dfg;
    let values: Vec<Node> = dfg.nodes.keys().filter(|&n| dfg.ty(n).is_some()).collect();
    let node = broken.dice.pick(&values)?;
    transfer(broken)?.node = node;
    Some(())
}

/// Lets an operation with a result write a file that is like this.
fn write(
    broken: &mut Loop<'_>,
    is: impl Fn(&Loop<'_>, &PlacedOp, Ty, RegFile) -> bool,
) -> Option<()> {
    let op = broken.op()?;
    let data = broken.schedule.ops[op].clone();
    let ty = broken.ty(&data)?;
    let files = broken.arch.srp.files.keys();
    let files: Vec<RegFile> = files.filter(|&file| is(broken, &data, ty, file)).collect();
    let file = broken.dice.pick(&files)?;
    broken.schedule.ops[op].writes = vec![RegAt {
        file,
        index: 0,
        ring: 1,
    }];
    Some(())
}

fn wrong_file(broken: &mut Loop<'_>) -> Option<()> {
    write(broken, |broken, op, ty, file| {
        let spec = &broken.arch.srp.files[file];
        spec.holds(ty) && !spec.writers.contains(&op.fu)
    })
}

fn unreadable_file(broken: &mut Loop<'_>) -> Option<()> {
    let (op, i) = broken.operand_like(|_| true)?;
    let data = &broken.schedule.ops[op];
    let kind = broken.opcode(data).info().operands[i];
    let files = broken.arch.srp.files.iter();
    let files: Vec<RegFile> = files
        .filter(|(_, file)| file.holds(kind.ty()) && !file.readers.contains(&data.fu))
        .map(|(file, _)| file)
        .collect();
    let reg = RegAt {
        file: broken.dice.pick(&files)?,
        index: 0,
        ring: 1,
    };
    broken.schedule.ops[op].operands[i] = Source::Reg { reg, distance: 0 };
    Some(())
}

fn narrow_file(broken: &mut Loop<'_>) -> Option<()> {
    write(broken, |broken, op, ty, file| {
        let spec = &broken.arch.srp.files[file];
        !spec.holds(ty) && spec.writers.contains(&op.fu)
    })
}

fn two_registers(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| !op.writes.is_empty())?;
    let mut other = broken.schedule.ops[op].writes[0];
    other.index = u32::from(other.index == 0);
    other.ring = 1;
    broken.schedule.ops[op].writes.push(other);
    Some(())
}

/// All operands of a slot that can come from a file do, each from a register of its own.
fn read_ports(broken: &mut Loop<'_>) -> Option<()> {
    let slot = broken.dice.below(broken.schedule.ii as usize) as u32;
    let ii = broken.schedule.ii;
    let ops = broken.ops_like(|op| op.time % ii == slot);
    let files: Vec<RegFile> = broken.arch.srp.files.keys().collect();
    let mut choices = Vec::new();
    for file in files {
        let spec = &broken.arch.srp.files[file];
        let readers = ops
            .iter()
            .filter(|&&op| spec.readers.contains(&broken.schedule.ops[op].fu));
        let operands = readers.flat_map(|&op| {
            let kinds = broken.opcode(&broken.schedule.ops[op]).info().operands;
            let fits = kinds.iter().enumerate().filter(|(_, k)| spec.holds(k.ty()));
            fits.map(move |(i, _)| (op, i))
        });
        let operands: Vec<_> = operands.collect();
        if operands.len() > spec.read_ports as usize && operands.len() <= spec.size as usize {
            choices.push((file, operands));
        }
    }
    let (file, operands) = broken.dice.pick(&choices)?;
    // In a rotating file, stages read registers that are apart; in one stage they stay so.
    let rotating = broken.arch.srp.files[file].kind == FileKind::Rotating;
    let size = broken.arch.srp.files[file].size;
    for (index, (op, i)) in operands.into_iter().enumerate() {
        let stage = broken.schedule.ops[op].time / ii;
        let shift = if rotating { stage } else { 0 };
        let index = (index as u32 + shift) % size;
        let reg = RegAt {
            file,
            index,
            ring: 1,
        };
        broken.schedule.ops[op].operands[i] = Source::Reg { reg, distance: 0 };
    }
    Some(())
}

/// A result goes into more registers of a file than it has ports.
fn write_ports(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    let data = broken.schedule.ops[op].clone();
    let ty = broken.ty(&data)?;
    let from = match ty {
        Ty::Pred => broken.graph.pred_out[data.fu],
        Ty::Word | Ty::Vec => broken.graph.out[data.fu],
    };
    let ways = broken.graph.transfers[from].iter();
    let ways: Vec<_> = ways.filter(|way| way.width >= ty.bits()).copied().collect();
    let way = broken.dice.pick(&ways)?;
    let file = broken.graph.as_file(way.to)?;
    let spec = &broken.arch.srp.files[file];
    (spec.write_ports < spec.size).then_some(())?;
    let time = data.time + broken.how(&data).latency;
    for index in 0..=spec.write_ports {
        broken.schedule.transfers.push(PlacedTransfer {
            node: data.node,
            over: way.over,
            time,
            to: RegAt {
                file,
                index,
                ring: 1,
            },
        });
    }
    broken.last(time + way.delay + 1);
    Some(())
}
