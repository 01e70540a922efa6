//! The settings that change accuracy: those of the machine file, of the compiler and of the kernels,
//! one of each knob at a time.

use crate::attributes::words;
use srp_archdesc::arch::{Approx, Arch, Precision, Refine, Subnormals};
use srp_archdesc::certify::Function;
use srp_archdesc::datapath::Intersection;
use srp_archdesc::format::{Format, KINDS};
use srp_archdesc::structure::{Special, Structure};
use srp_archdesc::system::NodeFormat;
use srp_ir::pass::FastMath;
use srp_kernels::form;
use srp_runtime::effect::{Effect, Guard};
use srp_runtime::scene::{Options, Scene};
use srp_toolchain::{Build, Frame};
use std::sync::Arc;

/// Knobs that change what is computed, not how exactly: their pictures are held against one with
/// the most of both.
pub const SAMPLING: [&str; 2] = ["samples a pixel", "bounces"];

/// True when a knob is one of [`SAMPLING`].
pub(super) fn is_sampling(knob: &str) -> bool {
    SAMPLING.contains(&knob)
}

/// The name of settings of several knobs.
pub const TOGETHER: &str = "together";

/// A frame that can be made: machine, program, and how far light is followed.
#[derive(Clone, PartialEq)]
pub(super) struct Subject {
    pub(super) arch: Arch,
    pub(super) build: Build,
    pub(super) options: Options,
}

impl Subject {
    /// Returns the machine, program and options of a frame.
    pub(super) fn of(frame: &Frame) -> Subject {
        Subject {
            arch: frame.arch.clone(),
            build: frame.build.clone(),
            options: frame.scene.options,
        }
    }

    /// The same frame made with this.
    pub(super) fn frame(self, frame: &Frame) -> Frame {
        let scene = Scene {
            options: self.options,
            ..frame.scene.clone()
        };
        Frame {
            arch: self.arch,
            scene,
            bvh: frame.bvh.clone(),
            size: frame.size,
            build: self.build,
            guard: Guard::default(),
        }
    }
}

/// One value of a knob, or of several.
#[derive(Clone)]
pub(super) struct Setting {
    /// The knob that is turned.
    pub(super) knob: String,
    /// The value that it is turned to.
    pub(super) value: String,
    /// How a user says it: a line of the machine file, or an option.
    pub(super) how: String,
    /// The units whose precision it sets.
    pub(super) units: Vec<(Function, Approx)>,
    /// The special functions of the SRP among them.
    pub(super) specials: Vec<Special>,
    /// It is of the texture unit.
    is_of_texels: bool,
    change: Change,
}

type Change = Arc<dyn Fn(&mut Subject) + Send + Sync>;

impl Setting {
    fn new(
        knob: &str,
        value: impl Into<String>,
        how: impl Into<String>,
        change: impl Fn(&mut Subject) + Send + Sync + 'static,
    ) -> Setting {
        Setting {
            knob: knob.to_owned(),
            value: value.into(),
            how: how.into(),
            units: Vec::new(),
            specials: Vec::new(),
            is_of_texels: false,
            change: Arc::new(change),
        }
    }

    fn of_units(self, functions: &[Function], approx: Approx) -> Setting {
        Setting {
            units: functions.iter().map(|&f| (f, approx)).collect(),
            ..self
        }
    }

    /// True if it is of the texture unit, and no texels are looked up, or if all special functions that it sets are
    /// others than these.
    pub(super) fn is_of_other_units(&self, used: &[Special], texels: bool) -> bool {
        let others = !self.specials.is_empty() && !self.specials.iter().any(|s| used.contains(s));
        others || self.is_of_texels && !texels
    }

    /// The frame as it is.
    pub(super) fn none() -> Setting {
        Setting::new("", "as it is", "", |_| {})
    }

    /// Several at once.
    pub(super) fn together(parts: &[&Setting]) -> Setting {
        let list = |of: fn(&Setting) -> String| parts.iter().map(|s| of(s)).collect::<Vec<_>>();
        let changes: Vec<Change> = parts.iter().map(|s| Arc::clone(&s.change)).collect();
        Setting::new(
            TOGETHER,
            list(|s| format!("{} {}", s.knob, s.value)).join(", "),
            list(|s| s.how.clone()).join("  "),
            move |subject| changes.iter().for_each(|change| change(subject)),
        )
    }

    /// The frame with this setting.
    pub(super) fn applied(&self, subject: &Subject) -> Subject {
        let mut changed = subject.clone();
        (self.change)(&mut changed);
        changed.arch.derive_cycles();
        changed
    }
}

/// The settings of the knobs that are asked for, without those that change nothing. The error says which
/// knobs there are.
pub(super) fn chosen(knobs: &[String], base: &Subject) -> Result<Vec<Setting>, String> {
    let all = all();
    let mut names: Vec<&str> = all.iter().map(|s| s.knob.as_str()).collect();
    names.dedup();
    if let Some(unknown) = knobs.iter().find(|k| !names.contains(&k.as_str())) {
        let names = names.join(", ");
        return Err(format!("there is no knob `{unknown}`; there are: {names}"));
    }
    let wanted = |s: &Setting| knobs.is_empty() || knobs.contains(&s.knob);
    let changes = |s: &Setting| is_sampling(&s.knob) || s.applied(base) != *base;
    Ok(all
        .into_iter()
        .filter(|s| wanted(s) && changes(s))
        .collect())
}

/// All settings, knob by knob; those that change nothing of a subject are among them.
fn all() -> Vec<Setting> {
    let mut all = Vec::new();
    intersection(&mut all);
    reciprocals(&mut all);
    functions(&mut all);
    floats(&mut all);
    formats(&mut all);
    forms(&mut all);
    compiler(&mut all);
    memory(&mut all);
    light(&mut all);
    all
}

fn intersection(all: &mut Vec<Setting>) {
    for variant in Intersection::ALL {
        let how = format!("<tni intersection=\"{}\">", variant.name());
        all.push(Setting::new(
            "intersection",
            variant.name(),
            how,
            move |s| {
                s.arch.system.tni.intersection = variant;
            },
        ));
    }
}

/// Precisions that are tried of a function whose steps the program can take.
const PROGRAMMED: &[Approx] = &[
    Approx::table(8, 0),
    Approx::table(12, 0),
    Approx::table(16, 0),
    Approx::table(8, 1),
    Approx::table(12, 1),
    step(false, Refine::Unit),
    step(true, Refine::Code),
    step(false, Refine::Code),
];

/// Those of a unit that takes its steps itself.
const STEPPED: &[Approx] = PROGRAMMED.split_at(6).0;

/// Those of one that has none.
const PLAIN: &[Approx] = PROGRAMMED.split_at(3).0;

/// A 12-bit table with a step.
const fn step(fused: bool, refine: Refine) -> Approx {
    Approx::Table {
        structure: Structure::Table,
        bits: 12,
        steps: 1,
        fused,
        refine,
    }
}

fn reciprocals(all: &mut Vec<Setting>) {
    for &approx in STEPPED {
        let (value, how) = words(approx);
        let how = format!("<tni><special function=\"rcp\" {how}/>");
        let change = move |s: &mut Subject| s.arch.system.tni.rcp = approx;
        let setting = Setting::new("T&I reciprocal", value, how, change);
        all.push(setting.of_units(&[Function::Rcp], approx));
    }
}

/// A special function of the SRP: its knob, its name, and its place in the precision.
type SpecialFunction = (
    &'static str,
    &'static str,
    fn(&mut Precision) -> &mut Approx,
    &'static [Approx],
);

const FUNCTIONS: &[SpecialFunction] = &[
    ("slab reciprocal", "rcp", |p| &mut p.rcp, PROGRAMMED),
    (
        "reciprocal square root",
        "rsqrt",
        |p| &mut p.rsqrt,
        PROGRAMMED,
    ),
    ("square root", "sqrt", |p| &mut p.sqrt, PLAIN),
    ("division", "div", |p| &mut p.div, STEPPED),
    ("exp2 and log2", "exp2", |p| &mut p.exp2, PLAIN),
    ("sine and cosine", "sincos", |p| &mut p.sincos, PLAIN),
];

fn functions(all: &mut Vec<Setting>) {
    for &(knob, name, place, values) in FUNCTIONS {
        for &approx in values {
            let (value, how) = words(approx);
            let how = format!("<special function=\"{name}\" {how}/>");
            let setting = Setting::new(knob, value, how, move |s| {
                *place(&mut s.arch.precision) = approx;
                if name == "exp2" {
                    s.arch.precision.log2 = approx;
                }
            });
            let function = Function::ALL.iter().filter(|f| name.starts_with(f.name()));
            let functions: Vec<Function> = function.copied().collect();
            let specials = Special::ALL
                .iter()
                .filter(|s| s.name() == name || name == "exp2" && **s == Special::Log2);
            all.push(Setting {
                specials: specials.copied().collect(),
                ..setting.of_units(&functions, approx)
            });
        }
    }
}

/// Adds the settings of subnormal floats on the SRP.
fn floats(all: &mut Vec<Setting>) {
    for subnormals in Subnormals::ALL {
        let how = format!("<float subnormals=\"{}\"/>", subnormals.name());
        all.push(Setting::new(
            "subnormals",
            subnormals.name(),
            how,
            move |s| {
                s.arch.precision.subnormals = subnormals;
            },
        ));
    }
}

/// Adds the settings of adders and multipliers on the SRP.
fn formats(all: &mut Vec<Setting>) {
    for (kind, (name, knob)) in KINDS.into_iter().enumerate() {
        for (value, format) in Format::NAMED {
            let how = format!("<float {name}=\"{value}\"/>");
            all.push(Setting::new(knob, value, how, move |s| {
                *s.arch.precision.formats.of_kind(kind) = format;
            }));
        }
    }
}

/// Whatever the kernels leave open.
fn forms(all: &mut Vec<Setting>) {
    for form in form::TABLE {
        for (value, _) in form.values {
            let choice = format!("{}={value}", form.name);
            let how = format!("--form {choice}");
            all.push(Setting::new(form.name, *value, how, move |s| {
                if let Ok(forms) = s.build.forms.with(&choice) {
                    s.build.forms = forms;
                }
            }));
        }
    }
}

fn compiler(all: &mut Vec<Setting>) {
    type Allow = fn(&mut FastMath);
    let allowances: [(&str, &str, Allow); 3] = [
        ("sums re-associated", "associative-math", |f| {
            f.associative = true
        }),
        ("quotients by reciprocals", "reciprocal-math", |f| {
            f.reciprocal = true
        }),
        ("products fused into sums", "fp-contract=fast", |f| {
            f.contract = true
        }),
    ];
    for (value, feature, allow) in allowances {
        let how = format!("-f{feature}");
        all.push(Setting::new("compiler", value, how, move |s| {
            allow(&mut s.build.fast_math);
        }));
    }
}

fn memory(all: &mut Vec<Setting>) {
    for format in NodeFormat::ALL {
        let how = format!("<tni node-format=\"{}\">", format.name());
        all.push(Setting::new("node boxes", format.name(), how, move |s| {
            let tni = &mut s.arch.system.tni;
            if tni.node_format != format {
                (tni.node_format, tni.node_bytes) = (format, format.bytes());
            }
        }));
    }
    for bits in [0, 4, 12] {
        let how = format!("<texture weight-bits=\"{bits}\"/>");
        let setting = Setting::new("texel weights", format!("{bits} bits"), how, move |s| {
            s.arch.precision.texture_weight_bits = bits;
        });
        all.push(Setting {
            is_of_texels: true,
            ..setting
        });
    }
}

/// Rays a pixel and bounces that are tried.
const SAMPLES: [u32; 3] = [1, 4, 16];
const BOUNCES: [u32; 4] = [0, 1, 2, 4];

/// A subject with the most samples and bounces that are tried of it.
pub(super) fn finest(base: &Subject) -> Subject {
    let mut finest = base.clone();
    let options = &mut finest.options;
    options.samples = SAMPLES.into_iter().fold(options.samples, u32::max);
    options.bounces = BOUNCES.into_iter().fold(options.bounces, u32::max);
    finest
}

fn light(all: &mut Vec<Setting>) {
    for samples in SAMPLES {
        let how = format!("--samples {samples}");
        all.push(Setting::new(
            "samples a pixel",
            samples.to_string(),
            how,
            move |s| {
                s.options.samples = samples;
                if samples > 1 {
                    s.build.effects = s.build.effects.with(Effect::Antialiasing);
                }
            },
        ));
    }
    for bounces in BOUNCES {
        let how = format!("--bounces {bounces}");
        all.push(Setting::new(
            "bounces",
            bounces.to_string(),
            how,
            move |s| {
                s.options.bounces = bounces;
                s.build.bounces = bounces;
            },
        ));
    }
}
