//! Distances between units.

use crate::modulo::negotiate::MOST_LATE;
use crate::modulo::problem::Problem;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;

/// Fewest cycles between units, from one and to one, by type, as rows.
pub(super) struct Distances {
    pub(super) from: [Vec<Vec<i16>>; 3],
    pub(super) to: [Vec<Vec<i16>>; 3],
    /// A row of zeros.
    pub(super) nowhere: Vec<i16>,
}

impl Distances {
    /// Rows have `stride` lanes.
    pub(super) fn of(problem: &Problem<'_>, stride: usize) -> Distances {
        let units = || problem.srp.fus.keys();
        let reach = |ty: Ty, from: Fu, to: Fu| {
            let out = match ty {
                Ty::Pred => problem.graph.pred_out[from],
                Ty::Word | Ty::Vec => problem.graph.out[from],
            };
            problem.reach(ty, out, to).min(MOST_LATE as u32) as i16
        };
        let rows = |ty: Ty, row: &dyn Fn(Ty, Fu, Fu) -> i16| {
            let row = |a: Fu| {
                let mut row: Vec<i16> = units().map(|b| row(ty, a, b)).collect();
                row.resize(stride, MOST_LATE as i16);
                row
            };
            units().map(row).collect()
        };
        Distances {
            from: Ty::ALL.map(|ty| rows(ty, &|ty, a, b| reach(ty, a, b))),
            to: Ty::ALL.map(|ty| rows(ty, &|ty, a, b| reach(ty, b, a))),
            nowhere: vec![0; stride],
        }
    }

    pub(super) fn between(&self, ty: Ty, from: Fu, to: Fu) -> i32 {
        i32::from(self.from[ty as usize][from.index()][to.index()])
    }
}
