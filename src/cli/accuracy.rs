//! The command line of `srp accuracy`.

use super::Sharing;
use super::compiling::{DOUBLES, define, parse_define};
use super::frame::{BUILDERS, Building, Frame, parse_size};
use super::one_of;
use super::parse_pixel;
use super::parse_threads;
use crate::failure::Failure;
use clap::Args;
use srp_runtime::bvh::Builder;
use srp_studies::accuracy;
use srp_studies::kernel;
use srp_toolchain::Options;
use std::path::{Path, PathBuf};

/// `srp accuracy`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp accuracy
  srp accuracy sibenik.obj --cameras cameras.json:sibenik/0 --target psnr=45,leaks=0 -o sibenik
  srp accuracy sibenik.obj --pixel 160,120
  srp accuracy scene.obj --knob 'T&I reciprocal' --knob power --machine mine.xml
  srp accuracy filter.c --range x=0.1:10 --range a=-1:1 --target ulp=16
  srp accuracy fir.c --function fir --range samples=-1:1 --length samples=128 -o fir
  srp accuracy benchmarks.fpcore --function 'doppler1'

A scene: the folder has the picture of every trial and a map of what is off in it. A C file (.c) or an FPCore file
(.fpcore): the error of a function's results over ranges of its parameters, and what each setting of the
special-function units and the compiler costs. Trials are kept in the cache, so that the command goes on where it
was interrupted.")]
pub(crate) struct Accuracy {
    #[command(flatten)]
    pub(crate) frame: Frame,
    #[command(flatten)]
    pub(crate) building: Building,
    #[command(flatten)]
    pub(crate) kernel: Kernel,
    /// Turn no knob, but say of one pixel where it parts from binary64, and what follows from it
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, conflicts_with = "knob")]
    pub(crate) pixel: Option<(u32, u32)>,
    /// Turn only this knob of a frame; several are possible
    #[arg(long, value_name = "NAME")]
    pub(crate) knob: Vec<String>,
    /// What a setting has to keep to. Of a picture (psnr=45,leaks=0): psnr=DB, flip=MEAN, leaks=N rays that
    /// get through between triangles, pixels=N that are off by more than eight levels. Of a kernel
    /// (ulp=16): bits=N lost on average, ulp=N, relative=N, absolute=N
    #[arg(long, value_name = "LIST")]
    target: Option<String>,
    /// Width and height of the frames (320x240)
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// How the bounding volume hierarchy is built (best)
    #[arg(long, value_name = "BUILDER", value_parser = one_of(BUILDERS))]
    bvh: Option<Builder>,
    /// Combinations of a frame's settings that are tried, at most (80); of a kernel, all settings (400)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    trials: Option<u32>,
    /// Try all combinations of all settings in full, whether they meet the target or not, at most 100,000; with
    /// --knob, of a few
    #[arg(long, conflicts_with_all = ["trials", "pixel"])]
    pub(crate) grid: bool,
    /// Trials at a time; they change no figure but the host's seconds
    #[arg(long, value_name = "N", default_value = "2", value_parser = parse_threads)]
    pub(crate) threads: usize,
    /// Folder of the report: of all pictures (accuracy), or, for a kernel, only where it is given, of a page,
    /// the report as JSON and the machine files of the best settings
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print the report as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) sharing: Sharing,
}

/// What is said of kernels.
#[derive(Args)]
#[command(next_help_heading = "Kernels (FILE.c or FILE.fpcore in place of a scene)")]
pub(crate) struct Kernel {
    /// Range of a parameter, or of an object of a whole program; `#pragma srp range(NAME, LOW, HIGH)` before
    /// a function and `:pre` of an FPCore say the same
    #[arg(long, value_name = "NAME=LOW:HIGH", allow_hyphen_values = true, value_parser = parse_range)]
    range: Vec<(String, f64, f64)>,
    /// Elements behind a pointer: 1, or 64 where the function takes their count
    #[arg(long, value_name = "NAME=N", value_parser = parse_length)]
    length: Vec<(String, u32)>,
    /// The function, or the benchmark of an FPCore file; all that have ranges where none is named
    #[arg(long, value_name = "NAME")]
    function: Option<String>,
    /// Evaluations that are drawn from the ranges, rounded up to whole calls of the function's loop, 256 of them each
    #[arg(long, value_name = "N", default_value = "1024", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    points: u32,
    /// Folder to look for included files in, after that of the including file
    #[arg(short = 'I', value_name = "DIR")]
    include: Vec<PathBuf>,
    /// Define a macro
    #[arg(short = 'D', value_name = "NAME[=VALUE]", value_parser = parse_define)]
    define: Vec<String>,
    /// What `double` is: binary64 in software, or `float`
    #[arg(long, value_name = "DOUBLE", default_value = "soft", value_parser = one_of(DOUBLES), action = clap::ArgAction::Set)]
    double: bool,
}

/// A name before an equals sign, and what is behind it.
fn named(text: &str) -> Option<(String, &str)> {
    let (name, rest) = text.split_once('=')?;
    (!name.trim().is_empty()).then(|| (name.trim().to_owned(), rest))
}

fn parse_range(text: &str) -> Result<(String, f64, f64), String> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let parts = named(text).and_then(|(name, range)| {
        let (low, high) = range.split_once(':')?;
        Some((name, number(low)?, number(high)?))
    });
    match parts {
        Some((name, low, high)) if low <= high => Ok((name, low, high)),
        Some((name, low, high)) => Err(format!(
            "the range of `{name}` is empty: {low} is above {high}"
        )),
        None => Err(format!("`{text}` is not NAME=LOW:HIGH")),
    }
}

/// Most elements that an array may have.
const MOST_ELEMENTS: u32 = 4096;

fn parse_length(text: &str) -> Result<(String, u32), String> {
    let parts = named(text).and_then(|(name, count)| Some((name, count.trim().parse().ok()?)));
    let parts = parts.filter(|(_, n)| (1..=MOST_ELEMENTS).contains(n));
    parts.ok_or_else(|| format!("`{text}` is not NAME=N with N from 1 to {MOST_ELEMENTS}"))
}

impl Accuracy {
    /// The C or FPCore file that takes the place of a scene.
    pub(crate) fn kernel_file(&self) -> Option<&Path> {
        let path = self.frame.scene.as_deref()?;
        let extension = path.extension()?;
        (extension == "c" || extension == "fpcore").then_some(path)
    }

    /// What a picture has to keep to.
    pub(crate) fn target(&self) -> Result<accuracy::Target, Failure> {
        let text = self.target.as_deref().unwrap_or("psnr=45,leaks=0");
        accuracy::Target::parse(text).map_err(|why| Failure::Usage(format!("--target: {why}")))
    }

    /// Width and height of the frames.
    pub(crate) fn size(&self) -> (u32, u32) {
        self.size.unwrap_or((320, 240))
    }

    /// Combinations of a frame's settings that are tried.
    pub(crate) fn combinations(&self) -> usize {
        self.trials.unwrap_or(80) as usize
    }

    /// How the tree is built.
    pub(crate) fn bvh(&self) -> Builder {
        self.bvh.unwrap_or_default()
    }

    /// Fails where something is said of kernels, and a frame is studied.
    pub(crate) fn check_frame(&self) -> Result<(), Failure> {
        let Kernel {
            range,
            length,
            function,
            include,
            define,
            ..
        } = &self.kernel;
        let said = [
            ("--range", !range.is_empty()),
            ("--length", !length.is_empty()),
            ("--function", function.is_some()),
            ("-I", !include.is_empty()),
            ("-D", !define.is_empty()),
            ("--double", self.kernel.double),
        ];
        refuse(&said, "is of kernels: give a .c or .fpcore file")
    }

    /// How the kernels of a file are studied on a machine.
    pub(crate) fn study(&self, arch: srp_archdesc::Arch) -> Result<kernel::Study, Failure> {
        let shading = &self.frame.shading;
        let said = [
            ("--pixel", self.pixel.is_some()),
            ("--knob", !self.knob.is_empty()),
            ("--share", self.sharing.share.is_some()),
            ("--size", self.size.is_some()),
            ("--bvh", self.bvh.is_some()),
            ("--form", !self.building.form.is_empty()),
            ("--kernels", self.building.kernels.is_some()),
            ("--camera", self.frame.camera.camera.is_some()),
            ("--cameras", self.frame.cameras.is_some()),
            ("--effects", shading.effects.is_some()),
            ("--samples", shading.samples.is_some()),
            ("--bounces", shading.bounces.is_some()),
            ("--occlusion", shading.occlusion.is_some()),
            ("--inter-reflections", shading.inter_reflections.is_some()),
            ("--light", !shading.light.is_empty()),
        ];
        refuse(&said, "is of scenes, not of kernels")?;
        let text = self.target.as_deref().unwrap_or("ulp=16");
        let target = kernel::Target::parse(text);
        let Kernel {
            range,
            length,
            function,
            points,
            include,
            define: defines,
            double,
        } = &self.kernel;
        Ok(kernel::Study {
            arch,
            options: Options {
                include: include.clone(),
                defines: defines.iter().map(|text| define(text)).collect(),
                double_is_float: *double,
                fast_math: super::fast_math(&self.building.feature),
                prefetch: self.building.prefetches(),
                ..Options::default()
            },
            question: kernel::Question {
                ranges: range.clone(),
                lengths: length.clone(),
                function: function.clone(),
            },
            points: *points as usize,
            budget: self.trials.unwrap_or(400) as usize,
            grid: self.grid,
            target: target.map_err(|why| Failure::Usage(format!("--target: {why}")))?,
            threads: self.threads,
        })
    }
}

/// Fails for the first argument that was given and has no meaning.
fn refuse(said: &[(&str, bool)], why: &str) -> Result<(), Failure> {
    match said.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Failure::Usage(format!("{name} {why}"))),
        None => Ok(()),
    }
}
