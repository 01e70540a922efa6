//! The subject of a study: a function of C, a whole program, or an FPCore, with a `main` that runs it on samples.

use super::fpcore::{self, At, Core};
use super::translate;
use crate::Error;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::nearest::nearest;
use srp_ir::interp::SYSTEM_BASE;
use srp_toolchain::{Function, Interface, Options, Shape};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

/// Evaluations of a function that one run of its `main` makes.
pub(super) const BATCH: u32 = 256;

/// Elements behind the last of every array, which nothing should access.
pub(super) const GUARD: u32 = 64;

/// Elements of an array whose length nobody says.
const ARRAY: u32 = 64;

/// The name that stands for the program's `main` while another is used.
const MAIN: &str = "srp_main_of_the_program";

/// The questions asked about a file.
#[derive(Clone, Debug, Default)]
pub struct Question {
    /// Ranges by the names of parameters or objects.
    pub ranges: Vec<(String, f64, f64)>,
    /// Elements of arrays, by the names of parameters.
    pub lengths: Vec<(String, u32)>,
    /// The function, or the benchmark, that is studied; all that have ranges where none is named.
    pub function: Option<String>,
}

/// Where numbers stand while a kernel runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// In an object with static storage.
    Object(String),
    /// In system memory, so many bytes behind its start.
    System(u32),
}

/// Numbers that a kernel is given.
#[derive(Clone, Debug)]
pub(super) struct Input {
    pub(super) name: String,
    pub(super) place: Place,
    /// Numbers of one evaluation.
    pub(super) length: u32,
    pub(super) integer: bool,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Numbers that it gives.
#[derive(Clone, Debug)]
pub(super) struct Output {
    pub(super) name: String,
    pub(super) place: Place,
    /// Numbers of one evaluation.
    pub(super) length: u32,
}

/// The subject of a study.
#[derive(Clone, Debug)]
pub(super) struct Kernel {
    pub(super) name: String,
    pub(super) file: String,
    pub(super) sources: Vec<Source>,
    pub(super) defines: Vec<(String, String)>,
    pub(super) inputs: Vec<Input>,
    pub(super) outputs: Vec<Output>,
    /// Evaluations that a run of `main` makes, each on numbers of its own.
    pub(super) batch: u32,
    /// The object that says how many they are, if one does.
    pub(super) count: Option<String>,
    /// Bytes of system memory.
    pub(super) system_bytes: u32,
    /// The benchmark that says what is meant, where C does not.
    pub(super) core: Option<Core>,
    /// Places in the user's file by the lines of the C that was made of it.
    pub(super) lines: BTreeMap<u32, At>,
    /// The assumptions that were made, in sentences.
    pub(super) notes: Vec<String>,
}

/// The kernels of a file that a question is about. Of a file of benchmarks, each that cannot be used has an error
/// of its own.
pub(super) fn kernels(
    source: &Source,
    question: &Question,
    arch: &Arch,
    options: &Options,
) -> Result<Vec<Result<Kernel, Error>>, Error> {
    match Path::new(&source.name)
        .extension()
        .is_some_and(|e| e == "fpcore")
    {
        true => benchmarks(source, question, arch, options),
        false => {
            let found = functions(source, question, arch, options)?;
            Ok(found.into_iter().map(Ok).collect())
        }
    }
}

/// The range of an argument of a benchmark that states none.
const UNSTATED: (f64, f64) = (-1e6, 1e6);

impl Question {
    /// Refuses a range or a length of what is none of some parameters.
    fn names_only(&self, params: &[&str], of: &str) -> Result<(), Error> {
        let ranges = self.ranges.iter().map(|(name, ..)| ("--range", name));
        let lengths = self.lengths.iter().map(|(name, _)| ("--length", name));
        for (option, name) in ranges.chain(lengths) {
            if params.contains(&name.as_str()) {
                continue;
            }
            let known = match nearest(name, params.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are {}", params.join(", ")),
            };
            return Err(Error::invalid(format_args!(
                "{option} {name}: {of} has no such parameter; {known}"
            )));
        }
        Ok(())
    }
}

/// Those of an FPCore file.
fn benchmarks(
    source: &Source,
    question: &Question,
    arch: &Arch,
    options: &Options,
) -> Result<Vec<Result<Kernel, Error>>, Error> {
    let at = |at: At, why: &str| {
        Error::invalid(format_args!(
            "{}:{}:{}: {why}",
            source.name, at.line, at.column
        ))
    };
    let cores = fpcore::read(&source.text).map_err(|w| at(w.at, &w.why))?;
    let known = cores.iter().flatten();
    let names: Vec<String> = known.map(|c| c.name.clone()).collect();
    let is_named = |core: &Core| {
        question
            .function
            .as_ref()
            .is_none_or(|name| *name == core.name)
    };
    let wanted = |core: &Result<Core, _>| match core {
        Ok(core) => is_named(core),
        Err(_) => question.function.is_none(),
    };
    let cores: Vec<_> = cores.into_iter().filter(wanted).collect();
    if cores.is_empty() {
        return Err(Error::invalid(format_args!(
            "{} has no benchmark of this name; there are {}",
            source.name,
            names.join(", ")
        )));
    }
    let arguments = cores.iter().flatten().flat_map(|core| &core.args);
    let arguments: Vec<&str> = arguments.map(String::as_str).collect();
    if cores.iter().all(Result::is_ok) {
        question.names_only(&arguments, &source.name)?;
    }
    let kernel = |core: Result<Core, fpcore::Wrong>| {
        let core = core.map_err(|w| at(w.at, &w.why))?;
        let translated = translate::translate(&core).map_err(|w| at(w.at, &w.why))?;
        let mut stated = fpcore::ranges(&core);
        for (name, low, high) in &question.ranges {
            stated.insert(name.clone(), (*low, *high));
        }
        let mut notes = Vec::new();
        for arg in &core.args {
            if !stated.contains_key(arg) {
                let (low, high) = UNSTATED;
                notes.push(format!("`{arg}` has no range: taken from {low} to {high}"));
                stated.insert(arg.clone(), UNSTATED);
            }
        }
        let path = source.name.clone() + ".c";
        let made = Source::new(path.clone(), translated.text);
        let interface = srp_toolchain::interface(std::slice::from_ref(&made), arch, options)?;
        let function = interface
            .functions
            .iter()
            .find(|f| f.name == translated.function);
        let function =
            function.ok_or_else(|| at(core.body.at, "the C made of it has no function"))?;
        let mut function = function.clone();
        for (param, name) in function.params.iter_mut().zip(&core.args) {
            param.0.clone_from(name);
        }
        let range = |name: &str| stated.get(name).copied();
        let mut kernel = call(&made, &function, &range, &[])?;
        kernel.name.clone_from(&core.name);
        kernel.file.clone_from(&source.name);
        kernel.lines = translated.lines;
        kernel.notes.extend(notes);
        kernel.core = Some(core);
        Ok(kernel)
    };
    Ok(cores.into_iter().map(kernel).collect())
}

/// Those of a C file: functions with ranges, or the whole program.
fn functions(
    source: &Source,
    question: &Question,
    arch: &Arch,
    options: &Options,
) -> Result<Vec<Kernel>, Error> {
    let interface = srp_toolchain::interface(std::slice::from_ref(source), arch, options)?;
    let names_all = |f: &Function| {
        let has = |name: &String| f.params.iter().any(|(param, _)| param == name);
        !question.ranges.is_empty() && question.ranges.iter().all(|(name, ..)| has(name))
    };
    let chosen: Vec<&Function> = match &question.function {
        Some(name) => {
            let found = interface.functions.iter().find(|f| f.name == *name);
            let names = || {
                interface
                    .functions
                    .iter()
                    .map(|f| f.name.as_str())
                    .collect::<Vec<_>>()
            };
            vec![found.ok_or_else(|| {
                Error::invalid(format_args!(
                    "{} defines no function `{name}`; there are {}",
                    source.name,
                    names().join(", ")
                ))
            })?]
        }
        None => {
            let stated = |f: &&Function| !ranges_before(&interface, f).is_empty();
            let by_pragma: Vec<&Function> = interface.functions.iter().filter(stated).collect();
            let by_name: Vec<&Function> = interface
                .functions
                .iter()
                .filter(|f| names_all(f))
                .collect();
            match (by_name.as_slice(), by_pragma.is_empty()) {
                ([_], _) => by_name,
                (_, false) => by_pragma,
                ([], true) => return program(source, question, &interface).map(|k| vec![k]),
                (several, true) => {
                    let names: Vec<&str> = several.iter().map(|f| f.name.as_str()).collect();
                    return Err(Error::invalid(format_args!(
                        "several functions have such parameters: {}; choose one with --function",
                        names.join(", ")
                    )));
                }
            }
        }
    };
    let params = chosen.iter().flat_map(|function| &function.params);
    let params: Vec<&str> = params.map(|(name, _)| name.as_str()).collect();
    let names: Vec<&str> = chosen.iter().map(|f| f.name.as_str()).collect();
    question.names_only(&params, &names.join(", "))?;
    let kernel = |function: &&Function| {
        let stated = ranges_before(&interface, function);
        let range = |name: &str| {
            let asked = question.ranges.iter().find(|(n, ..)| n == name);
            let asked = asked.map(|(_, low, high)| (*low, *high));
            asked.or_else(|| stated.get(name).copied())
        };
        call(source, function, &range, &question.lengths)
    };
    chosen.iter().map(kernel).collect()
}

/// The statements of pragmas between a function and the one before it.
fn ranges_before(interface: &Interface, function: &Function) -> BTreeMap<String, (f64, f64)> {
    let same_file = |f: &&Function| f.file == function.file && f.line < function.line;
    let before = interface.functions.iter().filter(same_file).map(|f| f.line);
    let before = before.max().unwrap_or(0);
    let between = |line: u32| before <= line && line <= function.line;
    let has = |name: &String| function.params.iter().any(|(param, _)| param == name);
    let ranges = interface.ranges.iter();
    ranges
        .filter(|r| r.file == function.file && between(r.line) && has(&r.name))
        .map(|r| (r.name.clone(), (r.low, r.high)))
        .collect()
}

/// The kernel that calls a function on samples of its parameters.
fn call(
    source: &Source,
    function: &Function,
    range: &dyn Fn(&str) -> Option<(f64, f64)>,
    lengths: &[(String, u32)],
) -> Result<Kernel, Error> {
    let refused = |what: &str| {
        let (file, line) = (&function.file, function.line);
        Error::invalid(format_args!("{file}:{line}: `{}` {what}", function.name))
    };
    let length = |name: &str| lengths.iter().find(|(n, _)| n == name).map(|(_, n)| *n);
    let is_size =
        |(name, shape): &&(String, Shape)| *shape == Shape::Integer && range(name).is_none();
    // A count of elements without a range: one evaluation is of whole arrays.
    let sized = function.params.iter().any(|param| is_size(&param));
    let size = lengths.iter().map(|(_, n)| *n).max().unwrap_or(ARRAY);
    let mut kernel = Kernel {
        name: function.name.clone(),
        file: source.name.clone(),
        sources: Vec::new(),
        defines: vec![("main".to_owned(), MAIN.to_owned())],
        inputs: Vec::new(),
        outputs: Vec::new(),
        batch: if sized { 1 } else { BATCH },
        count: Some("srp_count".to_owned()),
        system_bytes: 0,
        core: None,
        lines: BTreeMap::new(),
        notes: Vec::new(),
    };
    let mut driver = Driver::default();
    for param in &function.params {
        let (name, shape) = param;
        match shape {
            Shape::Float => {
                let range = range(name).ok_or_else(|| refused(&no_range(name)))?;
                let argument = driver.input(&mut kernel, name, (1, false), range, None);
                driver.arguments.push(argument);
            }
            Shape::Integer if is_size(&param) => {
                kernel
                    .notes
                    .push(format!("`{name}` is {size}, the length of the arrays"));
                driver.arguments.push(size.to_string());
            }
            Shape::Integer => {
                let range = range(name).ok_or_else(|| refused(&no_range(name)))?;
                let argument = driver.input(&mut kernel, name, (1, true), range, None);
                driver.arguments.push(argument);
            }
            Shape::Pointer {
                to,
                constant,
                global,
            } if matches!(**to, Shape::Float | Shape::Integer) => {
                let integer = **to == Shape::Integer;
                let count = length(name).unwrap_or(if sized { size } else { 1 });
                let range = range(name);
                let argument = match range {
                    Some(range) => {
                        driver.input(&mut kernel, name, (count, integer), range, Some(*global))
                    }
                    None if *constant || integer => return Err(refused(&no_range(name))),
                    None => driver.output(&mut kernel, name, count, *global),
                };
                if range.is_some() && !constant && !integer {
                    let input = kernel.inputs.last();
                    let place = input.map(|i| i.place.clone());
                    kernel.outputs.extend(place.map(|place| Output {
                        name: name.clone(),
                        place,
                        length: count,
                    }));
                }
                driver.arguments.push(argument);
            }
            Shape::Other(ty) if ty.contains("double") => {
                return Err(refused(&format!(
                    "takes the {ty} `{name}`: say --double float, or write float"
                )));
            }
            _ => {
                return Err(refused(&format!(
                    "has a parameter `{name}` that is neither a number nor a pointer to numbers"
                )));
            }
        }
    }
    let called = format!("{}({})", function.name, driver.arguments.join(", "));
    let call = match &function.result {
        Shape::Float => {
            let to = driver.output(&mut kernel, "result", 1, false);
            // An output is passed as a pointer; the result is set.
            format!("*({to}) = {called};")
        }
        Shape::Other(ty) if ty.contains("double") => {
            return Err(refused(
                "gives a double: say --double float, or write float",
            ));
        }
        _ => format!("{called};"),
    };
    if kernel.outputs.is_empty() {
        return Err(refused(
            "gives no float, neither as its result nor through a pointer",
        ));
    }
    if kernel.inputs.is_empty() {
        return Err(refused("has no parameter that varies"));
    }
    let batch = kernel.batch;
    let mut text = source.text.clone();
    let _ = write!(
        text,
        "\n#undef main\nint srp_count = {batch};\n{}int main(void)\n{{\n    for (int srp_i = 0; srp_i < srp_count; \
         srp_i++)\n        {call}\n    return 0;\n}}\n",
        driver.objects
    );
    kernel.sources.push(Source::new(source.name.clone(), text));
    Ok(kernel)
}

fn no_range(name: &str) -> String {
    format!(
        "has a parameter `{name}` without a range: --range {name}=LOW:HIGH, or #pragma srp range({name}, LOW, HIGH) before the function"
    )
}

/// The objects of a `main`, and the arguments of its call.
#[derive(Default)]
struct Driver {
    objects: String,
    arguments: Vec<String>,
    numbers: u32,
}

impl Driver {
    /// Room for numbers; where they stand, and an expression that points at those of one evaluation.
    fn room(
        &mut self,
        kernel: &mut Kernel,
        (length, integer): (u32, bool),
        global: bool,
    ) -> (Place, String) {
        let count = length * kernel.batch + GUARD;
        let ty = if integer { "int" } else { "float" };
        if global {
            let at = kernel.system_bytes;
            kernel.system_bytes += (4 * count).next_multiple_of(64);
            let address = SYSTEM_BASE + at;
            let pointer = format!("(__srp_global {ty} *){address:#x}u + {length} * srp_i");
            return (Place::System(at), pointer);
        }
        self.numbers += 1;
        let name = format!("srp_numbers_{}", self.numbers);
        let _ = writeln!(self.objects, "{ty} {name}[{count}];");
        let pointer = format!("{name} + {length} * srp_i");
        (Place::Object(name), pointer)
    }

    /// An input; its argument is a pointer where it is said in which memory.
    fn input(
        &mut self,
        kernel: &mut Kernel,
        name: &str,
        (length, integer): (u32, bool),
        (low, high): (f64, f64),
        pointer: Option<bool>,
    ) -> String {
        let (place, at) = self.room(kernel, (length, integer), pointer == Some(true));
        kernel.inputs.push(Input {
            name: name.to_owned(),
            place,
            length,
            integer,
            low,
            high,
        });
        match pointer {
            Some(_) => at,
            None => format!("*({at})"),
        }
    }

    fn output(&mut self, kernel: &mut Kernel, name: &str, length: u32, global: bool) -> String {
        let (place, at) = self.room(kernel, (length, false), global);
        kernel.outputs.push(Output {
            name: name.to_owned(),
            place,
            length,
        });
        at
    }
}

/// Why there is nothing to study: no range, or one of a name that no function and no object has.
fn unranged(source: &Source, question: &Question, interface: &Interface) -> Error {
    let parameters = interface.functions.iter().flat_map(|f| &f.params);
    let parameters = parameters.map(|(name, _)| name.as_str());
    let objects = interface.objects.iter().map(|o| o.name.as_str());
    let known: BTreeSet<&str> = parameters.chain(objects).collect();
    let unknown = question
        .ranges
        .iter()
        .find(|(name, ..)| !known.contains(name.as_str()));
    Error::invalid(match unknown {
        Some((name, ..)) => format!(
            "{}: no function has a parameter `{name}`, nor is there an object of numbers of this name; there are {}",
            source.name,
            Vec::from_iter(known).join(", ")
        ),
        None => format!(
            "{}: no parameter or object has a range: --range NAME=LOW:HIGH, or #pragma srp range(NAME, LOW, HIGH) before a function",
            source.name
        ),
    })
}

/// A whole program, whose objects are its inputs and outputs.
fn program(source: &Source, question: &Question, interface: &Interface) -> Result<Kernel, Error> {
    if !interface.functions.iter().any(|f| f.name == "main") {
        return Err(unranged(source, question, interface));
    }
    let mut ranges: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for stated in &interface.ranges {
        ranges.insert(&stated.name, (stated.low, stated.high));
    }
    for (name, low, high) in &question.ranges {
        ranges.insert(name, (*low, *high));
    }
    let numbers = |shape: &Shape| match shape {
        Shape::Float => Some((1, false)),
        Shape::Integer => Some((1, true)),
        Shape::Array(of, length) if **of == Shape::Float => Some((*length, false)),
        Shape::Array(of, length) if **of == Shape::Integer => Some((*length, true)),
        _ => None,
    };
    let object = |name: &str| interface.objects.iter().find(|o| o.name == name);
    let mut inputs = Vec::new();
    for (name, (low, high)) in &ranges {
        let found = object(name).and_then(|o| numbers(&o.shape));
        let (length, integer) = found.ok_or_else(|| {
            Error::invalid(format_args!(
                "{}: neither a function has a parameter `{name}`, nor is there an object of numbers of this name",
                source.name
            ))
        })?;
        inputs.push(Input {
            name: (*name).to_owned(),
            place: Place::Object((*name).to_owned()),
            length,
            integer,
            low: *low,
            high: *high,
        });
    }
    let mut outputs = Vec::new();
    for object in &interface.objects {
        let is_input = ranges.contains_key(object.name.as_str());
        if let (Some((length, false)), false, false) =
            (numbers(&object.shape), object.constant, is_input)
        {
            outputs.push(Output {
                name: object.name.clone(),
                place: Place::Object(object.name.clone()),
                length,
            });
        }
    }
    if inputs.is_empty() || outputs.is_empty() {
        let what = if inputs.is_empty() {
            "no object has a range: --range NAME=LOW:HIGH"
        } else {
            "no object of floats is left that results could be in"
        };
        return Err(Error::invalid(format_args!("{}: {what}", source.name)));
    }
    Ok(Kernel {
        name: "main".to_owned(),
        file: source.name.clone(),
        sources: vec![source.clone()],
        defines: Vec::new(),
        inputs,
        outputs,
        batch: 1,
        count: None,
        system_bytes: 0,
        core: None,
        lines: BTreeMap::new(),
        notes: Vec::new(),
    })
}
