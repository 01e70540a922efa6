//! Which memory accesses of a loop must stay in order.
//!
//! Addresses are sums of objects, unknown values and a multiple of the iteration number. Where two
//! accesses differ by a known number of bytes in each iteration, the iterations that they are apart
//! when they meet follow exactly, wrap-around included. Accesses to different objects never meet.
//! All others may: a pair of them is ordered in every iteration, and a [`Remark`] says so.

use super::body::Body;
use super::exchange;
use super::induction::Inductions;
use super::linear::{Affine, Linear, first_in_window};
use super::objects::{Objects, objects_of};
use super::shape::Loop;
use super::{Doubt, Remark};
use crate::dfg::{Assumed, MAX_OVERLAP, Node, Order};
use crate::program::{Bits, Independence, InstKind, KernelMark, Pos, Value};
use srp_archdesc::isa::{Effect, Opcode, Space};
use std::collections::BTreeSet;

/// How deep a guard is taken apart.
const MAX_GUARD_DEPTH: u32 = 16;

/// A memory access of the loop.
struct Access {
    node: Node,
    is_store: bool,
    space: Space,
    bytes: u32,
    /// The address, offset included, if it is known.
    address: Option<Affine>,
    objects: Objects,
    /// Facts known to hold when the access is made.
    guard: BTreeSet<(Fact, bool)>,
    pos: Pos,
}

/// Something that is true or false in an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fact {
    Value(Value),
    Compare(Opcode, Value, Value),
}

/// How many iterations apart two accesses can meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Meeting {
    /// The least number of iterations by which the second can be behind when it meets the first.
    forward: Option<u64>,
    /// The least number, from 1, by which the first can be behind.
    backward: Option<u64>,
    /// True if the accesses do meet; false if they only may.
    exact: bool,
}

const ANYTHING: Meeting = Meeting {
    forward: Some(0),
    backward: Some(1),
    exact: false,
};

const NEVER: Meeting = Meeting {
    forward: None,
    backward: None,
    exact: true,
};

/// The memory order of a loop.
pub(super) struct MemoryOrder {
    /// Accesses that must stay in order.
    pub(super) orders: Vec<Order>,
    /// The orders that would remain if pointers that may alias were `restrict`; `None` if all
    /// would.
    pub(super) relaxed: Option<Vec<Order>>,
    /// Statements of the source about accesses that could meet.
    pub(super) assumed: Vec<Assumed>,
    /// Accesses that could not be told apart.
    pub(super) remarks: Vec<Remark>,
}

/// The memory order of a loop with this mark. `trip` is the number of iterations, where it is known.
pub(super) fn order(
    lp: &Loop<'_>,
    body: &Body<'_>,
    trip: Option<u32>,
    mark: &KernelMark,
) -> MemoryOrder {
    let inductions = Inductions::of(lp, true);
    let accesses = accesses(lp, body, &inductions, mark);
    let mut orders = Vec::new();
    let mut relaxed = Vec::new();
    let mut assumed = Vec::new();
    let mut remarks = Vec::new();
    for (i, first) in accesses.iter().enumerate() {
        for second in &accesses[i + 1..] {
            if !(first.is_store || second.is_store) || first.space != second.space {
                continue;
            }
            let meeting = match exchanged(lp, mark, first, second) {
                true => NEVER,
                false => meet(first, second),
            };
            let limit = u64::from(trip.unwrap_or(MAX_OVERLAP).min(MAX_OVERLAP));
            let possible = |d: &u64| *d < limit;
            let edge = |from: Node, to: Node, distance: u64| Order {
                from,
                to,
                distance: u32::try_from(distance).expect("below the limit"),
            };
            let (a, b) = (first.node, second.node);
            let mut forward = meeting.forward.filter(possible);
            let mut backward = meeting.backward.filter(possible);
            let said = denied(&mark.independence, first, second);
            if let Some(together) = said
                && (backward.is_some() || forward.is_some_and(|d| d > 0 || together))
            {
                if !meeting.exact {
                    forward = forward.filter(|&d| d == 0 && !together);
                    backward = None;
                }
                assumed.push(Assumed {
                    first: a,
                    second: b,
                    together,
                });
            }
            let found = forward.map(|d| edge(a, b, d)).into_iter();
            let found = found.chain(backward.map(|d| edge(b, a, d)));
            let before = orders.len();
            orders.extend(found);
            let restrict = first.objects.could_be_apart_from(lp, &second.objects);
            if !restrict {
                relaxed.extend_from_slice(&orders[before..]);
            }
            if !meeting.exact && said.is_none() && orders.len() > before {
                let same = first.objects.same_as(lp, &second.objects);
                remarks.push(remark(&mark.name, first, second, (restrict, same)));
            }
        }
    }
    remarks.sort();
    remarks.dedup();
    let without_implied = |orders| super::reduce::without_implied(&body.nodes, orders);
    MemoryOrder {
        relaxed: (relaxed.len() < orders.len()).then(|| without_implied(relaxed)),
        orders: without_implied(orders),
        assumed,
        remarks,
    }
}

/// Returns `Some` when the source says that two accesses never meet in different iterations: true when
/// they do not meet in one iteration either.
fn denied(independence: &Independence, first: &Access, second: &Access) -> Option<bool> {
    if first.bytes == 0 || second.bytes == 0 {
        return None;
    }
    let [one, other] = [first, second].map(|access| access.objects.variables());
    let mut said = independence.all.then_some(false);
    for group in &independence.groups {
        let of = |variables: &BTreeSet<u32>| -> BTreeSet<u32> {
            let group = group.iter().copied();
            group.filter(|n| variables.contains(n)).collect()
        };
        let (one, other) = (of(&one), of(&other));
        if !one.is_empty() && !other.is_empty() {
            said = Some(said == Some(true) || one.is_disjoint(&other));
        }
    }
    said
}

/// Says of two accesses that nothing shows that they need no order, whether `restrict` would, and whether they are to one
/// object.
fn remark(kernel: &str, first: &Access, second: &Access, (restrict, same): (bool, bool)) -> Remark {
    let doubt = if restrict {
        Doubt::AliasUnlessRestrict
    } else if same || first.objects.is_known() && second.objects.is_known() {
        Doubt::SameElement
    } else {
        Doubt::Alias
    };
    Remark {
        kernel: kernel.to_owned(),
        first: first.pos,
        second: second.pos,
        doubt,
    }
}

fn accesses(
    lp: &Loop<'_>,
    body: &Body<'_>,
    inductions: &Inductions<'_>,
    mark: &KernelMark,
) -> Vec<Access> {
    let mut accesses = Vec::new();
    let mut stores = body.stores.iter();
    for &inst in &lp.func.blocks[lp.block].insts {
        let data = &lp.func.insts[inst];
        let InstKind::Op { op, args, imm } = &data.kind else {
            continue;
        };
        let Some(space) = op.space() else {
            continue;
        };
        let node = match data.results.first() {
            Some(result) => body.node_of.get(result),
            None => stores.next(),
        };
        let (Some(&node), [guard, address, ..]) = (node, &args[..]) else {
            continue;
        };
        if lp.constant(*guard) == Some(Bits::Pred(false)) {
            continue;
        }
        let offset = *imm as u32;
        // The texture unit reads where a descriptor says.
        let bytes = op.access_bytes();
        let known = inductions.affine(*address).filter(|_| bytes.is_some());
        let affine = known.map(|a| Affine {
            base: a.base.plus_constant(offset),
            stride: a.stride,
        });
        let mut facts = BTreeSet::new();
        collect_facts(lp, *guard, true, 0, &mut facts);
        accesses.push(Access {
            node,
            is_store: op.info().effect == Effect::Store,
            space,
            bytes: bytes.unwrap_or(0),
            address: affine,
            objects: match bytes {
                Some(_) => objects_of(lp, mark, *address),
                None => Objects::default(),
            },
            guard: facts,
            pos: data.pos,
        });
    }
    accesses
}

/// Adds the facts that `value == sense` implies.
fn collect_facts(
    lp: &Loop<'_>,
    value: Value,
    sense: bool,
    depth: u32,
    facts: &mut BTreeSet<(Fact, bool)>,
) {
    let mut both = |a: Value, b: Value| {
        collect_facts(lp, a, sense, depth + 1, facts);
        collect_facts(lp, b, sense, depth + 1, facts);
    };
    let sorted = |a: &Value, b: &Value| (*a.min(b), *a.max(b));
    let fact = match lp.op(value) {
        _ if lp.constant(value).is_some() => return,
        _ if depth >= MAX_GUARD_DEPTH => (Fact::Value(value), sense),
        Some((Opcode::Pand, [a, b])) if sense => return both(*a, *b),
        Some((Opcode::Por, [a, b])) if !sense => return both(*a, *b),
        Some((Opcode::Pnot, [a])) => return collect_facts(lp, *a, !sense, depth + 1, facts),
        Some((Opcode::Pmov, [a])) => return collect_facts(lp, *a, sense, depth + 1, facts),
        Some((op @ (Opcode::Eq | Opcode::Feq), [a, b])) => {
            let (a, b) = sorted(a, b);
            (Fact::Compare(op, a, b), sense)
        }
        Some((Opcode::Ne, [a, b])) => {
            let (a, b) = sorted(a, b);
            (Fact::Compare(Opcode::Eq, a, b), !sense)
        }
        Some((Opcode::Fne, [a, b])) => {
            let (a, b) = sorted(a, b);
            (Fact::Compare(Opcode::Feq, a, b), !sense)
        }
        Some((op @ (Opcode::Lt | Opcode::Ltu), [a, b])) => (Fact::Compare(op, *a, *b), sense),
        Some((Opcode::Le, [a, b])) => (Fact::Compare(Opcode::Lt, *b, *a), !sense),
        Some((Opcode::Leu, [a, b])) => (Fact::Compare(Opcode::Ltu, *b, *a), !sense),
        _ => (Fact::Value(value), sense),
    };
    facts.insert(fact);
}

/// True if two accesses are never both made in one iteration.
fn exclusive(a: &Access, b: &Access) -> bool {
    a.guard
        .iter()
        .any(|(fact, sense)| b.guard.contains(&(*fact, !sense)))
}

/// True if two accesses are by pointers that are exchanged outside of the loop, into two objects.
fn exchanged(lp: &Loop<'_>, mark: &KernelMark, one: &Access, other: &Access) -> bool {
    let (Some(a), Some(b)) = (&one.address, &other.address) else {
        return false;
    };
    let is_by_one = |access: &Access| access.objects.points();
    is_by_one(one) && is_by_one(other) && exchange::are_apart(lp, mark, &a.base, &b.base)
}

/// How two accesses can meet, `first` before `second` in the loop.
fn meet(first: &Access, second: &Access) -> Meeting {
    if first.objects.apart_from(&second.objects) {
        return NEVER;
    }
    let from = u32::from(exclusive(first, second));
    let later = |meeting: Meeting| Meeting {
        forward: meeting.forward.map(|d| d.max(u64::from(from))),
        ..meeting
    };
    let (Some(a), Some(b)) = (&first.address, &second.address) else {
        return later(ANYTHING);
    };
    let base = a.base.minus(&b.base);
    let Some(apart) = base.as_constant() else {
        return later(on_a_grid(a, b, &base, (first.bytes, second.bytes)));
    };
    // In the same iteration they meet if `apart + i · (stride of a − stride of b)` is in a window
    // around 0, where one's first byte is not behind the other's last.
    let (low, width) = window(apart, (first.bytes, second.bytes));
    let Some(slower) = a.stride.minus(&b.stride).as_constant() else {
        return later(ANYTHING);
    };
    if slower != 0 {
        return apart_strides(a, b, slower, low, width, from);
    }
    let Some(stride) = a.stride.as_constant() else {
        // The same unknown stride: the same iteration is certain, others are not.
        let together = first_in_window(0, low, width, 0).filter(|_| from == 0);
        return Meeting {
            forward: together.or(Some(1)),
            ..ANYTHING
        };
    };
    // `second` is `d` iterations behind: `apart − d · stride` is in the window.
    Meeting {
        forward: first_in_window(stride.wrapping_neg(), low, width, from),
        backward: first_in_window(stride, low, width, 1),
        exact: true,
    }
}

/// Where accesses of so many bytes meet that are `apart` and something more apart: if that is one of so many numbers from the
/// first one on.
fn window(apart: u32, (first, second): (u32, u32)) -> (u32, u32) {
    let low = 1u32.wrapping_sub(first).wrapping_sub(apart);
    (low, first + second - 1)
}

/// Two accesses whose distance has unknown parts: all of it but a constant is multiples of a power of two, as with rows of
/// a matrix.
fn on_a_grid(a: &Affine, b: &Affine, base: &Linear, bytes: (u32, u32)) -> Meeting {
    if bytes.0 == 0 || bytes.1 == 0 {
        return ANYTHING;
    }
    let (low, width) = window(base.constant, bytes);
    let meet = |bits: u32| {
        let grid = 1u32.checked_shl(bits).unwrap_or(0);
        first_in_window(grid, low, width, 0).is_some()
    };
    let rows = base.zero_bits_of_terms();
    if !meet(rows.min(a.stride.zero_bits()).min(b.stride.zero_bits())) {
        return NEVER;
    }
    let together = meet(rows.min(a.stride.minus(&b.stride).zero_bits()));
    Meeting {
        forward: Some(u64::from(!together)),
        ..ANYTHING
    }
}

/// Two accesses that move at different speeds.
fn apart_strides(a: &Affine, b: &Affine, slower: u32, low: u32, width: u32, from: u32) -> Meeting {
    let strides = (a.stride.as_constant(), b.stride.as_constant());
    if let (Some(sa), Some(sb)) = strides {
        // All differences are multiples of the largest power of two in both strides.
        let grid = 1u32 << sa.trailing_zeros().min(sb.trailing_zeros()).min(31);
        if first_in_window(grid, low, width, 0).is_none() {
            return NEVER;
        }
    }
    let together = first_in_window(slower, low, width, 0).filter(|_| from == 0);
    Meeting {
        forward: Some(if together.is_some() { 0 } else { 1 }),
        ..ANYTHING
    }
}
