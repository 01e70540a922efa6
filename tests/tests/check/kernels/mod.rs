//! Damage to modulo schedules.

mod places;
mod routes;
mod values;
mod wires;

use super::Dice;
use super::program::{Case, MACHINES, WIRED};
use super::tally::{Harm, Tally};
use srp_archdesc::ResourceGraph;
use srp_archdesc::arch::{Arch, FuOp};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Class, Opcode, Ty};
use srp_ir::check::{Rule, check_kernels};
use srp_ir::dre::scheduled::{ModuloSchedule, Placed, PlacedOp, ScheduledDre, Source};

/// A way to damage a schedule; `None` where there is nothing of the kind.
type Damage = fn(&mut Loop<'_>) -> Option<()>;

/// A kind of damage: its name, whether it is always wrong, and the rules that it may break.
type Kind = (&'static str, Harm, &'static [Rule], Damage);

/// The schedule that is damaged.
struct Loop<'a> {
    schedule: ModuloSchedule,
    arch: &'a Arch,
    graph: &'a ResourceGraph,
    dice: Dice,
}

impl Loop<'_> {
    /// The operations that are like this.
    fn ops_like(&self, is: impl Fn(&PlacedOp) -> bool) -> Vec<Placed> {
        let ops = self.schedule.ops.iter();
        ops.filter(|(_, op)| is(op)).map(|(op, _)| op).collect()
    }

    /// One of the operations that are like this.
    fn op_like(&mut self, is: impl Fn(&PlacedOp) -> bool) -> Option<Placed> {
        let all = self.ops_like(is);
        self.dice.pick(&all)
    }

    fn op(&mut self) -> Option<Placed> {
        self.op_like(|_| true)
    }

    /// One of the operands that are like this: whose, and which.
    fn operand_like(&mut self, is: impl Fn(&Source) -> bool) -> Option<(Placed, usize)> {
        let ops = self.schedule.ops.iter();
        let all: Vec<(Placed, usize)> = ops
            .flat_map(|(op, data)| {
                let operands = data.operands.iter().enumerate();
                let like = operands.filter(|(_, source)| is(source));
                like.map(move |(i, _)| (op, i)).collect::<Vec<_>>()
            })
            .collect();
        self.dice.pick(&all)
    }

    fn opcode(&self, op: &PlacedOp) -> Opcode {
        let node = self.schedule.dfg.nodes[op.node].op;
        match node.result() {
            Some(ty) if op.is_move => Opcode::mov(ty),
            _ => node,
        }
    }

    fn how(&self, op: &PlacedOp) -> FuOp {
        let how = self.arch.srp.fus[op.fu].timing(self.opcode(op));
        how.expect("the schedule was right").clone()
    }

    fn ty(&self, op: &PlacedOp) -> Option<Ty> {
        self.schedule.dfg.ty(op.node)
    }

    /// True if an operation is among those that memory orders name.
    fn is_ordered(&self, op: &PlacedOp) -> bool {
        let orders = self.schedule.dfg.order.iter();
        !op.is_move
            && orders
                .into_iter()
                .any(|o| o.from == op.node || o.to == op.node)
    }

    /// Makes room in the schedule for something that ends in this cycle.
    fn last(&mut self, cycle: u32) {
        self.schedule.length = self.schedule.length.max(cycle);
    }
}

/// How often each kind is tried on each loop and machine.
const ROUNDS: usize = 10;

#[test]
fn damaged_kernels_are_refused_or_do_the_same() {
    let kinds: Vec<Kind> = [places::KINDS, routes::KINDS, values::KINDS, wires::KINDS].concat();
    let mut tally = Tally::default();
    for (machine, name) in MACHINES.iter().enumerate() {
        let case = Case::on(machine);
        let graph = ResourceGraph::of(&case.arch.srp);
        for (kernel, right) in case.right.kernels.iter() {
            for (number, &(kind, harm, rules, damage)) in kinds.iter().enumerate() {
                let seed = number as u64 * 100 + kernel.index() as u64;
                let mut dice = Dice::new(seed, machine as u64);
                for _ in 0..ROUNDS {
                    let mut broken = Loop {
                        schedule: right.clone(),
                        arch: &case.arch,
                        graph: &graph,
                        dice,
                    };
                    let applied = damage(&mut broken).is_some() && broken.schedule != *right;
                    let schedule = broken.schedule;
                    dice = broken.dice;
                    if !applied {
                        continue;
                    }
                    let alone = ScheduledDre {
                        kernels: [schedule.clone()].into_iter().collect(),
                        ..case.right.clone()
                    };
                    let violations = check_kernels(&alone, &case.arch.srp);
                    let place = format!("{}, {name}", right.dfg.name);
                    tally.note((kind, harm, rules), &place, &violations, || {
                        let mut kernels = case.right.kernels.clone();
                        kernels[kernel] = schedule;
                        case.difference_with(kernels)
                    });
                }
            }
        }
    }
    tally.finish(kinds.iter().map(|(name, ..)| *name), 10);
}

/// A machine that has less than the schedule needs.
type Less = fn(&mut Arch);

#[test]
fn machines_with_less_are_noticed() {
    let less: [(Rule, Less); 7] = [
        (Rule::ReadPorts, |arch| {
            arch.srp.files.values_mut().for_each(|f| f.read_ports = 0)
        }),
        (Rule::WritePorts, |arch| {
            arch.srp.files.values_mut().for_each(|f| f.write_ports = 0)
        }),
        (Rule::Resource, |arch| {
            arch.srp.resources.values_mut().for_each(|r| r.count = 0)
        }),
        (Rule::Contexts, |arch| arch.srp.contexts = 0),
        (Rule::Constants, |arch| {
            arch.srp.fus.values_mut().for_each(|fu| fu.constants = 0)
        }),
        (Rule::IssueInterval, |arch| {
            slow(arch, |op| op.interval += 40)
        }),
        (Rule::Dataflow, |arch| {
            slow(arch, |op| op.latency += u32::from(op.class == Class::Load))
        }),
    ];
    for (machine, name) in MACHINES.iter().enumerate() {
        let case = Case::on(machine);
        for (rule, change) in less {
            let mut arch = case.arch.clone();
            change(&mut arch);
            let violations = check_kernels(&case.right, &arch.srp);
            assert!(
                violations.iter().any(|v| v.rule == rule),
                "{rule:?} on {name}: {violations:?}"
            );
        }
    }
}

#[test]
fn wires_beyond_the_hops_of_a_cycle_are_noticed() {
    let wired = MACHINES.iter().position(|&name| name == WIRED);
    let case = Case::on(wired.expect("it is one of them"));
    let mut arch = case.arch.clone();
    arch.srp.hops = 1;
    let violations = check_kernels(&case.right, &arch.srp);
    assert!(
        violations.iter().any(|v| v.rule == Rule::Wire),
        "{violations:?}"
    );
}

fn slow(arch: &mut Arch, change: fn(&mut FuOp)) {
    let ops = arch.srp.fus.values_mut().flat_map(|fu| &mut fu.ops);
    ops.for_each(change);
}
