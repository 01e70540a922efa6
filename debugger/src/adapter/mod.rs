//! The Debug Adapter Protocol: a session for editors.
//!
//! An [`Adapter`] answers requests; [`serve`] takes them from a queue, so that one can come while the program runs. The
//! messages are made here by hand: there are few of them, and what they hold is in the protocol's specification.

mod answers;
mod wire;

pub use wire::{read, write};

use crate::machine::End;
use crate::session::{Reason, Session, Stopped, Until};
use crate::show::{FrameOf, Scope, Variable};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Write};
use std::sync::mpsc::{Receiver, TryRecvError};

/// A text of a source, and its file, if it is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceText {
    /// The text.
    pub text: String,
    /// The file, as editors find it; `None` for one that comes along.
    pub path: Option<String>,
}

/// A request of an editor.
#[derive(Debug, Deserialize)]
struct Request {
    seq: u64,
    command: String,
    #[serde(default)]
    arguments: Value,
}

/// A run that a request asks for.
#[derive(Clone, Copy, Debug)]
struct Course {
    core: u32,
    until: Until,
    backwards: bool,
}

/// What a number that stands for variables means, until the session goes on.
enum Group {
    Scope(u32, FrameOf, Scope),
    Parts(u32, Vec<Variable>),
}

/// A session that an editor talks to.
pub struct Adapter<'a> {
    session: Session<'a>,
    sources: BTreeMap<String, SourceText>,
    seq: u64,
    stops_at_entry: bool,
    /// The core of the last stop.
    at: u32,
    /// Breakpoints by the source, or the kind, that they were set for.
    breakpoints: BTreeMap<String, Vec<u64>>,
    frames: Vec<(u32, FrameOf)>,
    groups: Vec<Group>,
    /// Bytes of each core's output that were sent.
    sent: Vec<usize>,
    is_over: bool,
}

/// Answers the requests of an editor until it leaves.
///
/// # Errors
///
/// Nobody takes the answers.
pub fn serve(
    adapter: &mut Adapter<'_>,
    requests: &Receiver<Value>,
    to: &mut dyn Write,
) -> io::Result<()> {
    let mut waiting: VecDeque<Value> = VecDeque::new();
    while !adapter.is_over {
        let Some(request) = waiting.pop_front().or_else(|| requests.recv().ok()) else {
            return Ok(());
        };
        let (answers, mut course) = adapter.handle(&request);
        for answer in &answers {
            write(to, answer)?;
        }
        while let Some(course_now) = course.take() {
            let mut is_left = false;
            let stop = {
                let mut poll = || match requests.try_recv() {
                    Ok(request) => {
                        waiting.push_back(request);
                        true
                    }
                    Err(TryRecvError::Empty) => false,
                    Err(TryRecvError::Disconnected) => {
                        is_left = true;
                        true
                    }
                };
                adapter.run(course_now, &mut poll)
            };
            if is_left {
                return Ok(());
            }
            if stop.reason == Reason::Pause {
                // Somebody asks for something meanwhile.
                let mut goes_on = true;
                while let Some(request) = waiting.pop_front() {
                    goes_on &= request["command"] != "pause" && request["command"] != "disconnect";
                    let (answers, _) = adapter.handle(&request);
                    for answer in &answers {
                        write(to, answer)?;
                    }
                }
                if goes_on {
                    course = Some(course_now);
                    continue;
                }
                if adapter.is_over {
                    return Ok(());
                }
            }
            for event in adapter.stopped(&stop) {
                write(to, &event)?;
            }
        }
    }
    Ok(())
}

impl<'a> Adapter<'a> {
    /// An adapter of a session, with the texts of its sources.
    pub fn new(session: Session<'a>, sources: BTreeMap<String, SourceText>) -> Adapter<'a> {
        Adapter {
            sent: vec![0; session.cores() as usize],
            session,
            sources,
            seq: 0,
            stops_at_entry: false,
            at: 0,
            breakpoints: BTreeMap::new(),
            frames: Vec::new(),
            groups: Vec::new(),
            is_over: false,
        }
    }

    fn message(&mut self, mut message: Value) -> Value {
        self.seq += 1;
        message["seq"] = self.seq.into();
        message
    }

    fn event(&mut self, name: &str, body: Value) -> Value {
        self.message(json!({"type": "event", "event": name, "body": body}))
    }

    /// Answers a request; the messages, and the run that it asks for.
    fn handle(&mut self, request: &Value) -> (Vec<Value>, Option<Course>) {
        let request = match Request::deserialize(request) {
            Ok(request) => request,
            Err(_) => return (Vec::new(), None),
        };
        let arguments = &request.arguments;
        let course = self.course(&request);
        let answer = match request.command.as_str() {
            "initialize" => Ok(answers::capabilities()),
            "launch" | "attach" => {
                self.stops_at_entry = arguments["stopOnEntry"] == true;
                Ok(Value::Null)
            }
            "setBreakpoints" => Ok(self.set_breakpoints(arguments)),
            "setFunctionBreakpoints" => Ok(self.set_function_breakpoints(arguments)),
            "dataBreakpointInfo" => Ok(self.data_breakpoint_info(arguments)),
            "setDataBreakpoints" => Ok(self.set_data_breakpoints(arguments)),
            "setExceptionBreakpoints" => Ok(json!({"breakpoints": []})),
            "configurationDone" | "pause" => Ok(Value::Null),
            "threads" => Ok(self.threads()),
            "stackTrace" => Ok(self.stack_trace(arguments)),
            "scopes" => self.scopes(arguments),
            "variables" => self.variables(arguments),
            "evaluate" => self.evaluate(arguments),
            "readMemory" => self.read_memory(arguments),
            "source" => self.source(arguments),
            "continue" => Ok(json!({"allThreadsContinued": true})),
            "next" | "stepIn" | "stepOut" | "stepBack" | "reverseContinue" => Ok(Value::Null),
            "disconnect" | "terminate" => {
                self.is_over = true;
                Ok(Value::Null)
            }
            other => Err(format!("this debugger has no request `{other}`")),
        };
        let response = match answer {
            Ok(body) => json!({"type": "response", "request_seq": request.seq, "success": true,
                "command": request.command, "body": body}),
            Err(why) => json!({"type": "response", "request_seq": request.seq, "success": false,
                "command": request.command, "message": why}),
        };
        let mut messages = vec![self.message(response)];
        match request.command.as_str() {
            "initialize" => messages.push(self.event("initialized", Value::Null)),
            "configurationDone" if self.stops_at_entry => {
                messages.push(self.stop_event("entry", "the beginning"));
            }
            _ => {}
        }
        (messages, course)
    }

    /// The run that a request asks for.
    fn course(&self, request: &Request) -> Option<Course> {
        let arguments = &request.arguments;
        let core = self.core_of(arguments);
        let by_cycle = arguments["granularity"] == "instruction";
        let step = |until| if by_cycle { Until::Cycle } else { until };
        let (until, backwards) = match request.command.as_str() {
            "configurationDone" if !self.stops_at_entry => (Until::Breakpoint, false),
            "continue" => (Until::Breakpoint, false),
            "next" => (step(Until::Line), false),
            "stepIn" => (step(Until::Into), false),
            "stepOut" => (step(Until::Out), false),
            "stepBack" => (step(Until::Line), true),
            "reverseContinue" => (Until::Breakpoint, true),
            _ => return None,
        };
        Some(Course {
            core,
            until,
            backwards,
        })
    }

    fn core_of(&self, arguments: &Value) -> u32 {
        let thread = arguments["threadId"].as_u64().unwrap_or(1);
        let core = thread
            .saturating_sub(1)
            .min(u64::from(self.session.cores() - 1));
        core as u32
    }

    fn run(&mut self, course: Course, poll: &mut dyn FnMut() -> bool) -> Stopped {
        self.frames.clear();
        self.groups.clear();
        match course.backwards {
            false => self.session.go(course.core, course.until, poll),
            true => self.session.back(course.core, course.until, poll),
        }
    }

    /// The events of a stop.
    fn stopped(&mut self, stop: &Stopped) -> Vec<Value> {
        let mut events = self.outputs();
        self.at = stop.core;
        let (reason, text) = match &stop.reason {
            Reason::Breakpoint(_) => ("breakpoint", String::new()),
            Reason::Watch(_, what) => ("data breakpoint", what.clone()),
            Reason::Step => ("step", String::new()),
            Reason::Pause => ("pause", String::new()),
            Reason::Beginning => ("entry", "the beginning".to_owned()),
            Reason::End(End::Over(status)) => {
                events.push(self.event("exited", json!({"exitCode": status})));
                events.push(self.event("terminated", Value::Null));
                return events;
            }
            Reason::End(End::Failed(why)) => ("exception", why.clone()),
        };
        let mut event = self.stop_event(reason, &text);
        if let Reason::Breakpoint(ids) = &stop.reason {
            event["body"]["hitBreakpointIds"] = json!(ids);
        }
        events.push(event);
        events
    }

    fn stop_event(&mut self, reason: &str, text: &str) -> Value {
        let cycle = self.session.cycle();
        let description = match text {
            "" => format!("cycle {cycle}"),
            text => format!("cycle {cycle}: {text}"),
        };
        let thread = self.at + 1;
        let body = json!({"reason": reason, "threadId": thread, "allThreadsStopped": true,
            "description": description, "text": text});
        self.event("stopped", body)
    }

    /// What the program has printed since it was asked last.
    fn outputs(&mut self) -> Vec<Value> {
        let mut events = Vec::new();
        for core in 0..self.session.cores() {
            let all = self.session.output(core);
            let sent = &mut self.sent[core as usize];
            let new = String::from_utf8_lossy(all.get(*sent..).unwrap_or_default()).into_owned();
            *sent = all.len().max(*sent);
            if !new.is_empty() {
                events.push(self.event("output", json!({"category": "stdout", "output": new})));
            }
        }
        events
    }
}
