//! What a program's tables say of its source: the lines of bundles and contexts, and the variables of their steps.

use crate::variables::Variables;
use srp_csimgen::SimSpec;
use srp_csimgen::spec::{BundleSpec, Control, Position, Step};
use std::collections::BTreeMap;

/// A line, by its number in [`Code`].
pub(crate) type Line = u32;

/// A variable's name, by its number in [`Code`].
pub(crate) type Name = u32;

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
    pub(crate) bundle_names: Vec<Vec<Option<Name>>>,
    pub(crate) kernels: Vec<KernelCode>,
    /// The names of variables.
    pub(crate) names: Vec<String>,
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
    /// The variables of the steps of each slot.
    pub(crate) names: Vec<Vec<Option<Name>>>,
    /// Its stages.
    pub(crate) stages: u32,
}

impl Code {
    /// The source behind these tables.
    pub(crate) fn of(spec: &SimSpec, variables: &Variables) -> Code {
        let mut code = Code::default();
        code.find_lines(spec);
        let mut names = BTreeMap::new();
        for bundle in &spec.bundles {
            let lines = code.lines_of(bundle);
            code.bundles.push(lines);
            let named = code.named(spec, &bundle.steps, variables, &mut names);
            code.bundle_names.push(named);
        }
        for kernel in &spec.kernels {
            let mut of_kernel = KernelCode::default();
            for (slot, steps) in (0..).zip(&kernel.contexts) {
                code.add_slot(&mut of_kernel, slot, steps);
                let named = code.named(spec, steps, variables, &mut names);
                of_kernel.names.push(named);
            }
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
        for at in &spec.positions {
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

    fn named(
        &mut self,
        spec: &SimSpec,
        steps: &[Step],
        variables: &Variables,
        numbers: &mut BTreeMap<String, Name>,
    ) -> Vec<Option<Name>> {
        let mut name = |step: &Step| {
            let name = variables.name(spec.position(step.at)?, step.opcode()?)?;
            let next = self.names.len() as Name;
            let number = *numbers.entry(name.to_owned()).or_insert(next);
            if number == next {
                self.names.push(name.to_owned());
            }
            Some(number)
        };
        steps.iter().map(&mut name).collect()
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
