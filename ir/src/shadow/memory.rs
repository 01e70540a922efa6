//! Marks in memory: those of whole words, where they were stored.

use super::{Mark, Marks, PLAIN, Shadows};
use srp_archdesc::isa::{Opcode, Space};

impl Shadows<'_> {
    /// The marks of the value that a load of the machine has read.
    #[inline]
    pub(super) fn loaded(&self, op: Opcode, address: u32) -> Marks {
        let mut marks = PLAIN;
        let words = op.access_bytes().unwrap_or(0) / 4;
        match op.space() {
            Some(Space::Sram) => {
                for (i, mark) in (0..words).zip(&mut marks) {
                    *mark = self.sram_mark(address + 4 * i);
                }
            }
            Some(Space::Cached) if !self.outside.is_empty() => {
                for (i, mark) in (0..words).zip(&mut marks) {
                    *mark = self.outside_mark(address + 4 * i);
                }
            }
            _ => {}
        }
        marks
    }

    fn outside_mark(&self, address: u32) -> Mark {
        self.outside.get(&address).copied().unwrap_or_default()
    }

    /// Marks the value stored. A part of a word has no mark, and takes that of the word.
    #[inline]
    pub(super) fn stored(&mut self, op: Opcode, address: u32, marks: Marks) {
        let bytes = op.access_bytes().unwrap_or(0);
        let part = bytes < 4;
        if part {
            self.settle(marks[0]);
        }
        for (i, mark) in (0..bytes.div_ceil(4)).zip(marks) {
            let mark = if part { Mark::PLAIN } else { mark };
            let address = (address & !3) + 4 * i;
            match op.space() {
                Some(Space::Sram) => self.mark_sram(address, mark),
                _ if mark == Mark::PLAIN => {
                    self.outside.remove(&address);
                }
                _ => {
                    self.outside.insert(address, mark);
                }
            }
        }
    }
}
