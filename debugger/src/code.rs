//! What a program's tables say of its source: the lines of bundles and contexts, and the variables of their steps.

use crate::kept::KeptOf;
use crate::variables::{Name, Variables};
use srp_archdesc::ResourceGraph;
use srp_archdesc::entity::Entity;
use srp_csimgen::SimSpec;
use srp_csimgen::spec::{BundleSpec, Control, Position, Step};
use srp_ir::check::Checked;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::collections::{BTreeMap, BTreeSet};

/// A line, by its number in [`Code`].
pub(crate) type Line = u32;

/// The source behind a program's tables.
#[derive(Debug, Default)]
pub(crate) struct Code {
    /// File and line.
    pub(crate) lines: Vec<(String, u32)>,
    /// The line of each position, if it is one.
    of_position: Vec<Option<Line>>,
    /// The lines of each bundle, that of its first step first.
    pub(crate) bundles: Vec<Vec<Line>>,
    /// The variables of its steps.
    pub(crate) bundle_names: Vec<Vec<Vec<Name>>>,
    pub(crate) kernels: Vec<KernelCode>,
    /// The variables of the source.
    pub(crate) variables: Variables,
    /// The block of each bundle: within one, every bundle runs.
    pub(crate) blocks: Vec<u32>,
    /// The reasons for which VLIW code does not tell the value of a variable.
    doubts: BTreeMap<Name, &'static str>,
    /// Those that some operation makes, or that a kernel counts.
    made: BTreeSet<Name>,
    /// The positions that are in the steps of `for` loops.
    steps: BTreeSet<Position>,
    /// The function in which a call is, by its position.
    callers: BTreeMap<Position, String>,
}

/// The source of a kernel.
#[derive(Debug, Default)]
pub(crate) struct KernelCode {
    /// For each line the slot and the stage in which an iteration comes to it first.
    pub(crate) first: BTreeMap<Line, (u32, u32)>,
    /// The line of each slot in each stage: that of the first step there.
    pub(crate) at: Vec<BTreeMap<u32, Line>>,
    /// Its variables.
    pub(crate) of: KeptOf,
    /// The cells of the live-ins, as they are when it is launched.
    pub(crate) live_ins: Vec<u32>,
    /// Its stages.
    pub(crate) stages: u32,
}

impl Code {
    /// The source behind these tables.
    pub(crate) fn of(program: &Checked, spec: &SimSpec, variables: &Variables) -> Code {
        let mut code = Code {
            variables: variables.clone(),
            ..Code::default()
        };
        code.find_lines(spec);
        for bundle in &spec.bundles {
            let lines = code.lines_of(bundle);
            code.bundles.push(lines);
            let named = bundle.steps.iter().map(|step| code.named(spec, step));
            let named: Vec<Vec<Name>> = named.collect();
            code.bundle_names.push(named);
        }
        code.find_blocks(spec);
        code.find_doubts(spec);
        code.made
            .extend(code.bundle_names.iter().flatten().flatten());
        for (schedule, kernel) in program.kernels.values().zip(&spec.kernels) {
            let mut of_kernel = KernelCode {
                of: KeptOf::of(program, schedule, kernel, variables),
                ..KernelCode::default()
            };
            for (slot, steps) in (0..).zip(&kernel.contexts) {
                code.add_slot(&mut of_kernel, slot, steps);
            }
            of_kernel.live_ins = live_ins(program, schedule, spec);
            code.made.extend(of_kernel.of.kept.keys());
            code.made.extend(of_kernel.of.names.values().flatten());
            code.kernels.push(of_kernel);
        }
        for (number, bundle) in (0..).zip(&spec.bundles) {
            if let Some((Control::Call { .. } | Control::CallReg { .. }, at)) = bundle.control {
                let function = spec.function_of(number).unwrap_or("start");
                code.callers.insert(at, function.to_owned());
            }
        }
        code
    }

    fn find_lines(&mut self, spec: &SimSpec) {
        let mut numbers: BTreeMap<(String, u32), Line> = BTreeMap::new();
        for (position, at) in (0..).zip(&spec.positions) {
            if self.variables.is_step(at) {
                self.steps.insert(position);
            }
            let mut parts = at.rsplitn(3, ':');
            let line = parts.nth(1).and_then(|line| line.parse().ok());
            let (Some(line), Some(file)) = (line, parts.next()) else {
                self.of_position.push(None);
                continue;
            };
            let next = numbers.len() as Line;
            let number = *numbers.entry((file.to_owned(), line)).or_insert(next);
            if number == next {
                self.lines.push((file.to_owned(), line));
            }
            self.of_position.push(Some(number));
        }
    }

    /// The line of a position.
    pub(crate) fn line(&self, at: Position) -> Option<Line> {
        self.of_position.get(at as usize).copied().flatten()
    }

    /// The function in which the call at a position is.
    pub(crate) fn caller(&self, at: Position) -> &str {
        self.callers.get(&at).map_or("start", String::as_str)
    }

    fn lines_of(&self, bundle: &BundleSpec) -> Vec<Line> {
        let steps = bundle.steps.iter().map(|step| step.at);
        let control = bundle.control.iter().map(|(_, at)| *at);
        let mut lines = Vec::new();
        for line in steps.chain(control).filter_map(|at| self.line(at)) {
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }

    fn add_slot(&self, kernel: &mut KernelCode, slot: u32, steps: &[Step]) {
        let mut at = BTreeMap::new();
        for step in steps {
            let (Some(line), Some(stage)) = (self.line(step.at), step.stage) else {
                continue;
            };
            kernel.stages = kernel.stages.max(stage + 1);
            // Moves come for other operations' sake.
            if step.opcode().is_some() {
                at.entry(stage).or_insert(line);
            }
            let first = kernel.first.entry(line).or_insert((slot, stage));
            if (stage, slot) < (first.1, first.0) {
                *first = (slot, stage);
            }
        }
        kernel.at.push(at);
    }

    /// The variables that a step makes.
    fn named(&self, spec: &SimSpec, step: &Step) -> Vec<Name> {
        let found = || {
            let names = self
                .variables
                .names(spec.position(step.at)?, step.opcode()?);
            Some(names.to_vec())
        };
        found().unwrap_or_default()
    }

    /// Numbers the blocks of bundles. A call or a launch does not end one.
    fn find_blocks(&mut self, spec: &SimSpec) {
        let target = |bundle: &BundleSpec| match bundle.control {
            Some((Control::Jump(target) | Control::Branch { target, .. }, _)) => Some(target),
            _ => None,
        };
        let targets: BTreeSet<u32> = spec.bundles.iter().filter_map(target).collect();
        let mut block = 0;
        for (number, bundle) in (0..).zip(&spec.bundles) {
            block += u32::from(targets.contains(&number));
            self.blocks.push(block);
            let goes_on = matches!(
                bundle.control,
                None | Some((
                    Control::Call { .. } | Control::CallReg { .. } | Control::Launch(_),
                    _
                ))
            );
            block += u32::from(!goes_on);
        }
    }

    /// True if a bundle runs in the same pass through a block as the last one of its call.
    pub(crate) fn goes_on(&self, last: Option<u32>, number: u32) -> bool {
        let block = |number: u32| self.blocks.get(number as usize);
        last.is_some_and(|last| number == last + 1 && block(number) == block(last))
    }

    fn find_doubts(&mut self, spec: &SimSpec) {
        let mut makers: BTreeSet<(Name, Position)> = BTreeSet::new();
        for (number, (bundle, named)) in (0..).zip(spec.bundles.iter().zip(&self.bundle_names)) {
            for (step, names) in bundle.steps.iter().zip(named) {
                for &name in names {
                    let piece = &self.variables.pieces[name as usize];
                    let is_elsewhere = spec.function_of(number) != Some(piece.function.as_str());
                    let by = spec.position(step.at).and_then(|at| piece.set.by.get(at));
                    let why = if !makers.insert((name, step.at)) || is_elsewhere {
                        Some("its function was inlined or its code copied")
                    } else if by.is_none_or(|by| by.is_in_loop) {
                        Some("VLIW code sets it in a loop, and may be ahead by iterations")
                    } else {
                        piece.set.doubt()
                    };
                    self.doubts.extend(why.map(|why| (name, why)));
                }
            }
        }
    }

    /// The reason for which VLIW code does not tell the value of a variable.
    pub(crate) fn doubt(&self, name: Name) -> Option<&'static str> {
        let piece = &self.variables.pieces[name as usize];
        self.doubts.get(&name).copied().or(piece.set.doubt())
    }

    /// True if a variable is made from a bundle on, in its block, by a line before this.
    pub(crate) fn is_late(
        &self,
        spec: &SimSpec,
        from: u32,
        name: Name,
        (file, line): &(String, u32),
    ) -> bool {
        let from = from as usize;
        let Some(block) = self.blocks.get(from) else {
            return false;
        };
        let rest = self.blocks[from..].iter().take_while(|of| *of == block);
        let bundles = spec.bundles.iter().zip(&self.bundle_names).skip(from);
        let steps = bundles
            .take(rest.count())
            .flat_map(|(bundle, names)| bundle.steps.iter().zip(names));
        { steps }.any(|(step, names)| {
            let at = self.line(step.at).map(|line| &self.lines[line as usize]);
            names.contains(&name)
                && !self.is_step(step.at)
                && at.is_some_and(|at| at.0 == *file && at.1 < *line)
        })
    }

    /// True if some operation makes a variable of this name, or it is known without.
    pub(crate) fn knows(&self, name: &str) -> bool {
        let pieces = (0..).zip(&self.variables.pieces);
        let mut known = pieces.filter(|(_, piece)| piece.name == name);
        known.any(|(number, piece)| piece.constant.is_some() || self.made.contains(&number))
    }

    /// True if some operation makes it.
    pub(crate) fn makes(&self, name: Name) -> bool {
        self.made.contains(&name)
    }

    /// True if the position is in the step of a `for` loop.
    pub(crate) fn is_step(&self, at: Position) -> bool {
        self.steps.contains(&at)
    }

    /// The lines of a file with this number, or the next after it that has code. The file may be named by the end of
    /// its path.
    pub(crate) fn find(&self, file: &str, line: u32) -> Option<Line> {
        let is_file = |name: &str| {
            name == file
                || file.ends_with(&format!("/{name}"))
                || name.ends_with(&format!("/{file}"))
        };
        let found = (0..)
            .zip(&self.lines)
            .filter(|(_, (name, _))| is_file(name));
        let found = found.filter(|&(_, &(_, number))| number >= line);
        let nearest = found.min_by_key(|&(_, &(_, number))| number);
        nearest.map(|(line, _)| line)
    }
}

/// The cells of a kernel's live-ins.
fn live_ins(program: &Checked, schedule: &ModuloSchedule, spec: &SimSpec) -> Vec<u32> {
    let graph = ResourceGraph::of(&program.arch().srp);
    // The stores of the machine are its places, with the same numbers.
    let cell = |reg: &Reg| spec.stores[graph.file[reg.file].index()].base + reg.index;
    schedule.live_in_regs.iter().map(cell).collect()
}
