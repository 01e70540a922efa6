//! `srp compile`

use crate::cli::{self, Compile, Form, RemarkKind};
use crate::failure::Failure;
use crate::pipeline::{self, Compiled, Effort, FrontEnd, Input};
use crate::{files, interrupt, machine, report, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_csimgen::{emit, link};
use srp_frontend::message::Messages;
use srp_frontend::source::SourceMap;
use srp_ir::dre::{self, Dre};
use std::path::{Path, PathBuf};

/// Runs `srp compile`.
pub(crate) fn run(args: &Compile) -> Result<(), Failure> {
    let arch = machine::read(&args.compilation.machine.machine)?;
    let front_end = FrontEnd::new(&args.compilation.source, &arch);
    let mut input = pipeline::read(&args.files, &arch)?;
    files::make_folder(&args.output)?;
    let loops = report::Loops::to(&args.loops.loops)?;
    let out = Output {
        folder: &args.output,
        name: stem(&args.files[0]),
    };
    let wants = |form| args.emit.contains(&form);

    if let Input::C(sources) = &input {
        // Everything that is wrong is said by the compilation, once.
        let program = front_end.compile(sources)?;
        if wants(Form::Ast) {
            write_trees(&out, sources, &front_end)?;
        }
        input = Input::Ir(Box::new(front_end.optimise(program)));
    } else if wants(Form::Ast) {
        return Err(Failure::message(
            "only C has a syntax tree: give C files for --emit ast",
        ));
    }
    if wants(Form::Ir) {
        match &input {
            Input::Ir(program) => out.write("ir", &srp_ir::text::write(program))?,
            _ => {
                return Err(Failure::message(
                    "the files are compiled further than --emit ir",
                ));
            }
        }
    }
    let scheduled = [Form::Schedule, Form::Rust].into_iter().any(wants)
        || !args.loops.loops.is_empty()
        || args.compilation.source.remarks.contains(&RemarkKind::Pass);
    if !scheduled {
        return write_divided_alone(&out, input, &arch, wants(Form::Dfg), wants(Form::Dre));
    }
    let compiled = pipeline::compile(input, &front_end, Effort::of(&args.compilation.search))?;
    say_not_pipelined(&compiled, &arch, &args.compilation.source);
    loops.write(&compiled, &arch)?;
    if wants(Form::Dfg) || wants(Form::Dre) {
        match &compiled.dre {
            Some(dre) => write_divided(&out, dre, wants(Form::Dfg), wants(Form::Dre))?,
            None => {
                return Err(Failure::message(
                    "the file is scheduled already: no --emit dfg, dre",
                ));
            }
        }
    }
    write_scheduled(
        &out,
        &compiled,
        &arch,
        wants(Form::Schedule),
        wants(Form::Rust),
    )?;
    interrupt::end_if_requested()
}

/// Says which loops a pragma has asked for in vain; with `-Rpass`, of every loop whether it runs on
/// the array, what `restrict` would buy, and else what stands in the way.
pub(crate) fn say_not_pipelined(compiled: &Compiled, arch: &Arch, source: &cli::Source) {
    let remarks = source.remarks.contains(&cli::RemarkKind::Pass);
    let report = report::report(compiled, arch);
    for done in report.loops.iter().filter(|_| remarks) {
        talk::say(format_args!(
            "remark: {}: {} is on the array at II = {}",
            done.at, done.kernel, done.ii
        ));
    }
    for aliased in report.loops.iter().filter(|_| remarks) {
        say_restrict(aliased);
    }
    for n in report
        .not_pipelined
        .iter()
        .filter(|n| n.required || remarks)
    {
        say_obstacle(n);
    }
}

/// Says what `restrict` would buy, and where.
fn say_restrict(aliased: &report::LoopReport) {
    let Some(bound) = aliased.restrict_bound else {
        return;
    };
    for pair in &aliased.ordered {
        talk::say(format_args!(
            "remark: {}: {}: it and {}: {}",
            pair.first, aliased.kernel, pair.second, pair.why
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

fn say_obstacle(obstacle: &report::Obstacle) {
    let kind = if obstacle.required {
        "warning"
    } else {
        "remark"
    };
    let text = report::not_pipelined(obstacle);
    talk::say(format_args!("{kind}: {}", text.trim_end()));
}

/// Where forms are written.
struct Output<'a> {
    folder: &'a Path,
    name: String,
}

impl Output<'_> {
    fn write(&self, ending: &str, text: &str) -> Result<(), Failure> {
        let path = self.folder.join(format!("{}.{ending}", self.name));
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
    front_end: &FrontEnd<'_>,
) -> Result<(), Failure> {
    for source in sources {
        let (mut map, mut messages) = (SourceMap::new(), Messages::new());
        let unit =
            front_end.with(|options| srp_frontend::parse(source, options, &mut map, &mut messages));
        let name = stem(&PathBuf::from(&source.name));
        Output {
            folder: out.folder,
            name,
        }
        .write("ast", &srp_frontend::ast::show::show(&unit, &map))?;
    }
    Ok(())
}

/// Divides a program and writes that, with no look for schedules.
fn write_divided_alone(
    out: &Output<'_>,
    input: Input,
    arch: &Arch,
    dfg: bool,
    whole: bool,
) -> Result<(), Failure> {
    if !dfg && !whole {
        return Ok(());
    }
    match input {
        Input::Ir(mut program) => {
            let divided = pipeline::divide(&mut program, arch)?;
            let required = divided.not_pipelined().filter(|n| n.required);
            let files = &divided.dre.control.files;
            for obstacle in &report::obstacles(required, files, arch) {
                say_obstacle(obstacle);
            }
            write_divided(out, &divided.dre, dfg, whole)
        }
        Input::Dre(dre) => write_divided(out, &dre, dfg, whole),
        Input::C(_) | Input::Scheduled(_) => Err(Failure::message(
            "the file is scheduled already: no --emit dfg, dre",
        )),
    }
}

fn write_divided(out: &Output<'_>, dre: &Dre, dfg: bool, whole: bool) -> Result<(), Failure> {
    if dfg {
        for kernel in dre.kernels.values() {
            let dot = srp_ir::dfg::dot(kernel, &dre.control.files);
            out.write(&format!("{}.dot", kernel.name), &dot)?;
        }
    }
    if whole {
        out.write("dre.xml", &dre::write(dre))?;
    }
    Ok(())
}

fn write_scheduled(
    out: &Output<'_>,
    compiled: &Compiled,
    arch: &Arch,
    schedule: bool,
    rust: bool,
) -> Result<(), Failure> {
    let program = &compiled.schedule.program;
    if schedule {
        out.write("sched.xml", &dre::write_scheduled(program, arch))?;
    }
    if rust {
        // A folder that rustc compiles as it is.
        let spec = link(program, arch).map_err(Failure::message)?;
        let folder = out.folder.join(format!("{}.csim", out.name));
        files::make_folder(&folder)?;
        for (name, text) in &emit(&spec).files {
            files::write(&folder.join(name), text.as_bytes())?;
        }
        talk::say(folder.join("lib.rs").display());
    }
    Ok(())
}
