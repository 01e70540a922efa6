//! A session by commands, one a line; the answer is text.

use crate::expression::count;
use crate::machine::End;
use crate::session::{Reason, Session, Stopped, Until};
use crate::show::{Frame, FrameOf, Scope, Variable};
use std::collections::BTreeMap;
use std::fmt::Write;

/// What commands there are.
pub const HELP: &str = "\
break PLACE [if CONDITION] [count N]   stop at FILE:LINE, a function, a kernel, KERNEL#N, KERNEL#N@CORE, cycle:N
watch EXPRESSION                       stop when it changes: counts[2], s.x, *p, *ADDRESS
delete N                               take breakpoint or watch N away
run | continue                         go on to the next stop (r, c)
step | next | out                      into calls, over them, out of them; on the array by cycles, by the lines of the
                                       iteration that is looked at, out of the launch (s, n, o)
cycle [N]                              go on by N cycles of the core (y)
back [step|next|cycle|continue]        the same backwards (b); `back` alone is `back next`
core N                                 look at another core
frame N                                look at another frame of `where`: an iteration is followed from then on
where                                  where the core stands (w)
print EXPRESSION                       x, s.x, p->x, a[2], *p, &x, *ADDRESS, REGISTER; or a comparison (p)
whatis EXPRESSION | ptype EXPRESSION   its type; also with the members of a struct
info locals|operations|registers|way|objects|cores
list                                   the source round the place (l)
quit                                   (q)
";

/// A session that takes commands.
pub struct Terminal<'a> {
    session: Session<'a>,
    /// The texts of the sources, by their names.
    sources: BTreeMap<String, String>,
    core: u32,
    frame: usize,
    /// Bytes of each core's output that were shown.
    shown: Vec<usize>,
}

/// What becomes of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// This text.
    Text(String),
    /// The session is over.
    Quit,
}

impl<'a> Terminal<'a> {
    /// A session that takes commands, with the texts of its sources.
    pub fn new(session: Session<'a>, sources: BTreeMap<String, String>) -> Terminal<'a> {
        Terminal {
            shown: vec![0; session.cores() as usize],
            session,
            sources,
            core: 0,
            frame: 0,
        }
    }

    /// Does what a line says. `poll` is asked now and then whether somebody wants a stop.
    pub fn command(&mut self, line: &str, poll: &mut dyn FnMut() -> bool) -> Answer {
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let text = match word {
            "" => String::new(),
            "q" | "quit" => return Answer::Quit,
            "h" | "help" => HELP.to_owned(),
            "break" => self.add_breakpoint(rest),
            "watch" => self.add_watch(rest),
            "delete" => match rest.parse() {
                Ok(id) if self.session.remove(id) => String::new(),
                _ => format!("there is no breakpoint {rest}\n"),
            },
            "r" | "run" | "c" | "continue" => self.go(Until::Breakpoint, 1, poll),
            "s" | "step" => self.go(Until::Into, 1, poll),
            "n" | "next" => self.go(Until::Line, 1, poll),
            "o" | "out" => self.go(Until::Out, 1, poll),
            "y" | "cycle" => match count(rest) {
                Ok(cycles) => self.go(Until::Cycle, cycles, poll),
                Err(why) => format!("{why}\n"),
            },
            "b" | "back" => self.back(rest, poll),
            "core" => match rest.parse() {
                Ok(core) if core < self.session.cores() => {
                    (self.core, self.frame) = (core, 0);
                    self.session.look_at(None);
                    self.here()
                }
                _ => format!("there are cores 0 to {}\n", self.session.cores() - 1),
            },
            "frame" => match rest.parse() {
                Ok(frame) => match self.frames().get::<usize>(frame).map(|f| f.of) {
                    Some(FrameOf::Iteration(iteration)) => {
                        // It is the first frame from now on.
                        self.session.look_at(Some(iteration));
                        self.frame = 0;
                        self.here()
                    }
                    Some(FrameOf::Call(_)) => {
                        self.frame = frame;
                        self.here()
                    }
                    None => "`where` numbers the frames\n".to_owned(),
                },
                Err(_) => "`where` numbers the frames\n".to_owned(),
            },
            "w" | "where" => self.place(),
            "p" | "print" => self.print(rest),
            "whatis" => self.type_of(rest, false),
            "ptype" => self.type_of(rest, true),
            "info" => self.info(rest),
            "l" | "list" => self.list(),
            _ => format!("no command is named `{word}`; `help` lists them\n"),
        };
        Answer::Text(text)
    }

    fn add_breakpoint(&mut self, text: &str) -> String {
        self.try_breakpoint(text)
            .unwrap_or_else(|why| format!("{why}\n"))
    }

    fn try_breakpoint(&mut self, text: &str) -> Result<String, String> {
        let (text, times) = text.rsplit_once(" count ").unwrap_or((text, ""));
        let times = count(times)?;
        let (place, condition) = match text.split_once(" if ") {
            Some((place, condition)) => (place.trim(), Some(self.session.parsed(condition)?)),
            None => (text.trim(), None),
        };
        let made = self.session.break_at(place);
        let id = made.map_err(|error| error.to_string())?;
        self.session.only_if(id, condition, times);
        Ok(format!("breakpoint {id} at {place}\n"))
    }

    fn add_watch(&mut self, text: &str) -> String {
        let of = self.looked_at();
        match self.session.watched(self.core, of, text) {
            Ok(at) => {
                let id = self.session.watch(self.core, &at, text);
                format!(
                    "watch {id} of {text}, {} bytes at {:#x}\n",
                    at.bytes, at.address
                )
            }
            Err(why) => format!("{why}\n"),
        }
    }

    fn go(&mut self, until: Until, times: u64, poll: &mut dyn FnMut() -> bool) -> String {
        let mut stopped = None;
        for _ in 0..times.max(1) {
            let stop = self.session.go(self.core, until, poll);
            let goes_on = stop.reason == Reason::Step;
            stopped = Some(stop);
            if !goes_on {
                break;
            }
        }
        stopped.map_or(String::new(), |stop| self.stopped(&stop))
    }

    fn back(&mut self, how: &str, poll: &mut dyn FnMut() -> bool) -> String {
        let until = match how {
            "" | "n" | "next" => Until::Line,
            "s" | "step" => Until::Into,
            "y" | "cycle" => Until::Cycle,
            "o" | "out" => Until::Out,
            "c" | "continue" => Until::Breakpoint,
            _ => return "back by step, next, out, cycle or continue\n".to_owned(),
        };
        let stop = self.session.back(self.core, until, poll);
        self.stopped(&stop)
    }

    fn stopped(&mut self, stop: &Stopped) -> String {
        (self.core, self.frame) = (stop.core, 0);
        let mut text = self.output();
        let why = match &stop.reason {
            Reason::Breakpoint(ids) => {
                let ids: Vec<String> = ids.iter().map(u64::to_string).collect();
                format!("breakpoint {}", ids.join(", "))
            }
            Reason::Watch(id, what) => format!("watch {id}: {what}"),
            Reason::Step => String::new(),
            Reason::Pause => "interrupted".to_owned(),
            Reason::Beginning => "the beginning".to_owned(),
            Reason::End(End::Over(status)) => {
                let _ = writeln!(
                    text,
                    "ended with status {status} after {} cycles",
                    self.session.cycle()
                );
                return text;
            }
            Reason::End(End::Failed(why)) => why.clone(),
        };
        if !why.is_empty() {
            let _ = writeln!(text, "{why}");
        }
        text + &self.here()
    }

    /// What the cores have printed since it was asked last.
    fn output(&mut self) -> String {
        let mut text = String::new();
        for core in 0..self.session.cores() {
            let all = self.session.output(core);
            let shown = &mut self.shown[core as usize];
            // Going back takes nothing back from the screen.
            let new = all.get(*shown..).unwrap_or_default();
            text.push_str(&String::from_utf8_lossy(new));
            *shown = all.len().max(*shown);
        }
        if !text.is_empty() && !text.ends_with('\n') {
            text.push('\n');
        }
        text
    }

    fn frames(&self) -> Vec<Frame> {
        self.session.frames(self.core)
    }

    fn looked_at(&self) -> FrameOf {
        let frames = self.frames();
        frames.get(self.frame).map_or(FrameOf::Call(0), |f| f.of)
    }

    /// The place in a line, and its source.
    fn here(&self) -> String {
        let frames = self.frames();
        let Some(frame) = frames.get(self.frame) else {
            return String::new();
        };
        let core = match self.session.cores() {
            1 => String::new(),
            _ => format!("core {}, ", self.core),
        };
        let mut text = format!("{core}cycle {}: {}", self.session.cycle(), frame.name);
        if frame.line > 0 {
            let _ = write!(text, " at {}:{}", frame.file, frame.line);
            if let Some(line) = self.line(frame, frame.line) {
                let _ = write!(text, "\n{:>5}  {line}", frame.line);
            }
        }
        text + "\n"
    }

    fn line(&self, frame: &Frame, line: u32) -> Option<&str> {
        let text = self.sources.get(&frame.file)?;
        text.lines().nth((line as usize).checked_sub(1)?)
    }

    fn place(&self) -> String {
        let mut text = String::new();
        for (number, frame) in self.frames().iter().enumerate() {
            let mark = if number == self.frame { '*' } else { ' ' };
            let _ = write!(text, "{mark}{number} {}", frame.name);
            if frame.line > 0 {
                let _ = write!(text, " at {}:{}", frame.file, frame.line);
            }
            text.push('\n');
        }
        if let Some(waits) = self.session.waits() {
            text += &waits;
            text.push('\n');
        }
        text
    }

    fn print(&self, text: &str) -> String {
        match self.session.evaluate(self.core, self.looked_at(), text) {
            Ok(value) => format!("{value}\n"),
            Err(why) => format!("{why}\n"),
        }
    }

    fn type_of(&self, text: &str, all: bool) -> String {
        match self.session.type_of(self.core, self.looked_at(), text, all) {
            Ok(ty) => format!("type = {ty}\n"),
            Err(why) => format!("{why}\n"),
        }
    }

    fn info(&self, what: &str) -> String {
        let scope = match what {
            "variables" | "locals" => Scope::Variables,
            "operations" => Scope::Operations,
            "registers" => Scope::Registers,
            "way" => Scope::OnTheWay,
            "objects" => Scope::Objects,
            "cores" => {
                let cores = 0..self.session.cores();
                let line = |core| {
                    let frames = self.session.frames(core);
                    let name = frames.first().map_or("", |f| f.name.as_str());
                    format!("core {core}: {name}\n")
                };
                return cores.map(line).collect();
            }
            _ => {
                return "info locals, operations, registers, way, objects or cores\n".to_owned();
            }
        };
        let variables = self.session.variables(self.core, self.looked_at(), scope);
        if variables.is_empty() {
            return format!("{}: none here\n", scope.name().to_lowercase());
        }
        let shows_parts = matches!(scope, Scope::Registers | Scope::OnTheWay);
        let mut text = String::new();
        for Variable {
            name, value, parts, ..
        } in variables
        {
            let parts: Vec<&str> = parts.iter().map(|p| p.value.as_str()).collect();
            let _ = match shows_parts && !parts.is_empty() {
                true => writeln!(text, "{name}: {}", parts.join(" ")),
                false => writeln!(text, "{name} = {value}"),
            };
        }
        text
    }

    fn list(&self) -> String {
        let frames = self.frames();
        let Some(frame) = frames.get(self.frame).filter(|f| f.line > 0) else {
            return "the place has no source\n".to_owned();
        };
        let mut text = String::new();
        for number in frame.line.saturating_sub(4).max(1)..=frame.line + 4 {
            let Some(line) = self.line(frame, number) else {
                continue;
            };
            let mark = if number == frame.line { '>' } else { ' ' };
            let _ = writeln!(text, "{mark}{number:>5}  {line}");
        }
        text
    }
}
