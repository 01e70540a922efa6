//! The cheapest deliveries of a value, for all units at once, cycle by cycle: to everywhere from what it has,
//! and from everywhere to where it is wanted.
//!
//! A value stands in a unit's output or file. It comes into an output in the cycle after a unit has moved it, and
//! into the file in the same cycle; to keep an output for a cycle is to move the value onto itself, as both
//! take the unit's issue slot. So with `x` for what a unit's operands can read in a cycle,
//!
//! ```text
//! out[t] = x[t − 1] + price of the issue slot at t − 1
//! file[t] = min(file[t − 1], out[t]) + price of a register at t
//! x[t] = min(out[t], file[t], out[t] of those that are linked)
//! ```
//!
//! Backwards it is the same with the ends exchanged.

use super::array::Array;
use super::prices::Prices;
use super::state::Tree;
use crate::modulo::rows::{NEVER, VECTOR, Vector, smaller, sum};

/// Costs by cycle and lane.
#[derive(Default)]
pub(super) struct Map {
    /// The first cycle, and how many there are.
    from: i32,
    cycles: usize,
    lanes: usize,
    margin: usize,
    /// Rows that links read, with margins that hold [`NEVER`]: forwards `out`, backwards `x`.
    linked: Vec<i16>,
    /// The other rows: forwards `x`, backwards `out`.
    other: Vec<i16>,
    file: Vec<i16>,
    /// Where the value is already, by cycle: lane, and true for the file.
    own: Vec<Vec<(u16, bool)>>,
}

/// A row in vectors.
#[inline(always)]
fn load(row: &[i16], at: usize) -> Vector {
    let lanes = row[at..].first_chunk::<VECTOR>();
    *lanes.expect("rows are whole vectors")
}

#[inline(always)]
fn store(row: &mut [i16], at: usize, vector: Vector) {
    let lanes = row[at..].first_chunk_mut::<VECTOR>();
    *lanes.expect("rows are whole vectors") = vector;
}

impl Map {
    fn begin(&mut self, array: &Array, from: i32, to: i32) {
        (self.from, self.cycles) = (from, (to - from + 1).max(0) as usize);
        (self.lanes, self.margin) = (array.lanes, array.margin);
        let narrow = self.cycles * self.lanes;
        let wide = self.cycles * self.width();
        for (rows, length) in [
            (&mut self.linked, wide),
            (&mut self.other, narrow),
            (&mut self.file, narrow),
        ] {
            if rows.len() < length {
                rows.resize(length, NEVER);
            }
        }
    }

    fn width(&self) -> usize {
        self.lanes + 2 * self.margin
    }

    /// Lanes of all rows that have been computed.
    pub(super) fn work(&self) -> u64 {
        (self.cycles * self.lanes) as u64
    }

    /// Forgets everything: nothing is delivered anywhere.
    pub(super) fn empty(&mut self) {
        self.cycles = 0;
    }

    fn cycle(&self, time: i32) -> Option<usize> {
        let cycle = usize::try_from(time - self.from).ok()?;
        (cycle < self.cycles).then_some(cycle)
    }

    /// Forwards, the costs of being read by units in a cycle; backwards, those of what lands in their outputs.
    #[inline(always)]
    pub(super) fn row(&self, time: i32) -> Option<&[i16]> {
        let cycle = self.cycle(time)?;
        Some(&self.other[cycle * self.lanes..][..self.lanes])
    }

    /// Forwards, the cost of standing in an output.
    pub(super) fn out(&self, time: i32, lane: u16) -> i16 {
        let at = |cycle| cycle * self.width() + self.margin + usize::from(lane);
        self.cycle(time)
            .map_or(NEVER, |cycle| self.linked[at(cycle)])
    }

    /// The cost of standing in a file.
    pub(super) fn file(&self, time: i32, lane: u16) -> i16 {
        let at = |cycle| cycle * self.lanes + usize::from(lane);
        self.cycle(time).map_or(NEVER, |cycle| self.file[at(cycle)])
    }

    /// The cost of being read by a unit.
    pub(super) fn read(&self, time: i32, lane: u16) -> i16 {
        self.row(time).map_or(NEVER, |row| row[usize::from(lane)])
    }

    /// Delivers a value to everywhere from where it is, from the first cycle to the last.
    #[inline(always)]
    pub(super) fn forward(
        &mut self,
        array: &Array,
        prices: &Prices,
        tree: &Tree,
        (from, to): (i32, i32),
    ) {
        self.begin(array, from, to);
        self.gather(tree);
        let (lanes, width, margin) = (self.lanes, self.width(), self.margin);
        for cycle in 0..self.cycles {
            let time = from + cycle as i32;
            let registers = prices.register_row(time);
            let out = &mut self.linked[cycle * width + margin..][..lanes];
            let (before, file) = self.file.split_at_mut(cycle * lanes);
            let file = &mut file[..lanes];
            if cycle == 0 {
                out.fill(NEVER);
                file.fill(NEVER);
            } else {
                let issue = prices.issue_row(time - 1);
                let read = &self.other[(cycle - 1) * lanes..][..lanes];
                let before = &before[(cycle - 1) * lanes..];
                for at in (0..lanes).step_by(VECTOR) {
                    let moved = sum(load(read, at), load(issue, at));
                    let moved = sum(moved, load(&array.movers, at));
                    store(out, at, moved);
                    let kept = smaller(load(before, at), moved);
                    store(file, at, sum(kept, load(registers, at)));
                }
            }
            for &(lane, in_file) in &self.own[cycle] {
                let lane = usize::from(lane);
                match in_file {
                    true => file[lane] = 0,
                    false => {
                        out[lane] = 0;
                        file[lane] = file[lane].min(registers[lane]);
                    }
                }
            }
            let row = &mut self.other[cycle * lanes..][..lanes];
            let linked = &self.linked[cycle * width..][..width];
            for at in (0..lanes).step_by(VECTOR) {
                let own = smaller(load(linked, margin + at), load(file, at));
                store(row, at, over_links(array, linked, margin, at, own));
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    pub(super) fn forward_wide(
        &mut self,
        array: &Array,
        prices: &Prices,
        tree: &Tree,
        span: (i32, i32),
    ) {
        self.forward(array, prices, tree, span);
    }

    /// Sorts the points of a tree by cycle, outputs first.
    fn gather(&mut self, tree: &Tree) {
        if self.own.len() < self.cycles {
            self.own.resize_with(self.cycles, Vec::new);
        }
        self.own[..self.cycles].iter_mut().for_each(Vec::clear);
        for in_file in [false, true] {
            for (point, _) in tree.points().filter(|(point, _)| point.in_file == in_file) {
                if let Some(cycle) = self.cycle(point.time) {
                    self.own[cycle].push((point.lane, in_file));
                }
            }
        }
    }

    /// Computes what it costs from everywhere to the operands of a unit in the last cycle. The rows are then the costs of
    /// all that comes after landing in an output.
    #[inline(always)]
    pub(super) fn backward(
        &mut self,
        array: &Array,
        prices: &Prices,
        unit: u16,
        (from, at): (i32, i32),
    ) {
        self.begin(array, from, at);
        let (lanes, width, margin) = (self.lanes, self.width(), self.margin);
        for cycle in (0..self.cycles).rev() {
            let time = from + cycle as i32;
            let read = &mut self.linked[cycle * width + margin..][..lanes];
            let (file, after) = self.file.split_at_mut((cycle + 1) * lanes);
            let file = &mut file[cycle * lanes..];
            if cycle + 1 == self.cycles {
                read.fill(NEVER);
                read[usize::from(unit)] = 0;
                file.copy_from_slice(read);
            } else {
                let issue = prices.issue_row(time);
                let registers = prices.register_row(time + 1);
                let out = &self.other[(cycle + 1) * lanes..][..lanes];
                for at in (0..lanes).step_by(VECTOR) {
                    let moved = sum(load(out, at), load(issue, at));
                    let moved = sum(moved, load(&array.movers, at));
                    store(read, at, moved);
                    let kept = sum(load(after, at), load(registers, at));
                    store(file, at, smaller(moved, kept));
                }
            }
            let registers = prices.register_row(time);
            let out = &mut self.other[cycle * lanes..][..lanes];
            let linked = &self.linked[cycle * width..][..width];
            for at in (0..lanes).step_by(VECTOR) {
                let kept = sum(load(file, at), load(registers, at));
                let own = smaller(load(linked, margin + at), kept);
                store(out, at, over_links_back(array, linked, margin, at, own));
            }
        }
    }
}

/// The least of some lanes and those that links bring to them.
#[inline(always)]
fn over_links(array: &Array, row: &[i16], margin: usize, at: usize, least: Vector) -> Vector {
    let mut least = least;
    for links in &array.links {
        let from = (margin + at).wrapping_add_signed(links.shift);
        least = smaller(least, sum(load(row, from), load(&links.mask, at)));
    }
    least
}

/// The least of some lanes and those that links from them lead to.
#[inline(always)]
fn over_links_back(array: &Array, row: &[i16], margin: usize, at: usize, least: Vector) -> Vector {
    let mut least = least;
    for links in &array.links {
        let to = (margin + at).wrapping_add_signed(-links.shift);
        least = smaller(least, sum(load(row, to), load(&links.back, at)));
    }
    least
}
