//! Random kernels: first operations in units and cycles, then registers for their results, then operands from
//! the values at hand. The dataflow graph follows from these.

use super::{Constants, Dice, LIVE_INS, Shape, files, immediate, opcodes, safe_operand};
use srp_archdesc::Arch;
use srp_archdesc::arch::{Carrier, FileKind, Fu, Input, RegFile, Resource, Wire};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::{Place, ResourceGraph};
use srp_ir::dfg::{Dfg, Initial, LiveIn, Node, NodeData, Operand};
use srp_ir::dre::scheduled::*;
use srp_ir::program::{Bits, Pos};
use std::collections::{BTreeMap, BTreeSet};

/// A random kernel, and the central registers that are not set after it.
pub(super) fn random(
    arch: &Arch,
    dice: &mut Dice,
    shape: &Shape,
    number: usize,
) -> (ModuloSchedule, Vec<(Ty, Reg)>) {
    let graph = ResourceGraph::of(&arch.srp);
    let ii = shape.ii + dice.roll(shape.iis) as u32;
    let mut ops = operations(arch, &graph, dice, shape, ii);
    loop {
        let mut made = Loop::new(arch, &graph, dice, shape, ii, ops);
        match made.connect() {
            Ok(operands) => return made.finish(operands, number),
            // There is nothing that it could take; the others may do without its result.
            Err(op) => {
                ops = made.ops;
                ops.remove(op);
            }
        }
    }
}

/// An operation in its place.
struct Op {
    op: Opcode,
    imm: i32,
    fu: Fu,
    time: u32,
    /// The cycle from which its result stands in the output, or in which it is over.
    end: u32,
}

/// Operations on all units, none of which is in another's way.
fn operations(
    arch: &Arch,
    graph: &ResourceGraph,
    dice: &mut Dice,
    shape: &Shape,
    ii: u32,
) -> Vec<Op> {
    let mut ops = Vec::new();
    let mut units: BTreeSet<(Fu, u32)> = BTreeSet::new();
    let mut landing: BTreeSet<(Place, u32)> = BTreeSet::new();
    let mut shared: BTreeMap<(Resource, u32), u32> = BTreeMap::new();
    for fu in arch.srp.fus.keys() {
        for slot in 0..ii {
            if dice.roll(16) >= shape.density {
                continue;
            }
            let op = dice.pick(&opcodes(arch, shape, fu));
            let op = op.expect("a unit that does something");
            let imm = immediate(dice, op);
            let time = slot + ii * dice.roll(4) as u32;
            let how = arch.srp.fus[fu].runs(op).expect("chosen so");
            let slots = || (0..how.interval).map(|cycle| (time + cycle) % ii);
            let used = |resource: Resource, slot| shared.get(&(resource, slot)).copied();
            let free = how.interval <= ii
                && slots().all(|slot| !units.contains(&(fu, slot)))
                && slots().all(|slot| {
                    let mut uses = how.uses.iter();
                    uses.all(|&r| used(r, slot).unwrap_or(0) < arch.srp.resources[r].count)
                });
            let end = time + op.result().map_or(1, |_| how.latency);
            let place = graph.result_place(fu, op);
            if !free || place.is_some_and(|place| !landing.insert((place, end % ii))) {
                continue;
            }
            for slot in slots() {
                units.insert((fu, slot));
                for &resource in &how.uses {
                    *shared.entry((resource, slot)).or_insert(0) += 1;
                }
            }
            ops.push(Op {
                op,
                imm,
                fu,
                time,
                end,
            });
        }
    }
    ops
}

/// A value of a node in a register, or in several by turns, that nothing else is written into.
struct Value {
    node: usize,
    ty: Ty,
    at: RegAt,
    /// True if a transfer brings it, and not its operation.
    moved: bool,
    /// How many registers take turns.
    turns: u32,
    /// The cycle of iteration 0 from which it stands there.
    stands: u32,
    /// Values for iterations before the first, the last of them first.
    initial: Vec<Initial>,
}

/// The other end of the wires that lead to one.
#[derive(Clone, Copy)]
struct Behind {
    node: usize,
    /// The output.
    place: Place,
    /// Registers on the way, but for those of the last wire.
    delay: u32,
    /// Wires since the last registers.
    hops: u32,
}

/// A kernel in the making.
struct Loop<'a> {
    arch: &'a Arch,
    graph: &'a ResourceGraph,
    dice: &'a mut Dice,
    shape: &'a Shape,
    ii: u32,
    ops: Vec<Op>,
    live_ins: Vec<(Ty, Reg)>,
    values: Vec<Value>,
    transfers: Vec<PlacedTransfer>,
    /// What wires take, by slot of the II.
    hops: BTreeMap<(Wire, u32), PlacedHop>,
    preloads: Vec<Preload>,
    /// The first register of each file that has no value.
    free: EntityMap<RegFile, u32>,
    /// Results that arrive in a file, and registers that are read, by cycle modulo the II.
    arrivals: BTreeMap<(RegFile, u32), u32>,
    reads: BTreeMap<(RegFile, u32), u32>,
}

/// Where an operand is taken from, and what it is.
type Take = (Source, Operand);

impl<'a> Loop<'a> {
    fn new(
        arch: &'a Arch,
        graph: &'a ResourceGraph,
        dice: &'a mut Dice,
        shape: &'a Shape,
        ii: u32,
        ops: Vec<Op>,
    ) -> Loop<'a> {
        let live_in = |(ty, index)| {
            let file = arch.srp.central(ty).expect("a checked machine");
            (ty, Reg { file, index })
        };
        let live_ins = [(Ty::Word, 0), (Ty::Word, 1), (Ty::Vec, 1), (Ty::Pred, 1)];
        let files = arch.srp.files.values();
        let free = files.map(|f| match f.kind {
            FileKind::Central => LIVE_INS,
            FileKind::Static | FileKind::Rotating => 0,
        });
        Loop {
            arch,
            graph,
            dice,
            shape,
            ii,
            ops,
            live_ins: live_ins.map(live_in).to_vec(),
            values: Vec::new(),
            transfers: Vec::new(),
            hops: BTreeMap::new(),
            preloads: Vec::new(),
            free: free.collect(),
            arrivals: BTreeMap::new(),
            reads: BTreeMap::new(),
        }
    }

    /// Registers for results and operands for all operations, or the operation that finds none.
    fn connect(&mut self) -> Result<Vec<Vec<Take>>, usize> {
        for node in 0..self.ops.len() {
            self.write(node);
        }
        let wires = self.arch.srp.wires.len();
        for _ in 0..2 * wires * self.ii as usize {
            let wire = Wire::new(self.dice.roll(wires));
            let time = self.dice.roll(6 * self.ii as usize) as u32;
            self.hop(wire, time);
        }
        let links = self.arch.srp.links.keys().map(Carrier::Link);
        let wires = self.arch.srp.wires.keys().map(Carrier::Wire);
        for over in links.chain(wires) {
            if self.dice.roll(2) == 0 {
                self.transfer(over);
            }
        }
        let all = 0..self.ops.len();
        all.map(|node| self.operands(node).ok_or(node)).collect()
    }

    /// Lets the result of a node be written into some registers.
    fn write(&mut self, node: usize) {
        let Op { op, fu, end, .. } = self.ops[node];
        let Some(ty) = op.result() else {
            return;
        };
        let writable = files(self.arch, |f| {
            self.arch.srp.files[f].writers.contains(&fu) && self.arch.srp.files[f].holds(ty)
        });
        let mut written = BTreeSet::new();
        for _ in 0..self.dice.roll(3) {
            let file = self.dice.pick(&writable);
            // One register of a file at once.
            if let Some(file) = file.filter(|&file| written.insert(file)) {
                self.keep(node, ty, file, end, false);
            }
        }
    }

    /// A register of `file` for a value that arrives in a cycle, if there is one. Its earlier contents may be
    /// set at entry, unless the value is moved there.
    fn keep(
        &mut self,
        node: usize,
        ty: Ty,
        file: RegFile,
        stands: u32,
        moved: bool,
    ) -> Option<RegAt> {
        let spec = &self.arch.srp.files[file];
        let arrivals = self.arrivals.entry((file, stands % self.ii)).or_insert(0);
        if *arrivals == spec.write_ports {
            return None;
        }
        let ring = 1 + self.dice.roll(self.shape.ring) as u32;
        let first = self.free[file];
        let (at, turns) = match spec.kind {
            // All registers of a rotating file are one value's.
            FileKind::Rotating if first == 0 => {
                let index = self.dice.roll(spec.size as usize) as u32;
                (
                    RegAt {
                        file,
                        index,
                        ring: 1,
                    },
                    spec.size,
                )
            }
            FileKind::Static if first + ring <= spec.size => {
                let index = first;
                (RegAt { file, index, ring }, ring)
            }
            FileKind::Central if first + ring < spec.size => {
                let index = first;
                (RegAt { file, index, ring }, ring)
            }
            _ => return None,
        };
        *arrivals += 1;
        self.free[file] += turns;
        let set = !moved && spec.kind != FileKind::Central && self.dice.roll(2) == 0;
        let before = (1..=i64::from(turns)).map(|back| match set {
            true => self.preload(ty, at, back),
            false => Initial::Any,
        });
        let initial = before.collect();
        self.values.push(Value {
            node,
            ty,
            at,
            moved,
            turns,
            stands,
            initial,
        });
        Some(at)
    }

    /// Sets the register of the iteration `back` before the first.
    fn preload(&mut self, ty: Ty, at: RegAt, back: i64) -> Initial {
        let same = |(_, (live_in, _)): &(usize, &(Ty, Reg))| *live_in == ty;
        let live_in = self.live_ins.iter().enumerate().find(same);
        let value = match (live_in, self.dice.roll(4)) {
            (Some((k, _)), 0) => Initial::LiveIn(k as u32),
            _ => Initial::Const(self.dice.constant(ty)),
        };
        let spec = &self.arch.srp.files[at.file];
        let rotating = spec.kind == FileKind::Rotating;
        self.preloads.push(Preload {
            file: at.file,
            index: at.physical(-back, rotating, spec.size),
            value,
            ty,
        });
        value
    }

    /// Sets a wire for a cycle, if it is free in that slot and an input of it has something then.
    fn hop(&mut self, wire: Wire, time: u32) {
        let Some(from) = self.dice.pick(&self.arch.srp.wires[wire].from) else {
            return;
        };
        let slot = (wire, time % self.ii);
        let (place, node, hops) = match from {
            Input::Unit(fu) => {
                let outputs: Vec<Place> = self.graph.outputs(fu).collect();
                let place = outputs[self.dice.roll(outputs.len())];
                let standing = self.standing(place, i64::from(time));
                (place, standing.map(|(node, _)| node), 1)
            }
            Input::Wire(before) => {
                let delay = self.arch.srp.wires[before].delay;
                let taken = i64::from(time) - i64::from(delay);
                let Some(behind) = self.behind(before, taken) else {
                    return;
                };
                // Of this iteration or an earlier one, as time is counted here.
                let standing = self.standing(behind.place, taken - i64::from(behind.delay));
                let hops = if delay > 0 { 1 } else { behind.hops + 1 };
                let place = self.graph.wire[before][0];
                (place, standing.map(|(node, _)| node), hops)
            }
        };
        let to = self.graph.wire[wire][0];
        let mut ways = self.graph.hops[place].iter();
        let way = ways.find(|way| way.to == to);
        if let (Some(node), Some(way)) = (node, way)
            && hops <= self.arch.srp.hops
            && !self.hops.contains_key(&slot)
            && self.ops[node]
                .op
                .result()
                .is_some_and(|ty| ty.bits() <= way.width)
        {
            let node = Node::new(node);
            let hop = PlacedHop {
                node,
                wire,
                from,
                time,
            };
            self.hops.insert(slot, hop);
        }
    }

    /// Where a wire has its value of a cycle from.
    fn behind(&self, wire: Wire, cycle: i64) -> Option<Behind> {
        let slot = cycle.rem_euclid(i64::from(self.ii)) as u32;
        let hop = self.hops.get(&(wire, slot))?;
        let node = hop.node.index();
        match hop.from {
            Input::Unit(_) => {
                let op = &self.ops[node];
                let place = self.graph.result_place(op.fu, op.op)?;
                Some(Behind {
                    node,
                    place,
                    delay: 0,
                    hops: 1,
                })
            }
            Input::Wire(before) => {
                let delay = self.arch.srp.wires[before].delay;
                let behind = self.behind(before, cycle - i64::from(delay))?;
                let hops = if delay > 0 { 1 } else { behind.hops + 1 };
                Some(Behind {
                    delay: behind.delay + delay,
                    hops,
                    ..behind
                })
            }
        }
    }

    /// A node whose value a link or wire has: the node, its output, registers on the way, and for a wire the slot.
    fn carried(&mut self, over: Carrier) -> Option<(usize, Place, u32, Option<u32>)> {
        match over {
            Carrier::Link(link) => {
                let from = self.arch.srp.links[link].from;
                let place = |op: &Op| self.graph.result_place(op.fu, op.op);
                let nodes = (0..self.ops.len()).filter(|&n| self.ops[n].fu == from);
                let nodes: Vec<usize> = nodes.filter(|&n| place(&self.ops[n]).is_some()).collect();
                let node = self.dice.pick(&nodes)?;
                Some((node, place(&self.ops[node])?, 0, None))
            }
            Carrier::Wire(wire) => {
                let slots = (0..self.ii).filter(|&slot| self.hops.contains_key(&(wire, slot)));
                let slots: Vec<u32> = slots.collect();
                let slot = self.dice.pick(&slots)?;
                let behind = self.behind(wire, i64::from(slot))?;
                Some((behind.node, behind.place, behind.delay, Some(slot)))
            }
        }
    }

    /// Takes a value over a link or wire into a register, if there is one that this carries to a file.
    fn transfer(&mut self, over: Carrier) {
        let Some((node, place, before, slot)) = self.carried(over) else {
            return;
        };
        let op = &self.ops[node];
        let Some(ty) = op.op.result() else {
            return;
        };
        let from = match over {
            Carrier::Link(_) => place,
            Carrier::Wire(wire) => self.graph.wire[wire][0],
        };
        let ways = self.graph.transfers[from].iter();
        let ways: Vec<_> = ways
            .filter(|way| way.over == over && way.width >= ty.bits())
            .copied()
            .collect();
        let time = op.end + before + self.dice.roll(self.ii as usize) as u32;
        let stood = i64::from(time) - i64::from(before);
        let stands_there = self.standing(place, stood) == Some((node, 0))
            && slot.is_none_or(|slot| slot == time % self.ii);
        let way = self.dice.pick(&ways).filter(|_| stands_there);
        let file = way.and_then(|way| Some((self.graph.as_file(way.to)?, way.delay)));
        let Some((file, delay)) = file else {
            return;
        };
        if let Some(to) = self.keep(node, ty, file, time + delay + 1, true) {
            self.transfers.push(PlacedTransfer {
                node: Node::new(node),
                over,
                time,
                to,
            });
        }
    }

    /// Which node's value an output holds in a cycle of any iteration, and of how many iterations before.
    fn standing(&self, place: Place, cycle: i64) -> Option<(usize, u32)> {
        let ii = i64::from(self.ii);
        let here = |op: &Op| self.graph.result_place(op.fu, op.op) == Some(place);
        let nodes = (0..self.ops.len()).filter(|&n| here(&self.ops[n]));
        let age = |node: usize| cycle - i64::from(self.ops[node].end);
        let latest = nodes.min_by_key(|&node| age(node).rem_euclid(ii))?;
        // That of a later iteration is nothing to take.
        let distance = u32::try_from(-age(latest).div_euclid(ii)).ok()?;
        Some((latest, distance))
    }

    fn operands(&mut self, node: usize) -> Option<Vec<Take>> {
        let Op { op, fu, time, .. } = self.ops[node];
        let mut constants = Constants::default();
        let mut all = Vec::new();
        for (number, kind) in op.info().operands.iter().enumerate() {
            if let Some(bits) = safe_operand(self.dice, op, number) {
                all.push(self.constant(fu, bits, &mut constants)?);
                continue;
            }
            let ty = kind.ty();
            // The first choice, and its alternatives.
            let choice = self.dice.roll(8);
            let first = (choice == 0).then(|| self.dice.constant(ty));
            let take = first.and_then(|bits| self.constant(fu, bits, &mut constants));
            let take = take.or_else(|| match choice {
                0..4 => self.output(fu, time, ty),
                _ => self.register(fu, time, ty),
            });
            let take = take.or_else(|| self.output(fu, time, ty));
            let take = take.or_else(|| self.live_in(fu, time, ty));
            let take = take.or_else(|| {
                let mut same = constants.0.iter().filter(|bits| bits.ty() == ty);
                let bits = same.next().copied().unwrap_or(Bits::zero(ty));
                self.constant(fu, bits, &mut constants)
            });
            all.push(take?);
        }
        Some(all)
    }

    fn constant(&self, fu: Fu, bits: Bits, constants: &mut Constants) -> Option<Take> {
        let fits = constants.take(bits, self.arch, fu);
        fits.then_some((Source::Const(bits), Operand::Const(bits)))
    }

    /// Returns the output of some unit, or the unit's own.
    fn output(&mut self, fu: Fu, time: u32, ty: Ty) -> Option<Take> {
        let output = |from: Fu| match ty {
            Ty::Pred => self.graph.pred_out[from],
            Ty::Word | Ty::Vec => self.graph.out[from],
        };
        let mut takes = Vec::new();
        for path in &self.graph.reads[fu] {
            let at = i64::from(time) - i64::from(path.delay);
            let (source, from, stood) = match path.over {
                None => (Source::Out(None), output(fu), at),
                Some(Carrier::Link(link)) => {
                    let from = output(self.arch.srp.links[link].from);
                    (Source::Out(Some(link)), from, at)
                }
                Some(Carrier::Wire(wire)) => match self.behind(wire, at) {
                    None => continue,
                    Some(behind) => {
                        let stood = at - i64::from(behind.delay);
                        (Source::Wire(wire), behind.place, stood)
                    }
                },
            };
            let is_there = path.from == from || matches!(source, Source::Wire(_));
            if !is_there || path.width < ty.bits() {
                continue;
            }
            let standing = self.standing(from, stood);
            let found = standing.filter(|&(node, _)| self.ops[node].op.result() == Some(ty));
            takes.extend(found.map(|(node, distance)| (source, node, distance)));
        }
        let (source, node, distance) = self.dice.pick(&takes)?;
        let init = vec![Initial::Any; distance as usize];
        Some((source, of_node(node, init)))
    }

    /// A value in a register.
    fn register(&mut self, fu: Fu, time: u32, ty: Ty) -> Option<Take> {
        let readable = |value: &&Value| {
            value.ty == ty && self.arch.srp.files[value.at.file].readers.contains(&fu)
        };
        let mut takes = Vec::new();
        for value in self.values.iter().filter(readable) {
            // It stands there for as many iterations as there are registers for it.
            let first = value.stands.saturating_sub(time).div_ceil(self.ii);
            for distance in first..first + value.turns {
                if time + self.ii * distance < value.stands + self.ii * value.turns {
                    let initial = |k| value.initial.get(k).copied().unwrap_or(Initial::Any);
                    let init: Vec<Initial> = (0..distance as usize).map(initial).collect();
                    takes.push((value.at, distance, of_node(value.node, init)));
                }
            }
        }
        let chosen = self.dice.roll(takes.len());
        let (reg, distance, value) = takes.into_iter().nth(chosen)?;
        self.read(reg.file, time)
            .then_some((Source::Reg { reg, distance }, value))
    }

    /// A value from outside, in its central register.
    fn live_in(&mut self, fu: Fu, time: u32, ty: Ty) -> Option<Take> {
        let readers = |file: RegFile| &self.arch.srp.files[file].readers;
        let is = |(live_in, reg): &&(Ty, Reg)| *live_in == ty && readers(reg.file).contains(&fu);
        let k = self.live_ins.iter().position(|l| is(&l))?;
        let Reg { file, index } = self.live_ins[k].1;
        let reg = RegAt {
            file,
            index,
            ring: 1,
        };
        let source = Source::Reg { reg, distance: 0 };
        self.read(file, time)
            .then_some((source, Operand::LiveIn(k as u32)))
    }

    /// True if a file has a port left in a cycle, which is then taken.
    fn read(&mut self, file: RegFile, time: u32) -> bool {
        let ports = self.arch.srp.files[file].read_ports;
        let reads = self.reads.entry((file, time % self.ii)).or_insert(0);
        *reads += 1;
        *reads <= ports
    }

    fn finish(self, operands: Vec<Vec<Take>>, number: usize) -> (ModuloSchedule, Vec<(Ty, Reg)>) {
        let ends = self.ops.iter().map(|op| op.end);
        let ends = ends.chain(self.values.iter().map(|value| value.stands));
        let length = ends.max().unwrap_or(1) + self.dice.roll(3) as u32;
        let central = |value: &&Value| self.arch.srp.files[value.at.file].kind == FileKind::Central;
        let (outs, rings): (Vec<&Value>, Vec<&Value>) = self
            .values
            .iter()
            .filter(central)
            .partition(|v| v.turns == 1);
        let reg = |value: &Value, k: u32| Reg {
            file: value.at.file,
            index: value.at.index + k,
        };
        let unset = rings.into_iter();
        let unset = unset.flat_map(|v| (0..v.turns).map(move |k| (v.ty, reg(v, k))));
        let nodes = self.ops.iter().zip(&operands).map(|(op, takes)| NodeData {
            op: op.op,
            operands: takes.iter().map(|(_, value)| value.clone()).collect(),
            imm: op.imm,
            pos: Pos::nowhere(),
        });
        let placed = self.ops.iter().zip(&operands).enumerate();
        let placed = placed.map(|(node, (op, takes))| PlacedOp {
            node: Node::new(node),
            is_move: false,
            fu: op.fu,
            time: op.time,
            operands: takes.iter().map(|(source, _)| *source).collect(),
            writes: {
                let written = self.values.iter().filter(|v| v.node == node && !v.moved);
                written.map(|v| v.at).collect()
            },
        });
        let live_ins = self.live_ins.iter().map(|&(ty, _)| LiveIn {
            ty,
            pos: Pos::nowhere(),
        });
        let schedule = ModuloSchedule {
            dfg: Dfg {
                name: format!("random {number}"),
                pos: Pos::nowhere(),
                live_ins: live_ins.collect(),
                trip: Some(0),
                nodes: nodes.collect(),
                order: Vec::new(),
                assumed: Vec::new(),
                live_outs: outs.iter().map(|v| Node::new(v.node)).collect(),
            },
            ii: self.ii,
            length,
            ops: placed.collect(),
            transfers: self.transfers.clone(),
            hops: self.hops.values().copied().collect(),
            preloads: self.preloads.clone(),
            live_in_regs: self.live_ins.iter().map(|&(_, reg)| reg).collect(),
            live_out_regs: outs.iter().map(|v| reg(v, 0)).collect(),
        };
        let unset = unset.collect();
        (schedule, unset)
    }
}

fn of_node(node: usize, init: Vec<Initial>) -> Operand {
    let node = Node::new(node);
    Operand::Node { node, init }
}
