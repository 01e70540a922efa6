//! The bodies of answers.

use super::{Adapter, Group};
use crate::breakpoint::Memory;
use crate::expression::{Expression, count};
use crate::show::{FrameOf, Variable};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// What this debugger can do.
pub(super) fn capabilities() -> Value {
    json!({
        "supportsConfigurationDoneRequest": true,
        "supportsFunctionBreakpoints": true,
        "supportsConditionalBreakpoints": true,
        "supportsHitConditionalBreakpoints": true,
        "supportsEvaluateForHovers": true,
        "supportsStepBack": true,
        "supportsSteppingGranularity": true,
        "supportsReadMemoryRequest": true,
        "supportsDataBreakpoints": true,
        "supportsTerminateRequest": true,
    })
}

/// The kinds of breakpoints without a source.
const FUNCTIONS: &str = "functions";
const DATA: &str = "data";

/// Most bytes that are read at once.
const MOST_BYTES: u64 = 1 << 20;

fn list(arguments: &Value, name: &str) -> Vec<Value> {
    arguments[name].as_array().cloned().unwrap_or_default()
}

/// The core, the memory and the name in a `dataId`.
fn data_id(text: &str) -> Option<(u32, Memory, &str)> {
    let mut parts = text.splitn(5, ':');
    let core = parts.next()?.parse().ok()?;
    let address = parts.next()?.parse().ok()?;
    let bytes = parts.next()?.parse().ok()?;
    let ty: usize = parts.next()?.parse().ok()?;
    let ty = ty.checked_sub(1);
    Some((core, Memory { address, bytes, ty }, parts.next()?))
}

impl Adapter<'_> {
    /// Takes the breakpoints of a source, or of a kind, away.
    fn clear(&mut self, of: &str) {
        for id in self.breakpoints.remove(of).unwrap_or_default() {
            self.session.remove(id);
        }
    }

    /// Sets what a breakpoint depends on, and says what became of it.
    fn set(&mut self, of: &str, wish: &Value, made: Result<(u64, Value), String>) -> Value {
        let set = made.and_then(|(id, body)| match self.dependence(wish) {
            Ok((condition, count)) => {
                self.session.only_if(id, condition, count);
                self.breakpoints.entry(of.to_owned()).or_default().push(id);
                Ok(body)
            }
            Err(why) => {
                self.session.remove(id);
                Err(why)
            }
        });
        set.unwrap_or_else(|why| json!({"verified": false, "message": why}))
    }

    /// The condition of a breakpoint, and the time that it is met at which it stops.
    fn dependence(&self, wish: &Value) -> Result<(Option<Expression>, u64), String> {
        let condition = wish["condition"].as_str().filter(|text| !text.is_empty());
        let condition = condition
            .map(|text| self.session.parsed(text))
            .transpose()?;
        Ok((
            condition,
            count(wish["hitCondition"].as_str().unwrap_or(""))?,
        ))
    }

    pub(super) fn set_breakpoints(&mut self, arguments: &Value) -> Value {
        let source = &arguments["source"];
        let reference = source["sourceReference"].as_u64().unwrap_or(0);
        let named = self
            .sources
            .keys()
            .nth((reference as usize).wrapping_sub(1));
        let file = match (named, source["path"].as_str().or(source["name"].as_str())) {
            (Some(name), _) => name.clone(),
            (None, path) => path.unwrap_or_default().to_owned(),
        };
        self.clear(&file);
        let wishes = list(arguments, "breakpoints");
        let set = wishes.iter().map(|wish| {
            let line = wish["line"].as_u64().unwrap_or(0) as u32;
            let made = self.session.break_at_line(&file, line);
            let made =
                made.map(|(id, line)| (id, json!({"id": id, "verified": true, "line": line})));
            self.set(&file, wish, made.map_err(|error| error.to_string()))
        });
        json!({"breakpoints": set.collect::<Vec<_>>()})
    }

    pub(super) fn set_function_breakpoints(&mut self, arguments: &Value) -> Value {
        self.clear(FUNCTIONS);
        let wishes = list(arguments, "breakpoints");
        let set = wishes.iter().map(|wish| {
            let made = self
                .session
                .break_at(wish["name"].as_str().unwrap_or_default());
            let made = made.map(|id| (id, json!({"id": id, "verified": true})));
            self.set(FUNCTIONS, wish, made.map_err(|error| error.to_string()))
        });
        json!({"breakpoints": set.collect::<Vec<_>>()})
    }

    pub(super) fn data_breakpoint_info(&mut self, arguments: &Value) -> Value {
        let name = arguments["name"].as_str().unwrap_or_default();
        let (core, of) = self.frame(arguments);
        let group = arguments["variablesReference"].as_u64().unwrap_or(0);
        let in_group = match self.groups.get((group as usize).wrapping_sub(1)) {
            Some(Group::Parts(core, parts)) => {
                let part = parts.iter().find(|part| part.name == name);
                part.and_then(|part| Some((*core, part.address?, 4, None)))
            }
            _ => None,
        };
        let found = in_group.or_else(|| {
            let at = self.session.watched(core, of, name).ok()?;
            Some((core, at.address, at.bytes, at.ty))
        });
        match found {
            Some((core, address, bytes, ty)) => json!({
                "dataId": format!("{core}:{address}:{bytes}:{}:{name}", ty.map_or(0, |ty| ty + 1)),
                "description": format!("{name}: {bytes} bytes at {address:#x}"),
                "accessTypes": ["write"],
            }),
            None => {
                json!({"dataId": null, "description": format!("{name} does not lie in memory")})
            }
        }
    }

    pub(super) fn set_data_breakpoints(&mut self, arguments: &Value) -> Value {
        self.clear(DATA);
        let wishes = list(arguments, "breakpoints");
        let set = wishes.iter().map(|wish| {
            let text = wish["dataId"].as_str().unwrap_or_default();
            let made = match data_id(text) {
                Some((core, at, name)) if core < self.session.cores() => {
                    let id = self.session.watch(core, &at, name);
                    Ok((id, json!({"id": id, "verified": true})))
                }
                _ => Err("this is no dataId of this session".to_owned()),
            };
            self.set(DATA, wish, made)
        });
        json!({"breakpoints": set.collect::<Vec<_>>()})
    }

    pub(super) fn threads(&self) -> Value {
        let cores = 0..self.session.cores();
        let threads = cores.map(|core| json!({"id": core + 1, "name": format!("core {core}")}));
        json!({"threads": threads.collect::<Vec<_>>()})
    }

    pub(super) fn stack_trace(&mut self, arguments: &Value) -> Value {
        let core = self.core_of(arguments);
        let frames = self.session.frames(core);
        let total = frames.len();
        let mut shown = Vec::new();
        for frame in frames {
            self.frames.push((core, frame.of));
            let mut entry = json!({"id": self.frames.len(), "name": frame.name, "line": frame.line,
                "column": u32::from(frame.line > 0)});
            if frame.line > 0 {
                entry["source"] = self.source_of(&frame.file);
            }
            shown.push(entry);
        }
        let start = arguments["startFrame"].as_u64().unwrap_or(0) as usize;
        let levels = arguments["levels"].as_u64().filter(|&n| n > 0);
        let levels = levels.map_or(total, |n| n as usize);
        let shown: Vec<Value> = shown.into_iter().skip(start).take(levels).collect();
        json!({"stackFrames": shown, "totalFrames": total})
    }

    fn source_of(&self, file: &str) -> Value {
        let name = file.rsplit('/').next().unwrap_or(file);
        let number = self.sources.keys().position(|known| known == file);
        match self.sources.get(file).map(|source| &source.path) {
            Some(Some(path)) => json!({"name": name, "path": path}),
            Some(None) => json!({"name": name, "sourceReference": number.unwrap_or(0) + 1}),
            None => json!({"name": name, "path": file}),
        }
    }

    pub(super) fn source(&self, arguments: &Value) -> Result<Value, String> {
        let number = arguments["sourceReference"].as_u64().unwrap_or(0) as usize;
        let source = self.sources.values().nth(number.wrapping_sub(1));
        let source = source.ok_or("there is no such source")?;
        Ok(json!({"content": source.text, "mimeType": "text/x-c"}))
    }

    fn frame(&self, arguments: &Value) -> (u32, FrameOf) {
        let id = arguments["frameId"].as_u64().unwrap_or(0) as usize;
        let known = self.frames.get(id.wrapping_sub(1)).copied();
        known.unwrap_or_else(|| {
            let core = self.at;
            let frames = self.session.frames(core);
            (core, frames.first().map_or(FrameOf::Call(0), |f| f.of))
        })
    }

    pub(super) fn scopes(&mut self, arguments: &Value) -> Result<Value, String> {
        let id = arguments["frameId"].as_u64().unwrap_or(0) as usize;
        let known = self.frames.get(id.wrapping_sub(1)).copied();
        let (core, of) = known.ok_or("there is no such frame any more")?;
        let mut scopes = Vec::new();
        for scope in self.session.scopes(of) {
            self.groups.push(Group::Scope(core, of, scope));
            scopes.push(
                json!({"name": scope.name(), "variablesReference": self.groups.len(),
                "expensive": !scope.is_small()}),
            );
        }
        Ok(json!({"scopes": scopes}))
    }

    pub(super) fn variables(&mut self, arguments: &Value) -> Result<Value, String> {
        let number = arguments["variablesReference"].as_u64().unwrap_or(0) as usize;
        let group = self.groups.get(number.wrapping_sub(1));
        let (core, variables) = match group.ok_or("there are no such variables any more")? {
            Group::Scope(core, of, scope) => (*core, self.session.variables(*core, *of, *scope)),
            Group::Parts(core, parts) => (*core, parts.clone()),
        };
        let shown = variables
            .into_iter()
            .map(|variable| self.variable(core, variable));
        Ok(json!({"variables": shown.collect::<Vec<_>>()}))
    }

    fn variable(&mut self, core: u32, variable: Variable) -> Value {
        let mut shown =
            json!({"name": variable.name, "value": variable.value, "variablesReference": 0});
        if let Some(address) = variable.address {
            shown["memoryReference"] = format!("{core}:{address:#x}").into();
        }
        if !variable.parts.is_empty() {
            self.groups.push(Group::Parts(core, variable.parts));
            shown["variablesReference"] = self.groups.len().into();
        }
        shown
    }

    pub(super) fn evaluate(&self, arguments: &Value) -> Result<Value, String> {
        let text = arguments["expression"].as_str().unwrap_or_default();
        let (core, of) = self.frame(arguments);
        let value = self.session.evaluate(core, of, text)?;
        Ok(json!({"result": value, "variablesReference": 0}))
    }

    pub(super) fn read_memory(&self, arguments: &Value) -> Result<Value, String> {
        let text = arguments["memoryReference"].as_str().unwrap_or_default();
        let (core, address) = text.split_once(':').unwrap_or(("0", text));
        let address = crate::expression::address(address);
        let core = core
            .parse()
            .ok()
            .filter(|&core: &u32| core < self.session.cores());
        let (Some(core), Some(address)) = (core, address) else {
            return Err(format!(
                "`{text}` is no place in memory: write CORE:ADDRESS"
            ));
        };
        let offset = arguments["offset"].as_i64().unwrap_or(0);
        let address = i64::from(address).checked_add(offset);
        let address = address.and_then(|address| u32::try_from(address).ok());
        let address = address.ok_or("there is no such address")?;
        let count = arguments["count"].as_u64().unwrap_or(0).min(MOST_BYTES) as u32;
        let bytes = self.session.memory(core, address, count);
        Ok(
            json!({"address": format!("{address:#x}"), "data": STANDARD.encode(bytes),
            "unreadableBytes": count as usize - bytes.len()}),
        )
    }
}
