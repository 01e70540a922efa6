//! The passes as data, and running them.

use super::rewrite::rewrite;
use super::*;
use crate::program::{Func, Function, Program};
use crate::verify::verify_functions;
use serde::Serialize;
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Ty};

/// Permissions to change results of floating-point arithmetic beyond what C allows. Each place
/// where a pass does so gets a [`Remark`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FastMath {
    /// Sums and products may be reassociated.
    pub associative: bool,
    /// Quotients may become products with reciprocals.
    pub reciprocal: bool,
    /// Products may be contracted into sums without rounding.
    pub contract: bool,
    /// Library functions may return the result of the special-function unit and ignore rare
    /// operands.
    pub approximate: bool,
}

/// How to optimise.
#[derive(Clone, Debug)]
pub struct Options {
    /// How exact the special functions of the machine are: constants are folded by them.
    pub precision: Precision,
    /// Permissions to change results.
    pub fast_math: FastMath,
    /// Bytes of a line of the data cache, where loops on the array are to ask for lines ahead.
    pub prefetch: Option<u32>,
    /// Expressions that are to be rewritten.
    pub rewrites: Vec<Rewrite>,
    /// Classes of operations that no unit runs, and for which functions of the program stand in.
    pub software: Vec<Class>,
    /// Values of each type, in the order of [`Ty::ALL`], that can wait in registers for a loop on the array.
    pub live_ins: [u32; Ty::ALL.len()],
}

impl Options {
    /// Options that keep to C, on a machine of this precision.
    pub const fn new(precision: Precision) -> Options {
        Options {
            precision,
            fast_math: FastMath {
                associative: false,
                reciprocal: false,
                contract: false,
                approximate: false,
            },
            prefetch: None,
            rewrites: Vec::new(),
            software: Vec::new(),
            live_ins: [16, 62, 32],
        }
    }
}

/// A step on the way from the form that a front end lowers to into the one that the machine runs.
#[derive(Debug)]
pub struct Pass {
    /// Its name in [`parse`] and on command lines.
    pub name: &'static str,
    /// Its purpose, in one sentence.
    pub what: &'static str,
    run: Run,
}

/// State shared by passes.
struct Context<'a> {
    options: &'a Options,
    /// True if the steps of special functions are in the program. Until then, one operation stands
    /// for all steps.
    refined: bool,
    stage: Stage,
    /// True if unrolling has made loops innermost ones.
    unrolled: bool,
    remarks: Vec<Remark>,
}

impl Context<'_> {
    /// True when the machine has units of all of these classes.
    fn has(&self, classes: &[Class]) -> bool {
        let software = &self.options.software;
        !classes.iter().any(|class| software.contains(class))
    }

    fn precision(&self) -> Precision {
        match self.refined {
            true => self.options.precision,
            false => self.options.precision.in_units(),
        }
    }
}

/// A pass says whether it may have changed what it was given.
#[derive(Debug)]
enum Run {
    Function(fn(&mut Function, &mut Context<'_>) -> bool),
    Program(fn(&mut Program, &mut Context<'_>) -> bool),
    /// Passes on functions, again and again until a function stays as it is.
    Repeat(&'static [&'static str]),
}

/// Rounds of a repeated group, at most: each may make the next possible.
const MAX_ROUNDS: u32 = 8;

/// Repeats the first group of [`STANDARD`] on a function that is only tried: its remarks go.
fn simplify(func: &mut Function, context: &mut Context<'_>) {
    let Some(Run::Repeat(names)) = pass("simplify").map(|group| &group.run) else {
        unreachable!("it is a group")
    };
    let told = context.remarks.len();
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for pass in names.iter().filter_map(|name| pass(name)) {
            if let Run::Function(run) = &pass.run {
                changed |= run(func, context);
            }
        }
        if !changed {
            break;
        }
    }
    context.remarks.truncate(told);
}

/// All passes.
pub const PASSES: &[Pass] = &[
    Pass {
        name: "simplify",
        what: "Repeats cfg, fold, mem2reg, copyprop, gvn and dce until a function stays as it is.",
        run: Run::Repeat(&["cfg", "fold", "mem2reg", "copyprop", "gvn", "dce"]),
    },
    Pass {
        name: "cfg",
        what: "Joins blocks, removes those that are never reached, and unrolls loops that a pragma marks.",
        run: Run::Function(|f, context| {
            let nests = match context.stage {
                Stage::Whole => Nests::Merge,
                Stage::Control => Nests::Keep,
            };
            simplify_cfg(f, nests, &mut context.remarks)
        }),
    },
    Pass {
        name: "fold",
        what: "Computes what is known, and replaces operations by cheaper ones with the same result.",
        run: Run::Function(|f, context| fold(f, &context.precision(), context.stage)),
    },
    Pass {
        name: "mem2reg",
        what: "Keeps variables in values whose addresses nobody takes.",
        run: Run::Function(|f, _| mem2reg(f)),
    },
    Pass {
        name: "copyprop",
        what: "Removes parameters of blocks that always bring the same value.",
        run: Run::Function(|f, _| copyprop(f)),
    },
    Pass {
        name: "gvn",
        what: "Computes once what is computed several times.",
        run: Run::Function(|f, _| gvn(f)),
    },
    Pass {
        name: "dce",
        what: "Removes what nobody uses.",
        run: Run::Function(|f, _| dce(f)),
    },
    Pass {
        name: "dead-loops",
        what: "Removes loops that do nothing and certainly end.",
        run: Run::Function(|f, context| dead_loops(f, &context.precision())),
    },
    Pass {
        name: "dead-stores",
        what: "Removes stores that others of their block overwrite before anything reads them.",
        run: Run::Function(|f, _| dead_stores(f)),
    },
    Pass {
        name: "rewrite",
        what: "Rewrites floating-point expressions by the rules and on the lines that are asked for.",
        run: Run::Program(|program, context| {
            rewrite(program, &context.options.rewrites, &mut context.remarks)
        }),
    },
    Pass {
        name: "software",
        what: "Calls functions for operations that no unit of the machine runs.",
        run: Run::Program(|program, context| {
            software(program, &context.options.software, &mut context.remarks)
        }),
    },
    Pass {
        name: "inline",
        what: "Puts functions in the place of their calls: small ones, and all that kernel loops call.",
        run: Run::Program(|program, context| {
            context.remarks.extend(inline(program));
            true
        }),
    },
    Pass {
        name: "copies",
        what: "Writes out copies of a small, constant number of bytes.",
        run: Run::Program(|program, _| copies(program)),
    },
    Pass {
        name: "constants",
        what: "Computes loads of globals that nothing writes.",
        run: Run::Program(|program, _| constants(program)),
    },
    Pass {
        name: "inline-kernels",
        what: "Puts functions in the place of their calls in loops that have become kernels by unrolling.",
        run: Run::Program(|program, context| {
            if !context.unrolled {
                return false;
            }
            let remarks = inline(program);
            context.remarks.retain(|r| r.pass != "inline");
            context.remarks.extend(remarks);
            true
        }),
    },
    Pass {
        name: "unroll",
        what: "Unrolls short loops of constant counts in loops that can run on the array without them.",
        run: Run::Program(|program, context| {
            let (precision, live_ins) = (context.precision(), context.options.live_ins);
            let mut simplify = |f: &mut Function| simplify(f, context);
            context.unrolled = unroll(program, &precision, live_ins, &mut simplify);
            context.unrolled
        }),
    },
    Pass {
        name: "unnest",
        what: "Forgets the marks of loops that still have loops inside them.",
        run: Run::Function(|f, _| unnest(f)),
    },
    Pass {
        name: "reciprocal-math",
        what: "Makes quotients products with reciprocals, where that is allowed.",
        run: Run::Function(|f, context| {
            context.has(&[Class::Sfu, Class::Fmul])
                && context.options.fast_math.reciprocal
                && reciprocal(f, &mut context.remarks)
        }),
    },
    Pass {
        name: "refine",
        what: "Adds Newton's steps to special functions that the machine leaves to code.",
        run: Run::Function(|f, context| {
            context.refined = true;
            refine(f, &context.options.precision)
        }),
    },
    Pass {
        name: "widen",
        what: "Takes counters of narrow types for words where their test keeps them in range.",
        run: Run::Function(|f, _| widen_counters(f)),
    },
    Pass {
        name: "licm",
        what: "Moves out of loops what is the same in every iteration.",
        run: Run::Program(|program, _| {
            let Program { globals, funcs, .. } = program;
            let changed = funcs.values_mut().map(|f| licm(f, globals));
            changed.fold(false, |any, changed| any | changed)
        }),
    },
    Pass {
        name: "promote",
        what: "Keeps words of memory in values while a kernel loop runs.",
        run: Run::Program(|program, _| {
            let Program { globals, funcs, .. } = program;
            let changed = funcs.values_mut().map(|f| promote(f, globals));
            changed.fold(false, |any, changed| any | changed)
        }),
    },
    Pass {
        name: "ifconvert",
        what: "Makes branches in kernel loops selections and guarded accesses.",
        run: Run::Program(|program, context| {
            let Program { funcs, globals, .. } = program;
            for func in funcs.values_mut() {
                context.remarks.extend(ifconvert(func, globals));
            }
            true
        }),
    },
    Pass {
        name: "low-bits",
        what: "Leaves out extensions of narrow types that only low bits come through, in recurrences first.",
        run: Run::Function(|f, _| low_bits(f)),
    },
    Pass {
        name: "associative-math",
        what: "Associates sums and products for shorter recurrences, where that is allowed.",
        run: Run::Function(|f, context| {
            context.options.fast_math.associative && reassociate(f, &mut context.remarks)
        }),
    },
    Pass {
        name: "recurrences",
        what: "Takes what a loop carries last in its integer operations, and selects before it, so that its recurrences get shorter.",
        run: Run::Function(|f, context| {
            shorten_recurrences(f, &context.precision(), context.has(&[Class::Imul]))
        }),
    },
    Pass {
        name: "fp-contract",
        what: "Lets sums take in products without rounding them, where that is allowed.",
        run: Run::Function(|f, context| {
            context.has(&[Class::Fma, Class::Vfma])
                && context.options.fast_math.contract
                && contract(f, &mut context.remarks)
        }),
    },
    Pass {
        name: "prefetch",
        what: "Asks for lines of system memory ahead in kernel loops, where that is wanted.",
        run: Run::Function(|f, context| {
            let line = context.options.prefetch;
            line.is_some_and(|line| prefetch(f, line))
        }),
    },
    Pass {
        name: "strength",
        what: "Counts addresses of loops up instead of computing them anew.",
        run: Run::Function(|f, _| strength(f)),
    },
    Pass {
        name: "write-out",
        what: "Writes out loops of control code that run a small, constant number of times.",
        run: Run::Function(|f, context| write_out_loops(f, &context.precision())),
    },
    Pass {
        name: "short-ways",
        what: "Makes loops of the ways through loops of control code that run no loop inside.",
        run: Run::Function(|f, _| short_ways(f)),
    },
    Pass {
        name: "carry",
        what: "Brings what a loop has loaded to the next iteration, where that loads it again.",
        run: Run::Function(|f, _| carry(f)),
    },
    Pass {
        name: "forward",
        what: "Brings what a kernel has stored to the next iteration, where that loads it.",
        run: Run::Function(|f, _| forward(f)),
    },
    Pass {
        name: "hyperblock",
        what: "Joins blocks of control code under predicates where that takes less than the branch.",
        run: Run::Function(|f, context| hyperblocks(f, context.stage)),
    },
    Pass {
        name: "replicate",
        what: "Unrolls loops of control code that are one block.",
        run: Run::Function(|f, context| replicate(f, &context.precision())),
    },
    Pass {
        name: "addresses",
        what: "Puts the constants of addresses last, where they go into the access.",
        run: Run::Function(|f, _| addresses(f)),
    },
    Pass {
        name: "balance",
        what: "Takes the operands of associative integer operations in the order in which they come.",
        run: Run::Function(|f, _| balance(f)),
    },
    Pass {
        name: "compact",
        what: "Numbers what is left without gaps.",
        run: Run::Function(|f, _| {
            compact(f);
            false
        }),
    },
];

/// The pass with this name.
pub fn pass(name: &str) -> Option<&'static Pass> {
    PASSES.iter().find(|pass| pass.name == name)
}

/// The passes of a list of names with commas between them; `standard` stands for those of
/// [`optimise`].
///
/// # Errors
///
/// The name that no pass has.
pub fn parse(list: &str) -> Result<Vec<&'static Pass>, String> {
    let names = list
        .split(',')
        .map(str::trim)
        .filter(|name| !name.is_empty());
    let names = names.flat_map(|name| match name {
        "standard" => STANDARD.to_vec(),
        name => vec![name],
    });
    names
        .map(|name| pass(name).ok_or_else(|| name.to_owned()))
        .collect()
}

/// Brings a verified program from the form that a front end lowers to into the one that the
/// machine runs: no calls and no branches in kernel loops, variables in registers, nothing twice.
/// Returns the remarks, each once, in the order of the sources.
pub fn optimise(program: &mut Program, options: &Options) -> Vec<Remark> {
    run(program, &standard(), options, &mut |_, _| {})
}

/// Makes the control code of a divided program fit the VLIW engine: fewer branches, and more operations
/// beside each other.
pub fn optimise_control(program: &mut Program, options: &Options) {
    let passes = CONTROL.iter().map(|name| pass(name));
    let passes: Vec<&Pass> = passes.map(|p| p.expect("it is in the table")).collect();
    let remarks = run_on(program, &passes, options, Stage::Control, &mut |_, _| {});
    debug_assert_eq!(remarks, [], "control code has no marks to speak of");
}

/// The passes of [`optimise`].
pub fn standard() -> Vec<&'static Pass> {
    let passes = STANDARD.iter().map(|name| pass(name));
    passes.map(|p| p.expect("it is in the table")).collect()
}

/// Runs some passes. `after` sees the program after each of them, those of a repeated group too.
pub fn run(
    program: &mut Program,
    passes: &[&Pass],
    options: &Options,
    after: &mut dyn FnMut(&Pass, &Program),
) -> Vec<Remark> {
    run_on(program, passes, options, Stage::Whole, after)
}

/// Runs some passes on a program at a stage.
fn run_on(
    program: &mut Program,
    passes: &[&Pass],
    options: &Options,
    stage: Stage,
    after: &mut dyn FnMut(&Pass, &Program),
) -> Vec<Remark> {
    let mut runner = Runner {
        context: Context {
            options,
            refined: stage == Stage::Control,
            stage,
            unrolled: false,
            remarks: Vec::new(),
        },
        settled: EntityMap::new(),
        touched: Touched::Functions(Vec::new()),
        after,
    };
    passes.iter().for_each(|pass| runner.run(program, pass));
    let mut remarks = runner.context.remarks;
    remarks.sort();
    remarks.dedup();
    remarks
}

/// The parts of the program that may have changed since the last check.
enum Touched {
    Functions(Vec<Func>),
    Everything,
}

struct Runner<'a, 'f> {
    context: Context<'a>,
    touched: Touched,
    /// For each function the name of the repeated group after which it has not been changed.
    settled: EntityMap<Func, Option<&'static str>>,
    after: &'f mut dyn FnMut(&Pass, &Program),
}

impl Runner<'_, '_> {
    fn run(&mut self, program: &mut Program, pass: &Pass) {
        if self.settled.len() != program.funcs.len() {
            self.settled = EntityMap::filled(program.funcs.len(), None);
        }
        match &pass.run {
            Run::Function(_) => {
                for func in program.funcs.keys() {
                    if self.apply(pass, program, func) {
                        self.settled[func] = None;
                    }
                }
            }
            Run::Program(run) => {
                if run(program, &mut self.context) {
                    self.settled = EntityMap::filled(program.funcs.len(), None);
                    self.touched = Touched::Everything;
                }
            }
            Run::Repeat(names) => self.repeat(program, pass.name, names),
        }
        self.finish(pass, program);
    }

    /// Runs a group on every function until it stays as it is, round by round.
    fn repeat(&mut self, program: &mut Program, group: &'static str, names: &[&str]) {
        let open =
            |(func, settled): (Func, &Option<&str>)| (*settled != Some(group)).then_some(func);
        let mut open: Vec<Func> = self.settled.iter().filter_map(open).collect();
        for _ in 0..MAX_ROUNDS {
            let mut changed: EntityMap<Func, bool> = EntityMap::filled(program.funcs.len(), false);
            for name in names {
                let pass = pass(name).expect("groups consist of passes");
                for &func in &open {
                    changed[func] |= self.apply(pass, program, func);
                }
                self.finish(pass, program);
            }
            for &func in open.iter().filter(|func| !changed[**func]) {
                self.settled[func] = Some(group);
            }
            open.retain(|func| changed[*func]);
            if open.is_empty() {
                break;
            }
        }
    }

    fn apply(&mut self, pass: &Pass, program: &mut Program, func: Func) -> bool {
        let changed = match &pass.run {
            Run::Function(run) => run(&mut program.funcs[func], &mut self.context),
            Run::Program(_) | Run::Repeat(_) => {
                unreachable!("groups consist of passes on functions")
            }
        };
        if let (true, Touched::Functions(touched)) = (changed, &mut self.touched) {
            touched.push(func);
        }
        changed
    }

    /// Verifies, in a debug build, what a pass has changed, and shows the program.
    fn finish(&mut self, pass: &Pass, program: &Program) {
        let touched = std::mem::replace(&mut self.touched, Touched::Functions(Vec::new()));
        if cfg!(debug_assertions) {
            let verified = match touched {
                Touched::Functions(funcs) => verify_functions(program, funcs.into_iter()),
                Touched::Everything => crate::verify(program),
            };
            assert_eq!(verified, Ok(()), "after {}", pass.name);
        }
        (self.after)(pass, program);
    }
}
