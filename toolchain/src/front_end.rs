//! From C to the intermediate form, and through the passes.

use crate::Error;
use crate::approximate;
use crate::coarse;
use crate::files::{self, Kind, Room};
use crate::input::{self, Input};
use crate::options::Options;
use srp_archdesc::arch::Arch;
use srp_archdesc::choice::Choices;
use srp_archdesc::diagnostic::{Diagnostic, Messages, Severity, Source, line_column};
use srp_archdesc::isa::Class;
use srp_frontend::interface::Interface;
use srp_frontend::{Include, Included, library};
use srp_ir::described::Described;
use srp_ir::pass::{self, Pass, Remark};
use srp_ir::program::Program;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Finds included files, and remembers every text that was read.
struct Texts<'a> {
    folders: &'a [PathBuf],
    room: Room,
    read: RefCell<BTreeMap<String, Source>>,
    /// The names of the sources themselves.
    asked_for: Vec<String>,
}

impl<'a> Texts<'a> {
    fn new(sources: &[Source], options: &'a Options) -> Texts<'a> {
        let read = sources.iter().map(|s| (s.name.clone(), s.clone()));
        let own = sources.iter().filter(|s| !comes_along(s));
        let folders = own.filter_map(|s| Path::new(&s.name).parent());
        let folders = folders.chain(options.include.iter().map(PathBuf::as_path));
        Texts {
            folders: &options.include,
            room: Room::of(folders, options.outside),
            read: RefCell::new(read.collect()),
            asked_for: sources.iter().map(|s| s.name.clone()).collect(),
        }
    }

    /// An included file: beside the file that asks, in the folders of the options, or one of those
    /// that come along. Nothing lies beside a file that comes along, whatever the current folder has.
    fn find(&self, include: &Include<'_>) -> Included {
        let beside = Path::new(include.from).parent().map(Path::to_owned);
        let asks_beside = !include.system
            && !self
                .read
                .borrow()
                .get(include.from)
                .is_some_and(comes_along);
        let folders = beside.into_iter().filter(|_| asks_beside);
        let mut refused = None;
        for folder in folders.chain(self.folders.iter().cloned()) {
            let path = folder.join(include.name);
            match self.room.read(&path, Kind::Source) {
                Ok(named) => {
                    let text = srp_frontend::bytes::decode(named.bytes);
                    let source = Source::new(path.display().to_string(), text);
                    self.remember(&source);
                    let outside =
                        || format!("`{}` is outside the folders of the program", source.name);
                    return match named.is_outside {
                        true => Included::Doubtful(source.clone(), outside()),
                        false => Included::Found(source),
                    };
                }
                Err(why) if is_absent(why.kind()) => {}
                Err(why) => refused = refused.or(Some(why.to_string())),
            }
        }
        match (srp_kernels::header(include.name), refused) {
            (Some(header), _) => {
                let source = input::source(header);
                self.remember(&source);
                Included::Found(source)
            }
            // One that the library has of that name is as good.
            (None, Some(why)) if library::header(include.name).is_none() => Included::Refused(why),
            (None, _) => Included::Missing,
        }
    }

    fn remember(&self, source: &Source) {
        let mut read = self.read.borrow_mut();
        read.insert(source.name.clone(), source.clone());
    }

    /// The texts of a program's files, but of those that are not C by their names.
    fn of(&self, program: &Program) -> BTreeMap<String, String> {
        let read = self.read.borrow();
        let text = |name: &String| match read.get(name) {
            Some(source) => (!self.is_foreign(name)).then(|| source.text.clone()),
            None => library::text(name).map(str::to_owned),
        };
        let names = program.files.values();
        let texts = names.filter_map(|name| Some((name.clone(), text(name)?)));
        texts.collect()
    }

    /// True for an included file that is not C by its name.
    fn is_foreign(&self, name: &str) -> bool {
        let is_asked_for = self.asked_for.iter().any(|asked| asked == name);
        !is_asked_for && self.read.borrow().contains_key(name) && !files::is_c(Path::new(name))
    }

    /// Messages in which one that quotes nothing stands for all about a file that is not C by its name.
    fn without_foreign_text(&self, diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
        let read = self.read.borrow();
        let mut told = BTreeSet::new();
        let mut shown = Vec::new();
        for message in diagnostics {
            if !self.is_foreign(&message.file) {
                shown.push(message);
            } else if told.insert(message.file.clone()) {
                let text = read.get(&message.file).map_or("", |s| s.text.as_str());
                let at = message.primary.as_ref().map(|label| label.span.start);
                let line = at.map_or(1, |at| line_column(text, at).0);
                let what = format!(
                    "`{}` is included and is not right in line {line}; it is not C by its name, so none of it is shown",
                    message.file
                );
                shown.push(Diagnostic {
                    severity: message.severity,
                    ..Diagnostic::error(message.code, &message.file, what)
                });
            }
        }
        shown
    }

    /// The messages with the texts that they are about. Of files that are not C by their names, such as a list of
    /// passwords that a stranger's program includes, nothing is shown.
    fn messages(&self, diagnostics: Vec<Diagnostic>) -> Messages {
        let diagnostics = self.without_foreign_text(diagnostics);
        let mut read = self.read.borrow_mut();
        let mut text = |name: &str| {
            let library = || library::text(name).map(|text| Source::new(name, text));
            read.remove(name).or_else(library)
        };
        let sources = diagnostics.iter().filter_map(|d| text(&d.file));
        Messages {
            sources: sources.collect(),
            diagnostics,
        }
    }
}

/// True if a source is one of those that come along.
fn comes_along(source: &Source) -> bool {
    let mut all = srp_kernels::SOURCES.iter().chain(srp_kernels::HEADERS);
    all.any(|file| file.path == source.name && file.text == source.text)
}

/// True if a file is not there, and may be in another folder.
fn is_absent(error: ErrorKind) -> bool {
    use ErrorKind::{IsADirectory, NotADirectory, NotFound};
    matches!(error, NotFound | NotADirectory | IsADirectory)
}

/// Runs `f` with the front end's options.
fn with<R>(
    texts: &Texts<'_>,
    arch: &Arch,
    options: &Options,
    f: impl FnOnce(&srp_frontend::Options<'_>) -> R,
) -> R {
    let buffers = &arch.system.buffers;
    let machine = [
        ("SRP_RAYS", buffers.rays),
        ("SRP_RAY_BUFFERS", buffers.ray_buffers),
        ("SRP_SRAM_BYTES", arch.system.sram_bytes),
        ("SRP_HIT_BUFFERS", buffers.hit_buffers),
    ];
    let machine = machine.map(|(name, value)| (name.to_owned(), value.to_string()));
    let pairs = [
        ("SRP_PAIRS", Class::Pair),
        ("SRP_VECTOR_PAIRS", Class::Vpair),
    ];
    let pairs = pairs
        .into_iter()
        .filter(|(_, class)| arch.srp.fus.values().any(|fu| fu.op(*class).is_some()))
        .map(|(name, _)| (name.to_owned(), "1".to_owned()));
    let approximate = ("__SRP_APPROX_FUNC".to_owned(), "1".to_owned());
    let approximate = options.fast_math.approximate.then_some(approximate);
    let units = srp_frontend::precision_macros(&arch.precision);
    let machine = machine.into_iter().chain(units).chain(pairs);
    let machine = machine.chain(approximate);
    f(&srp_frontend::Options {
        defines: machine.chain(options.defines.clone()).collect(),
        resolve: &|include| texts.find(include),
        auto_kernel: options.auto_kernel,
        double_is_float: options.double_is_float,
        single_constants: options.single_constants,
        choices: Choices::of(arch),
        max_ulp: options.max_ulp,
        software: arch.srp.in_software(),
    })
}

/// Compiles C to the intermediate form, before the passes, with warnings.
///
/// # Errors
///
/// All that is wrong with the sources.
pub fn front_end(
    sources: &[Source],
    arch: &Arch,
    options: &Options,
) -> Result<(Program, Messages), Error> {
    let front = with_texts(sources, arch, options)?;
    Ok((front.program, front.messages))
}

/// A program with the text that it comes from.
#[derive(Clone, Debug)]
pub struct WithTexts {
    /// The program.
    pub program: Program,
    /// Warnings.
    pub messages: Messages,
    /// The text of each of its files, by the file's name: of the sources, of what they include, and of the library's.
    /// Included files that are not C by their names have none.
    pub texts: BTreeMap<String, String>,
}

/// [`front_end`], with the texts of all files that were read.
///
/// # Errors
///
/// All that is wrong with the sources.
pub fn with_texts(sources: &[Source], arch: &Arch, options: &Options) -> Result<WithTexts, Error> {
    let texts = Texts::new(sources, options);
    let compiled = with(&texts, arch, options, |o| srp_frontend::compile(sources, o));
    told(compiled, &texts, arch, options)
}

/// [`with_texts`], with the types and variables that a debugger shows.
///
/// # Errors
///
/// All that is wrong with the sources.
pub fn described(
    sources: &[Source],
    arch: &Arch,
    options: &Options,
) -> Result<(WithTexts, Described), Error> {
    let texts = Texts::new(sources, options);
    let mut described = Described::default();
    let compiled = with(&texts, arch, options, |o| {
        let (program, warnings, found) = srp_frontend::compile_described(sources, o)?;
        described = found;
        Ok((program, warnings))
    });
    Ok((told(compiled, &texts, arch, options)?, described))
}

/// A program, with the messages that are asked for.
fn told(
    compiled: Result<(Program, Vec<Diagnostic>), Vec<Diagnostic>>,
    texts: &Texts<'_>,
    arch: &Arch,
    options: &Options,
) -> Result<WithTexts, Error> {
    let (program, mut diagnostics) = match compiled {
        Ok((program, warnings)) => (Some(program), warnings),
        Err(errors) => (None, errors),
    };
    let of_files = program.as_ref().map(|program| texts.of(program));
    if let (Some(program), Some(texts), Some(max_ulp)) = (&program, &of_files, options.max_ulp) {
        diagnostics.extend(coarse::errors(program, max_ulp, &Choices::of(arch), texts));
    }
    let messages = texts.messages(options.warnings.choose(diagnostics));
    let is_error = |m: &Diagnostic| m.severity == Severity::Error;
    match program.zip(of_files) {
        Some((program, texts)) if !messages.diagnostics.iter().any(is_error) => Ok(WithTexts {
            program,
            messages,
            texts,
        }),
        _ => Err(Error::Messages(messages)),
    }
}

/// The functions and objects that sources define, with their types.
///
/// # Errors
///
/// All that is wrong with the sources.
pub fn interface(sources: &[Source], arch: &Arch, options: &Options) -> Result<Interface, Error> {
    let texts = Texts::new(sources, options);
    let found = with(&texts, arch, options, |o| {
        srp_frontend::interface::interface(sources, o)
    });
    found.map_err(|list| Error::Messages(texts.messages(options.warnings.choose(list))))
}

/// The syntax tree of a source, as text.
pub fn syntax_tree(source: &Source, arch: &Arch, options: &Options) -> String {
    let texts = Texts::new(std::slice::from_ref(source), options);
    let mut map = srp_frontend::source::SourceMap::new();
    let mut messages = srp_frontend::message::Messages::new();
    let unit = with(&texts, arch, options, |o| {
        srp_frontend::parse(source, o, &mut map, &mut messages)
    });
    srp_frontend::ast::show::show(&unit, &map)
}

/// Runs the usual passes over a program. Returns their remarks.
pub fn optimise(program: &mut Program, arch: &Arch, options: &Options) -> Vec<Remark> {
    run_passes(program, &pass::standard(), arch, options, &mut |_, _| {})
}

/// Runs some passes over a program. Returns their remarks; `after` sees the program after each pass.
pub fn run_passes(
    program: &mut Program,
    passes: &[&Pass],
    arch: &Arch,
    options: &Options,
    after: &mut dyn FnMut(&Pass, &Program),
) -> Vec<Remark> {
    let options = pass::Options {
        precision: arch.precision,
        fast_math: options.fast_math,
        prefetch: options.prefetch.then_some(arch.system.data_cache.line),
        rewrites: options.rewrites.clone(),
        software: arch.srp.in_software(),
        live_ins: srp_scheduler::abi::live_ins(&arch.srp),
    };
    let mut remarks = match options.fast_math.approximate {
        true => approximate::remarks(program, arch),
        false => Vec::new(),
    };
    remarks.extend(pass::run(program, passes, &options, after));
    remarks.sort();
    remarks.dedup();
    debug_assert_eq!(srp_ir::verify(program), Ok(()));
    remarks
}

/// The program of an input before it is divided, with warnings: its meaning without a schedule.
///
/// # Errors
///
/// Those of [`front_end`]; an input of a later form.
pub fn program(input: Input, arch: &Arch, options: &Options) -> Result<(Program, Messages), Error> {
    match input {
        Input::C(sources) => {
            let (mut program, warnings) = front_end(&sources, arch, options)?;
            optimise(&mut program, arch, options);
            Ok((program, warnings))
        }
        Input::Ir(program) => Ok((*program, Messages::default())),
        Input::Dre(_) | Input::Scheduled { .. } => {
            Err(Error::invalid("the program is divided already"))
        }
    }
}
