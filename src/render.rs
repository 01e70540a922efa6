//! `srp render`

use crate::cli::{self, Render};
use crate::failure::Failure;
use crate::fidelity::{frame_text, sampled_text};
use crate::profile::Target;
use crate::run::COUNTS;
use crate::{
    checkpoint, document, energy, files, interrupt, pixel, ready, refused_kernel, report, scenes,
    sharing, talk, trace,
};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_ir::check::Checked;
use srp_kernels::effect::Effect;
use srp_runtime::digits::thousands;
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{self, Observer, Observers};
use srp_studies::comparison::FRAME;
use srp_studies::effects::{LeftOut, left_out};
use srp_studies::energy::Energy;
use srp_studies::fidelity::{self, Fidelity, FrameFigure, Prepared, Untimed};
use srp_studies::profile::{Profiler, Surroundings, add_account};
use srp_toolchain::envelope::{About, Contents};
use srp_toolchain::{
    Build, Compiled, Engine, Engines, Error, Frame, Scheduled, Session, Warnings, system_options,
};
use srp_traces::Tracer;
use srp_traces::history::StoreWatch;

/// Where time and energy of a frame went.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Account<'a> {
    /// The report of the simulation.
    #[serde(flatten)]
    report: &'a system::Report,
    /// The energy of the frame.
    energy: &'a Energy,
    /// Names of the effects that its kernels are built for.
    effects: Vec<&'static str>,
    /// Secondary rays in a row that its kernels have room for.
    bounces: u32,
}

impl Contents for Account<'_> {
    const FORMAT: &'static str = FRAME.format;
    const VERSION: u32 = FRAME.version;
    const WRITTEN_BY: &'static str = FRAME.written_by;
}

/// A frame without an account of every cycle.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Figures {
    /// The level of simulation.
    fidelity: &'static str,
    /// What is known at this level.
    figures: Vec<FrameFigure>,
}

impl Contents for Figures {
    const FORMAT: &'static str = "srp-frame-figures";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str =
        "`srp render --fidelity functional` and `analytic`, by --json and --report";
}

/// Runs `srp render`.
pub(crate) fn run(args: &Render) -> Result<(), Failure> {
    if args.prepare {
        return prepare(args);
    }
    files::check_writable(&args.output)?;
    if let Some(report) = &args.report {
        files::check_writable(report)?;
    }
    let warnings = Warnings::parse(&args.warnings).map_err(Failure::Usage)?;
    let loops = report::Loops::to(&args.loops.loops)?;
    let profile = Target::to(&args.profile)?;
    check_profiled(args)?;
    let session = &Session {
        threads: cli::threads(args.threads),
        ..talk::session()
    };
    let mut frame = scenes::frame(
        &args.frame,
        Some(&args.building),
        args.bvh,
        args.size,
        session,
    )?;
    frame.build.effort = args.search.effort();
    let is_scheduled = args.level.fidelity != Fidelity::Functional || !args.loops.loops.is_empty();
    let own_is_ready = !args.ready || !is_scheduled || ready::choose(&mut frame, session);
    let trace = trace::Target::of_frame(&args.trace, &frame.arch, args.size)?;
    // A frame that is refused is so before kernels are compiled for it.
    let image = frame.image()?;
    pixel::Wanted::of(args.pixel, &frame, &image)?;
    if !is_scheduled {
        return without_clock(&frame, &image, args, session);
    }
    let compiles = || match args.loops.loops.is_empty() {
        true => frame.build.scheduled(&frame.arch, session),
        false => (frame.build.compile(&frame.arch, session)).map(|all| Scheduled::Now(all.into())),
    };
    let kernels = interrupt::looked_for(compiles)?;
    if let Scheduled::Now(compiled) = &kernels {
        say_messages(compiled, &frame.arch, &warnings, session)?;
        loops.write(compiled, &frame.arch, session)?;
    }
    interrupt::end_if_requested()?;
    if !own_is_ready {
        ready::schedule_beside(args, session);
    }

    let program = kernels.program()?;
    let engine = match profile {
        Some(_) => Engine::Interpreter,
        None => args.engine,
    };
    let tracer = match &trace {
        Some(target) => Some(target.tracer(program, frame.arch.system.cores)?),
        None => None,
    };
    let engines = Engines::of(program, engine, session)?;
    if args.level.fidelity < Fidelity::Cycle {
        let session = &Session {
            threads: cli::threads(args.threads),
            ..sharing::session(&args.sharing, args.threads)?
        };
        let prepared = Prepared {
            frame: &frame,
            image,
            program,
            engines: &engines,
            threads: cli::threads(args.threads),
            recorded_hits: false,
            session,
        };
        return cheaply(&prepared, args);
    }
    let timed = Timed {
        frame: &frame,
        arch: args.level.fidelity.machine(&frame.arch),
        program,
        engines: &engines,
        session,
    };
    timed.run(args, image, profile, trace.zip(tracer))
}

/// Schedules the kernels of a frame for later ones.
fn prepare(args: &Render) -> Result<(), Failure> {
    let warnings = Warnings::parse(&args.warnings).map_err(Failure::Usage)?;
    let session = &talk::session();
    let arch = args.frame.machine.read()?;
    let options = (args.frame).options(Some(&args.building), args.bvh, args.size)?;
    let (_, build, _) = Build::of_scene(&options, &mut scenes::say, session)?;
    let build = Build {
        effort: args.search.effort(),
        ..build
    };
    if let Scheduled::Now(compiled) = interrupt::looked_for(|| build.scheduled(&arch, session))? {
        say_messages(&compiled, &arch, &warnings, session)?;
    }
    interrupt::end_if_requested()?;
    // A cache that nothing is written to makes nothing ready; this session remembers what it made, another one does not.
    let is_ready =
        (build.nearest(&arch, &talk::session())).is_some_and(|found| found.build == build);
    match is_ready {
        true => talk::say(format_args!("ready: {}", build.effects)),
        false => talk::complain(
            "warning: the cache keeps none of it, so no later frame finds these kernels ready",
        ),
    }
    Ok(())
}

/// Says what the compiler has to say about the kernels.
fn say_messages(
    compiled: &Compiled,
    arch: &Arch,
    warnings: &Warnings,
    session: &Session<'_>,
) -> Result<(), Failure> {
    talk::say_all(&compiled.messages.render(talk::colour()));
    let format = cli::ErrorFormat::Human;
    refused_kernel::check(compiled, arch, warnings, format, session)
}

/// A frame of which every cycle is simulated.
struct Timed<'a> {
    frame: &'a Frame,
    /// The machine, as the level of simulation has it.
    arch: Arch,
    program: &'a Checked,
    engines: &'a Engines,
    session: &'a Session<'a>,
}

impl Timed<'_> {
    fn options(&self) -> system::Options<'_> {
        let guard = self.frame.guard.clone();
        system_options(
            self.program,
            &self.arch,
            guard,
            system::Timing::Full,
            self.session,
        )
    }

    /// Renders, and writes all that is asked for.
    fn run(
        &self,
        args: &Render,
        image: SceneImage,
        profile: Option<Target>,
        trace: Option<(trace::Target, Tracer)>,
    ) -> Result<(), Failure> {
        let Timed { frame, arch, .. } = self;
        let count = arch.system.cores;
        let mut profiler = match &profile {
            Some(_) => Some(Profiler::new(self.program).map_err(Error::from)?),
            None => None,
        };
        // A profile counts in cores of its own: what is traced besides is run again.
        let (mut traced, traced_later) = match profiler {
            None => (trace, None),
            Some(_) => (None, trace),
        };
        let cores = match (&mut profiler, &mut traced) {
            (Some(profiler), _) => {
                profiler.frame(Surroundings::of(&image, &frame.scene, &arch.system), count)
            }
            (None, Some((_, tracer))) => trace::cores(tracer, self.engines, count),
            (None, None) => self.engines.cores(count),
        };
        let pixel = pixel::Wanted::of(args.pixel, frame, &image)?;
        let mut watch = pixel.as_ref().map(pixel::Wanted::watch);
        let mut kept = checkpoint::OfFrame::of(&args.checkpoints, self.program, &image)?;
        if let (Some((_, tracer)), Some(start)) = (&mut traced, &kept.start) {
            tracer.begin_at(&start.ready());
        }
        let mut observers: Vec<&mut dyn Observer> = Vec::new();
        observers.extend(profiler.as_mut().map(|o| o as &mut dyn Observer));
        observers.extend(traced.as_mut().map(|(_, o)| o as &mut dyn Observer));
        observers.extend(watch.as_mut().map(|o| o as &mut dyn Observer));
        let mut observers = Observers(observers);
        let options = system::Options {
            start: kept.start.as_ref(),
            checkpoint: kept.wanted.as_mut(),
            observer: observers.as_one(),
            ..self.options()
        };
        let rendered = interrupt::looked_for(|| system::render(image, cores, arch, options));
        let (picture, report) = rendered.map_err(Failure::message)?;
        talk::say_shares(self.engines);

        let about = || About::scene(arch, &frame.scene);
        if let (Some(target), Some(profiler)) = (profile, profiler) {
            let mut profile = profiler.profile();
            add_account(&mut profile, &report, self.program, arch);
            target.write("the frame", about(), &profile)?;
        }
        if let Some((target, tracer)) = &traced {
            target.write(tracer)?;
        }
        if let Some((target, tracer)) = traced_later {
            let (image, options) = (frame.image()?, self.options());
            target.record_frame(tracer, image, self.engines, arch, options)?;
        }
        kept.write(&args.checkpoints, report.cycles)?;
        if report.complete {
            files::write(&args.output, &picture.png())?;
        }
        let energy = srp_studies::energy::energy(&report, self.program, arch);
        let account = Account {
            report: &report,
            energy: &energy,
            effects: frame.build.effects.iter().map(Effect::name).collect(),
            bounces: frame.build.bounces,
        };
        let text = report.text() + &energy::text(&energy);
        match pixel.filter(|_| report.complete) {
            None => show(args, about(), &account, text)?,
            Some(pixel) => {
                write_report(args, about(), &account)?;
                let stored = watch.and_then(StoreWatch::stored);
                let by = (self.program, self.engines);
                let history = pixel.history(stored, by, frame, self.session)?;
                history.show(about(), args.json)?;
            }
        }
        if !report.complete {
            return Err(Failure::Interrupted);
        }
        if report.tni().unit.hits == 0 {
            talk::complain(NOTHING_SEEN);
        }
        talk::say(args.output.display());
        say_left_out(frame, self.session)
    }
}

/// Said of a frame that is its background alone.
const NOTHING_SEEN: &str = "warning: no ray meets the scene; a camera has a position and a direction, not a point to look \
                            at: --camera X,Y,Z/DX,DY,DZ/FOV";

/// Refuses a profile, a trace or a history where the cycles are not counted one by one.
fn check_profiled(args: &Render) -> Result<(), Failure> {
    if args.trace.trace.is_some() && args.level.fidelity < Fidelity::Cycle {
        let why = "a trace needs every cycle: leave --fidelity out";
        return Err(Failure::Usage(why.to_owned()));
    }
    if args.pixel.is_some() && args.level.fidelity < Fidelity::Cycle {
        let why = "the history of a pixel needs every cycle: leave --fidelity out";
        return Err(Failure::Usage(why.to_owned()));
    }
    if args.sharing.share.is_some() && args.level.fidelity != Fidelity::Sampled {
        let why = "all cycles of a frame are one piece of work, for its cores share a memory: --share goes with \
                   --fidelity sampled";
        return Err(Failure::Usage(why.to_owned()));
    }
    let kept = &args.checkpoints;
    if (kept.checkpoint_at.is_some() || kept.restore.is_some())
        && args.level.fidelity < Fidelity::Cycle
    {
        let why = "a checkpoint needs every cycle: leave --fidelity out";
        return Err(Failure::Usage(why.to_owned()));
    }
    checkpoint::check(kept)?;
    if args.profile.is_none() {
        return Ok(());
    }
    if args.level.fidelity < Fidelity::Cycle {
        let why = "a profile needs every cycle: leave --fidelity out";
        return Err(Failure::Usage(why.to_owned()));
    }
    match args.engine {
        Engine::Generated => Err(Failure::Usage(COUNTS.to_owned())),
        Engine::Auto | Engine::Interpreter => Ok(()),
    }
}

/// A frame of which only the picture and the counts are wanted: its kernels are not even scheduled.
fn without_clock(
    frame: &Frame,
    image: &SceneImage,
    args: &Render,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let (program, warnings) = (frame.build).program(&frame.arch)?;
    talk::say_all(&warnings.render(talk::colour()));
    let run = || fidelity::untimed(image, &program, &frame.arch, &frame.guard, session);
    let Untimed { picture, figures } = interrupt::looked_for(run)?;
    let about = About::scene(&frame.arch, &frame.scene);
    show_whole(args, about, &picture, figures)?;
    say_left_out(frame, session)
}

/// A frame at a level without an account of every cycle.
fn cheaply(prepared: &Prepared<'_>, args: &Render) -> Result<(), Failure> {
    let level = args.level.fidelity;
    let frame = prepared.frame;
    let about = About::scene(&level.machine(&frame.arch), &frame.scene);
    if level == Fidelity::Sampled {
        let (seed, error) = (args.level.seed, args.level.error);
        let (sampled, _) = interrupt::looked_for(|| prepared.sampled(seed, error))?;
        let text = sampled_text(&sampled, args.size);
        show(args, about, &sampled, text)?;
        talk::say("note: a sample has no picture; --fidelity functional makes the whole one");
        return Ok(());
    }
    let whole = interrupt::looked_for(|| prepared.whole(level))?;
    show_whole(args, about, &whole.picture, whole.figures)?;
    say_left_out(frame, prepared.session)
}

/// Says how much of the picture each effect touches that is left out of it.
fn say_left_out(frame: &Frame, session: &Session<'_>) -> Result<(), Failure> {
    let all = thousands(u64::from(frame.size.0) * u64::from(frame.size.1));
    for LeftOut { effect, pixels } in interrupt::looked_for(|| left_out(frame, session))? {
        let (name, pixels) = (effect.name(), thousands(pixels));
        talk::say(format_args!(
            "note: `{name}`, which is left out, touches {pixels} of {all} pixels"
        ));
    }
    Ok(())
}

/// Writes the picture of a frame, and shows its figures: without a clock, only those that are counts.
fn show_whole(
    args: &Render,
    about: About,
    picture: &Picture,
    mut figures: Vec<FrameFigure>,
) -> Result<(), Failure> {
    files::write(&args.output, &picture.png())?;
    let level = args.level.fidelity;
    figures.retain(|f| level != Fidelity::Functional || f.quantity.is_count());
    let text = frame_text(level, args.size, &figures);
    let found = Figures {
        fidelity: level.name(),
        figures,
    };
    show(args, about, &found, text)?;
    talk::say(args.output.display());
    Ok(())
}

/// Prints what is known of a frame, as text or JSON, and writes the report that is asked for.
fn show(args: &Render, about: About, found: &impl Contents, text: String) -> Result<(), Failure> {
    let json = write_report(args, about, found)?;
    talk::print(if args.json { json } else { text })?;
    Ok(())
}

/// Writes the report that is asked for: what is known of a frame, as JSON.
fn write_report(args: &Render, about: About, found: &impl Contents) -> Result<String, Failure> {
    let json = document::json(about, found)?;
    if let Some(path) = &args.report {
        files::write(path, json.as_bytes())?;
    }
    Ok(json)
}
