//! A VLIW engine that follows the rules of time to the letter, and runs kernels by their meaning:
//! a launch takes the live-in registers, runs the loop's dataflow graph in program order, sets the
//! live-out registers, and fills everything else that the kernel may write with rubbish.

use srp_archdesc::arch::{Arch, FileKind};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::ops::Value;
use srp_ir::dre::scheduled::*;
use srp_ir::interp::{self, Stop, TrapKind, World};
use srp_ir::program::{Bits, Pos};

/// How a run ended.
#[derive(Debug, PartialEq)]
pub(crate) enum End {
    Halted(i32),
    Trap(TrapKind, Pos),
}

const RUBBISH: Value = srp_archdesc::ops::V4([0xdead_beef; 4]);

/// Runs scheduled code from its start; gives how it ended and how many bundles it issued.
pub(crate) fn run(dre: &ScheduledDre, arch: &Arch, world: &mut dyn World, limit: u64) -> End {
    let sizes = arch.srp.files.values();
    let mut engine = Engine {
        dre,
        arch,
        regs: sizes.map(|f| vec![RUBBISH; f.size as usize]).collect(),
        flying: Vec::new(),
        cycle: 0,
    };
    engine.run(world, limit)
}

struct Engine<'a> {
    dre: &'a ScheduledDre,
    arch: &'a Arch,
    regs: EntityMap<srp_archdesc::arch::RegFile, Vec<Value>>,
    /// Results on their way: the cycle from which they stand, where, what.
    flying: Vec<(u64, Reg, Value)>,
    cycle: u64,
}

impl Engine<'_> {
    fn read(&self, reg: Reg) -> Value {
        self.regs[reg.file][reg.index as usize]
    }

    fn write(&mut self, reg: Reg, value: Value) {
        let width = self.arch.srp.files[reg.file].width;
        let value = match width {
            1 => srp_archdesc::ops::V4([value.0[0] & 1, 0, 0, 0]),
            32 => srp_archdesc::ops::V4([value.0[0], 0, 0, 0]),
            _ => value,
        };
        self.regs[reg.file][reg.index as usize] = value;
    }

    fn land(&mut self) {
        let (now, later) = std::mem::take(&mut self.flying)
            .into_iter()
            .partition(|&(cycle, ..)| cycle <= self.cycle);
        self.flying = later;
        let now: Vec<(u64, Reg, Value)> = now;
        for (_, reg, value) in now {
            self.write(reg, value);
        }
    }

    fn run(&mut self, world: &mut dyn World, limit: u64) -> End {
        let mut at = self.dre.start;
        let mut jump: Option<(u64, Bundle)> = None;
        loop {
            self.land();
            if let Some((cycle, target)) = jump
                && cycle == self.cycle
            {
                at = target;
                jump = None;
            }
            assert!(self.cycle < limit, "the program does not end");
            let bundle = &self.dre.bundles[at];
            let taken = bundle
                .control
                .as_ref()
                .and_then(|(control, pos)| Some((self.control(control, at)?, *pos)));
            if let Err(end) = self.operations(bundle, world) {
                return end;
            }
            self.cycle += 1;
            at = Bundle::new(at.index() + 1);
            match taken {
                None => {}
                Some((Next::Jump(target), _)) => {
                    assert!(jump.is_none(), "two transfers at a time");
                    jump = Some((self.cycle + u64::from(self.arch.srp.branch_delay), target));
                }
                Some((Next::Launch(kernel), _)) => {
                    assert!(jump.is_none());
                    self.land();
                    assert!(self.flying.is_empty(), "results in flight at a launch");
                    if let Err(end) = self.launch(&self.dre.kernels[kernel], world) {
                        return end;
                    }
                }
                Some((Next::End(kind), pos)) => return End::Trap(kind, pos),
                Some((Next::Halt(status), _)) => return End::Halted(status),
            }
        }
    }

    /// Returns the effect of a control transfer, decided when it issues.
    fn control(&mut self, control: &Control, at: Bundle) -> Option<Next> {
        let delay = u64::from(self.arch.srp.branch_delay);
        let back = (at.index() as u64 + 1 + delay) as u32;
        Some(match *control {
            Control::Jump(target) => Next::Jump(target),
            Control::Branch {
                cond,
                sense,
                target,
            } => {
                if (self.read(cond).0[0] != 0) != sense {
                    return None;
                }
                Next::Jump(target)
            }
            Control::Call { target, link } => {
                let lands = self.cycle + delay + 1;
                self.flying.push((lands, link, Value::word(back)));
                Next::Jump(target)
            }
            Control::CallReg { target, link } => {
                let address = self.read(target).0[0];
                let entry = address
                    .checked_sub(FUNC_BASE)
                    .filter(|offset| offset % 4 == 0)
                    .and_then(|offset| self.dre.functions.get(offset as usize / 4));
                let Some(entry) = entry else {
                    return Some(Next::End(TrapKind::BadCall(address)));
                };
                let lands = self.cycle + delay + 1;
                self.flying.push((lands, link, Value::word(back)));
                Next::Jump(entry.bundle)
            }
            Control::Return(reg) => Next::Jump(Bundle::new(self.read(reg).0[0] as usize)),
            Control::Launch(kernel) => Next::Launch(kernel),
            Control::Halt(reg) => Next::Halt(self.read(reg).0[0] as i32),
            Control::Unreachable => Next::End(TrapKind::Unreachable),
            Control::StackOverflow => Next::End(TrapKind::StackOverflow),
        })
    }

    /// Issues the operations: loads read memory before the stores of the same bundle write it.
    fn operations(&mut self, bundle: &BundleData, world: &mut dyn World) -> Result<(), End> {
        let mut stores_last: Vec<&SlotOp> = bundle.ops.iter().collect();
        stores_last.sort_by_key(|op| op.op.result().is_none());
        for op in stores_last {
            let src = |src: &Src| match *src {
                Src::Reg(reg) => self.read(reg),
                Src::Const(bits) => srp_archdesc::ops::V4(bits.lanes()),
            };
            let args: Vec<Value> = op.srcs.iter().map(src).collect();
            let result = interp::operate(op.op, &args, op.imm, &self.arch.precision, world);
            let result = match result {
                Ok(result) => result,
                Err(Stop::Trap(kind)) => return Err(End::Trap(kind, op.pos)),
                Err(Stop::Exit(status)) => return Err(End::Halted(status)),
            };
            if let (Some(dst), Some(value)) = (op.dst, result) {
                let how = self.arch.srp.fus[op.fu]
                    .timing(op.op)
                    .expect("a unit that runs it");
                self.flying
                    .push((self.cycle + u64::from(how.latency), dst, value));
            }
        }
        Ok(())
    }

    fn launch(&mut self, kernel: &ModuloSchedule, world: &mut dyn World) -> Result<(), End> {
        let ins = kernel.live_in_regs.iter().zip(&kernel.dfg.live_ins);
        let ins = ins.map(|(&reg, live_in)| Bits::of_lanes(live_in.ty, self.read(reg).0));
        let ins: Vec<Bits> = ins.collect();
        let precision = &self.arch.precision;
        let outs = srp_ir::dfg::run(&kernel.dfg, &ins, world, precision, &mut 1_000_000)
            .map_err(|trap| End::Trap(trap.kind, trap.pos))?;
        for op in kernel.ops.values() {
            for w in &op.writes {
                if self.arch.srp.files[w.file].kind == FileKind::Central {
                    for index in w.index..w.index + w.ring {
                        let reg = Reg {
                            file: w.file,
                            index,
                        };
                        self.write(reg, RUBBISH);
                    }
                }
            }
        }
        for (&reg, value) in kernel.live_out_regs.iter().zip(outs) {
            self.write(reg, srp_archdesc::ops::V4(value.lanes()));
        }
        Ok(())
    }
}

enum Next {
    Jump(Bundle),
    Launch(srp_ir::program::Kernel),
    Halt(i32),
    End(TrapKind),
}
