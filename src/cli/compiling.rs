//! The command lines of what compiles programs: `srp compile`, `srp run`, `srp report`.

use super::{Checkpoints, Choice, MachineFile, Search, Trace, one_of};
use crate::failure::Failure;
use crate::limits;
use clap::{Args, ValueEnum};
use srp_ir::pass::{self, FastMath, Rewrite, Rule};
use srp_toolchain::{Options, Warnings};
use std::path::PathBuf;

/// For which machine, how C is compiled, and how hard loops are scheduled.
#[derive(Args)]
pub(crate) struct Compilation {
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    #[command(flatten)]
    pub(crate) source: Source,
    #[command(flatten)]
    pub(crate) search: Search,
}

/// Where the report of the loops goes, beside what a command is for.
#[derive(Args)]
pub(crate) struct Loops {
    /// Write what `srp report` says of every loop too: JSON, or a page (.html) or text (.txt) by FILE's name
    #[arg(long, value_name = "FILE")]
    pub(crate) loops: Vec<PathBuf>,
}

/// How C is compiled.
#[derive(Args)]
pub(crate) struct Source {
    /// Folder to look for included files in, after that of the including file
    #[arg(short = 'I', value_name = "DIR")]
    pub(crate) include: Vec<PathBuf>,
    /// Define a macro
    #[arg(short = 'D', value_name = "NAME[=VALUE]", value_parser = parse_define)]
    pub(crate) define: Vec<String>,
    /// Put only loops with `#pragma srp kernel` on the array
    #[arg(long)]
    pub(crate) no_auto_kernel: bool,
    /// What `double` is: binary64 in software, or `float`
    #[arg(long, value_name = "DOUBLE", default_value = "soft", value_parser = one_of(DOUBLES), action = clap::ArgAction::Set)]
    pub(crate) double: bool,
    /// `no-auto-kernel`, as the option of that name; `single-precision-constant`: constants without
    /// suffix are floats; `associative-math`: floating-point sums and products in any order;
    /// `reciprocal-math`: quotients as products with reciprocals; `fp-contract=fast`: sums that take in
    /// a product without rounding it; `approx-func`: functions of math.h as the special-function unit
    /// gives them; `fast-math`: all four. `-R pass` tells each place that changes a result
    #[arg(short = 'f', value_name = "FEATURE", value_enum)]
    pub(crate) feature: Vec<Feature>,
    /// Compute each reciprocal, root and quotient by the cheapest unit of the machine whose results are off by
    /// at most N units in the last place; `#pragma srp precision` overrides it in its loop
    #[arg(long, value_name = "N", value_parser = ulp)]
    pub(crate) max_ulp: Option<f64>,
    /// Rewrite what a rule fits on a line, though rounding then differs: `srp accuracy FILE.c` finds the places and
    /// measures each. Several are possible
    #[arg(long, value_name = "RULE@[FILE:]LINE", value_parser = Rewrite::parse, long_help = rewrite_help())]
    pub(crate) rewrite: Vec<Rewrite>,
    /// Warnings: NAME, no-NAME, error, error=NAME, no-error=NAME, none
    #[arg(short = 'W', value_name = "NAME")]
    pub(crate) warnings: Vec<String>,
    /// Remarks: `pass` says of every loop whether it runs on the array, what stands in the way, and what
    /// `restrict` would buy
    #[arg(short = 'R', value_name = "KIND", value_enum)]
    pub(crate) remarks: Vec<RemarkKind>,
    /// How messages are written: for people, or one JSON object a line in rustc's shape
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = ErrorFormat::Human)]
    pub(crate) error_format: ErrorFormat,
}

/// What `-R` asks for.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RemarkKind {
    /// Loops on the array, loops that are not, and accesses that `restrict` would let overlap
    Pass,
}

/// How messages are written.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ErrorFormat {
    /// With the lines of the text and carets
    Human,
    /// One object a line
    Json,
}

/// What `double` is: whether it is `float`.
pub(super) const DOUBLES: &[Choice<bool>] = &[
    Choice {
        value: false,
        name: "soft",
        what: "Binary64, by functions of the library",
    },
    Choice {
        value: true,
        name: "float",
        what: "The same as `float`; each use is told",
    },
];

/// What `-f` asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Feature {
    /// Put only loops with `#pragma srp kernel` on the array
    NoAutoKernel,
    /// Floating constants without suffix are floats; each is told
    SinglePrecisionConstant,
    /// Sums and products of floating-point numbers may be associated otherwise
    AssociativeMath,
    /// x / y may be x * (1/y), by the machine's reciprocal
    ReciprocalMath,
    /// a * b + c may be a fused multiply-add
    #[value(name = "fp-contract=fast")]
    ContractFast,
    /// It may not, as if nothing were said
    #[value(name = "fp-contract=off")]
    ContractOff,
    /// Functions of math.h may be what the special-function unit gives
    ApproxFunc,
    /// Loops on the array ask for lines of system memory some iterations ahead
    PrefetchLoopArrays,
    /// All of associative-math, reciprocal-math, fp-contract=fast and approx-func
    FastMath,
}

/// What some features allow that may change results.
pub(crate) fn fast_math(features: &[Feature]) -> FastMath {
    let contract = |f: &&Feature| matches!(f, Feature::ContractFast | Feature::ContractOff);
    let has = |feature| features.contains(&feature) || features.contains(&Feature::FastMath);
    let contracts = match features.iter().rfind(contract) {
        Some(last) => *last == Feature::ContractFast,
        None => features.contains(&Feature::FastMath),
    };
    FastMath {
        associative: has(Feature::AssociativeMath),
        reciprocal: has(Feature::ReciprocalMath),
        contract: contracts,
        approximate: has(Feature::ApproxFunc),
    }
}

/// The help of `--rewrite`, with the rules.
pub(crate) fn rewrite_help() -> String {
    let rules = Rule::ALL.map(|rule| format!("\n  {:19} {}", rule.name(), rule.what()));
    format!(
        "Rewrite what a rule fits on a line, though rounding then differs: `srp accuracy FILE.c` finds the places and \
         measures each. Several are possible. Rules:{}",
        rules.concat()
    )
}

/// A number of units in the last place, at least 1.
fn ulp(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|&n: &f64| n >= 1.0 && n.is_finite());
    number
        .ok_or_else(|| "a number of 1 or more is wanted: no unit is known to be nearer".to_owned())
}

/// The name and the value of a macro of the command line.
pub(super) fn define(text: &str) -> (String, String) {
    let (name, value) = text.split_once('=').unwrap_or((text, "1"));
    (name.to_owned(), value.to_owned())
}

pub(super) fn parse_define(text: &str) -> Result<String, String> {
    let (name, _) = define(text);
    let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let mut letters = name.chars();
    match letters.next().is_some_and(is_letter)
        && letters.all(|c| is_letter(c) || c.is_ascii_digit())
    {
        true => Ok(text.to_owned()),
        false => Err("write NAME or NAME=VALUE, where NAME is one of C".to_owned()),
    }
}

impl Compilation {
    /// How C is compiled, and its loops are scheduled.
    pub(crate) fn options(&self) -> Result<Options, Failure> {
        let source = &self.source;
        let has = |feature| source.feature.contains(&feature);
        Ok(Options {
            include: source.include.clone(),
            outside: limits::outside(),
            defines: source.define.iter().map(|text| define(text)).collect(),
            auto_kernel: !source.no_auto_kernel && !has(Feature::NoAutoKernel),
            double_is_float: source.double,
            single_constants: has(Feature::SinglePrecisionConstant),
            fast_math: fast_math(&source.feature),
            prefetch: has(Feature::PrefetchLoopArrays),
            max_ulp: source.max_ulp,
            rewrites: source.rewrite.clone(),
            warnings: Warnings::parse(&source.warnings).map_err(Failure::Usage)?,
            effort: self.search.effort(),
        })
    }
}

impl Source {
    /// Whether every loop is to be remarked on.
    pub(crate) fn remarks_passes(&self) -> bool {
        self.remarks.contains(&RemarkKind::Pass)
    }
}

/// What runs a program.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RunEngine {
    /// A generated simulator if it is compiled already; else the interpreter begins, and gives way to a
    /// simulator that is compiled beside it
    Auto,
    /// A simulator generated for the program and compiled by rustc
    Csim,
    /// The interpreter of the same tables
    Interp,
    /// The meaning of the intermediate form: no machine, no cycles
    Ir,
}

/// Forms of a program.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// The syntax tree
    Ast,
    /// The intermediate form, after the passes
    Ir,
    /// The dataflow graph of each kernel, for Graphviz
    Dfg,
    /// The program divided between VLIW engine and array, XML; no schedules are looked for
    Dre,
    /// The scheduled program, XML
    Schedule,
    /// The generated simulator
    Rust,
}

/// `srp compile`
#[derive(Args)]
#[command(after_help = "\
The files may be C, or one file of a later form (.ir, .dre.xml, .sched.xml), from which compilation goes on.

Examples:
  srp compile kernels/secondary.c -I kernels --emit ast,ir,dfg,dre,schedule,rust -o build
  srp compile build/secondary.dre.xml --machine wide --emit schedule -o build
  srp compile kernels/secondary.c -I kernels --emit ir --passes simplify,inline --print-after gvn")]
pub(crate) struct Compile {
    /// C files, or one file of a later form
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) compilation: Compilation,
    #[command(flatten)]
    pub(crate) loops: Loops,
    /// Forms to write
    #[arg(long, value_enum, value_delimiter = ',', default_value = "schedule")]
    pub(crate) emit: Vec<Form>,
    /// Folder to write them into
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) passes: Passes,
    /// Print the seconds of each stage and loop on this host, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Which passes run over the intermediate form, and what is shown of them.
#[derive(Args)]
pub(crate) struct Passes {
    #[arg(long, value_name = "LIST", help = passes_help())]
    pub(crate) passes: Option<String>,
    /// Print the intermediate form after each run of this pass, or of `all`
    #[arg(long, value_name = "NAME", value_parser = parse_pass_or_all)]
    pub(crate) print_after: Vec<String>,
}

/// The help of `--passes`, with what there is.
fn passes_help() -> String {
    let names: Vec<&str> = pass::PASSES.iter().map(|p| p.name).collect();
    format!(
        "Run these passes only, in this order, with commas between them; `standard` stands for the usual ones, \
         which forms beyond --emit ast,ir need. There are {}",
        names.join(", ")
    )
}

fn parse_pass_or_all(name: &str) -> Result<String, String> {
    match name == "all" || pass::pass(name).is_some() {
        true => Ok(name.to_owned()),
        false => Err(unknown_pass(name)),
    }
}

fn unknown_pass(name: &str) -> String {
    let names: Vec<&str> = pass::PASSES.iter().map(|p| p.name).collect();
    format!("no pass is named `{name}`; there are {}", names.join(", "))
}

impl Passes {
    /// The passes to run, and whether they are the usual ones.
    pub(crate) fn chosen(&self) -> Result<(Vec<&'static pass::Pass>, bool), Failure> {
        let list = self.passes.as_deref().unwrap_or("standard");
        let chosen = pass::parse(list).map_err(|name| Failure::Usage(unknown_pass(&name)))?;
        let names: Vec<&str> = chosen.iter().map(|p| p.name).collect();
        Ok((chosen, names == pass::STANDARD))
    }

    /// Whether the program is to be shown after a pass.
    pub(crate) fn shows(&self, pass: &pass::Pass) -> bool {
        let is = |name: &String| name == "all" || name == pass.name;
        self.print_after.iter().any(is)
    }
}

/// `srp run`
#[derive(Args)]
#[command(after_help = "\
The program's output goes to standard output, cycles to standard error.

Examples:
  srp run program.c
  srp run program.c --loops loops.html
  srp run program.c --profile profile.html
  srp run program.c --engine interp --registers -
  srp run program.c --trace kernel:sum#3 --trace-output sum.kanata
  srp run program.c --trace 1000..2000 --trace-output waves.fst
  srp run program.c --json 2> /dev/null
  srp run program.c --engine ir")]
pub(crate) struct Run {
    /// C files, or one file of a later form
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) compilation: Compilation,
    #[command(flatten)]
    pub(crate) loops: Loops,
    /// What runs it; without rustc, csim gives way to interp
    #[arg(long, value_enum, default_value_t = RunEngine::Auto)]
    pub(crate) engine: RunEngine,
    /// Write where every cycle went, by function, loop and source line: a page if the name ends in .html, JSON if
    /// in .json, else text; `-` is standard output. The interpreter counts, so it runs the program
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) trace: Trace,
    #[command(flatten)]
    pub(crate) checkpoints: Checkpoints,
    /// Write the registers as they are at the end, those that are not 0, by their names in the machine file: JSON if
    /// the name ends in .json, else a line each; `-` is standard output. Every engine ends with the same
    #[arg(long, value_name = "FILE")]
    pub(crate) registers: Option<PathBuf>,
    /// Stop after so many cycles (steps of --engine ir)
    #[arg(long, value_name = "N", default_value_t = 20_000_000_000)]
    pub(crate) limit: u64,
    /// Write status and cycles as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Print the same on standard output; the program's output then goes to standard error
    #[arg(long)]
    pub(crate) json: bool,
}

/// `srp watch`
#[derive(Args)]
#[command(after_help = "\
Files are watched by their folders, so included files are seen too. Ctrl-C ends it.

Examples:
  srp watch light.c --frame                         its loops as the default frame has them
  srp watch kernels/secondary.c -I kernels          its loops, without the program round them
  srp watch fir.c --machine my-machine.xml          the machine's file is watched too")]
pub(crate) struct Watch {
    #[command(flatten)]
    pub(crate) of: Reported,
}

/// What is reported on.
#[derive(Args)]
pub(crate) struct Reported {
    /// C files, or one file of a later form; the kernels that come along where none is given
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) compilation: Compilation,
    /// Report the kernels of a frame as they are rendered: built for what the scene (the default one where
    /// none is given) calls for. Files take the place of the kernels of the same name, and only their loops
    /// are reported
    #[arg(long, value_name = "SCENE", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub(crate) frame: Option<String>,
    /// Report this kernel only
    #[arg(long, value_name = "NAME")]
    pub(crate) kernel: Option<String>,
}

/// `srp report`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp report light.c --frame                        its loops as the default frame has them
  srp report kernels/secondary.c -I kernels         its loops, without the program round them
  srp report kernels/secondary.c -I kernels --machine wide --html report.html --json
  srp report kernels/secondary.c -I kernels --what-if
  srp report --frame=church.obj --kernel shade_hit
  srp report --json > old.json; …; srp report --json > new.json; srp report --diff old.json new.json

docs/report.md is the reference of the JSON. Exit status of --diff: 0 nothing got worse, 1 something did.")]
pub(crate) struct Report {
    #[command(flatten)]
    pub(crate) of: Reported,
    /// Write a DRAT certificate that the II below is impossible; its formula goes to FILE.cnf
    #[arg(long, value_name = "FILE")]
    pub(crate) proof: Option<PathBuf>,
    /// Try small changes of the machine, and say which lower each loop's II
    #[arg(long)]
    pub(crate) what_if: bool,
    /// Compare two reports in JSON, and name what got worse
    #[arg(long, num_args = 2, value_names = ["OLD.json", "NEW.json"], conflicts_with_all = ["files", "frame", "kernel", "proof", "what_if", "times", "html"])]
    pub(crate) diff: Option<Vec<PathBuf>>,
    /// Say how long each schedule was looked for on this host
    #[arg(long)]
    pub(crate) times: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// Write a self-contained page too
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
}
