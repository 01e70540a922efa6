//! What is called impossible, held against searches for schedules: an exhaustive one over placements and routes, which
//! shares nothing with the scheduler, and the scheduler itself, whose schedules are checked.

use super::{certificate, folded, listed, parsed, star};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_ir::check::check_loop;
use srp_scheduler::modulo::{self, Scope, Stopped};
use std::time::Duration;

/// A row of units, each linked to the next and back, without register files.
fn row(units: usize) -> Arch {
    let unit = |k: usize| {
        format!(
            r#"<fu row="0" col="{k}" name="u{k}" pred-out="false"><op class="alu" latency="1" interval="1"/></fu>"#
        )
    };
    let all: String = (0..units).map(unit).collect();
    parsed(&format!(
        r#"<machine name="row{units}"><array rows="1" cols="{units}" topology="mesh">{all}</array><vliw slots="0"/></machine>"#
    ))
}

/// An exhaustive search for a schedule on a row: every unit and cycle for every node in turn, and every way over moves
/// for every edge.
struct Exhaustive<'a> {
    units: i32,
    ii: i32,
    /// The last cycle that anything is issued in.
    last: i32,
    nodes: usize,
    /// From, to, distance.
    edges: &'a [(usize, usize, i32)],
    at: Vec<(i32, i32)>,
    /// Who has issued on each unit in each slot: the node whose value it makes, and the cycle of iteration 0.
    issued: Vec<Vec<Option<(usize, i32)>>>,
    /// Reads of outputs: the unit, the cycle of the issue whose value it is, and the cycle of the read.
    kept: Vec<(i32, i32, i32)>,
}

impl Exhaustive<'_> {
    fn finds(&mut self) -> bool {
        let node = self.at.len();
        if node == self.nodes {
            return self.routes(0);
        }
        for time in 0..=self.last {
            for unit in 0..self.units {
                if self.issue(unit, time, node) {
                    self.at.push((unit, time));
                    if self.is_in_time(node) && self.finds() {
                        return true;
                    }
                    self.at.pop();
                    self.withdraw(unit, time);
                }
            }
        }
        false
    }

    /// True if the edges between this node and those before it leave time to pass the value.
    fn is_in_time(&self, node: usize) -> bool {
        let placed = |&&(from, to, _): &&(usize, usize, i32)| from.max(to) == node;
        self.edges
            .iter()
            .filter(placed)
            .all(|&(from, to, distance)| {
                let ((unit, time), (reader, read)) = (self.at[from], self.at[to]);
                let wait = read + self.ii * distance - time - 1;
                wait >= 0 && wait >= (unit - reader).abs() - 1
            })
    }

    fn issue(&mut self, unit: i32, time: i32, node: usize) -> bool {
        let slot = time.rem_euclid(self.ii) as usize;
        let free = self.issued[unit as usize][slot].is_none();
        if free {
            self.issued[unit as usize][slot] = Some((node, time));
        }
        free
    }

    fn withdraw(&mut self, unit: i32, time: i32) {
        self.issued[unit as usize][time.rem_euclid(self.ii) as usize] = None;
    }

    /// Routes the edges from this one on. Issues decide what stands where: a value stands in an output from the
    /// cycle after its issue until the cycle of the unit's next issue, in which it can still be read.
    fn routes(&mut self, edge: usize) -> bool {
        let Some(&(from, to, distance)) = self.edges.get(edge) else {
            return self.stands();
        };
        let ((unit, time), (reader, read)) = (self.at[from], self.at[to]);
        self.passes(
            edge,
            from,
            (unit, time),
            (reader, read + self.ii * distance),
        )
    }

    /// Tries all ways from an issue of a value to its reader.
    fn passes(
        &mut self,
        edge: usize,
        node: usize,
        (unit, time): (i32, i32),
        to: (i32, i32),
    ) -> bool {
        let (reader, read) = to;
        let in_reach = |from: i32, to: i32| (from - to).abs() <= 1;
        if in_reach(unit, reader) && (time + 1..=time + self.ii).contains(&read) {
            self.kept.push((unit, time, read));
            if self.routes(edge + 1) {
                return true;
            }
            self.kept.pop();
        }
        // A move on this unit or the next, in a cycle in which the value stands.
        for mover in (0..self.units).filter(|&mover| in_reach(unit, mover)) {
            for moved in time + 1..=(time + self.ii).min(read - 1) {
                let slot = moved.rem_euclid(self.ii) as usize;
                let shared = self.issued[mover as usize][slot] == Some((node, moved));
                let is_move = self.at[node] != (mover, moved);
                let is_known = shared && is_move;
                let is_new = !is_known && self.issue(mover, moved, node);
                if !is_known && !is_new {
                    continue;
                }
                self.kept.push((unit, time, moved));
                if self.passes(edge, node, (mover, moved), to) {
                    return true;
                }
                self.kept.pop();
                if is_new {
                    self.withdraw(mover, moved);
                }
            }
        }
        false
    }

    /// True if every value that is read stands there still: its unit issues nothing in between.
    fn stands(&self) -> bool {
        self.kept.iter().all(|&(unit, time, read)| {
            (time + 1..read).all(|cycle| {
                let slot = cycle.rem_euclid(self.ii) as usize;
                self.issued[unit as usize][slot].is_none()
            })
        })
    }
}

/// A random connected graph: nodes in a row by values, more values between them, and some from earlier iterations.
fn random_graph(random: &mut Pcg32) -> (usize, Vec<(usize, usize, i32)>) {
    let mut below = |most: usize| random.next_u32() as usize % most;
    let nodes = 3 + below(2);
    let mut edges: Vec<(usize, usize, i32)> = (1..nodes).map(|to| (below(to), to, 0)).collect();
    for _ in 0..below(3) {
        let to = 1 + below(nodes - 1);
        edges.push((below(to), to, 0));
    }
    for _ in 0..below(2) {
        let from = below(nodes);
        edges.push((from, below(from + 1), 1 + below(2) as i32));
    }
    (nodes, edges)
}

#[test]
fn nothing_that_an_exhaustive_search_finds_is_called_impossible() {
    let (mut impossible, mut found) = (0, 0);
    for seed in 0..24 {
        let mut random = Pcg32::seed_from_u64(seed);
        let units = 2 + seed as usize % 2;
        let (nodes, edges) = random_graph(&mut random);
        let lines = edges
            .iter()
            .map(|(from, to, distance)| format!("{from} {to} {distance}"));
        let (graph, _) = listed(&lines.collect::<Vec<_>>().join("\n"));
        let arch = row(units);
        let bound = modulo::bounds(&graph.dfg, &arch.srp).min_ii();
        for ii in bound..(bound + 2).min(4) {
            let mut search = Exhaustive {
                units: units as i32,
                ii: ii as i32,
                last: 9,
                nodes,
                edges: &edges,
                at: Vec::new(),
                issued: vec![vec![None; ii as usize]; units],
                kept: Vec::new(),
            };
            let exists = search.finds();
            let scopes = [
                folded(1, 2),
                folded(2, 3),
                folded(3, 8),
                Scope::Timed { slack: 9 },
            ];
            for scope in scopes {
                let refuted = certificate(&graph.dfg, &arch, ii, scope).is_some();
                assert!(
                    !(exists && refuted),
                    "seed {seed}, II {ii}: {scope:?} {edges:?}"
                );
                impossible += u32::from(refuted && matches!(scope, Scope::Folded(_)));
            }
            found += u32::from(exists);
        }
    }
    assert!(
        impossible > 5 && found > 10,
        "{impossible} impossible, {found} found"
    );
}

/// Loads at one end of a row, multiplications at the other: the value is moved four times on its way.
#[test]
fn a_schedule_longer_than_the_horizon_is_not_called_impossible() {
    let unit = |k: usize| {
        let class = ["load", "alu", "alu", "alu", "alu", "imul"][k];
        format!(
            r#"<fu row="0" col="{k}" name="u{k}" pred-out="false"><op class="{class}" latency="1" interval="1"/></fu>"#
        )
    };
    let all: String = (0..6).map(unit).collect();
    let arch = parsed(&format!(
        r#"<machine name="long"><array rows="1" cols="6" topology="mesh">{all}</array><vliw slots="0"/></machine>"#
    ));
    let source = |name: &str, text: &str| srp_archdesc::diagnostic::Source::new(name, text);
    let options = srp_ir::graph::Options::default();
    let (edges, ops) = (source("g.edges", "x y 0"), source("g.ops", "x load\ny mul"));
    let graph = srp_ir::graph::read_edges(&edges, &ops, &options).expect("a graph");
    let refuted = |scope| certificate(&graph.dfg, &arch, 1, scope).is_some();
    assert!(
        refuted(Scope::Timed { slack: 3 }),
        "four moves take four cycles"
    );
    assert!(!refuted(Scope::Timed { slack: 4 }));
    for laps in 1..12 {
        assert!(!refuted(folded(laps, laps % 5)), "{laps} laps");
    }
    let scheduled = modulo::schedule(
        &graph.dfg,
        &arch.srp,
        &modulo::Options::default(),
        &Unwatched,
    );
    let scheduled = scheduled.expect("it has a schedule");
    assert_eq!(scheduled.schedule.ii, 1);
    assert_eq!(check_loop(&scheduled.schedule, &arch.srp), Vec::new());
}

/// Four units on one bus, and no links: at II 1 three values need it, at II 2 one of them stays on its unit.
#[test]
fn a_schedule_over_wires_is_not_called_impossible() {
    let arch = parsed(
        r#"<machine name="bus">
  <op class="alu" latency="1"/>
  <fu-type name="pe" classes="alu"/>
  <array rows="1" cols="4" topology="none" wires="row"><row units="pe"/></array>
  <vliw slots="0"/>
</machine>"#,
    );
    let (graph, _) = listed(&star(2));
    let options = modulo::Options {
        beyond: Some(Duration::from_secs(600)),
        ..modulo::Options::default()
    };
    let found = modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched);
    let found = found.expect("it has a schedule");
    assert_eq!((found.bounds.min_ii(), found.schedule.ii), (1, 2));
    assert_eq!(check_loop(&found.schedule, &arch.srp), Vec::new());
    assert!(!found.schedule.hops.is_empty(), "there are no other ways");
    // The folded formula has no clauses for wires, and would refute both.
    let asked = found.search.asked.iter().map(|asked| asked.scope);
    assert!({ asked }.all(|scope| matches!(scope, Scope::Timed { .. })));
    assert_eq!(found.search.stopped, Stopped::NothingLeft);
    for scope in [folded(1, 2), folded(2, 4), Scope::Timed { slack: 15 }] {
        let refuted = certificate(&graph.dfg, &arch, 2, scope).is_some();
        assert!(!refuted, "{scope:?}");
    }
}
