//! The command line of `srp map` and `srp machine mesh`.

use clap::{Args, ValueEnum};
use srp_archdesc::isa::Class;
use srp_archdesc::xml::ArrayTopology;
use std::path::PathBuf;

/// `srp map`
#[derive(Args)]
#[command(after_help = "\
A graph is a loop body: nodes with an operation, edges with operand and distance. It may be
  NAME.dot, NAME.gv   Graphviz, also what `srp compile --emit dfg` writes
  NAME.json           {\"nodes\": [{\"id\", \"op\"}], \"edges\": [{\"from\", \"to\", \"operand\", \"distance\"}]}
  NAME.edges          `source target distance latency` a line; operations in NAME.ops or --ops FILE
  -                   standard input: JSON if it begins with a brace, else Graphviz
and docs/graphs.md is the reference of all three. Folders are searched for graphs.

Each schedule is checked before it is shown. Times are of this host; everything else is the same on
every host, unless --timeout cuts the search short.

Examples:
  srp map conv.dot --mesh 4x4
  srp map graphs/ --mesh 4x4 --timeout 5 --json > table.json
  srp machine mesh --rows 8 --cols 8 --topology torus --memory-columns 2 -o torus.xml
  srp map kernel.edges --ops kernel.ops --machine torus.xml -o kernel.sched.xml
  srp map fir.json --machine torus.xml --what-if
  srp map fir.json --mesh 4x4 --set array.contexts=8
  my-frontend fir.c | srp map - --mesh 4x4

Exit status: 0 every graph was mapped, 1 one was not or is at fault, 2 the command line is at fault,
130 interrupted.")]
pub(crate) struct Map {
    /// Graphs, and folders of graphs; - is standard input
    #[arg(required = true, value_name = "GRAPH")]
    pub(crate) graphs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: Target,
    #[command(flatten)]
    pub(crate) changes: super::Changes,
    /// Operations of the nodes of NAME.edges, where they are not in NAME.ops
    #[arg(long, value_name = "FILE")]
    pub(crate) ops: Option<PathBuf>,
    /// Treat operations of unknown name as ones of this class, such as alu
    #[arg(long, value_name = "CLASS", value_parser = parse_class)]
    pub(crate) any_op: Option<Class>,
    #[command(flatten)]
    pub(crate) search: super::Search,
    /// Write a DRAT certificate that the II below is impossible; its formula goes to FILE.cnf
    #[arg(long, value_name = "FILE")]
    pub(crate) proof: Option<PathBuf>,
    /// End the search for a graph after so many seconds, with the best schedule so far
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    pub(crate) timeout: Option<f64>,
    /// Map without modulo variable expansion: no value lives longer than the II in a file that does not rotate,
    /// and the kernel takes one context a cycle; the II with it is shown beside
    #[arg(long)]
    pub(crate) no_expansion: bool,
    /// Try small changes of the machine, and say which lower the II of each graph
    #[arg(long)]
    pub(crate) what_if: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the schedules, XML: of the graphs that have one
    #[arg(short, long, value_name = "FILE.sched.xml")]
    pub(crate) output: Option<PathBuf>,
}

/// What graphs are mapped onto.
#[derive(Args)]
#[group(required = true, multiple = false)]
pub(crate) struct Target {
    /// Machine file, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
    #[arg(long, value_name = "FILE.xml")]
    pub(crate) machine: Option<PathBuf>,
    /// A mesh of units that run every operation in one cycle and have 8 registers each
    #[arg(long, value_name = "ROWSxCOLS", value_parser = parse_mesh)]
    pub(crate) mesh: Option<(u32, u32)>,
}

/// `srp machine mesh`
#[derive(Args)]
#[command(after_help = "\
Each unit has one output, which its neighbours and itself read until it issues again, and registers
of its own, which do not rotate. There are no VLIW slots and no central files: graphs can be mapped
onto such a machine (`srp map`), programs cannot be compiled for it.

Examples:
  srp machine mesh --rows 4 --cols 4
  srp machine mesh --rows 4 --cols 4 --wires mesh --hops 4 --memory-columns 1 -o hycube.xml
  srp machine mesh --rows 8 --cols 8 --wires row,column -o buses.xml
  srp machine mesh --rows 8 --cols 8 --topology one-hop --registers 4 -o one-hop.xml
  srp machine mesh --rows 4 --cols 4 --ops alu,imul,load,store --latency 2")]
pub(crate) struct Mesh {
    /// Rows of units
    #[arg(long, value_name = "N")]
    pub(crate) rows: u32,
    /// Columns of units
    #[arg(long, value_name = "N")]
    pub(crate) cols: u32,
    /// Which units are linked
    #[arg(long, value_enum, default_value_t = Topology::Mesh)]
    pub(crate) topology: Topology,
    /// Switches or buses beside the links: mesh, mesh-diagonal, torus, one-hop, row, column or array, or a list, each
    /// with how many of it, as in row,column:2
    #[arg(
        long,
        value_name = "WIRES",
        default_value = "",
        hide_default_value = true
    )]
    pub(crate) wires: String,
    /// How many wires of switches a value passes in one cycle at most
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub(crate) hops: u32,
    /// Registers that each unit has for itself
    #[arg(long, value_name = "R", default_value_t = 8)]
    pub(crate) registers: u32,
    /// Only the first K columns load and store
    #[arg(long, value_name = "K")]
    pub(crate) memory_columns: Option<u32>,
    /// Classes of operations that the units run: all (of scalars), or a list such as alu,imul
    #[arg(long, value_name = "CLASSES", default_value = "all")]
    pub(crate) ops: String,
    /// Cycles of every operation
    #[arg(long, value_name = "L", default_value_t = 1)]
    pub(crate) latency: u32,
    /// Depth of the configuration memory
    #[arg(long, value_name = "N", default_value_t = 128)]
    pub(crate) contexts: u32,
    /// Write it into a file instead of to standard output
    #[arg(short, long, value_name = "FILE.xml", default_value = "-")]
    pub(crate) output: PathBuf,
}

/// Links of a standard array.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Topology {
    /// The four neighbours
    Mesh,
    /// The eight neighbours
    Diagonal,
    /// The four neighbours, edges joined
    Torus,
    /// The four neighbours, and those two steps away
    OneHop,
}

impl From<Topology> for ArrayTopology {
    fn from(topology: Topology) -> ArrayTopology {
        match topology {
            Topology::Mesh => ArrayTopology::Mesh,
            Topology::Diagonal => ArrayTopology::Diagonal,
            Topology::Torus => ArrayTopology::Torus,
            Topology::OneHop => ArrayTopology::OneHop,
        }
    }
}

/// A class of operations by its name.
pub(crate) fn parse_class(name: &str) -> Result<Class, String> {
    Class::parse(name).ok_or_else(|| {
        let names: Vec<&str> = Class::ALL.iter().map(|class| class.name()).collect();
        match srp_archdesc::nearest::nearest(name, names.iter().copied()) {
            Some(near) => format!("there is no class `{name}`; did you mean `{near}`?"),
            None => format!("there is no class `{name}`; there are {}", names.join(", ")),
        }
    })
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| (0.0..=1e9).contains(s));
    seconds.ok_or_else(|| "a time-out is a number of seconds".to_owned())
}

fn parse_mesh(text: &str) -> Result<(u32, u32), String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=64).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(rows, cols)| Some((side(rows)?, side(cols)?)))
        .ok_or_else(|| "a mesh is ROWSxCOLS, each from 1 to 64".to_owned())
}
