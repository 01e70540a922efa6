//! The variables of a frame: which of them can be named there, and the value that each has, or why it has none.

use crate::kept::{Kept, StepOf};
use crate::session::Session;
use crate::show::{FrameOf, shown};
use crate::typed::Bytes;
use crate::variables::Name;
use crate::watched::Watched;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::preamble::sequencer::Place;
use srp_csimgen::spec::Position;
use srp_ir::described::Variable;

/// A value, and what is to be said with it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) ty: Ty,
    pub(crate) value: V4,
    /// When it changes, where the place alone does not tell.
    pub(crate) note: String,
}

/// A place in the source, as far as a frame has one.
pub(crate) type Spot = (String, u32);

impl Session<'_> {
    /// The variables that can be named at a place, those declared last first.
    pub(crate) fn in_scope(&self, spot: &Spot) -> Vec<usize> {
        let (file, line) = spot;
        let described = &self.code.variables.described;
        let of_file = |variable: &Variable| {
            let files = &self.code.variables.files;
            files
                .get(variable.from.file.index())
                .is_some_and(|f| f == file)
        };
        let all = described.variables.iter().enumerate();
        let here = all.filter(|(_, v)| (v.from.line..=v.to).contains(line) && of_file(v));
        let mut here: Vec<usize> = here.map(|(number, _)| number).collect();
        here.sort_by_key(|&number| std::cmp::Reverse(described.variables[number].from));
        here
    }

    /// The variable of a name at a place.
    pub(crate) fn local(&self, spot: &Spot, name: &str) -> Option<usize> {
        let described = &self.code.variables.described;
        let mut here = self.in_scope(spot).into_iter();
        here.find(|&number| described.variables[number].name == name)
    }

    /// The place of a frame.
    pub(crate) fn spot(&self, core: u32, of: FrameOf) -> Spot {
        let frames = self.frames(core);
        let frame = frames.into_iter().find(|frame| frame.of == of);
        frame.map_or((String::new(), 0), |frame| (frame.file, frame.line))
    }

    /// The bytes of a variable as far as they are known, what is to be said with them, and why the others are not.
    pub(crate) fn bytes_of(
        &self,
        core: u32,
        of: FrameOf,
        spot: &Spot,
        variable: usize,
    ) -> (Bytes, String, Option<String>) {
        let ty = self.code.variables.described.variables[variable].ty;
        let size = self.code.variables.described.types[ty].size;
        let (mut bytes, mut notes, mut why) = (Bytes::unknown(size), Vec::new(), None);
        let pieces = (0..).zip(&self.code.variables.pieces);
        for (piece, data) in pieces.filter(|(_, piece)| piece.variable == Some(variable)) {
            match self.piece(core, of, spot, piece) {
                Ok(seen) => {
                    let lanes = if seen.ty == Ty::Vec { 4 } else { 1 };
                    let words = seen.value.0[..lanes].iter();
                    let value: Vec<u8> = words.flat_map(|word| word.to_le_bytes()).collect();
                    let size = value.len().min(data.size as usize);
                    bytes.set(data.offset, &value[..size]);
                    if !seen.note.is_empty() && !notes.contains(&seen.note) {
                        notes.push(seen.note);
                    }
                }
                Err(reason) => why = why.or(Some(reason)),
            }
        }
        (bytes, notes.join("; "), why)
    }

    /// The value of a piece of a variable.
    fn piece(&self, core: u32, of: FrameOf, spot: &Spot, piece: Name) -> Result<Seen, String> {
        let data = &self.code.variables.pieces[piece as usize];
        if data.in_memory {
            return Err("it lies on the stack, where the debugger does not find it".to_owned());
        }
        let watched = self.cores[core as usize].get();
        let on_array = match watched.marks.place {
            Place::Context { kernel, .. } => Some(kernel),
            _ => None,
        };
        if let Some(constant) = data.constant {
            return Ok(Seen {
                ty: constant.ty(),
                value: V4(constant.lanes()),
                note: String::new(),
            });
        }
        let innermost = watched.marks.calls.len() - 1;
        let level = match (of, on_array) {
            (FrameOf::Iteration(iteration), Some(kernel)) => {
                if let Some(seen) = self.of_iteration(&watched, kernel, iteration, spot, piece) {
                    return seen;
                }
                innermost
            }
            (FrameOf::Iteration(_), None) => return Err("the iteration is over".to_owned()),
            (FrameOf::Call(level), kernel) => {
                let of_kernel = kernel.map(|k| &self.code.kernels[k as usize].of);
                let changes = of_kernel.is_some_and(|of| {
                    let mut names = of.names.values().flatten();
                    of.kept.contains_key(&piece) || names.any(|name| *name == piece)
                });
                if level == innermost && changes {
                    return Err("the loop on the array changes it: look at an iteration".to_owned());
                }
                level
            }
        };
        self.in_bundles(&watched, level, spot, piece)
    }

    fn why_none(&self, piece: Name) -> String {
        let data = &self.code.variables.pieces[piece as usize];
        let described = &self.code.variables.described;
        let is_param = data
            .variable
            .is_some_and(|v| described.variables[v].is_param);
        match (is_param, self.code.makes(piece)) {
            (true, _) => "it is a parameter that no operation makes".to_owned(),
            (_, true) => "no operation has made it yet".to_owned(),
            _ => {
                "no operation makes it: it is a copy or a constant, or went into others".to_owned()
            }
        }
    }

    /// True if a position is not before the place: an operation of it that has run is ahead of the lines.
    fn is_ahead(&self, at: Position, spot: &Spot) -> bool {
        let line = self
            .code
            .line(at)
            .map(|line| &self.code.lines[line as usize]);
        self.code.is_step(at) || line.is_some_and(|(file, line)| *file == spot.0 && *line >= spot.1)
    }

    /// The value that VLIW code has made, where it is sure that the program has it at this place.
    fn in_bundles(
        &self,
        watched: &Watched,
        level: usize,
        spot: &Spot,
        piece: Name,
    ) -> Result<Seen, String> {
        if let Some(doubt) = self.code.doubt(piece) {
            return Err(doubt.to_owned());
        }
        let Some(call) = watched.marks.calls.get(level) else {
            return Err("the call is over".to_owned());
        };
        let is_innermost = level + 1 == watched.marks.calls.len();
        let (next, goes_on) = match (is_innermost, watched.marks.place) {
            (true, Place::Bundle(number)) => (number, self.code.goes_on(call.last, number)),
            _ => (call.last.map_or(0, |last| last + 1), true),
        };
        if self.code.is_late(&self.spec, next, piece, spot) {
            return Err("its operation runs later than its line".to_owned());
        }
        let Some(made) = call.variables.get(&piece) else {
            return Err(self.why_none(piece));
        };
        let (ty, line) = (made.ty, self.line_of(made.at).1);
        let is_ahead = self.is_ahead(made.at, spot);
        let is_now = goes_on && made.stretch == call.stretch;
        let is_set_once = self.code.variables.pieces[piece as usize].set.stores <= 1;
        let seen = |value, note| Ok(Seen { ty, value, note });
        match (is_ahead, is_now, is_set_once) {
            (true, true, true) => seen(made.value, format!("from line {line} on, which ran ahead")),
            (true, false, true) => Err(format!("line {line} has not set it again yet")),
            (true, true, false) => {
                let next = shown(ty, made.value);
                let before = made
                    .before
                    .ok_or_else(|| format!("it becomes {next} by line {line}, which ran ahead"));
                seen(
                    before?,
                    format!("{next} from line {line} on, which ran ahead"),
                )
            }
            _ => seen(made.value, String::new()),
        }
    }

    fn line_of(&self, at: Position) -> Spot {
        let line = self.code.line(at);
        line.map_or((String::new(), 0), |line| {
            self.code.lines[line as usize].clone()
        })
    }

    /// The value in an iteration; `None` where its kernel does not change the variable.
    fn of_iteration(
        &self,
        watched: &Watched,
        kernel: u32,
        iteration: u64,
        spot: &Spot,
        piece: Name,
    ) -> Option<Result<Seen, String>> {
        let of = &self.code.kernels[kernel as usize].of;
        let contexts = &self.spec.kernels[kernel as usize].contexts;
        let made = |number: u64, step: StepOf| {
            let mut iterations = watched.marks.iterations.iter();
            let (_, values) = iterations.find(|(known, _)| *known == number)?;
            let mut values = values.iter().rev();
            values.find(|(at, _)| *at == step).map(|(_, value)| *value)
        };
        if let Some(kept) = of.kept.get(&piece) {
            let live_ins = &watched.marks.live_ins;
            let before = match (kept.stride, kept.update, iteration.checked_sub(1)) {
                (Some(_), ..) => kept.counted(live_ins, iteration),
                (None, _, None) => kept.first.value(live_ins),
                (None, update, Some(last)) => update.and_then(|step| made(last, step)),
            };
            let now = kept.update.and_then(|step| {
                let at = contexts[step.0 as usize][step.1 as usize].at;
                made(iteration, step).map(|value| (value, self.is_ahead(at, spot)))
            });
            return Some(self.kept(kept, iteration, before, now));
        }
        if let Some(&step) = of.own.get(&piece) {
            let data = &contexts[step.0 as usize][step.1 as usize];
            let Some(value) = made(iteration, step) else {
                return Some(Err(format!("iteration {iteration} has not come to it yet")));
            };
            let ty = data.ty?;
            let note = String::new();
            return Some(Ok(Seen { ty, value, note }));
        }
        of.refused.get(&piece).map(|why| Err(why.clone()))
    }

    /// The value of what a loop keeps: before an iteration, or what the iteration has made of it, with whether that is ahead.
    fn kept(
        &self,
        kept: &Kept,
        iteration: u64,
        before: Option<V4>,
        now: Option<(V4, bool)>,
    ) -> Result<Seen, String> {
        let (ty, passes) = (kept.ty, kept.passes);
        let line = kept.place.rsplit(':').nth(1).unwrap_or_default();
        if let (Some((value, false)), 1, false) = (now, passes, kept.is_step) {
            let note = String::new();
            return Ok(Seen { ty, value, note });
        }
        let note = match now {
            _ if passes > 1 => format!("before the {passes} passes of iteration {iteration}"),
            _ if kept.is_step => String::new(),
            Some((value, _)) => {
                format!("{} from line {line} on, which ran ahead", shown(ty, value))
            }
            None => format!("before line {line} in iteration {iteration}"),
        };
        let unknown =
            || format!("what it was before line {line} in iteration {iteration} is kept nowhere");
        let value = before.ok_or_else(unknown)?;
        Ok(Seen { ty, value, note })
    }
}
