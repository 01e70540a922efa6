//! A program's machine code: where it lies in system memory, and how it comes to the engines of a core.
//!
//! Without an instruction cache the VLIW engine has its code in a memory of its own, and where kernels do not share the
//! configuration memory, all their contexts are there from the start: nothing is waited for. Else both kinds of code lie
//! behind the scene, contexts first. A bundle whose lines are not in the instruction cache, and a launch of a kernel
//! whose contexts are not in the configuration memory, freeze the whole core after their cycle until the last of the
//! missing bytes is there.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::ops::Range;

use schemars::JsonSchema;
use srp_archdesc::ResourceGraph;
use srp_archdesc::arch::Arch;
use srp_archdesc::chip;
use srp_archdesc::system::CacheSpec;

use super::error::SystemError;
use crate::memory::cache::{Access, Cache, CacheCounters};
use crate::sums::sums;

/// Code begins at a multiple of this behind the scene.
const ALIGNMENT: u64 = 4096;

/// Bytes of a request for contexts.
const BURST: u32 = 64;

/// A memory of machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum CodeMemory {
    /// The instruction cache.
    Instructions,
    /// The configuration memory.
    Contexts,
}

/// The sizes of a program's code.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CodeSizes {
    /// Bytes of each bundle of VLIW code.
    pub bundles: Vec<u32>,
    /// Contexts of each kernel.
    pub contexts: Vec<u32>,
}

/// A program's code in system memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct CodeLayout {
    /// Where each bundle begins, and where the last one ends.
    bundles: Vec<u32>,
    /// Where each kernel's contexts begin, and where the last ones end.
    kernels: Vec<u32>,
    /// Contexts of each kernel.
    contexts: Vec<u32>,
}

impl CodeLayout {
    /// Lays out code behind a scene that ends at this address.
    ///
    /// # Errors
    ///
    /// The machine fetches code, and there are no addresses left for it.
    pub(super) fn behind(
        scene_end: u64,
        sizes: &CodeSizes,
        arch: &Arch,
    ) -> Result<CodeLayout, SystemError> {
        let graph = ResourceGraph::of(&arch.srp);
        let context_bytes = u64::from(chip::all_context_bits(&arch.srp, &graph).div_ceil(8));
        let mut at = scene_end.next_multiple_of(ALIGNMENT);
        let mut places = |sizes: &mut dyn Iterator<Item = u64>, alignment| {
            let mut starts = Vec::new();
            for size in sizes {
                at = at.next_multiple_of(alignment);
                starts.push(at);
                at += size;
            }
            starts.push(at);
            starts
        };
        let of_kernels = sizes.contexts.iter();
        let kernels = places(
            &mut of_kernels.map(|&n| u64::from(n) * context_bytes),
            u64::from(BURST),
        );
        let bundles = places(&mut sizes.bundles.iter().map(|&n| u64::from(n)), 1);
        let is_fetched = arch.system.instruction_cache.is_some() || arch.srp.shared_contexts;
        if is_fetched && at > u64::from(u32::MAX) {
            return Err(SystemError::Machine(
                "no addresses are left behind the scene for the program's code".to_owned(),
            ));
        }
        let addresses = |places: Vec<u64>| places.into_iter().map(|at| at as u32).collect();
        Ok(CodeLayout {
            bundles: addresses(bundles),
            kernels: addresses(kernels),
            contexts: sizes.contexts.clone(),
        })
    }
}

/// Counts of a configuration memory that kernels share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ContextCounters {
    /// Launches of kernels.
    pub launches: u64,
    /// Launches whose contexts were not there.
    pub loads: u64,
    /// Bytes of those.
    pub bytes: u64,
}

sums!(ContextCounters: launches loads bytes);

/// The instruction cache of a VLIW engine.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Instructions {
    cache: Cache,
    line: u32,
    /// The number of the line that the engine has read last: it reads on there without another access.
    current: Option<u32>,
    /// Lines that are waited for.
    missing: u32,
}

/// The configuration memory of an array.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Contexts {
    depth: u32,
    /// The kernels that are there, the one launched last first.
    kernels: Vec<u32>,
    counters: ContextCounters,
    /// Requests that are waited for.
    missing: u32,
}

/// The code of one core.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Code {
    instructions: Option<Instructions>,
    contexts: Option<Contexts>,
    /// Requests to be sent: for whom, address and bytes.
    requests: VecDeque<(CodeMemory, u32, u32)>,
    /// True if lines are there as soon as they are asked for.
    immediate: bool,
}

impl Code {
    /// The code of a core that has fetched nothing.
    pub(super) fn new(arch: &Arch, immediate: bool) -> Code {
        let instructions = arch.system.instruction_cache.map(|spec| Instructions {
            // A bundle may lie in many lines, which are asked for together.
            cache: Cache::new(&CacheSpec {
                misses: u16::MAX.into(),
                ..spec
            }),
            line: spec.line,
            current: None,
            missing: 0,
        });
        let contexts = arch.srp.shared_contexts.then(|| Contexts {
            depth: arch.srp.contexts,
            kernels: Vec::new(),
            counters: ContextCounters::default(),
            missing: 0,
        });
        Code {
            instructions,
            contexts,
            requests: VecDeque::new(),
            immediate,
        }
    }

    /// Reads a bundle: the bundles that lie whole in the line where it ends, and can be read without asking.
    pub(super) fn fetch(&mut self, bundle: u32, layout: &CodeLayout) -> Range<u32> {
        let Some(instructions) = &mut self.instructions else {
            return 0..u32::MAX;
        };
        let starts = &layout.bundles;
        let Some(&[start, end]) = starts.get(bundle as usize..).and_then(<[u32]>::first_chunk)
        else {
            return 0..u32::MAX;
        };
        let line = instructions.line;
        let [first, last] = [start / line, (end - 1) / line];
        if (first, Some(first)) != (last, instructions.current) {
            instructions.current = Some(last);
            let is_missing = |&number: &u32| instructions.cache.access(number) == Access::Miss;
            let missing: Vec<u32> = (first..=last).filter(is_missing).collect();
            instructions.missing += missing.len() as u32;
            for number in missing {
                self.ask(CodeMemory::Instructions, number * line, line);
            }
        }
        let line_end = (last + 1) * line;
        let from = starts.partition_point(|&start| start < last * line);
        let upto = starts.partition_point(|&start| start <= line_end);
        // The last of these starts is the end of the bundle before.
        from as u32..(upto as u32).saturating_sub(1)
    }

    /// Asks the memory for bytes.
    fn ask(&mut self, memory: CodeMemory, address: u32, bytes: u32) {
        self.requests.push_back((memory, address, bytes));
        if self.immediate {
            self.fill(memory, address);
        }
    }

    /// A kernel is launched.
    pub(super) fn launch(&mut self, kernel: u32, layout: &CodeLayout) {
        let Some(contexts) = &mut self.contexts else {
            return;
        };
        let number = kernel as usize;
        let Some(&[start, end]) = (layout.kernels.get(number..)).and_then(<[u32]>::first_chunk)
        else {
            return;
        };
        contexts.counters.launches += 1;
        let place = contexts.kernels.iter().position(|&there| there == kernel);
        match place {
            Some(place) => contexts.kernels[..=place].rotate_right(1),
            None => {
                contexts.kernels.insert(0, kernel);
                let depth = |kernels: &[u32]| -> u64 {
                    let of = |&kernel: &u32| u64::from(layout.contexts[kernel as usize]);
                    kernels.iter().map(of).sum()
                };
                while contexts.kernels.len() > 1
                    && depth(&contexts.kernels) > u64::from(contexts.depth)
                {
                    contexts.kernels.pop();
                }
                contexts.counters.loads += 1;
                contexts.counters.bytes += u64::from(end - start);
                contexts.missing += (end - start).div_ceil(BURST);
                for address in (start..end).step_by(BURST as usize) {
                    self.ask(CodeMemory::Contexts, address, BURST.min(end - address));
                }
            }
        }
    }

    /// A line or burst at an address arrives.
    pub(super) fn fill(&mut self, memory: CodeMemory, address: u32) {
        if memory == CodeMemory::Contexts {
            if let Some(contexts) = &mut self.contexts {
                contexts.missing = contexts.missing.saturating_sub(1);
            }
        } else if let Some(instructions) = &mut self.instructions {
            instructions.cache.fill(address / instructions.line);
            instructions.missing = instructions.missing.saturating_sub(1);
        }
    }

    /// The memory that the core has to stand still for.
    pub(super) fn waits(&self) -> Option<CodeMemory> {
        let instructions = self.instructions.as_ref().is_some_and(|i| i.missing > 0);
        let contexts = self.contexts.as_ref().is_some_and(|c| c.missing > 0);
        match (instructions, contexts) {
            (true, _) => Some(CodeMemory::Instructions),
            (_, true) => Some(CodeMemory::Contexts),
            _ => None,
        }
    }

    /// The next request to be sent: for whom, address and bytes.
    #[inline]
    pub(super) fn take_request(&mut self) -> Option<(CodeMemory, u32, u32)> {
        self.requests.pop_front()
    }

    /// Counts of the instruction cache, where there is one.
    pub(super) fn instruction_counters(&self) -> Option<CacheCounters> {
        Some(self.instructions.as_ref()?.cache.counters)
    }

    /// Counts of the configuration memory, where kernels share it.
    pub(super) fn context_counters(&self) -> Option<ContextCounters> {
        Some(self.contexts.as_ref()?.counters)
    }
}
