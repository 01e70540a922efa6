//! The lines that bundles and contexts belong to.

use super::model::Line;
use srp_archdesc::isa::{Class, Effect};
use srp_csimgen::Turn;
use srp_csimgen::spec::{BundleSpec, KernelSpec, Position, SimSpec, Step};
use std::collections::BTreeMap;

/// The lines of a program's parts.
pub(super) struct Lines {
    bundles: Vec<Line>,
    kernels: Vec<KernelLines>,
    /// The function of each bundle, by its index.
    functions: Vec<Option<usize>>,
    /// The lines of a bundle's or context's loads and texture samples.
    bundle_loads: Vec<Loads>,
    /// Cycles after which values are due that a core stands still for: loads', and texture samples'.
    due: [u32; 2],
}

/// The lines of a kernel.
struct KernelLines {
    own: Line,
    /// Lines of the operations of each context.
    contexts: Vec<Vec<Line>>,
    loads: Vec<Loads>,
    /// The function that launches it, by its index.
    launcher: Option<usize>,
}

/// The line of the first load, and of the first texture sample, of a cycle.
type Loads = [Option<Line>; 2];

impl Lines {
    /// The lines of a program. Values of loads and texture samples are due so many cycles after them that the core
    /// stands still then; 0 if it stands still at once.
    pub(super) fn of(spec: &SimSpec, load_due: u32, sample_due: u32) -> Lines {
        let mut bundles = Vec::with_capacity(spec.bundles.len());
        let mut functions = Vec::with_capacity(spec.bundles.len());
        let mut entries: Vec<(u32, usize)> = Vec::new();
        for (i, &(_, entry)) in spec.functions.iter().enumerate() {
            entries.push((entry, i));
        }
        entries.sort_unstable();
        let nowhere = (String::new(), 0);
        let mut before = nowhere.clone();
        for (number, bundle) in spec.bundles.iter().enumerate() {
            let number = number as u32;
            let at = entries.partition_point(|&(entry, _)| entry <= number);
            let function = at.checked_sub(1).map(|i| entries[i]);
            if function.is_some_and(|(entry, _)| entry == number) {
                before = nowhere.clone();
            }
            functions.push(function.map(|(_, i)| i));
            if let Some(line) = line_of_bundle(spec, bundle) {
                before = line;
            }
            bundles.push(before.clone());
        }
        let kernels = (spec.kernels.iter().enumerate())
            .map(|(number, kernel)| {
                let launch = |b: &BundleSpec| b.launches() == Some(number as u32);
                let launcher = spec.bundles.iter().position(launch);
                KernelLines::of(spec, kernel, launcher.and_then(|b| functions[b]))
            })
            .collect();
        let loads = |bundle: &BundleSpec| loads(spec, bundle.steps.iter());
        Lines {
            bundle_loads: spec.bundles.iter().map(loads).collect(),
            bundles,
            kernels,
            functions,
            due: [load_due, sample_due],
        }
    }

    pub(super) fn bundle_line(&self, bundle: u32) -> Line {
        self.bundles[bundle as usize].clone()
    }

    pub(super) fn loop_line(&self, kernel: usize) -> Line {
        self.kernels[kernel].own.clone()
    }

    /// The function of a bundle, by its index.
    pub(super) fn function(&self, bundle: u32) -> Option<usize> {
        self.functions[bundle as usize]
    }

    /// The function that launches a kernel, by its index.
    pub(super) fn launcher(&self, kernel: usize) -> Option<usize> {
        self.kernels[kernel].launcher
    }

    /// The line of the load, or else texture sample, that a core stands still for after a turn.
    pub(super) fn stalled(&self, turn: Turn, is_load: bool) -> Line {
        let which = usize::from(!is_load);
        self.issued(turn, which, self.due[which] as usize)
    }

    /// The line of the load, or else texture sample, of a turn.
    pub(super) fn asked(&self, turn: Turn, is_load: bool) -> Line {
        self.issued(turn, usize::from(!is_load), 0)
    }

    /// The line of the load or texture sample so many cycles before a turn.
    fn issued(&self, turn: Turn, which: usize, due: usize) -> Line {
        match turn {
            Turn::Bundle(bundle) => {
                let bundle = bundle as usize;
                // Where a branch has come between, the nearest one before is the best guess.
                let first = bundle.saturating_sub(due);
                let mut nearest = (0..=bundle).rev().skip(bundle - first);
                let load = nearest.find_map(|b| self.bundle_loads[b][which].clone());
                load.unwrap_or_else(|| self.bundles[bundle].clone())
            }
            Turn::Context { kernel, slot } => {
                let kernel = &self.kernels[kernel as usize];
                let ii = kernel.loads.len();
                let issued = slot as usize + ii * due.div_ceil(ii) - due;
                let mut nearest = (0..ii).map(|back| (issued + ii - back) % ii);
                let load = nearest.find_map(|slot| kernel.loads[slot][which].clone());
                load.unwrap_or_else(|| kernel.own.clone())
            }
        }
    }

    /// The cycles of a kernel's contexts, shared out over the lines of their operations; all together as many.
    pub(super) fn shares(&self, kernel: usize, contexts: &[u64]) -> BTreeMap<Line, u64> {
        let kernel = &self.kernels[kernel];
        let mut shares: BTreeMap<Line, u64> = BTreeMap::new();
        for (lines, &cycles) in kernel.contexts.iter().zip(contexts) {
            if lines.is_empty() {
                *shares.entry(kernel.own.clone()).or_default() += cycles;
            }
            // The i-th operation has the cycles up to its part of them, less those of the ones before.
            let count = lines.len() as u64;
            for (i, line) in (0..).zip(lines) {
                let up_to =
                    |i: u64| (u128::from(cycles) * u128::from(i) / u128::from(count)) as u64;
                *shares.entry(line.clone()).or_default() += up_to(i + 1) - up_to(i);
            }
        }
        shares
    }
}

impl KernelLines {
    fn of(spec: &SimSpec, kernel: &KernelSpec, launcher: Option<usize>) -> KernelLines {
        let own = line(spec, kernel.at).unwrap_or_default();
        let operations = |steps: &Vec<Step>| {
            let operations = steps.iter().filter(|step| step.opcode().is_some());
            operations
                .map(|step| line(spec, step.at).unwrap_or_else(|| own.clone()))
                .collect()
        };
        KernelLines {
            contexts: kernel.contexts.iter().map(operations).collect(),
            loads: (kernel.contexts.iter())
                .map(|steps| loads(spec, steps.iter()))
                .collect(),
            own,
            launcher,
        }
    }
}

fn line_of_bundle(spec: &SimSpec, bundle: &BundleSpec) -> Option<Line> {
    let control = bundle.control.iter().map(|&(_, at)| at);
    let places = bundle.steps.iter().map(|step| step.at).chain(control);
    places.filter_map(|at| line(spec, at)).next()
}

fn loads<'s>(spec: &SimSpec, steps: impl Iterator<Item = &'s Step> + Clone) -> Loads {
    [Class::Cload, Class::Tex].map(|class| {
        let is = |step: &&Step| {
            let info = step.opcode().map(|op| op.info());
            info.is_some_and(|info| info.class == class && info.effect == Effect::Load)
        };
        steps
            .clone()
            .filter(is)
            .find_map(|step| line(spec, step.at))
    })
}

/// The line of a position.
fn line(spec: &SimSpec, at: Position) -> Option<Line> {
    let mut parts = spec.position(at)?.rsplitn(3, ':').skip(1);
    let line = parts.next()?.parse().ok()?;
    Some((parts.next()?.to_owned(), line))
}
