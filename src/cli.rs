//! The command line.

pub(crate) mod dram;
pub(crate) mod map;

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Compiler, scheduler and simulator generator for the SRP, the programmable half of the SGRT
/// ray-tracing GPU.
///
/// Kernels in C and a machine in XML become a schedule for the machine's VLIW engine and
/// reconfigurable array, and a cycle-accurate simulator of both beside the traversal and
/// intersection unit.
#[derive(Parser)]
#[command(
    name = "srp",
    version,
    arg_required_else_help = true,
    args_conflicts_with_subcommands = true,
    propagate_version = true,
    after_help = "\
Examples:
  srp render                                   the default scene, kernels and machine to out.png
  srp render church.obj --size 640x480 --camera 0,2,9/0,0,-1/60 -o church.png
  srp run program.c --engine interp            compile, schedule and simulate main()
  srp report kernels.c --html report.html      initiation intervals, and what sets them
  srp compile kernels.c --emit ir,dfg -o build
  srp dram requests.trace --preset lpddr3-1600
  srp machine check my-machine.xml
  srp map conv.dot --mesh 4x4                  a bare dataflow graph onto a standard array

Exit status: 0 done, 1 the input is at fault or a check failed, 2 the command line is, 130 interrupted
(what is known by then is printed)."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Say what the code of a message stands for, such as C0502
    #[arg(long, value_name = "CODE")]
    pub(crate) explain: Option<String>,
}

/// What to do.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Render a scene: the kernels run on the simulated SRPs beside their T&I units.
    Render(Render),
    /// Compile C to any of its forms on the way to a simulator.
    Compile(Compile),
    /// Compile, schedule and simulate a C program; its status is the command's.
    Run(Run),
    /// Report the initiation interval of every loop, and what sets it.
    Report(Report),
    /// Run T&I units alone on rays, and account for every cycle.
    Tni(Tni),
    /// Hold the T&I units against the figures of the SGRT paper.
    Paper(Paper),
    /// Count what the T&I unit of a machine is made of, its area and its energy.
    Area(Area),
    /// Map bare dataflow graphs onto an array: initiation intervals, bounds, and what sets them.
    Map(map::Map),
    /// Run a trace of requests through a memory: bandwidth, rows, latency.
    Dram(dram::Dram),
    /// Check a machine file, show what it describes, write it out in full, or make one.
    Machine(Machine),
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// The machine that everything is for.
#[derive(Args)]
pub(crate) struct MachineFile {
    /// Machine file, or one of the machines that come along: sgrt, tiny, wide
    #[arg(long, value_name = "FILE.xml", default_value = "sgrt")]
    pub(crate) machine: PathBuf,
}

/// How hard loops are scheduled.
#[derive(Args)]
pub(crate) struct Search {
    /// Look for the smallest II by SAT too, for so many seconds (60), or prove that there is none
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true, default_missing_value = "60")]
    pub(crate) optimal: Option<f64>,
}

/// How C is compiled.
#[derive(Args)]
pub(crate) struct Source {
    /// Folder to look for included files in, after that of the including file
    #[arg(short = 'I', value_name = "DIR")]
    pub(crate) include: Vec<PathBuf>,
    /// Define a macro
    #[arg(short = 'D', value_name = "NAME[=VALUE]")]
    pub(crate) define: Vec<String>,
    /// Put only loops with `#pragma srp kernel` on the array
    #[arg(long)]
    pub(crate) no_auto_kernel: bool,
    /// What `double` is: binary64 in software, or `float`
    #[arg(long, value_enum, default_value_t = Double::Soft)]
    pub(crate) double: Double,
    /// `no-auto-kernel`, as the option of that name; `single-precision-constant`: constants without
    /// suffix are floats
    #[arg(short = 'f', value_name = "FEATURE", value_enum)]
    pub(crate) feature: Vec<Feature>,
    /// Warnings: NAME, no-NAME, error, error=NAME, no-error=NAME, none
    #[arg(short = 'W', value_name = "NAME")]
    pub(crate) warnings: Vec<String>,
    /// Remarks: `pass` says of every loop whether it runs on the array, and what stands in the way
    #[arg(short = 'R', value_name = "KIND", value_enum)]
    pub(crate) remarks: Vec<RemarkKind>,
    /// How messages are written: for people, or one JSON object a line in rustc's shape
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = ErrorFormat::Human)]
    pub(crate) error_format: ErrorFormat,
}

/// What `-R` asks for.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RemarkKind {
    /// Loops on the array, and loops that are not
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

/// What `double` is.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Double {
    /// Binary64, by functions of the library
    Soft,
    /// The same as `float`; each use is told
    Float,
}

/// What `-f` asks for.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Feature {
    /// Put only loops with `#pragma srp kernel` on the array
    NoAutoKernel,
    /// Floating constants without suffix are floats; each is told
    SinglePrecisionConstant,
}

/// What all `-f` together ask for.
pub(crate) struct Features {
    pub(crate) no_auto_kernel: bool,
    pub(crate) single_constants: bool,
}

impl Source {
    /// What all `-f` together ask for.
    pub(crate) fn features(&self) -> Features {
        Features {
            no_auto_kernel: self.feature.contains(&Feature::NoAutoKernel),
            single_constants: self.feature.contains(&Feature::SinglePrecisionConstant),
        }
    }
}

/// What simulates the SRP.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// A simulator generated for the program and compiled by rustc
    Csim,
    /// The interpreter of the same tables
    Interp,
}

/// What runs a program.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RunEngine {
    /// A simulator generated for the program and compiled by rustc
    Csim,
    /// The interpreter of the same tables
    Interp,
    /// The meaning of the intermediate form: no machine, no cycles
    Ir,
}

/// How the bounding volume hierarchy is built.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BvhBuilder {
    /// Full-sweep surface area heuristic
    Sweep,
    /// The same, then improved by reinsertion
    #[value(name = "sweep+reinsertion")]
    SweepReinsertion,
    /// Parallel locally-ordered clustering
    Ploc,
}

/// `srp render`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp render
  srp render sibenik.obj --cameras cameras.json:sibenik/0 --size 320x240 -o sibenik.png
  srp render scene.obj --camera 0,1,5/0,0,-1/60 --machine wide --report frame.json")]
pub(crate) struct Render {
    /// Scene to render; the default scene where none is given
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Position, direction and angle of view (degrees, of the shorter side of the image)
    #[arg(
        long,
        value_name = "X,Y,Z/DX,DY,DZ/FOV",
        conflicts_with = "cameras",
        allow_hyphen_values = true
    )]
    pub(crate) camera: Option<String>,
    /// View N of the scene NAME in a file of cameras
    #[arg(long, value_name = "FILE.json:NAME/N")]
    pub(crate) cameras: Option<String>,
    /// Width and height of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// What simulates the SRP; without rustc, csim gives way to interp
    #[arg(long, value_enum, default_value_t = Engine::Csim)]
    pub(crate) engine: Engine,
    /// Folder with the kernels in C, instead of those that come along
    #[arg(long, value_name = "DIR")]
    pub(crate) kernels: Option<PathBuf>,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_enum, default_value_t = BvhBuilder::Sweep)]
    pub(crate) bvh: BvhBuilder,
    /// The image
    #[arg(short, long, value_name = "FILE.png", default_value = "out.png")]
    pub(crate) output: PathBuf,
    /// Write the whole account as JSON too
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Print the account as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
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
    /// The program divided between VLIW engine and array, XML
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
  srp compile shade.c -I kernels --emit ast,ir,dfg,dre,schedule,rust -o build
  srp compile build/shade.dre.xml --machine wide --emit schedule -o build")]
pub(crate) struct Compile {
    /// C files, or one file of a later form
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    #[command(flatten)]
    pub(crate) source: Source,
    #[command(flatten)]
    pub(crate) search: Search,
    /// Forms to write
    #[arg(long, value_enum, value_delimiter = ',', default_value = "schedule")]
    pub(crate) emit: Vec<Form>,
    /// Folder to write them into
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub(crate) output: PathBuf,
}

/// `srp run`
#[derive(Args)]
#[command(after_help = "\
The program's output goes to standard output, cycles to standard error.

Examples:
  srp run program.c
  srp run program.c --engine ir")]
pub(crate) struct Run {
    /// C files, or one file of a later form
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    #[command(flatten)]
    pub(crate) source: Source,
    #[command(flatten)]
    pub(crate) search: Search,
    /// What runs it; without rustc, csim gives way to interp
    #[arg(long, value_enum, default_value_t = RunEngine::Csim)]
    pub(crate) engine: RunEngine,
    /// Stop after so many cycles (steps of --engine ir)
    #[arg(long, value_name = "N", default_value_t = 20_000_000_000)]
    pub(crate) limit: u64,
}

/// `srp report`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp report shade.c -I kernels
  srp report shade.c -I kernels --machine wide --html report.html --json")]
pub(crate) struct Report {
    /// C files, or one file of a later form; the kernels that come along where none is given
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    #[command(flatten)]
    pub(crate) source: Source,
    #[command(flatten)]
    pub(crate) search: Search,
    /// Report this kernel only
    #[arg(long, value_name = "NAME")]
    pub(crate) kernel: Option<String>,
    /// Write a DRAT certificate that the II below is impossible; its formula goes to FILE.cnf
    #[arg(long, value_name = "FILE")]
    pub(crate) proof: Option<PathBuf>,
    /// Try small changes of the machine, and say which lower each loop's II
    #[arg(long)]
    pub(crate) what_if: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// Write a self-contained page too
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
}

/// Kinds of rays.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RayKind {
    /// Through the pixel centres
    Primary,
    /// Ambient occlusion: short, any hit
    Ao,
    /// Diffuse reflection: the nearest hit
    Diffuse,
    /// Those of --ray-file
    File,
}

/// Forms of the traversal unit.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Pipeline {
    /// One deep pipeline
    Single,
    /// Three sub-pipelines side by side
    Parallel,
}

/// Latencies by name.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Latencies {
    /// Those with which the unit has the rates of the paper
    Calibrated,
    /// Those of a 65 nm synthesis: a lower bound
    #[value(name = "65nm")]
    Synthesis65nm,
}

/// Who shares a memory.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TniMemory {
    /// All units have one
    Shared,
    /// Every unit has its own
    Private,
}

/// Orders of rays.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RayOrder {
    /// By a Morton key of origin and direction, in batches of 2^20
    Morton,
    /// Pixels along a Z-curve, a pixel's rays together
    Pixels,
    /// Pixels row by row
    Rows,
    /// Shuffled
    Random,
}

/// What a heat map shows.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum HeatOf {
    /// Cycles from dispatch to result
    Cycles,
    /// Nodes visited
    Visits,
}

/// `srp tni`
#[derive(Args)]
#[command(after_help = "\
Views come from --cameras, or from a cameras.json beside the scene or one folder above that names it.

Examples:
  srp tni sibenik.obj --rays primary --size 1024x768
  srp tni sibenik.obj --rays diffuse --spp 32 --sample 1/64 --units 4 --threads 2
  srp tni sibenik.obj --views 2 --heat heat.png --heat-of visits
  srp tni sibenik.obj --views 2 --ray 160,120")]
pub(crate) struct Tni {
    /// Scene; the default scene where none is given
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Rays to trace
    #[arg(long, value_enum, default_value_t = RayKind::Primary)]
    pub(crate) rays: RayKind,
    /// Rays as text, one a line: ox oy oz dx dy dz, then tmin tmax, then any; the last two may be left out
    #[arg(long, value_name = "FILE")]
    pub(crate) ray_file: Option<PathBuf>,
    /// Form of the traversal units, instead of the machine's
    #[arg(long, value_enum)]
    pub(crate) pipeline: Option<Pipeline>,
    /// Latencies of the unit by name, instead of the machine's
    #[arg(long, value_enum)]
    pub(crate) latencies: Option<Latencies>,
    /// Number of T&I units; the machine's cores where none is given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) units: Option<u32>,
    /// Who shares a memory
    #[arg(long, value_enum, default_value_t = TniMemory::Shared)]
    pub(crate) memory: TniMemory,
    /// Position, direction and angle of view (degrees, of the shorter side of the image)
    #[arg(
        long,
        value_name = "X,Y,Z/DX,DY,DZ/FOV",
        conflicts_with = "cameras",
        allow_hyphen_values = true
    )]
    pub(crate) camera: Option<String>,
    /// Views of the scene NAME in a file of cameras
    #[arg(long, value_name = "FILE.json:NAME")]
    pub(crate) cameras: Option<String>,
    /// Run all views, or view N
    #[arg(long, value_name = "all|N", default_value = "all", value_parser = parse_views)]
    pub(crate) views: Views,
    /// Width and height of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Secondary rays a pixel
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) spp: u32,
    /// Length of ambient-occlusion rays; else what the file of cameras says, or a tenth of the
    /// scene's diagonal
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub(crate) radius: Option<f32>,
    /// Measure one run of packets in N
    #[arg(long, value_name = "1/N", default_value = "1/1", value_parser = parse_sample)]
    pub(crate) sample: u64,
    /// Order of the rays
    #[arg(long, value_enum, default_value_t = RayOrder::Morton)]
    pub(crate) order: RayOrder,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_enum, default_value_t = BvhBuilder::Sweep)]
    pub(crate) bvh: BvhBuilder,
    /// Most triangles of a leaf
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub(crate) max_leaf: Option<u32>,
    /// Threads of the host; they change no figure
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) threads: usize,
    /// Write what each pixel of the first view costs as a picture
    #[arg(long, value_name = "FILE.png")]
    pub(crate) heat: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = HeatOf::Cycles)]
    pub(crate) heat_of: HeatOf,
    /// Trace the first ray of this pixel alone, and tell all that happens to it
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pub(crate) ray: Option<(u32, u32)>,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// Tables of the paper.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Table {
    /// One unit, traversal with a single and with parallel pipelines
    Table4,
    /// Four units: utilisation, steps, hit rates, bandwidth
    Table5,
}

/// `srp paper`
#[derive(Args)]
#[command(after_help = "\
Views come from a cameras.json beside the scene or one folder above that names it. The paper's figures
are those of the scene of the same name; for others only ours are printed.

Examples:
  srp paper table4 sibenik.obj
  srp paper table5 sibenik.obj --size 1024x768 --sample 1/64 --threads 2")]
pub(crate) struct Paper {
    /// Which table
    pub(crate) table: Table,
    /// Scenes to compare on
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Width and height of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Measure one run of packets of secondary rays in N
    #[arg(long, value_name = "1/N", default_value = "1/64", value_parser = parse_sample)]
    pub(crate) sample: u64,
    /// Measure one run of packets of primary rays in N
    #[arg(long, value_name = "1/N", default_value = "1/1", value_parser = parse_sample)]
    pub(crate) sample_primary: u64,
    /// Most triangles of a leaf
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub(crate) max_leaf: Option<u32>,
    /// Threads of the host; they change no figure
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) threads: usize,
}

/// `srp area`
#[derive(Args)]
pub(crate) struct Area {
    /// Machine file, or one of the machines that come along: sgrt, tiny, wide
    #[arg(default_value = "sgrt")]
    pub(crate) file: PathBuf,
}

/// Views to run: all of them, or this one.
pub(crate) type Views = Option<usize>;

/// `srp machine`
#[derive(Args)]
pub(crate) struct Machine {
    /// What to do with it
    #[command(subcommand)]
    pub(crate) action: MachineAction,
}

/// What to do with a machine file.
#[derive(Subcommand)]
pub(crate) enum MachineAction {
    /// Say everything that is wrong with it.
    Check {
        /// The file
        file: PathBuf,
    },
    /// Show the array, the units and the peak rate.
    Show {
        /// The file, or one of the machines that come along: sgrt, tiny, wide
        #[arg(default_value = "sgrt")]
        file: PathBuf,
    },
    /// Write it with every unit, link, file and default spelled out.
    Expand {
        /// The file, or one of the machines that come along: sgrt, tiny, wide
        #[arg(default_value = "sgrt")]
        file: PathBuf,
    },
    /// Write the machine file of a standard array: a mesh of equal units, or the like.
    Mesh(map::Mesh),
}

fn parse_views(text: &str) -> Result<Views, String> {
    match text {
        "all" => Ok(None),
        n => n
            .parse()
            .map(Some)
            .map_err(|_| "write `all` or the number of a view, from 0".to_owned()),
    }
}

fn parse_sample(text: &str) -> Result<u64, String> {
    let n = text.strip_prefix("1/").and_then(|n| n.parse().ok());
    n.filter(|n| (1..=1 << 20).contains(n))
        .ok_or_else(|| "a part is 1/N, N from 1 to 1048576".to_owned())
}

fn parse_length(text: &str) -> Result<f32, String> {
    let length = text.parse().ok();
    length
        .filter(|l: &f32| *l > 0.0 && l.is_finite())
        .ok_or_else(|| "a length is a number above 0".to_owned())
}

fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "a pixel is X,Y, from 0,0 in the upper left corner".to_owned())
}

/// Largest side of an image.
const MAX_SIDE: u32 = 16_384;

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("a size is WIDTHxHEIGHT, each from 1 to {MAX_SIDE}"))
}
