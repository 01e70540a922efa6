//! Words of which only the low bits are used. C narrows what is assigned to a `short` at each assignment, which puts an
//! extension, or two shifts, into the recurrence of each sum that a loop forms in one. What the loop carries is the
//! sum as it is here, and it is extended where all of it is used: after the loop, or beside the recurrence.

mod demand;

use super::defs::Defs;
use super::narrow::{Narrow, extended, range};
use super::rename::Renames;
use crate::flow::{Cfg, Flow, LoopData};
use crate::program::*;
use demand::leave_out;
use rustc_hash::FxHashMap;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};

const WORD: u32 = 32;

/// Selections that are looked through, one in another.
const MAX_SELECTIONS: u32 = 8;

/// A loop's parameter whose words are always those of a narrow type.
struct Carried {
    header: Block,
    param: Value,
    narrow: Narrow,
    /// The place in the source that narrows it.
    pos: Pos,
    /// Selections that are brought to it, one for each way back at most.
    selections: Vec<Inst>,
}

/// Leaves out extensions where only low bits are used, and takes them out of recurrences.
pub(crate) fn low_bits(func: &mut Function) -> bool {
    let mut carried = carried(func);
    while !carried.is_empty() {
        let mut tried = func.clone();
        let extensions: Vec<Vec<Value>> = (carried.iter())
            .map(|carried| extend_all(&mut tried, carried))
            .collect();
        leave_out(&mut tried);
        let defs = Defs::of(&tried);
        let stays = |(carried, extensions): (&Carried, &Vec<Value>)| {
            !recurs_through(&tried, &defs, carried, extensions)
        };
        let kept: Vec<bool> = carried.iter().zip(&extensions).map(stays).collect();
        if kept.iter().all(|&kept| kept) {
            *func = tried;
            move_after_loops(func);
            return true;
        }
        let mut kept = kept.into_iter();
        carried.retain(|_| kept.next() == Some(true));
    }
    leave_out(func)
}

/// The parameters of loops that are of narrow types.
fn carried(func: &Function) -> Vec<Carried> {
    let flow = Flow::of(func);
    let defs = Defs::of(func);
    let mut found = Vec::new();
    for data in flow.loops.loops.values() {
        if data.header == func.entry() {
            continue;
        }
        for (place, &param) in func.blocks[data.header].params.iter().enumerate() {
            if func.values[param] == Ty::Word
                && let Some(narrow) = carried_at(func, &defs, data, place)
            {
                found.push(narrow);
            }
        }
    }
    found
}

/// The parameter of a loop in a place, if it always is of a narrow type.
fn carried_at(func: &Function, defs: &Defs, data: &LoopData, place: usize) -> Option<Carried> {
    let header = data.header;
    let param = func.blocks[header].params[place];
    let brought = |is_inside: bool| {
        let from = func.layout.iter().copied();
        let from = from.filter(move |&from| data.contains(from) == is_inside);
        let targets = from.flat_map(|from| func.blocks[from].end.targets());
        let targets = targets.filter(|target| target.block == header);
        targets.map(|target| target.args[place])
    };
    let (narrow, pos) = brought(true).find_map(|next| type_of(func, defs, next, 0))?;
    let mut all = brought(true).chain(brought(false));
    if !all.all(|value| is_within(func, defs, value, (param, narrow), 0)) {
        return None;
    }
    let selections = brought(true).filter(|&next| selected(func, defs, next).is_some());
    Some(Carried {
        header,
        param,
        narrow,
        pos,
        selections: selections.filter_map(|next| defs.inst(next)).collect(),
    })
}

/// The type that a value is extended from, or one that it is selected from, and where that is done.
fn type_of(func: &Function, defs: &Defs, value: Value, depth: u32) -> Option<(Narrow, Pos)> {
    if let Some((_, narrow)) = extended(func, defs, value) {
        return Some((narrow, func.insts[defs.inst(value)?].pos));
    }
    let selected = selected(func, defs, value).filter(|_| depth < MAX_SELECTIONS)?;
    let mut selected = selected.into_iter();
    selected.find_map(|value| type_of(func, defs, value, depth + 1))
}

/// True if a value is of a type as long as a parameter is.
fn is_within(
    func: &Function,
    defs: &Defs,
    value: Value,
    (param, narrow): (Value, Narrow),
    depth: u32,
) -> bool {
    if value == param || range(func, defs, value).within(narrow.range()) {
        return true;
    }
    let selected = selected(func, defs, value).filter(|_| depth < MAX_SELECTIONS);
    selected.is_some_and(|selected| {
        let mut selected = selected.into_iter();
        selected.all(|value| is_within(func, defs, value, (param, narrow), depth + 1))
    })
}

/// The two values of which one is selected.
fn selected(func: &Function, defs: &Defs, value: Value) -> Option<[Value; 2]> {
    match defs.op(func, value)? {
        (Opcode::Sel, &[_, holds, fails]) => Some([holds, fails]),
        _ => None,
    }
}

/// Extends a parameter and what is selected for it, for all that uses them; returns what took their places.
fn extend_all(func: &mut Function, carried: &Carried) -> Vec<Value> {
    let header = carried.header;
    let mut extensions = vec![extend(func, carried, carried.param, (header, 0))];
    for &selection in &carried.selections {
        let is_in = |block: Block| {
            let mut insts = func.blocks[block].insts.iter();
            Some((block, insts.position(|&inst| inst == selection)? + 1))
        };
        let place = func.layout.iter().find_map(|&block| is_in(block));
        let selected = func.insts[selection].results[0];
        let place = place.expect("a selection is in a block");
        extensions.push(extend(func, carried, selected, place));
    }
    extensions
}

/// Extends a value at a place in a block for all that uses it; returns what took its place.
fn extend(
    func: &mut Function,
    carried: &Carried,
    value: Value,
    (block, at): (Block, usize),
) -> Value {
    let &Carried { narrow, pos, .. } = carried;
    let (insts, extension) = narrow.extend(func, value, pos);
    // What extends it is in no block yet, so that it is left as it is.
    let mut renames = Renames::default();
    renames.replace(value, extension);
    renames.apply(func);
    func.blocks[block].insts.splice(at..at, insts);
    extension
}

/// True if what a loop carries on needs one of the extensions in the same iteration.
fn recurs_through(func: &Function, defs: &Defs, carried: &Carried, extensions: &[Value]) -> bool {
    let header = &func.blocks[carried.header];
    let place = header.params.iter().position(|&p| p == carried.param);
    let place = place.expect("it is a parameter");
    let targets = func.layout.iter();
    let targets = targets.flat_map(|&from| func.blocks[from].end.targets());
    let brought = targets.filter(|target| target.block == carried.header);
    let mut open: Vec<Value> = brought.map(|target| target.args[place]).collect();
    let mut seen = EntityMap::filled(func.values.len(), false);
    while let Some(value) = open.pop() {
        if extensions.contains(&value) {
            return true;
        }
        if !std::mem::replace(&mut seen[value], true)
            && let Some(kind) = defs.kind(func, value)
        {
            kind.for_each_use(|value| open.push(value));
        }
    }
    false
}

/// Moves extensions that are used after loops only out of them.
fn move_after_loops(func: &mut Function) {
    let Flow { cfg, loops, .. } = Flow::of(func);
    let mut uses: EntityMap<Value, u32> = EntityMap::filled(func.values.len(), 0);
    for &block in &func.layout {
        for_each_use(func, block, |value| uses[value] += 1);
    }
    // What leaves an inner loop may leave the one round it too.
    for data in loops.loops.values().rev() {
        if let Some(after) = only_exit(func, &cfg, data) {
            move_after(func, data, after, &uses);
        }
    }
}

/// Calls `f` on every value that a block uses.
fn for_each_use(func: &Function, block: Block, mut f: impl FnMut(Value)) {
    let data = &func.blocks[block];
    for &inst in &data.insts {
        func.insts[inst].kind.for_each_use(&mut f);
    }
    data.end.for_each_use(f);
}

/// The block that a loop ends in, where it does so in one that nothing else leads to.
fn only_exit(func: &Function, cfg: &Cfg, data: &LoopData) -> Option<Block> {
    let mut exits = data.exits(func).map(|(_, target)| target.block);
    let after = exits.next()?;
    let is_only = exits.all(|exit| exit == after);
    let mut preds = cfg.preds[after].iter();
    (is_only && preds.all(|&pred| data.contains(pred))).then_some(after)
}

/// Moves the extensions of a loop that are used outside of it only to the head of the block after it, which all ways to
/// those uses pass. `uses` has how often each value is used.
fn move_after(func: &mut Function, data: &LoopData, after: Block, uses: &EntityMap<Value, u32>) {
    let mut inside: FxHashMap<Value, u32> = FxHashMap::default();
    for &block in &data.blocks {
        for_each_use(func, block, |value| *inside.entry(value).or_default() += 1);
    }
    let mut moved = Vec::new();
    for &block in data.blocks.iter().rev() {
        for inst in std::mem::take(&mut func.blocks[block].insts)
            .into_iter()
            .rev()
        {
            let InstData { kind, results, .. } = &func.insts[inst];
            let is_part = match kind {
                InstKind::Op { op, .. } => {
                    matches!(op, Opcode::And | Opcode::Shl | Opcode::Sar | Opcode::Shr)
                }
                kind => matches!(kind, InstKind::Const(_)),
            };
            let used = |value: &Value| (inside.get(value).copied().unwrap_or(0), uses[*value]);
            if is_part
                && results
                    .iter()
                    .map(used)
                    .all(|(inside, all)| inside == 0 && all > 0)
            {
                kind.for_each_use(|value| {
                    inside.entry(value).and_modify(|uses| *uses -= 1);
                });
                moved.push(inst);
            } else {
                func.blocks[block].insts.push(inst);
            }
        }
        func.blocks[block].insts.reverse();
    }
    moved.reverse();
    func.blocks[after].insts.splice(0..0, moved);
}
