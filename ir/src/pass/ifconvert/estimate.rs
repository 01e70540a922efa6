//! Estimates of the cycles of a loop in chunks on the array, and on the VLIW engine, before either is scheduled.
//!
//! The estimate goes by how long an iteration waits for the one before: over the values that it hands on,
//! over what it stores where the next one may load, and over the tests by which it is left.

use super::ahead::{Ahead, latency};
use super::counted::Within;
use super::limit::Limit;
use crate::flow::{Dominators, LoopData};
use crate::pass::alias::Objects;
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::Effect;

/// Iterations of the first chunk, and of the longest.
pub(super) const FIRST_CHUNK: u32 = 16;
pub(super) const LONGEST_CHUNK: u32 = 512;

/// Iterations by which the two engines are compared.
const USUAL: u32 = 80;
/// Cycles of a launch beyond its iterations.
const LAUNCH: u32 = 24;
/// Operations of an array in a cycle, most of the time, and of the VLIW engine; cycles that this takes for an iteration
/// at least, and beyond the recurrence.
const ARRAY_OPERATIONS: u32 = 11;
const VLIW_OPERATIONS: u32 = 2;
const LEAST: u32 = 3;
const BRANCH: u32 = 2;

/// A loop of one way back.
struct Body<'a> {
    func: &'a Function,
    data: &'a LoopData,
    dominators: &'a Dominators,
}

/// Estimates a loop of one way back.
pub(super) fn estimate(
    func: &Function,
    dominators: &Dominators,
    data: &LoopData,
    ahead: &Ahead,
    limit: Option<&Limit>,
) -> Estimate {
    let body = Body {
        func,
        data,
        dominators,
    };
    let insts = data
        .blocks
        .iter()
        .flat_map(|&block| &func.blocks[block].insts);
    let operations = insts.filter(|&&i| matches!(func.insts[i].kind, InstKind::Op { .. }));
    let size = operations.count() as u32;
    let recurrence = over_values(&body).max(over_memory(&body));
    let interval = (recurrence.max(ahead.wait(func, data)))
        .max(size.div_ceil(ARRAY_OPERATIONS))
        .max(1);
    let of_one = LEAST
        .max(size.div_ceil(VLIW_OPERATIONS))
        .max(recurrence + BRANCH);
    // Where it runs a few times at most, each number of them is as good a guess as any.
    let most = limit
        .and_then(Limit::count)
        .map_or(u32::MAX, |most| most.max(1));
    let guesses = match most < 2 * USUAL {
        true => 1..=most,
        false => USUAL..=USUAL,
    };
    let number = guesses.clone().count() as u32;
    let (iterations, launches) = (guesses.clone())
        .map(|guess| in_chunks(guess, most))
        .fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    let usual: u32 = guesses.sum();
    Estimate {
        iterations: usual.div_ceil(number),
        array: (iterations * interval + launches * LAUNCH).div_ceil(number),
        vliw: (usual * of_one).div_ceil(number),
    }
}

/// The iterations of the chunks that a loop takes which runs so many times, of so many at most, and the launches.
fn in_chunks(times: u32, most: u32) -> (u32, u32) {
    let (mut iterations, mut launches, mut chunk) = (0, 0, FIRST_CHUNK);
    while iterations < times {
        iterations += chunk.min(most - iterations);
        launches += 1;
        chunk = (2 * chunk).min(LONGEST_CHUNK);
    }
    (iterations, launches)
}

/// The longest way, in cycles of a common machine, from a value of the loop to what it is in the next
/// iteration.
fn over_values(body: &Body<'_>) -> u32 {
    let Body { func, data, .. } = *body;
    let latch = &func.blocks[data.latches[0]].end;
    let Some(back) = latch.targets().find(|t| t.block == data.header) else {
        return 0;
    };
    let params = &func.blocks[data.header].params;
    let ways = params.iter().zip(&back.args).map(|(&param, next)| {
        let depths = Depths::from(body, param, 0);
        depths.of.get(next).copied().unwrap_or(0)
    });
    ways.max().unwrap_or(0)
}

/// The longest way from a load to a store of what may be loaded in the next iteration.
fn over_memory(body: &Body<'_>) -> u32 {
    let Body { func, data, .. } = *body;
    let objects = Objects::of(func);
    let within = Within::of(func, data);
    let accesses = [Effect::Load, Effect::Store].map(|effect| {
        let blocks = data.blocks.iter();
        let all =
            blocks.flat_map(|&block| func.blocks[block].insts.iter().map(move |&i| (block, i)));
        let ops = all.filter_map(|(block, inst)| match &func.insts[inst].kind {
            InstKind::Op { op, args, .. } if op.info().effect == effect => {
                Some((block, inst, *op, args))
            }
            _ => None,
        });
        ops.collect::<Vec<_>>()
    });
    let [loads, stores] = &accesses;
    let mut longest = 0;
    for &(_, load, op, read) in loads.iter() {
        let Some(&loaded) = func.insts[load].results.first() else {
            continue;
        };
        let mut depths = None;
        for (block, _, to, written) in stores.iter() {
            // Addresses that go on by the same amount each seldom meet in the next iteration.
            let meets = op.space() == to.space() && {
                let (from, to) = (read[1], written[1]);
                let (one, other) = (objects.object(from), objects.object(to));
                let regular = [from, to]
                    .iter()
                    .all(|&v| within.is_regular(v, &mut Vec::new()));
                !regular && (one == other || one.is_none() || other.is_none())
            };
            if meets {
                let depths = depths.get_or_insert_with(|| Depths::from(body, loaded, latency(op)));
                let args = written.iter().filter_map(|arg| depths.of.get(arg));
                let under = depths.under.get(block);
                longest = longest.max(args.chain(under).max().map_or(0, |depth| depth + 1));
            }
        }
    }
    longest
}

/// How late values are computed that depend on one of the loop, within an iteration.
struct Depths {
    of: FxHashMap<Value, u32>,
    /// The tests that decide whether a block is reached.
    under: FxHashMap<Block, u32>,
}

impl Depths {
    fn from(over: &Body<'_>, value: Value, depth: u32) -> Depths {
        let Body { func, data, .. } = *over;
        let mut of = FxHashMap::from_iter([(value, depth)]);
        let mut under = FxHashMap::<Block, u32>::default();
        for &block in &data.blocks {
            let tests = under.get(&block).copied();
            for &inst in &func.blocks[block].insts {
                let InstData { kind, results, .. } = &func.insts[inst];
                let InstKind::Op { op, args, .. } = kind else {
                    continue;
                };
                let from = args.iter().filter_map(|arg| of.get(arg)).max().copied();
                let from = from.max(tests.filter(|_| op.is_guarded()));
                if let (Some(from), Some(&result)) = (from, results.first()) {
                    of.insert(result, from + latency(*op));
                }
            }
            let end = &func.blocks[block].end;
            let tested = match end {
                Terminator::Branch { cond, .. } if !data.is_left_at(func, block) => {
                    of.get(cond).copied()
                }
                _ => None,
            };
            let below = tests.max(tested);
            for target in end.targets().filter(|t| t.block != data.header) {
                // Where ways meet, the tests count above which they part.
                let parted = match over.dominators.parent(target.block) {
                    Some(parent) if parent != block => under.get(&parent).copied(),
                    _ => below,
                };
                under.extend(parted.map(|parted| (target.block, parted)));
                for (&param, arg) in func.blocks[target.block].params.iter().zip(&target.args) {
                    if let Some(from) = of.get(arg).copied().max(below) {
                        let known = of.entry(param).or_default();
                        *known = (*known).max(from + 1);
                    }
                }
            }
        }
        Depths { of, under }
    }
}
