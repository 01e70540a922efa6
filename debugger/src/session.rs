//! A session: cores that go on, stop, and go back.

use crate::breakpoint::{Breakpoint, Memory, NoBreakpoint, Place as Where, Watch};
use crate::code::{Code, Line};
use crate::expression::Expression;
use crate::history::{Checkpoint, History};
use crate::machine::{End, Machine};
use crate::variables::Variables;
use crate::watched::Shared;
use srp_archdesc::arch::Arch;
use srp_csimgen::preamble::sequencer::Place;
use srp_csimgen::{SimSpec, TooManyStages, link};
use srp_ir::check::Checked;
use srp_ir::dre::scheduled::DataSymbol;
use srp_runtime::core::Core;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{Options, System, SystemError};
use srp_traces::names::Names;
use std::sync::Arc;

/// Why there is no session.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// Simulators have no room for one of the kernels.
    #[error(transparent)]
    TooManyStages(#[from] TooManyStages),
    /// The frame cannot begin.
    #[error(transparent)]
    System(#[from] SystemError),
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// To a breakpoint, a watched change, or the end.
    Breakpoint,
    /// The next cycle of the core.
    Cycle,
    /// Another line in the same function or the one that called it; on the array another line of the iteration that is
    /// looked at, or the next iteration where that one is over.
    Line,
    /// Another line, also of a function that is called; on the array the next cycle.
    Into,
    /// Out of the function or the launch.
    Out,
}

/// Why a session has stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// These breakpoints are met.
    Breakpoint(Vec<u64>),
    /// Watched bytes have changed.
    Watch(u64, String),
    /// It has gone as far as it was to.
    Step,
    /// Somebody wants it to.
    Pause,
    /// It is back at the beginning.
    Beginning,
    /// It goes no further.
    End(End),
}

/// A stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stopped {
    /// Why.
    pub reason: Reason,
    /// The core that it is about.
    pub core: u32,
    /// The iteration that it is about, where it is on the array.
    pub iteration: Option<u64>,
    /// The line of a breakpoint to which that iteration has come.
    pub(crate) line: Option<Line>,
}

/// How far to go, with where it began.
pub(crate) struct Goal {
    pub(crate) until: Until,
    pub(crate) core: u32,
    pub(crate) depth: usize,
    /// The iteration that is followed on the array, and its line.
    pub(crate) iteration: Option<u64>,
    pub(crate) line: Option<Line>,
    pub(crate) on_array: bool,
}

/// Cycles between two looks at the outside.
const LOOK: u64 = 1 << 10;

/// A program or a frame that is debugged.
pub struct Session<'a> {
    pub(crate) machine: Machine<'a>,
    pub(crate) spec: Arc<SimSpec>,
    pub(crate) code: Arc<Code>,
    pub(crate) names: Names,
    pub(crate) symbols: Vec<DataSymbol>,
    pub(crate) cores: Vec<Shared>,
    /// How often it has advanced since the beginning.
    instant: u64,
    /// Before that, the cycle was this.
    pub(crate) last_cycle: u64,
    /// Turns of each core before that.
    pub(crate) turns: Vec<u64>,
    history: History,
    pub(crate) breakpoints: Vec<Breakpoint>,
    pub(crate) watches: Vec<Watch>,
    next_id: u64,
    /// The iteration that is looked at, of the core of the last stop.
    looked_at: Option<u64>,
    /// The breakpoint's line to which an iteration has come: among the lines of its slot the one to show.
    come_to: Option<ComeTo>,
    end: Option<End>,
}

/// A line to which an iteration came at the last stop.
#[derive(Clone, Copy)]
struct ComeTo {
    instant: u64,
    place: Place,
    iteration: u64,
    line: Line,
}

impl<'a> Session<'a> {
    /// A program by itself, at its beginning.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels.
    pub fn of_program(
        program: &Checked,
        variables: &Variables,
    ) -> Result<Session<'a>, SessionError> {
        let (spec, code) = tables(program, variables)?;
        let core = Shared::new(&spec, &code);
        let machine = Machine::program(core.clone(), &spec);
        Ok(Session::new(machine, program, spec, code, vec![core]))
    }
}

fn tables(
    program: &Checked,
    variables: &Variables,
) -> Result<(Arc<SimSpec>, Arc<Code>), SessionError> {
    let spec = Arc::new(link(program)?);
    let code = Arc::new(Code::of(program, &spec, variables));
    Ok((spec, code))
}

impl<'a> Session<'a> {
    /// A frame over the scene in `image`, at its beginning, on all cores of a machine.
    ///
    /// # Errors
    ///
    /// The machine cannot be simulated.
    pub fn of_frame(
        program: &Checked,
        variables: &Variables,
        image: SceneImage,
        arch: &Arch,
        options: Options<'a>,
    ) -> Result<Session<'a>, SessionError> {
        let (spec, code) = tables(program, variables)?;
        let cores = (0..arch.system.cores).map(|_| Shared::new(&spec, &code));
        let cores: Vec<Shared> = cores.collect();
        let boxed = |core: &Shared| Box::new(core.clone()) as Box<dyn Core>;
        let engines = cores.iter().map(boxed).collect();
        let system = System::new(image, engines, arch, options)?;
        let machine = Machine::Frame(Box::new(system));
        Ok(Session::new(machine, program, spec, code, cores))
    }

    fn new(
        machine: Machine<'a>,
        program: &Checked,
        spec: Arc<SimSpec>,
        code: Arc<Code>,
        cores: Vec<Shared>,
    ) -> Session<'a> {
        Session {
            machine,
            names: Names::of(&spec, program.arch()),
            symbols: program.symbols.clone(),
            spec,
            code,
            turns: vec![0; cores.len()],
            cores,
            instant: 0,
            last_cycle: 0,
            history: History::new(),
            breakpoints: Vec::new(),
            watches: Vec::new(),
            next_id: 1,
            looked_at: None,
            come_to: None,
            end: None,
        }
    }

    /// The number of cores.
    pub fn cores(&self) -> u32 {
        self.cores.len() as u32
    }

    /// The cycle that comes next.
    pub fn cycle(&self) -> u64 {
        self.machine.cycle()
    }

    /// Looks at an iteration, which is followed from now on, or at the one that has begun last.
    pub fn look_at(&mut self, iteration: Option<u64>) {
        self.looked_at = iteration;
    }

    /// The iteration that is looked at.
    pub fn looked_at(&self) -> Option<u64> {
        self.looked_at
    }

    /// The end, where it is reached.
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// Adds a breakpoint at a line. Returns its number, and the line that it is at: the next with code.
    ///
    /// # Errors
    ///
    /// There is no code from there on.
    pub fn break_at_line(&mut self, file: &str, line: u32) -> Result<(u64, u32), NoBreakpoint> {
        let place = Where::line(&self.code, file, line)?;
        let at = match place {
            Where::Line(line) => self.code.lines[line as usize].1,
            _ => line,
        };
        Ok((self.add(place), at))
    }

    /// Adds a breakpoint at a place in words: `FILE:LINE`, a function, a kernel, `KERNEL#N`, `KERNEL#N@CORE` or
    /// `cycle:N`.
    ///
    /// # Errors
    ///
    /// There is no such place.
    pub fn break_at(&mut self, place: &str) -> Result<u64, NoBreakpoint> {
        let place = Where::parse(place, &self.spec, &self.code, self.cores())?;
        Ok(self.add(place))
    }

    fn add(&mut self, place: Where) -> u64 {
        let id = self.next_id;
        self.next_id += 1;
        self.breakpoints.push(Breakpoint {
            id,
            place,
            condition: None,
            count: 1,
            met: 0,
        });
        id
    }

    /// Makes a breakpoint stop only where a condition holds, and only when it is met for the `count`-th time.
    pub fn only_if(&mut self, id: u64, condition: Option<Expression>, count: u64) {
        if let Some(breakpoint) = self.breakpoints.iter_mut().find(|b| b.id == id) {
            breakpoint.condition = condition;
            breakpoint.count = count;
        }
    }

    /// Takes a breakpoint or a watch away; whether there was one.
    pub fn remove(&mut self, id: u64) -> bool {
        let before = self.breakpoints.len() + self.watches.len();
        self.breakpoints.retain(|b| b.id != id);
        self.watches.retain(|w| w.id != id);
        before > self.breakpoints.len() + self.watches.len()
    }

    /// Stops when bytes of a core's SRAM, or of the memory of all, change, which an expression names. Returns the watch's
    /// number.
    pub fn watch(&mut self, core: u32, at: &Memory, name: &str) -> u64 {
        let &Memory { address, bytes, ty } = at;
        let id = self.next_id;
        self.next_id += 1;
        self.watches.push(Watch {
            id,
            core,
            address,
            bytes,
            name: name.to_owned(),
            ty,
            last: self.machine.read(core, address, bytes).to_vec(),
        });
        id
    }

    /// Goes on. `poll` is asked now and then whether somebody wants a stop.
    pub fn go(&mut self, core: u32, until: Until, poll: &mut dyn FnMut() -> bool) -> Stopped {
        let stop = self.forward(core, until, poll);
        self.look_at_stop(&stop);
        stop
    }

    /// Goes back to the last stop before this one.
    pub fn back(&mut self, core: u32, until: Until, poll: &mut dyn FnMut() -> bool) -> Stopped {
        let stop = self.backward(core, until, poll);
        self.look_at_stop(&stop);
        stop
    }

    fn look_at_stop(&mut self, stop: &Stopped) {
        self.looked_at = stop.iteration;
        let come_to = stop.iteration.zip(stop.line);
        self.come_to = come_to.map(|(iteration, line)| ComeTo {
            instant: self.instant,
            place: self.cores[stop.core as usize].get().marks.place,
            iteration,
            line,
        });
    }

    fn forward(&mut self, core: u32, until: Until, poll: &mut dyn FnMut() -> bool) -> Stopped {
        let goal = self.goal(core, until);
        loop {
            if self.instant.is_multiple_of(LOOK) && poll() {
                return self.stopped(Reason::Pause, core);
            }
            if let Some(end) = self.advance() {
                let core = self.trapped().unwrap_or(core);
                return self.stopped(Reason::End(end), core);
            }
            if let Some(stop) = self.stop(&goal, true) {
                return stop;
            }
        }
    }

    fn backward(&mut self, core: u32, until: Until, poll: &mut dyn FnMut() -> bool) -> Stopped {
        let goal = self.goal(core, until);
        // Stops before this instant are looked for, checkpoint by checkpoint.
        let mut end = self.instant;
        while end > 0 && self.rewind(end - 1) {
            let begin = self.instant;
            let mut found = None;
            while self.instant + 1 < end && self.advance().is_none() {
                if self.instant.is_multiple_of(LOOK) && poll() {
                    return self.stopped(Reason::Pause, core);
                }
                if let Some(stop) = self.stop(&goal, false) {
                    found = Some((self.instant, stop));
                }
            }
            if let Some((instant, stop)) = found {
                self.travel(instant);
                return stop;
            }
            if begin == 0 {
                break;
            }
            end = begin + 1;
        }
        self.travel(0);
        self.stopped(Reason::Beginning, core)
    }

    /// Goes to an instant that was before.
    fn travel(&mut self, instant: u64) {
        if self.rewind(instant) {
            while self.instant < instant && self.advance().is_none() {}
            self.see_watched();
        }
    }

    /// Takes watched bytes as they are.
    fn see_watched(&mut self) {
        for watch in &mut self.watches {
            let bytes = self.machine.read(watch.core, watch.address, watch.bytes);
            watch.last = bytes.to_vec();
        }
    }

    /// Goes to the last checkpoint at this instant or before.
    fn rewind(&mut self, instant: u64) -> bool {
        let Some(checkpoint) = self.history.before(instant) else {
            return self.instant == 0;
        };
        let is_restored = self.machine.restore(&checkpoint.state);
        for (core, marks) in self.cores.iter().zip(&checkpoint.marks) {
            core.get().marks.clone_from(marks);
        }
        self.instant = checkpoint.instant;
        self.end = None;
        self.last_cycle = self.machine.cycle();
        for (turns, core) in self.turns.iter_mut().zip(&self.cores) {
            *turns = core.get().marks.turns;
        }
        self.see_watched();
        is_restored
    }

    /// Advances to the next instant; where it cannot, the end.
    fn advance(&mut self) -> Option<End> {
        if self.end.is_some() {
            return self.end.clone();
        }
        if self.history.is_due(self.instant) {
            let last = self.history.last();
            if let Some(state) = self.machine.save(last.map(|last| &last.state)) {
                let marks = self.cores.iter().map(|core| core.get().marks.clone());
                self.history.add(Checkpoint {
                    instant: self.instant,
                    marks: marks.collect(),
                    state,
                });
            }
        }
        self.last_cycle = self.machine.cycle();
        for (turns, core) in self.turns.iter_mut().zip(&self.cores) {
            *turns = core.get().marks.turns;
        }
        self.end = self.machine.advance().err();
        self.instant += 1;
        self.end.clone()
    }

    fn goal(&self, core: u32, until: Until) -> Goal {
        let watched = self.cores[core as usize].get();
        let place = watched.marks.place;
        let iteration = self.followed(place);
        Goal {
            until,
            core,
            depth: watched.marks.calls.len(),
            iteration,
            line: iteration.and_then(|iteration| self.line_ahead(place, iteration)),
            on_array: matches!(place, Place::Context { .. }),
        }
    }

    /// The core that has trapped.
    fn trapped(&self) -> Option<u32> {
        let mut cores = (0..).zip(&self.cores);
        let found = cores.find(|(_, core)| core.get().marks.trap.is_some());
        found.map(|(core, _)| core)
    }

    /// The iteration that is looked at, where it is on its way; else the one that has begun last.
    pub(crate) fn followed(&self, place: Place) -> Option<u64> {
        let Place::Context { iteration, .. } = place else {
            return None;
        };
        let looked_at = self.looked_at.filter(|&of| self.is_on_its_way(place, of));
        looked_at.or(Some(iteration))
    }

    /// True if an iteration is on the array.
    pub(crate) fn is_on_its_way(&self, place: Place, of: u64) -> bool {
        let Place::Context {
            kernel,
            iteration,
            stages,
            ..
        } = place
        else {
            return false;
        };
        let stage = iteration.wrapping_sub(of);
        stage < u64::from(self.code.kernels[kernel as usize].stages) && stages >> stage & 1 == 1
    }

    /// The line of an iteration: the one that the last stop is about, or that of its next operation in this stage.
    pub(crate) fn line_ahead(&self, place: Place, of: u64) -> Option<Line> {
        let is_here =
            |to: &ComeTo| (to.instant, to.place, to.iteration) == (self.instant, place, of);
        if let Some(to) = self.come_to.filter(is_here) {
            return Some(to.line);
        }
        let Place::Context {
            kernel,
            slot,
            iteration,
            ..
        } = place
        else {
            return None;
        };
        let stage = iteration.checked_sub(of)? as u32;
        let at = self.code.kernels[kernel as usize].at.get(slot as usize..)?;
        at.iter().find_map(|lines| lines.get(&stage).copied())
    }

    pub(crate) fn stopped(&self, reason: Reason, core: u32) -> Stopped {
        let place = self.cores[core as usize].get().marks.place;
        Stopped {
            reason,
            core,
            iteration: self.followed(place),
            line: None,
        }
    }
}
