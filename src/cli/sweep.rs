//! The command line of `srp sweep`.

use super::parse_threads;
use crate::failure::Failure;
use clap::{Args, Subcommand};
use srp_archdesc::xml::split_setting;
use srp_studies::sweep::{PlanFile, Shard, plan};
use std::path::{Path, PathBuf};

/// `srp sweep`
#[derive(Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  srp sweep --set array.rows=4,5,6 --set array.contexts=64,128 -o rows
  srp sweep --set 'dram.latency-ns=0:300:100' --set tni.trvs=2,4 --measure cycles,energy,area --size 64x48
  srp sweep --set 'special[function=rcp].bits=8,12,exact' --measure ii,cycles,psnr --scene church.obj
  srp sweep --set 'op[class=fadd].latency=1..8' --set system.cores=1..8 --sample lhs:40 --measure cycles,area
  srp sweep --set array.rows=2:8:1 --set array.cols=2:8:1 --set tni.trvs=1..8 --measure cycles,area --sample search:60
  srp sweep plan.toml --sample search:200 --objective cycles,energy,max:psnr --seed 1
  srp sweep plan.toml -o sweep --engine slurm --jobs 32
  srp sweep report sweep --html page.html
  srp sweep show sweep 17 -o mine.xml

A parameter is an attribute of the machine file by its path (array.rows, tni/trv-l1.size, fu-type[name=vec].classes),
or machine, bvh, effort, fidelity, form:NAME, effect:NAME, f:FEATURE. Values are a list 4,5,6, steps 0:300:100, or a
range 1..64 to draw from and to search.
The folder has the plan, every row as it is done, results.csv, results.parquet and report.html. A sweep that was stopped goes on
where it was. docs/sweep.md tells the rest."
)]
pub(crate) struct Sweep {
    #[command(subcommand)]
    pub(crate) action: Option<SweepAction>,
    /// Plan of the sweep, in TOML; what is said besides comes before it
    pub(crate) plan: Option<PathBuf>,
    /// Vary a parameter over values; several are possible
    #[arg(long, value_name = "PARAMETER=VALUES", value_parser = parse_set)]
    pub(crate) set: Vec<(String, String)>,
    /// Machine file that is varied, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
    #[arg(long, value_name = "FILE.xml")]
    pub(crate) machine: Option<String>,
    /// Scene to render, or `default`; several are possible. FILE@CAMERAS.json:NAME/N is a view
    #[arg(long, value_name = "FILE.obj")]
    pub(crate) scene: Vec<String>,
    /// C program to run; several are possible
    #[arg(long, value_name = "FILE.c")]
    pub(crate) program: Vec<String>,
    /// Folder with the kernels in C, instead of those that come along
    #[arg(long, value_name = "DIR")]
    pub(crate) kernels: Option<String>,
    /// Width and height of frames (320x240)
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<String>,
    /// Level of simulation: functional, analytic, sampled, cycle, cycle+dram (the default)
    #[arg(long, value_name = "LEVEL")]
    pub(crate) fidelity: Option<String>,
    /// Measures: ii, cycles, energy, area, psnr (ii and area)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) measure: Vec<String>,
    /// Objectives: columns to be made small (psnr and fps large), as cycles,min:area.srp,max:psnr. They say what the front is,
    /// and where search:N goes (cycles or else ii, energy, area, psnr, as far as they are measured)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) objective: Vec<String>,
    /// Which points: grid, random:N, lhs:N, or search:N, which looks for those that no other beats in the objectives
    /// (search:N:P for P a generation)
    #[arg(long, value_name = "SAMPLE")]
    pub(crate) sample: Option<String>,
    /// Seed of what is drawn (0)
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Look for schedules so many times as long as usual (1)
    #[arg(long, value_name = "TIMES")]
    pub(crate) effort: Option<f64>,
    /// Folder of the sweep
    #[arg(short, long, value_name = "DIR", default_value = "sweep")]
    pub(crate) output: PathBuf,
    /// Measure only one row in so many: of M shards the one with the number N, from 0
    #[arg(long, value_name = "N/M", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// Where rows are measured: local, slurm (a job array), dask or dask:ADDRESS, or a command that runs what stands for {}
    /// and waits, as 'hq submit --wait {}'
    #[arg(
        long,
        value_name = "ENGINE",
        visible_alias = "jobs-on",
        default_value = "local",
        conflicts_with = "shard"
    )]
    pub(crate) engine: String,
    /// Shards that an engine other than local gets
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) jobs: u32,
    /// Refuse to run if this is another build of the tool
    #[arg(long, value_name = "ID", hide = true)]
    pub(crate) build: Option<String>,
    /// Threads of the host, as many as it has processors by default; they change no figure
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// Print the report as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// Other things that can be done with a sweep.
#[derive(Subcommand)]
pub(crate) enum SweepAction {
    /// Report what is known of a sweep: its rows, fronts, and which parameter moves what
    Report {
        /// Folder of the sweep
        folder: PathBuf,
        /// Write the report as a page too
        #[arg(long, value_name = "FILE.html")]
        html: Option<PathBuf>,
        /// Print the report as JSON instead of text
        #[arg(long)]
        json: bool,
    },
    /// Print the machine file of a point, and the command that renders with it
    Show {
        /// Folder of the sweep
        folder: PathBuf,
        /// The point's number, as the table has it
        point: usize,
        /// Write the machine file here
        #[arg(short, long, value_name = "FILE.xml", default_value = "-")]
        output: PathBuf,
    },
}

fn parse_set(text: &str) -> Result<(String, String), String> {
    split_setting(text)
        .map(|(parameter, values)| (parameter.to_owned(), values.to_owned()))
        .ok_or_else(|| "write PARAMETER=VALUES, as in array.rows=4,5,6".to_owned())
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(n, m)| Some((n.parse().ok()?, m.parse().ok()?)));
    match numbers {
        Some((number, of)) if number < of => Ok(Shard { number, of }),
        _ => Err("write N/M, N from 0 to below M".to_owned()),
    }
}

impl Sweep {
    /// The plan that is asked for: that of the file, with what the command line says in place of it.
    pub(crate) fn plan(&self) -> Result<PlanFile, Failure> {
        let here = Path::new("");
        let mut plan = match &self.plan {
            Some(path) => {
                let text = crate::files::read_text(path, crate::files::Kind::Plan)?;
                PlanFile::parse(&path.display().to_string(), &text, &plan::folder_of(path))?
            }
            None => PlanFile::default(),
        };
        let said = PlanFile {
            machine: self.machine.clone(),
            scenes: self.scene.clone(),
            programs: self.program.clone(),
            kernels: self.kernels.clone(),
            ..PlanFile::default()
        };
        let said = said.within(here);
        plan.machine = said.machine.or(plan.machine);
        plan.kernels = said.kernels.or(plan.kernels);
        if !(said.scenes.is_empty() && said.programs.is_empty()) {
            plan.scenes = said.scenes;
            plan.programs = said.programs;
        }
        plan.size = self.size.clone().or(plan.size);
        plan.fidelity = self.fidelity.clone().or(plan.fidelity);
        plan.sample = self.sample.clone().or(plan.sample);
        plan.seed = self.seed.unwrap_or(plan.seed);
        plan.effort = self.effort.or(plan.effort);
        if !self.measure.is_empty() {
            plan.measure.clone_from(&self.measure);
        }
        if !self.objective.is_empty() {
            plan.objective.clone_from(&self.objective);
        }
        for (name, values) in &self.set {
            plan.set(name, values);
        }
        if plan.set.is_empty() && plan.point.is_empty() {
            return Err(Failure::Usage(
                "nothing is varied: say --set PARAMETER=VALUES, or give a plan".to_owned(),
            ));
        }
        Ok(plan)
    }
}
