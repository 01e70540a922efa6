//! `srp tandem`

use crate::cli::Tandem;
use crate::count::count;
use crate::debug::{Prepared, prepare};
use crate::failure::Failure;
use crate::{interrupt, talk};
use srp_debugger::tandem::{self, Agreed, Difference};
use srp_ir::check::Checked;
use srp_ir::dre::{self, Dre};
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_runtime::picture::Picture;
use srp_runtime::solo::{self, Finish, Solo, SoloError};
use srp_runtime::system::{self, Timing};
use srp_studies::fidelity;
use srp_toolchain::{Engine, Engines, Error, Frame, Session, program, system_options};

/// What came of a run without a machine: everything that there is to compare with.
type Meaning = (Vec<u8>, i32);

/// Runs `srp tandem`; its exit status.
pub(crate) fn run(args: &Tandem) -> Result<i32, Failure> {
    let session = &talk::session();
    let prepared = prepare(&args.of, session)?;
    let program = prepared.compiled.runnable()?;
    let engines = Engines::of(program, args.engine, session)?;
    if args.engine == Engine::Generated && matches!(engines, Engines::Interpreters(_)) {
        let why = "there is no simulator to compare with; --engine interp compares the interpreter with itself";
        return Err(Failure::Message(why.to_owned()));
    }
    let mut both = tandem::Tandem::new(program).map_err(Failure::message)?;
    let by_meaning = match &prepared.frame {
        None => of_program(args, &prepared, &engines, &mut both)?,
        Some(frame) => of_frame(args, &prepared, frame, &engines, &mut both, session)?,
    };
    let agreed = both.agreed();
    talk::say(told(&agreed));
    match (agreed.difference, by_meaning) {
        (Some(difference), _) => {
            talk::print(difference_text(&difference))?;
            Ok(1)
        }
        (None, Some(what)) => {
            talk::print(format!("{what}\n"))?;
            Ok(1)
        }
        (None, None) => Ok(0),
    }
}

fn difference_text(difference: &Difference) -> String {
    format!("{difference}\n")
}

fn told(agreed: &Agreed) -> String {
    let all: u64 = agreed.cycles.iter().sum();
    format!(
        "{} agreed on {}, compared {}",
        count(all, "cycle"),
        count(agreed.cycles.len() as u64, "core"),
        count(agreed.runs, "time")
    )
}

/// A program by itself; how its meaning differs from what it did.
fn of_program(
    args: &Tandem,
    prepared: &Prepared,
    engines: &Engines,
    both: &mut tandem::Tandem,
) -> Result<Option<String>, Failure> {
    let program: &Checked = prepared.compiled.runnable()?;
    let mut core = both.core(engines.core());
    let mut bus = Solo::new(&program.image, prepared.arch.system.sram_bytes);
    let mut finish = Finish::default();
    let ended = interrupt::looked_for(|| {
        let core = core.as_mut();
        solo::run_until(core, &mut bus, args.limit, &talk::CONSOLE, &mut finish)
    });
    match ended {
        Err(SoloError::Stopped) => return Err(Failure::Interrupted),
        Err(_) if both.agreed().difference.is_some() => return Ok(None),
        Err(error) => {
            talk::say(format_args!("both end the same way: {error}"));
            return Ok(None);
        }
        Ok(()) => {}
    }
    let Some((output, status)) = meaning(args, prepared)? else {
        return Ok(None);
    };
    if status != finish.status {
        let own = finish.status;
        return Ok(Some(format!(
            "the engines agree on status {own}; the intermediate form has {status}"
        )));
    }
    let first = (0..).zip(output.iter().zip(&bus.output));
    let first = first.filter(|(_, (a, b))| a != b).map(|(at, _)| at).next();
    let ends = output.len().min(bus.output.len());
    Ok((output != bus.output).then(|| {
        let at: usize = first.unwrap_or(ends);
        format!("the engines agree on an output that is not that of the intermediate form from byte {at} on")
    }))
}

/// What the intermediate form does, where the input goes through it.
fn meaning(args: &Tandem, prepared: &Prepared) -> Result<Option<Meaning>, Failure> {
    let input = match &prepared.input {
        srp_toolchain::Input::C(sources) => srp_toolchain::Input::C(sources.clone()),
        _ => return Ok(None),
    };
    let (control, _) = program(input, &prepared.arch, &prepared.options)?;
    let sram_bytes = prepared.arch.system.sram_bytes;
    let layout = Layout::of(&control, sram_bytes).map_err(Failure::message)?;
    let main = control.main.ok_or(Error::NoMain)?;
    let mut world = FlatWorld::new(&layout, sram_bytes);
    let options = interp::Options {
        precision: prepared.arch.precision,
        steps: args.limit,
        ..interp::Options::new(&layout)
    };
    let zeros = control.funcs[main].zero_arguments();
    let dre = Dre {
        control,
        kernels: Default::default(),
    };
    let outcome = dre::run(&dre, main, &zeros, &mut world, &options);
    let outcome = outcome.map_err(|trap| Failure::Message(trap.show(&dre.control)))?;
    Ok(Some((world.output, outcome.status())))
}

/// A frame; how the picture of its functional form differs.
fn of_frame(
    args: &Tandem,
    prepared: &Prepared,
    frame: &Frame,
    engines: &Engines,
    both: &mut tandem::Tandem,
    session: &Session<'_>,
) -> Result<Option<String>, Failure> {
    let checked: &Checked = prepared.compiled.runnable()?;
    let cores = engines.cores(frame.arch.system.cores).into_iter();
    let cores = cores.map(|core| both.core(core)).collect();
    let options = system::Options {
        max_cycles: args.limit,
        ..system_options(
            checked,
            &frame.arch,
            frame.guard.clone(),
            Timing::Full,
            session,
        )
    };
    let image = frame.image()?;
    let rendered = interrupt::looked_for(|| system::render(image, cores, &frame.arch, options));
    let picture = match rendered {
        Ok((picture, report)) if report.complete => picture,
        Ok(_) => return Err(Failure::Interrupted),
        Err(_) if both.agreed().difference.is_some() => return Ok(None),
        Err(error) => {
            talk::say(format_args!("both end the same way: {error}"));
            return Ok(None);
        }
    };
    let srp_toolchain::Input::C(sources) = &prepared.input else {
        return Ok(None);
    };
    let input = srp_toolchain::Input::C(sources.clone());
    let (functional, _) = program(input, &prepared.arch, &prepared.options)?;
    let image = frame.image()?;
    let untimed = || fidelity::untimed(&image, &functional, &frame.arch, &frame.guard, session);
    let expected = interrupt::looked_for(untimed)?.picture;
    Ok(unequal_pixels(&picture, &expected))
}

fn unequal_pixels(picture: &Picture, expected: &Picture) -> Option<String> {
    (picture != expected).then(|| {
        "the engines agree on a picture that is not that of the functional form".to_owned()
    })
}
