//! How often a plain counting loop runs.

use super::Checker;
use crate::typed::*;

impl Checker<'_> {
    /// How often `for (i = a; i < b; i += c)` runs, with constants a, b and c, where nothing else
    /// changes `i`; `assigned` are the variables that the body assigns.
    pub(super) fn trip(
        &self,
        init: Option<StmtId>,
        cond: Option<ExprId>,
        step: Option<ExprId>,
        assigned: &[LocalId],
    ) -> Option<Trip> {
        let ExprKind::Compare(relation, l, r) = self.body.exprs[cond?].kind else {
            return None;
        };
        let counter = self.variable(l)?;
        let end = i64::from(self.const_value(r)? as i32);
        let start = i64::from(self.start(init?, counter)? as i32);
        let by = i64::from(self.step_of(step?, counter)?);
        let local = &self.body.locals[counter];
        let plain = local.ty.ty == self.types.known.int && self.ty(l) == local.ty.ty;
        if assigned.contains(&counter) || !plain || local.ty.quals.volatile {
            return None;
        }
        let span = match (relation, by) {
            (Relation::Lt, 1..) => end - start,
            (Relation::Le, 1..) => end - start + 1,
            (Relation::Gt, ..=-1) => start - end,
            (Relation::Ge, ..=-1) => start - end + 1,
            (Relation::Ne, _) if by != 0 && (end - start) % by == 0 => (end - start) * by.signum(),
            _ => return None,
        };
        let trip = span.max(0).div_euclid(by.abs()) + i64::from(span.max(0) % by.abs() != 0);
        // The counter must not pass the ends of `int`, where it would wrap.
        let last = start + trip * by;
        let fits = i32::try_from(last).is_ok() && span >= 0;
        let count = u32::try_from(trip).ok().filter(|_| fits)?;
        Some(Trip { count, counter })
    }

    /// The variable that an expression reads.
    fn variable(&self, e: ExprId) -> Option<LocalId> {
        match self.body.exprs[e].kind {
            ExprKind::Load(place) => self.plain_local(place),
            _ => None,
        }
    }

    fn plain_local(&self, place: PlaceId) -> Option<LocalId> {
        match self.body.places[place].kind {
            PlaceKind::Local(local) => Some(local),
            _ => None,
        }
    }

    /// Returns the constant that a statement sets the counter to.
    fn start(&self, init: StmtId, counter: LocalId) -> Option<u64> {
        match &self.body.stmts[init].kind {
            StmtKind::Init(local, init) if *local == counter => match init.parts.as_slice() {
                [only] if only.offset == 0 => self.const_value(only.value),
                _ => None,
            },
            StmtKind::Expr(e) => match self.body.exprs[*e].kind {
                ExprKind::Assign(place, value) if self.plain_local(place) == Some(counter) => {
                    self.const_value(value)
                }
                _ => None,
            },
            StmtKind::Block(list) => match list.as_slice() {
                [only] => self.start(*only, counter),
                _ => None,
            },
            _ => None,
        }
    }

    /// Returns the constant that a step adds to the counter.
    fn step_of(&self, step: ExprId, counter: LocalId) -> Option<i32> {
        let ExprKind::Update(update) = &self.body.exprs[step].kind else {
            return None;
        };
        if self.plain_local(update.place) != Some(counter) {
            return None;
        }
        let by = self.const_value(update.operand)? as i32;
        match update.step {
            Step::Arithmetic(BinaryOp::Add, _) => Some(by),
            Step::Arithmetic(BinaryOp::Sub, _) => by.checked_neg(),
            _ => None,
        }
    }
}
