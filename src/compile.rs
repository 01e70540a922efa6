//! `srp compile`

use crate::cli::{self, Compile, Form};
use crate::failure::Failure;
use crate::talk::CONSOLE;
use crate::{diagnostics, document, files, interrupt, refused_kernel, report, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::watch::Stage;
use srp_csimgen::{emit, link};
use srp_ir::dre::{self, Dre};
use srp_ir::pass::{Pass, Remark, Rewrite, SOFTWARE};
use srp_ir::program::{Program, SourceFile};
use srp_kernels::libc;
use srp_studies::loops::{self, LoopReport, NotPipelined, Subject};
use srp_toolchain::envelope::{About, Contents};
use srp_toolchain::{
    Compiled, Input, Options, Session, Timed, Times, compile, divide, front_end, input, run_passes,
    syntax_tree,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Runs `srp compile`.
pub(crate) fn run(args: &Compile) -> Result<(), Failure> {
    let arch = args.compilation.machine.read()?;
    let options = args.compilation.options()?;
    let source = &args.compilation.source;
    let (passes, are_usual) = args.passes.chosen()?;
    let goes_on = |form: &Form| !matches!(form, Form::Ast | Form::Ir);
    let goes_on = args.emit.iter().any(goes_on) || source.remarks_passes();
    if !are_usual && (goes_on || !args.loops.loops.is_empty()) {
        return Err(Failure::Usage(
            "without the usual passes a program has no form beyond --emit ast,ir".to_owned(),
        ));
    }
    let timed = Timed::new(&CONSOLE);
    let session = &Session {
        watch: &timed,
        ..talk::session()
    };
    forms(args, &passes, &arch, &options, session)?;
    if args.json {
        let seconds = Seconds::of(&timed.times());
        talk::print(document::json(About::machine(&arch), &seconds)?)?;
    }
    interrupt::end_if_requested()
}

/// The seconds of each stage and loop on this host.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Seconds {
    /// By stage.
    stages: BTreeMap<String, f64>,
    /// By loop, those that were scheduled anew.
    loops: BTreeMap<String, f64>,
}

impl Contents for Seconds {
    const FORMAT: &'static str = "srp-compile-times";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp compile --json`";
}

impl Seconds {
    fn of(times: &Times) -> Seconds {
        let (stages, loops) = (times.stages.iter(), times.items.iter());
        Seconds {
            stages: stages
                .map(|(name, time)| (name.to_string(), time.as_secs_f64()))
                .collect(),
            loops: loops
                .map(|(name, time)| (name.clone(), time.as_secs_f64()))
                .collect(),
        }
    }
}

/// Writes the forms that are asked for, and compiles as far as that takes.
fn forms(
    args: &Compile,
    passes: &[&Pass],
    arch: &Arch,
    options: &Options,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let source = &args.compilation.source;
    let mut input = input::read(&args.files, arch)?;
    check_one_output(args, &input)?;
    if !files::is_output(&args.output) {
        files::make_folder(&args.output)?;
    }
    let loops = report::Loops::to(&args.loops.loops)?;
    let out = Output {
        folder: &args.output,
        name: stem(&args.files[0]),
    };
    let wanted = Wanted(&args.emit);
    out.check(args, &input)?;

    if let Input::C(sources) = &input {
        let program = front(args, sources, passes, (arch, options), session)?;
        if wanted.has(Form::Ast) {
            write_trees(&out, sources, arch, options)?;
        }
        input = Input::Ir(Box::new(program));
    } else if wanted.has(Form::Ast) {
        return Err(Failure::usage(
            "only C has a syntax tree: give C files for --emit ast",
        ));
    }
    if wanted.has(Form::Ir) {
        match &input {
            Input::Ir(program) => out.write("ir", &srp_ir::text::write(program))?,
            _ => {
                return Err(Failure::usage(
                    "the files are compiled further than --emit ir",
                ));
            }
        }
    }
    let scheduled = wanted.has(Form::Schedule)
        || wanted.has(Form::Rust)
        || !args.loops.loops.is_empty()
        || source.remarks_passes();
    if !scheduled {
        return match wanted.divided() {
            true => write_divided(&out, &divided(input, arch)?, wanted),
            false => Ok(()),
        };
    }
    let compiled = interrupt::looked_for(|| compile(input, arch, options, session))?;
    let format = source.error_format;
    refused_kernel::check(&compiled, arch, &options.warnings, format, session)?;
    if source.remarks_passes() {
        say_not_pipelined(&compiled, arch, session)?;
    }
    loops.write(&compiled, arch, session)?;
    if wanted.divided() {
        let dre = compiled.dre.as_ref().ok_or_else(scheduled_already)?;
        write_divided(&out, dre, wanted)?;
    }
    write_scheduled(&out, &compiled, arch, wanted)
}

/// The forms that are asked for.
#[derive(Clone, Copy)]
struct Wanted<'a>(&'a [Form]);

impl Wanted<'_> {
    fn has(self, form: Form) -> bool {
        self.0.contains(&form)
    }

    /// True if a form of the divided program is among them.
    fn divided(self) -> bool {
        self.has(Form::Dfg) || self.has(Form::Dre)
    }
}

/// Compiles C up to the passes, with messages and remarks said.
fn front(
    args: &Compile,
    sources: &[Source],
    passes: &[&Pass],
    (arch, options): (&Arch, &Options),
    session: &Session<'_>,
) -> Result<Program, Failure> {
    let source = &args.compilation.source;
    let stage = Stage::unknown(session.watch, "front end");
    let compiled = front_end(sources, arch, options);
    drop(stage);
    let (mut program, warnings) =
        compiled.map_err(|e| diagnostics::failure(e, source.error_format))?;
    talk::say_all(&diagnostics::show(&warnings, source.error_format));
    let mut shown = String::new();
    let mut after = |pass: &Pass, program: &Program| {
        if args.passes.shows(pass) {
            shown += &format!("; after {}\n{}\n", pass.name, srp_ir::text::write(program));
        }
    };
    let stage = Stage::unknown(session.watch, "passes");
    let remarks = run_passes(&mut program, passes, arch, options, &mut after);
    drop(stage);
    talk::print(shown)?;
    say_remarks(&program.files, &remarks, source)?;
    Ok(program)
}

/// Refuses standard output as the place of more than one text. How many kernels there are is not known yet.
fn check_one_output(args: &Compile, input: &Input) -> Result<(), Failure> {
    if !files::is_output(&args.output) {
        return Ok(());
    }
    let trees = match input {
        Input::C(sources) => sources.len(),
        _ => 1,
    };
    let many = match args.emit[..] {
        [Form::Rust] => Some("--emit rust writes a folder"),
        [Form::Ast] if trees > 1 => Some("there is a syntax tree for each file"),
        [_] if args.json => Some("--json is printed there"),
        [_] if !args.passes.print_after.is_empty() => Some("--print-after is printed there"),
        [_] => None,
        _ => Some("--emit has several forms"),
    };
    many.map_or(Ok(()), |why| {
        Err(Failure::Usage(format!(
            "-o - is standard output, which takes one text, and {why}: name a folder"
        )))
    })
}

/// Says with `-Rpass` of every loop whether it runs on the array, what `restrict` would buy, and else what
/// stands in the way. Of loops that a pragma asks for in vain, [`refused_kernel::check`] has said it.
pub(crate) fn say_not_pipelined(
    compiled: &Compiled,
    arch: &Arch,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let subject = Subject::of_program(compiled);
    let report = loops::report(&subject, arch, &loops::Options::default(), session)?;
    for done in &report.loops {
        talk::say(format_args!(
            "remark: {}: {} is on the array at II = {}",
            done.at, done.kernel, done.ii
        ));
    }
    report.loops.iter().for_each(say_restrict);
    let others = report.not_pipelined.iter().filter(|n| !n.required);
    say_obstacles(others);
    Ok(())
}

/// Compiles an input, with warnings and remarks said.
pub(crate) fn compile_and_say(
    input: Input,
    arch: &Arch,
    options: &Options,
    source: &cli::Source,
    session: &Session<'_>,
) -> Result<Compiled, Failure> {
    let compiled = interrupt::looked_for(|| compile(input, arch, options, session));
    let compiled = compiled.map_err(|e| diagnostics::failure(e, source.error_format))?;
    talk::say_all(&diagnostics::show(&compiled.messages, source.error_format));
    let files = &compiled.schedule.program.files;
    say_remarks(files, &compiled.pass_remarks, source)?;
    Ok(compiled)
}

/// Says what computes in software for want of a unit, and each place where fast math or a rewrite changes a result.
///
/// # Errors
///
/// A rewrite that is asked for and has no place.
pub(crate) fn say_remarks(
    files: &EntityMap<SourceFile, String>,
    remarks: &[Remark],
    source: &cli::Source,
) -> Result<(), Failure> {
    let rewritten = |wish: &&Rewrite| {
        remarks.iter().any(|remark| {
            let file = files.get(remark.pos.file).map_or("", String::as_str);
            remark.rule() == Some(wish.rule) && wish.is_at(file, remark.pos.line)
        })
    };
    if let Some(wish) = source.rewrite.iter().find(|wish| !rewritten(wish)) {
        let (rule, line) = (wish.rule, wish.line);
        return Err(Failure::Message(format!(
            "--rewrite {wish}: line {line} has nothing that `{}` fits ({}); `srp accuracy FILE.c` lists the places",
            rule.name(),
            rule.what()
        )));
    }
    for remark in remarks.iter().filter(|r| r.pass == SOFTWARE) {
        let file = files.get(remark.pos.file).map_or("", String::as_str);
        if libc::at(file).is_some() {
            continue;
        }
        let (line, column) = (remark.pos.line, remark.pos.column);
        talk::say(format_args!(
            "remark: {file}:{line}:{column}: {}",
            remark.message
        ));
    }
    if !source.remarks_passes() {
        return Ok(());
    }
    // What stands in a loop's way is said again, with the loop's name, when it is divided.
    for remark in remarks.iter().filter(|r| r.changes_results()) {
        let (pass, message, pos) = (remark.pass, &remark.message, remark.pos);
        let file = files.get(pos.file).map_or("", String::as_str);
        let place = format_args!("{file}:{}:{}", pos.line, pos.column);
        let by = match remark.rule() {
            Some(rule) => format!("--rewrite {}", rule.name()),
            None => format!("-f{pass}"),
        };
        talk::say(format_args!("remark: {place}: {message} ({by})"));
    }
    Ok(())
}

/// Says what `restrict` would buy, and where.
fn say_restrict(aliased: &LoopReport) {
    let Some(bound) = aliased.restrict_bound else {
        return;
    };
    for pair in aliased.ordered.iter().take(report::MOST_ORDERED) {
        talk::say(format_args!(
            "remark: {}: {}: it and {}: {}",
            pair.first, aliased.kernel, pair.second, pair.why
        ));
    }
    if let more @ 1.. = aliased.ordered.len().saturating_sub(report::MOST_ORDERED) {
        talk::say(format_args!(
            "remark: {}: {}: so it is with {more} more pairs of accesses, which `srp report --json` lists",
            aliased.at, aliased.kernel
        ));
    }
    talk::say(format_args!(
        "remark: {}: `restrict` on these pointers of {} would lower the bound of its II from {} to \
         {bound}",
        aliased.at,
        aliased.kernel,
        aliased.bound()
    ));
}

fn say_obstacles<'a>(loops: impl IntoIterator<Item = &'a NotPipelined>) {
    for text in report::not_pipelined(loops) {
        talk::say(format_args!("remark: {}", text.trim_end()));
    }
}

/// Where forms are written.
struct Output<'a> {
    folder: &'a Path,
    name: String,
}

impl Output<'_> {
    /// Fails now if a file cannot be written later whose name is known by now.
    fn check(&self, args: &Compile, input: &Input) -> Result<(), Failure> {
        if files::is_output(self.folder) {
            return Ok(());
        }
        let endings = [
            (Form::Ir, "ir"),
            (Form::Dre, "dre.xml"),
            (Form::Schedule, "sched.xml"),
        ];
        for (_, ending) in endings.iter().filter(|(form, _)| args.emit.contains(form)) {
            files::check_writable(&self.path(ending))?;
        }
        match input {
            Input::C(sources) if args.emit.contains(&Form::Ast) => {
                let mut trees = sources.iter().map(|source| self.tree(source).path("ast"));
                trees.try_for_each(|path| files::check_writable(&path))
            }
            _ => Ok(()),
        }
    }

    /// Where the syntax tree of a source goes.
    fn tree(&self, source: &Source) -> Output<'_> {
        Output {
            folder: self.folder,
            name: stem(Path::new(&source.name)),
        }
    }

    fn path(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}.{ending}", self.name))
    }

    fn write(&self, ending: &str, text: &str) -> Result<(), Failure> {
        if files::is_output(self.folder) {
            return Ok(talk::print(text)?);
        }
        let path = self.path(ending);
        files::write(&path, text.as_bytes())?;
        talk::say(path.display());
        Ok(())
    }
}

/// The name of a file without its endings.
fn stem(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    name.split('.')
        .next()
        .filter(|s| !s.is_empty())
        .unwrap_or("program")
        .to_owned()
}

fn write_trees(
    out: &Output<'_>,
    sources: &[Source],
    arch: &Arch,
    options: &Options,
) -> Result<(), Failure> {
    for source in sources {
        out.tree(source)
            .write("ast", &syntax_tree(source, arch, options))?;
    }
    Ok(())
}

fn scheduled_already() -> Failure {
    Failure::usage("the file is scheduled already: no --emit dfg, dre")
}

/// Divides a program that is compiled up to the passes, with no look for schedules.
fn divided(input: Input, arch: &Arch) -> Result<Dre, Failure> {
    match input {
        Input::Ir(mut program) => {
            let divided = divide(&mut program, arch)?;
            let required = divided.not_pipelined.iter().filter(|n| n.required);
            let files = &divided.dre.control.files;
            say_obstacles(&loops::not_pipelined(required, files));
            Ok(divided.dre)
        }
        Input::Dre(dre) => Ok(*dre),
        Input::Scheduled { .. } => Err(scheduled_already()),
        Input::C(_) => unreachable!("C is compiled up to the passes before"),
    }
}

fn write_divided(out: &Output<'_>, dre: &Dre, wanted: Wanted<'_>) -> Result<(), Failure> {
    if wanted.has(Form::Dfg) {
        write_graphs(out, dre)?;
    }
    if wanted.has(Form::Dre) {
        out.write("dre.xml", &dre::write(dre))?;
    }
    Ok(())
}

fn write_graphs(out: &Output<'_>, dre: &Dre) -> Result<(), Failure> {
    if files::is_output(out.folder) && dre.kernels.len() != 1 {
        return Err(Failure::Usage(format!(
            "-o - is standard output, which takes one graph, and there are {}: name a folder",
            dre.kernels.len()
        )));
    }
    for kernel in dre.kernels.values() {
        let dot = srp_ir::dfg::dot(kernel, &dre.control.files);
        let name = srp_toolchain::files::file_name(&kernel.name);
        let ending = format!("{name}.dot");
        if !files::is_output(out.folder) {
            files::check_writable(&out.path(&ending))?;
        }
        out.write(&ending, &dot)?;
    }
    Ok(())
}

fn write_scheduled(
    out: &Output<'_>,
    compiled: &Compiled,
    arch: &Arch,
    wanted: Wanted<'_>,
) -> Result<(), Failure> {
    let program = &compiled.schedule.program;
    if wanted.has(Form::Schedule) {
        out.write("sched.xml", &dre::write_scheduled(program, arch))?;
    }
    if wanted.has(Form::Rust) {
        // A folder that rustc compiles as it is.
        let spec = link(program).map_err(Failure::message)?;
        let folder = out.folder.join(format!("{}.csim", out.name));
        files::make_folder(&folder)?;
        for (name, text) in &emit(&spec).files {
            files::write_once(&folder.join(name), text.as_bytes())?;
        }
        talk::say(folder.join("lib.rs").display());
    }
    Ok(())
}
