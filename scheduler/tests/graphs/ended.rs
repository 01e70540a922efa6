//! Searches that a watch ends: what is left is a schedule, and says that no search has made it.

use super::{mesh, tree};
use srp_archdesc::Watch;
use srp_ir::check::check_loop;
use srp_scheduler::modulo::{self, Obstacle};

/// Ends all work at once, and takes a poor result.
struct Over;

impl Watch for Over {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn what_is_left_is_in_sequence_at_a_small_interval() {
    for side in [4, 24] {
        let arch = mesh(side, side);
        let graph = tree(16);
        let options = modulo::Options::default();
        let scheduled = modulo::schedule(&graph.dfg, &arch.srp, &options, &Over);
        let scheduled = scheduled.expect("there is one in sequence");
        let wrong = check_loop(&scheduled.schedule, &arch.srp);
        assert!(wrong.is_empty(), "{wrong:?}");
        let why = scheduled.why_not_lower.expect("the bound is lower");
        assert_eq!(why.obstacle, Obstacle::CutShort, "{why}");
        let (ii, contexts) = (scheduled.schedule.ii, arch.srp.contexts);
        assert!(ii < contexts / 4, "II {ii} of {contexts} contexts");
        assert!(why.to_string().contains("in sequence"), "{why}");
    }
}
