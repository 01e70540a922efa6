//! Bundles of all functions one after another, with numbers for the targets of jumps.

use super::lir::{Code, FrameLayout, Label};
use super::list::{self, Packed};
use super::region::{self, Frames, Region, Transfer};
use super::target::Target;
use super::{FunctionFacts, VliwCode, VliwError, place};
use crate::abi;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::check::sequence::{Step, Stretch};
use srp_ir::dre::scheduled::{Bundle, BundleData, Control, FunctionEntry, SlotOp};
use srp_ir::program::{Func, Program};

/// The code so far.
pub(super) struct Linker<'a> {
    program: &'a Program,
    target: &'a Target<'a>,
    bundles: EntityMap<Bundle, BundleData>,
    /// Bundles that hold a call, to be aimed at the entry of the callee.
    calls: Vec<(Bundle, Func)>,
    /// First bundles of the functions and the start code, in the order they were added.
    entries: Vec<Bundle>,
    /// The operations of the bundles in sequence.
    sequence: Vec<Stretch>,
    /// Facts about each, in the same order as the entries.
    facts: Vec<FunctionFacts>,
}

impl<'a> Linker<'a> {
    /// Nothing yet.
    pub(super) fn new(program: &'a Program, target: &'a Target<'a>) -> Linker<'a> {
        Linker {
            program,
            target,
            bundles: EntityMap::new(),
            calls: Vec::new(),
            entries: Vec::new(),
            sequence: Vec::new(),
            facts: Vec::new(),
        }
    }

    /// Schedules and appends a function; gives its first bundle.
    pub(super) fn add(
        &mut self,
        code: &Code,
        frame: &FrameLayout,
        limit: u32,
    ) -> Result<Bundle, VliwError> {
        let entry = Bundle::new(self.bundles.len());
        self.entries.push(entry);
        let mut labels: EntityMap<Label, Option<Bundle>> =
            EntityMap::filled(code.blocks.len(), None);
        let mut jumps: Vec<(Bundle, Label)> = Vec::new();
        let (mut least, mut operations) = (0, 0);
        let frames = Frames {
            layout: frame,
            limit,
        };
        for (i, &label) in code.order.iter().enumerate() {
            labels[label] = Some(Bundle::new(self.bundles.len()));
            let next = code.order.get(i + 1).copied();
            for region in region::regions(&code.blocks[label], next, self.target, &frames) {
                let packed = list::pack(&region, self.target).map_err(|list::NoSlot(op)| {
                    let op = &region.ops[op];
                    VliwError::Unsupported {
                        op: op.op,
                        at: place(self.program, &code.name, op.pos),
                    }
                })?;
                least += packed.least;
                operations += region.ops.len() as u32;
                self.append(&region, &packed, &mut jumps);
            }
        }
        for (bundle, label) in jumps {
            let to = labels[label].expect("jumps go to blocks of the layout");
            let control = self.bundles[bundle].control.as_mut();
            match control.map(|(control, _)| control) {
                Some(Control::Jump(target) | Control::Branch { target, .. }) => *target = to,
                _ => unreachable!("only bundles with jumps were noted"),
            }
        }
        self.facts.push(FunctionFacts {
            name: code.name.clone(),
            operations,
            bundles: (self.bundles.len() - entry.index()) as u32,
            least,
            frame: frame.size,
            spilled: code.frame.homes.len() as u32,
        });
        Ok(entry)
    }

    fn append(&mut self, region: &Region, packed: &Packed, jumps: &mut Vec<(Bundle, Label)>) {
        self.sequence.push(Stretch {
            first: Bundle::new(self.bundles.len()),
            bundles: packed.bundles.len(),
            steps: region.ops.clone(),
            // Filled in when all targets are known.
            exit: None,
        });
        for (cycle, ops) in packed.bundles.iter().enumerate() {
            let slot = |&(fu, i): &(Fu, usize)| slot_op(fu, &region.ops[i]);
            let bundle = self.bundles.push(BundleData {
                ops: ops.iter().map(slot).collect(),
                control: None,
            });
            let Some((transfer, pos)) = region.exit.filter(|_| packed.exit == Some(cycle)) else {
                continue;
            };
            let link = abi::link(self.target.srp);
            // Filled in when the target is known.
            let later = bundle;
            let control = match transfer {
                Transfer::Jump(to) => {
                    jumps.push((bundle, to));
                    Control::Jump(later)
                }
                Transfer::Branch { cond, sense, to } => {
                    jumps.push((bundle, to));
                    Control::Branch {
                        cond,
                        sense,
                        target: later,
                    }
                }
                Transfer::Call(func) => {
                    self.calls.push((bundle, func));
                    Control::Call {
                        target: later,
                        link,
                    }
                }
                Transfer::CallLink => Control::CallReg { target: link, link },
                Transfer::Launch(kernel) => Control::Launch(kernel),
                Transfer::Return => Control::Return(link),
                Transfer::Halt(status) => Control::Halt(status),
                Transfer::Unreachable => Control::Unreachable,
                Transfer::StackOverflow => Control::StackOverflow,
            };
            self.bundles[bundle].control = Some((control, pos));
        }
    }

    /// The code, where the start code was added first and then all functions in their order.
    pub(super) fn finish(mut self, start: Bundle) -> VliwCode {
        let names = self.program.funcs.values().map(|f| f.name.clone());
        let functions: Vec<FunctionEntry> = names
            .zip(&self.entries[1..])
            .map(|(name, &bundle)| FunctionEntry { name, bundle })
            .collect();
        for (bundle, func) in self.calls {
            if let Some((Control::Call { target, .. }, _)) = &mut self.bundles[bundle].control {
                *target = functions[func.index()].bundle;
            }
        }
        for stretch in &mut self.sequence {
            let numbers = stretch.first.index()..stretch.first.index() + stretch.bundles;
            let mut controls = numbers.filter_map(|b| self.bundles[Bundle::new(b)].control.clone());
            stretch.exit = controls.next().map(|(control, _)| control);
        }
        VliwCode {
            sequence: self.sequence,
            bundles: self.bundles,
            functions,
            start,
            facts: self.facts.split_off(1),
        }
    }
}

fn slot_op(fu: Fu, op: &Step) -> SlotOp {
    SlotOp {
        fu,
        op: op.op,
        srcs: op.srcs.clone(),
        imm: op.imm,
        dst: op.dst,
        pos: op.pos,
    }
}
