//! The rules of a [`Dre`], checked.

use super::Dre;
use crate::dfg::Dfg;
use crate::program::{Function, InstKind};
use crate::verify::Violation;
use srp_archdesc::isa::Ty;

impl Dre {
    /// Checks the control code ([`verify`](crate::verify())), every kernel ([`Dfg::verify`]), that
    /// kernels have different names and trip counts, and that each launch is of a kernel that exists, with values
    /// of its live-ins' types and results of its live-outs'.
    pub fn verify(&self) -> Result<(), Vec<Violation>> {
        let mut found = crate::verify(&self.control).err().unwrap_or_default();
        let whole = |message| Violation {
            func: None,
            block: None,
            inst: None,
            message,
        };
        for (kernel, dfg) in self.kernels.iter() {
            if self
                .kernels
                .values()
                .take_while(|d| !std::ptr::eq(*d, dfg))
                .any(|d| d.name == dfg.name)
            {
                found.push(whole(format!(
                    "{kernel}: a second kernel called `{}`",
                    dfg.name
                )));
            }
            if dfg.is_bare() {
                found.push(whole(format!("{kernel} ({}) has no trip count", dfg.name)));
            }
            for violation in dfg.verify().err().unwrap_or_default() {
                found.push(whole(format!("{kernel} ({}): {violation}", dfg.name)));
            }
        }
        for (func, data) in self.control.funcs.iter() {
            for &block in &data.layout {
                for &inst in &data.blocks[block].insts {
                    if let Err(message) = self.launch(data, &data.insts[inst]) {
                        found.push(Violation {
                            func: Some(func),
                            block: Some(block),
                            inst: Some(inst),
                            message,
                        });
                    }
                }
            }
        }
        if found.is_empty() { Ok(()) } else { Err(found) }
    }

    fn launch(&self, func: &Function, data: &crate::program::InstData) -> Result<(), String> {
        let InstKind::Launch { kernel, args } = &data.kind else {
            return Ok(());
        };
        let Some(dfg) = self.kernels.get(*kernel) else {
            return Err(format!("{kernel} does not exist"));
        };
        let tys = |values: &[crate::program::Value]| -> Vec<Option<Ty>> {
            values
                .iter()
                .map(|v| func.values.get(*v).copied())
                .collect()
        };
        let live_ins: Vec<Option<Ty>> = dfg.live_ins.iter().map(|l| Some(l.ty)).collect();
        if tys(args) != live_ins {
            return Err(format!(
                "the arguments are not the live-ins of `{}`",
                dfg.name
            ));
        }
        if tys(&data.results) != live_outs(dfg) {
            return Err(format!(
                "the results are not the live-outs of `{}`",
                dfg.name
            ));
        }
        Ok(())
    }
}

fn live_outs(dfg: &Dfg) -> Vec<Option<Ty>> {
    let outs = dfg.live_outs.iter();
    outs.map(|n| dfg.nodes.get(*n).and_then(|data| data.op.result()))
        .collect()
}
