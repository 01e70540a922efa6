//! Copies of values: where each stands on the clock, and its causes.

use super::Folded;
use crate::modulo::exact::formula::Lit;
use crate::modulo::exact::names;
use crate::modulo::problem::Goal;
use crate::modulo::table::Via;
use srp_archdesc::arch::{Carrier, Fu, FuOp};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

/// A way into a file.
struct Write {
    file: Place,
    via: Via,
    /// The output that it takes the value from, and the cycles from there until it stands in the file; `None`
    /// for the result of the unit.
    over: Option<(Place, i64)>,
    by_cycle: Vec<Lit>,
}

/// The copies of a value on one level. Each list goes by the clock.
struct Level {
    /// In outputs and in files; empty where it cannot be.
    stands: EntityMap<Place, Vec<Lit>>,
    writes: Vec<Write>,
    /// Moves by their issue; empty on units that do not move it, and on level 0.
    moves: EntityMap<Fu, Vec<Lit>>,
}

/// A value and its copies.
struct Value<'a> {
    node: Node,
    ty: Ty,
    /// How each unit moves it.
    moving: EntityMap<Fu, Option<&'a FuOp>>,
    levels: Vec<Level>,
}

impl<'p> Folded<'_, 'p> {
    /// The variables of a node's value, and the clauses of its copies and of who needs them.
    pub(super) fn value(&mut self, node: Node) {
        let problem = self.problem;
        let Some(ty) = problem.dfg.ty(node) else {
            return;
        };
        let needed = problem.edges.iter().any(|edge| edge.from == node);
        if !needed {
            // What nobody needs takes its output for a cycle all the same.
            return self.lands_unneeded(node);
        }
        let moving = (problem.srp.fus.keys())
            .map(|fu| {
                let way = problem.move_timing(fu, ty);
                way.filter(|timing| timing.interval as usize <= self.ii)
            })
            .collect();
        let mut value = Value {
            node,
            ty,
            moving,
            levels: Vec::new(),
        };
        for level in 0..self.levels {
            let level = self.level(&value, level);
            value.levels.push(level);
        }
        for level in 0..self.levels {
            self.outputs(&value, level);
            self.files(&value, level);
            self.moves(&value, level);
        }
        self.consumers(&value);
        self.registers(&value);
    }

    fn lands_unneeded(&mut self, node: Node) {
        for &fu in &self.problem.units[node] {
            let op = self.problem.dfg.nodes[node].op;
            let Some(place) = self.problem.graph.result_place(fu, op) else {
                continue;
            };
            let latency = self.problem.timing(node, fu).latency as usize;
            for (time, &start) in self.start[node][fu].iter().enumerate() {
                self.limits.output(place, time + latency, start);
            }
        }
    }

    /// The variables of a level.
    fn level(&mut self, value: &Value<'_>, number: usize) -> Level {
        let (problem, node) = (self.problem, value.node);
        let level = self.level_name(number);
        let round = self.round;
        let fits = |place: Place| problem.graph.places[place].width >= value.ty.bits();
        let mut made = Level {
            stands: EntityMap::filled(problem.graph.places.len(), Vec::new()),
            writes: Vec::new(),
            moves: EntityMap::filled(problem.srp.fus.len(), Vec::new()),
        };
        let into = |file: Place| (file, self.ways_into(file, value.ty));
        let files = problem.graph.file.values().filter(|&&file| fits(file));
        let files: Vec<_> = files.map(|&file| into(file)).collect();
        let formula = &mut self.formula;
        let mut each_cycle = |what: String, of: &str| -> Vec<Lit> {
            let name = |time: usize| format!("{what} {node} {of} {level} {time}");
            (0..round)
                .map(|time| formula.variable(|| name(time)))
                .collect()
        };
        for fu in problem.srp.fus.keys() {
            let place = problem.graph.result_place(fu, Opcode::mov(value.ty));
            if let Some(place) = place.filter(|&place| fits(place)) {
                let name = problem.graph.name(problem.srp, place);
                made.stands[place] = each_cycle("out".to_owned(), &name);
            }
        }
        for (file, ways) in files {
            let name = problem.graph.name(problem.srp, file);
            made.stands[file] = each_cycle("held".to_owned(), &name);
            for (via, over) in ways {
                let what = format!("write.{}", names::via(problem, via));
                made.writes.push(Write {
                    file,
                    via,
                    over,
                    by_cycle: each_cycle(what, &name),
                });
            }
        }
        if number > 0 {
            for (fu, _) in value.moving.iter().filter(|(_, way)| way.is_some()) {
                made.moves[fu] = each_cycle("move".to_owned(), &problem.srp.fus[fu].name);
            }
        }
        made
    }

    /// The ways into a file: results of units, and links past them.
    fn ways_into(&self, file: Place, ty: Ty) -> Vec<(Via, Option<(Place, i64)>)> {
        let graph = &self.problem.graph;
        let results = self.problem.srp.fus.keys();
        let results = results.filter(|&fu| graph.writes[fu].contains(&file));
        let mut ways: Vec<_> = results.map(|fu| (Via::Result(fu), None)).collect();
        for transfer in graph.transfers.values().flatten() {
            let Carrier::Link(link) = transfer.over else {
                continue;
            };
            let from = self.problem.srp.links[link].from;
            let stands = graph.result_place(from, Opcode::mov(ty)) == Some(transfer.from);
            if transfer.to == file && transfer.width >= ty.bits() && stands {
                let over = (transfer.from, i64::from(transfer.delay) + 1);
                ways.push((Via::Over(transfer.over), Some(over)));
            }
        }
        ways
    }

    /// What lands on a unit in a cycle: the node's result on level 0, a move above.
    fn landing(&self, value: &Value<'p>, level: usize, fu: Fu, time: i64) -> Option<Lit> {
        if level > 0 {
            let latency = i64::from(value.moving[fu]?.latency);
            return Some(value.levels[level].moves[fu][self.cycle(time - latency)]);
        }
        let starts = &self.start[value.node][fu];
        let (first, rest) = (starts.first()?, starts.len());
        debug_assert_eq!(rest, self.round, "{first}");
        let latency = i64::from(self.problem.timing(value.node, fu).latency);
        Some(starts[self.cycle(time - latency)])
    }

    /// Copies in outputs: landed, and not more than the II ago, as the unit issues again by then.
    fn outputs(&mut self, value: &Value<'p>, level: usize) {
        for fu in self.problem.srp.fus.keys() {
            let mov = Opcode::mov(value.ty);
            let Some(place) = self.problem.graph.result_place(fu, mov) else {
                continue;
            };
            let stands = &value.levels[level].stands[place];
            for (time, &standing) in stands.iter().enumerate() {
                let now = time as i64;
                let landing = self.landing(value, level, fu, now);
                if let Some(landing) = landing {
                    self.formula.clause([-landing, standing]);
                }
                if self.round > 1 {
                    let before = stands[self.cycle(now - 1)];
                    let clause = [-standing, before].into_iter().chain(landing);
                    self.formula.clause(clause);
                }
                let within =
                    (0..self.ii as i64).filter_map(|ago| self.landing(value, level, fu, now - ago));
                let clause: Vec<Lit> = std::iter::once(-standing).chain(within).collect();
                self.formula.clause(clause);
                self.limits.output(place, time, standing);
            }
        }
    }

    /// Copies in files: written, and how.
    fn files(&mut self, value: &Value<'p>, level: usize) {
        let copies = &value.levels[level];
        for &file in self.problem.graph.file.values() {
            let stands = &copies.stands[file];
            let writes = || copies.writes.iter().filter(move |write| write.file == file);
            for (time, &held) in stands.iter().enumerate() {
                let now = time as i64;
                for write in writes() {
                    let written = write.by_cycle[time];
                    let cause = match (write.via, write.over) {
                        (Via::Result(fu), _) => self.landing(value, level, fu, now),
                        (Via::Over(_), None) => None,
                        (Via::Over(_), Some((from, cycles))) => {
                            let stood = copies.stands[from].get(self.cycle(now - cycles));
                            stood.copied()
                        }
                    };
                    self.formula.clause([-written, held]);
                    self.formula
                        .clause(std::iter::once(-written).chain(cause).collect::<Vec<_>>());
                    self.limits.write(file, time, written);
                }
                if self.round > 1 {
                    let before = stands[self.cycle(now - 1)];
                    let here = writes().map(|write| write.by_cycle[time]);
                    let clause: Vec<Lit> = [-held, before].into_iter().chain(here).collect();
                    self.formula.clause(clause);
                }
                let ever = writes().flat_map(|write| write.by_cycle.iter().copied());
                let clause: Vec<Lit> = std::iter::once(-held).chain(ever).collect();
                self.formula.clause(clause);
            }
        }
    }

    /// Moves: each reads a copy of the level below; the last level, where it is for all deeper ones, of itself too,
    /// and then there are moves of every level before.
    fn moves(&mut self, value: &Value<'p>, level: usize) {
        let Some(below) = level.checked_sub(1) else {
            return;
        };
        let deep = level as u32 > self.depth;
        for (fu, moves) in value.levels[level].moves.iter() {
            for (time, &issued) in moves.iter().enumerate() {
                let timing = value.moving[fu].expect("only units that move it have moves");
                self.limits.issue(fu, time, timing, issued);
                self.limits.moved(&mut self.formula, fu, time, issued);
                let mut clause = vec![-issued];
                for from in [Some(below), deep.then_some(level)].into_iter().flatten() {
                    clause.extend(self.readable(value, from, fu, time as i64));
                }
                self.formula.clause(clause);
                if deep && below > 0 {
                    let before = value.levels[below].moves.values().flatten();
                    let clause = std::iter::once(-issued).chain(before.copied());
                    self.formula.clause(clause.collect::<Vec<_>>());
                }
            }
        }
    }

    /// The copies of a level that a unit can read in a cycle.
    fn readable(&self, value: &Value<'p>, level: usize, fu: Fu, time: i64) -> Vec<Lit> {
        let paths = self.problem.graph.reads[fu].iter();
        let wide = paths.filter(|path| path.width >= value.ty.bits());
        wide.filter_map(|path| {
            let stands = &value.levels[level].stands[path.from];
            let stood = self.cycle(time - i64::from(path.delay));
            stands.get(stood).copied()
        })
        .collect()
    }

    /// A start implies that each operand can be read then; a live-out is written into a central register.
    fn consumers(&mut self, value: &Value<'p>) {
        let problem = self.problem;
        for edge in problem.edges.iter().filter(|edge| edge.from == value.node) {
            match edge.goal {
                Goal::LiveOut(_) => {
                    let central = problem.srp.central(value.ty);
                    let file = central.map(|central| problem.graph.file[central]);
                    let writes = value.levels.iter().flat_map(|level| &level.writes);
                    let writes = writes.filter(|write| Some(write.file) == file);
                    let clause = writes.flat_map(|write| write.by_cycle.iter().copied());
                    self.formula.clause(clause.collect::<Vec<_>>());
                }
                Goal::Operand(to, _) => {
                    let later = self.ii as i64 * i64::from(edge.distance);
                    for (fu, starts) in self.start[to].clone().iter() {
                        for (time, &start) in starts.iter().enumerate() {
                            let mut clause = vec![-start];
                            for level in 0..self.levels {
                                let read = self.readable(value, level, fu, time as i64 + later);
                                clause.extend(read);
                            }
                            self.formula.clause(clause);
                        }
                    }
                }
            }
        }
    }

    /// Copies of several levels in one file are counted as one register: they may be one.
    fn registers(&mut self, value: &Value<'p>) {
        let node = value.node;
        for &file in self.problem.graph.file.values() {
            let of_level = |level: usize| &value.levels[level].stands[file];
            if of_level(0).is_empty() {
                continue;
            }
            let name = self.problem.graph.name(self.problem.srp, file);
            for time in 0..self.round {
                if self.levels == 1 {
                    self.limits.register(file, time, of_level(0)[time]);
                    continue;
                }
                let keeps = (self.formula).variable(|| format!("keep {node} {name} {time}"));
                for level in 0..self.levels {
                    self.formula.clause([-of_level(level)[time], keeps]);
                }
                self.limits.register(file, time, keeps);
            }
        }
    }
}
