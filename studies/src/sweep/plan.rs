//! Plans of sweeps: what is varied, of what, and what is measured.
//!
//! A [`PlanFile`] is a plan as it is written, in TOML and on the command line; a [`Plan`] is one that was read and found
//! to make sense, with its points drawn.

use super::draw::Sample;
use super::measure::Measure;
use super::objective::Objective;
pub use super::point::Point;
use super::point::{Parameter, Target};
use super::search::Search;
use super::values::Values;
use crate::Error;
use crate::fidelity::Fidelity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_ir::pass::FastMath;
use srp_kernels::effect::Effects;
use srp_kernels::form::Forms;
use srp_runtime::bvh::Builder;
use srp_toolchain::{Effort, machine};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A plan as a file has it. Paths are relative to the folder that it is read from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct PlanFile {
    /// The machine that is varied: a file, or the name of one that comes along.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
    /// Scenes: files, `default`, or `FILE@CAMERAS.json:NAME/N` for a view.
    pub scenes: Vec<String>,
    /// C programs.
    pub programs: Vec<String>,
    /// The folder of the kernels, instead of those that come along.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernels: Option<String>,
    /// `WIDTHxHEIGHT`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
    /// The level of simulation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fidelity: Option<String>,
    /// The measures.
    pub measure: Vec<String>,
    /// Objectives: columns of the measures, as `cycles`, `min:area.srp` or `max:psnr`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objective: Vec<String>,
    /// `grid`, `list`, `random:N`, `lhs:N`, `search:N`, `search:N:P`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<String>,
    /// The seed of what is drawn.
    pub seed: u64,
    /// How long loops are scheduled, in so many times the usual.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// The parameters that are varied, with their values.
    pub set: BTreeMap<String, Listed>,
    /// Points of a list.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub point: Vec<BTreeMap<String, Scalar>>,
}

/// A value as TOML has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Scalar {
    /// A flag.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// Another number.
    Number(f64),
    /// A text.
    Text(String),
}

impl Scalar {
    fn text(&self) -> String {
        match self {
            Scalar::Flag(flag) => flag.to_string(),
            Scalar::Whole(number) => number.to_string(),
            Scalar::Number(number) => number.to_string(),
            Scalar::Text(text) => text.clone(),
        }
    }
}

/// The values of a parameter as TOML has them: a list, or a text as on the command line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Listed {
    /// All of them.
    List(Vec<Scalar>),
    /// `4,5,6`, `0:300:100` or `1..64`, or a single value.
    One(Scalar),
}

impl PlanFile {
    /// Reads a plan. Its paths become paths that hold anywhere.
    ///
    /// # Errors
    ///
    /// It is no TOML, or has a key that a plan does not have.
    pub fn parse(name: &str, text: &str, folder: &Path) -> Result<PlanFile, Error> {
        let plan: PlanFile = toml::from_str(text).map_err(|error| {
            let before = &text[..error.span().map_or(0, |span| span.start)];
            let line = before.matches('\n').count() + 1;
            let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
            Error::Invalid(format!("{name}:{line}:{column}: {}", error.message()))
        })?;
        Ok(plan.within(folder))
    }

    /// The same, with the paths of files taken from a folder.
    #[must_use]
    pub fn within(mut self, folder: &Path) -> PlanFile {
        let absolute = |path: &str| {
            let path = folder.join(path);
            let path = std::path::absolute(&path).unwrap_or(path);
            path.display().to_string()
        };
        let is_file = |name: &str| name.ends_with(".xml") || name.contains('/');
        self.machine = self
            .machine
            .map(|m| if is_file(&m) { absolute(&m) } else { m });
        self.kernels = self.kernels.map(|k| absolute(&k));
        self.programs = self.programs.iter().map(|p| absolute(p)).collect();
        let scene = |scene: &String| match scene.split_once('@') {
            _ if scene == "default" => scene.clone(),
            Some((file, view)) => format!("{}@{}", absolute(file), absolute(view)),
            None => absolute(scene),
        };
        self.scenes = self.scenes.iter().map(scene).collect();
        self
    }

    /// Varies a parameter over values as the command line has them.
    pub fn set(&mut self, name: &str, values: &str) {
        let values = Listed::One(Scalar::Text(values.to_owned()));
        self.set.insert(name.to_owned(), values);
    }

    /// What is measured: what the plan says, and what its objectives need.
    fn measures(&self) -> Result<Vec<Measure>, Error> {
        let said = self.measure.iter().map(|name| Measure::parse(name));
        let mut measures: Vec<Measure> = said.collect::<Result<_, _>>()?;
        if self.measure.is_empty() && self.objective.is_empty() {
            measures = vec![Measure::Ii, Measure::Area];
        }
        for objective in Objective::all(&self.objective)? {
            let needed = objective.measure().filter(|m| !measures.contains(m));
            measures.extend(needed);
        }
        Ok(measures)
    }

    /// The objectives that the plan states; of a search that states none, those that are measured. Any other sweep without
    /// objectives compares by what its rows have.
    pub(super) fn objectives(&self) -> Result<Vec<Objective>, Error> {
        let stated = Objective::all(&self.objective)?;
        if !stated.is_empty() || !matches!(self.sample()?, Sample::Search(_)) {
            return Ok(stated);
        }
        let measures = self.measures()?;
        let is_measured =
            |column: &str| Measure::of_column(column).is_some_and(|m| measures.contains(&m));
        Ok(Objective::usual(&is_measured))
    }

    /// The level of simulation by its name.
    pub(super) fn level(&self) -> &str {
        self.fidelity.as_deref().unwrap_or("cycle+dram")
    }

    /// Width and height of frames.
    pub(super) fn sides(&self) -> Result<(u32, u32), Error> {
        size(self.size.as_deref().unwrap_or("320x240"))
    }

    fn sample(&self) -> Result<Sample, Error> {
        Sample::parse(self.sample.as_deref(), !self.point.is_empty())
    }

    fn parameters(&self) -> Result<Vec<Parameter>, Error> {
        let set = self.set.iter();
        set.map(|(name, values)| parameter(name, values)).collect()
    }

    /// The search, where points are found by one.
    pub(super) fn search(&self) -> Result<Option<Search>, Error> {
        match self.sample()? {
            Sample::Search(budget) => {
                Ok(Some(Search::new(budget, self.seed, &self.parameters()?)?))
            }
            _ => Ok(None),
        }
    }

    /// The plan as a file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a plan has only what TOML can write")
    }
}

/// A sweep that can be run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// As it was written.
    pub file: PlanFile,
    /// The machine that is varied: its name, and its text.
    pub machine: (String, String),
    /// The parameters that are varied.
    pub parameters: Vec<Parameter>,
    /// The points, each once; none of a search, which finds its points on its way.
    pub points: Vec<Point>,
    /// The search, where points are found by one.
    pub search: Option<Search>,
    /// The objectives that are stated, or searched by.
    pub objectives: Vec<Objective>,
    /// The measures.
    pub measures: Vec<Measure>,
    /// The level of simulation.
    pub fidelity: Fidelity,
    /// Width and height of frames.
    pub size: (u32, u32),
}

/// The choices of a point besides its machine file.
pub(super) struct Choices {
    pub(super) forms: Forms,
    pub(super) fast_math: FastMath,
    pub(super) prefetch: bool,
    pub(super) tree: Builder,
    pub(super) effort: Effort,
    pub(super) level: Fidelity,
    /// Effects beyond those that the scene calls for, or less, as `--effects` has them; empty of those alone.
    pub(super) effects: String,
}

impl Plan {
    /// Makes a plan of a file.
    ///
    /// # Errors
    ///
    /// A name that nothing has, a value that no point can have, or a combination that makes no sense.
    pub fn of(file: PlanFile) -> Result<Plan, Error> {
        let name = file.machine.clone().unwrap_or_else(|| "sgrt".to_owned());
        let text = machine::text(Path::new(&name))?;
        let measures = file.measures()?;
        let parameters = file.parameters()?;
        let fidelity = level(file.level())?;
        if file.scenes.is_empty() && !file.programs.is_empty() {
            for measure in &measures {
                measure.check_of_program()?;
            }
        }
        if !(parameters.iter()).any(|parameter| parameter.target == Target::Level) {
            for measure in &measures {
                measure.check(fidelity)?;
            }
        }
        let listed = file.point.iter().map(|point| {
            let settings = point
                .iter()
                .map(|(name, value)| (name.clone(), value.text()));
            Point(settings.collect())
        });
        let listed: Vec<Point> = listed.collect();
        for name in listed.iter().flat_map(|point| point.0.keys()) {
            target(name)?;
        }
        let points = file.sample()?.points(&parameters, listed, file.seed)?;
        let size = file.sides()?;
        let plan = Plan {
            machine: (name, text),
            parameters,
            points,
            search: file.search()?,
            objectives: file.objectives()?,
            measures,
            fidelity,
            size,
            file,
        };
        plan.check()?;
        Ok(plan)
    }

    /// Refuses parameters of which no value alone makes a machine: they are misspelt.
    fn check(&self) -> Result<(), Error> {
        for parameter in &self.parameters {
            let values: Vec<String> = match &parameter.values {
                Values::These(values) => values.clone(),
                between @ Values::Between { .. } => vec![between.at(0.0), between.at(0.5)],
            };
            let mut first = None;
            let works = values.iter().any(|value| {
                let point = Point([(parameter.name.clone(), value.clone())].into());
                match self.machine_of(&point).and_then(|_| self.choices(&point)) {
                    Ok(_) => true,
                    Err(why) => {
                        first.get_or_insert(why);
                        false
                    }
                }
            });
            if let (false, Some(why)) = (works, first) {
                return Err(Error::Invalid(format!(
                    "`{}`: no value of it makes a machine, the first for this reason: {why}",
                    parameter.name
                )));
            }
        }
        Ok(())
    }

    /// The machine file of a point, as text, with its name.
    ///
    /// # Errors
    ///
    /// The sentence of why it is none.
    pub fn text_of(&self, point: &Point) -> Result<(String, String), Error> {
        let (mut name, mut text) = self.machine.clone();
        if let Some(other) = point.0.get("machine") {
            name.clone_from(other);
            text = machine::text(Path::new(other))?;
        }
        for (path, value) in &point.0 {
            if let Target::Attribute(path) = target(path)? {
                text = path.set(&text, value).map_err(Error::invalid)?;
            }
        }
        Ok((name, text))
    }

    /// The machine of a point.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong with it.
    pub(super) fn machine_of(&self, point: &Point) -> Result<srp_archdesc::Arch, Error> {
        let (name, text) = self.text_of(point)?;
        let arch = match srp_archdesc::xml::parse(&name, &text) {
            Ok(arch) => arch,
            Err(diagnostics) => {
                let first = diagnostics.first();
                let why = first.map_or_else(String::new, |d| match &d.help {
                    Some(help) => format!("{} ({})", d.message, help),
                    None => d.message.clone(),
                });
                return Err(Error::Invalid(why));
            }
        };
        machine::check_system(&name, &arch)?;
        Ok(arch)
    }

    /// The other choices of a point.
    pub(super) fn choices(&self, point: &Point) -> Result<Choices, Error> {
        let mut choices = Choices {
            forms: Forms::default(),
            fast_math: FastMath::default(),
            prefetch: false,
            tree: Builder::Best,
            effort: effort(self.file.effort.unwrap_or(1.0))?,
            level: self.fidelity,
            effects: String::new(),
        };
        for (name, value) in &point.0 {
            match target(name)? {
                Target::Attribute(_) | Target::Machine => {}
                Target::Form(form) => {
                    let with = choices.forms.with(&format!("{form}={value}"));
                    choices.forms = with.map_err(Error::invalid)?;
                }
                Target::Feature(feature) => {
                    let on = flag(value).ok_or_else(|| wrong(name, value, "on or off"))?;
                    choose(&mut choices, &feature, on)?;
                }
                Target::Effect(effect) => {
                    let on = flag(value).ok_or_else(|| wrong(name, value, "on or off"))?;
                    let sign = if on { '+' } else { '-' };
                    let comma = if choices.effects.is_empty() { "" } else { "," };
                    choices.effects += &format!("{comma}{sign}{effect}");
                    let known = Effects::NONE.parse(&choices.effects);
                    known.map_err(srp_toolchain::Error::from)?;
                }
                Target::Level => {
                    choices.level = level(value)?;
                    for measure in &self.measures {
                        measure.check(choices.level)?;
                    }
                }
                Target::Tree => {
                    let all = [
                        Builder::Best,
                        Builder::Sweep,
                        Builder::SweepReinsertion,
                        Builder::Ploc,
                    ];
                    let found = all.into_iter().find(|b| b.name() == value);
                    let names: Vec<&str> = all.iter().map(|b| b.name()).collect();
                    choices.tree = found.ok_or_else(|| wrong(name, value, &names.join(", ")))?;
                }
                Target::Effort => {
                    let times = value.parse().ok();
                    choices.effort = effort(times.ok_or_else(|| wrong(name, value, "a number"))?)?;
                }
            }
        }
        Ok(choices)
    }
}

fn wrong(name: &str, value: &str, what: &str) -> Error {
    Error::Invalid(format!("`{name}={value}`: the value is {what}"))
}

fn flag(value: &str) -> Option<bool> {
    match value {
        "on" | "true" | "yes" => Some(true),
        "off" | "false" | "no" => Some(false),
        _ => None,
    }
}

fn level(name: &str) -> Result<Fidelity, Error> {
    let found = Fidelity::ALL.into_iter().find(|f| f.name() == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = Fidelity::ALL.iter().map(|f| f.name()).collect();
        Error::Invalid(format!("fidelity `{name}`: there are {}", names.join(", ")))
    })
}

fn effort(times: f64) -> Result<Effort, Error> {
    let percent = (times * 100.0).round();
    match (0.0..=1e7).contains(&percent) {
        true => Ok(Effort {
            percent: percent as u32,
            ..Effort::default()
        }),
        false => Err(Error::Invalid("effort: write 0 to 100000".to_owned())),
    }
}

/// A feature of the compiler: its name on the command line, and its choice.
type Feature = (&'static str, fn(&mut Choices, bool));

const FEATURES: [Feature; 6] = [
    ("fast-math", |all, on| {
        if on {
            all.fast_math = FastMath {
                associative: true,
                reciprocal: true,
                contract: true,
                approximate: true,
            };
        }
    }),
    ("associative-math", |all, on| {
        all.fast_math.associative |= on
    }),
    ("reciprocal-math", |all, on| all.fast_math.reciprocal |= on),
    ("fp-contract", |all, on| all.fast_math.contract |= on),
    ("approx-func", |all, on| all.fast_math.approximate |= on),
    ("prefetch-loop-arrays", |all, on| all.prefetch |= on),
];

fn choose(all: &mut Choices, feature: &str, on: bool) -> Result<(), Error> {
    match FEATURES.iter().find(|(name, _)| *name == feature) {
        Some((_, set)) => set(all, on),
        None => {
            let names: Vec<String> = FEATURES.iter().map(|(n, _)| format!("f:{n}")).collect();
            return Err(Error::Invalid(format!(
                "`f:{feature}`: there are {}",
                names.join(", ")
            )));
        }
    }
    Ok(())
}

/// The target of a name.
fn target(name: &str) -> Result<Target, Error> {
    if let Some(form) = name.strip_prefix("form:") {
        return Ok(Target::Form(form.to_owned()));
    }
    if let Some(feature) = name.strip_prefix("f:") {
        return Ok(Target::Feature(feature.to_owned()));
    }
    if let Some(effect) = name.strip_prefix("effect:") {
        return Ok(Target::Effect(effect.to_owned()));
    }
    match name {
        "machine" => Ok(Target::Machine),
        "fidelity" => Ok(Target::Level),
        "bvh" => Ok(Target::Tree),
        "effort" => Ok(Target::Effort),
        path if path.contains('.') => Ok(Target::Attribute(path.parse().map_err(Error::invalid)?)),
        name => Err(Error::Invalid(format!(
            "`{name}` sets nothing: write an attribute of the machine file (array.rows, \
             special[function=rcp].bits), machine, bvh, effort, fidelity, form:NAME, effect:NAME or f:FEATURE"
        ))),
    }
}

fn parameter(name: &str, values: &Listed) -> Result<Parameter, Error> {
    let values = match values {
        Listed::List(list) if list.is_empty() => {
            return Err(Error::Invalid(format!("`{name}` has no values")));
        }
        Listed::List(list) => Values::These(list.iter().map(Scalar::text).collect()),
        Listed::One(Scalar::Text(text)) => {
            Values::parse(text).map_err(|why| Error::Invalid(format!("`{name}`: {why}")))?
        }
        Listed::One(scalar) => Values::These(vec![scalar.text()]),
    };
    Ok(Parameter {
        name: name.to_owned(),
        target: target(name)?,
        values,
    })
}

fn size(text: &str) -> Result<(u32, u32), Error> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=16_384).contains(n));
    let sides = text.split_once('x');
    sides
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| Error::Invalid(format!("size `{text}`: write WIDTHxHEIGHT")))
}

/// Where a plan lies, for paths that it names.
pub fn folder_of(path: &Path) -> PathBuf {
    path.parent().map(Path::to_owned).unwrap_or_default()
}
