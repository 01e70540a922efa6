//! Traces of requests, and how a memory answers one.
//!
//! A trace is text with a request on each line: the address of its first byte (decimal, or
//! hexadecimal after `0x`), `READ` or `WRITE`, the memory cycle from which on it is offered, and
//! optionally its bytes, without which it is of one burst. What follows a `#` is a comment. This is
//! the format of DRAMsim3 with bytes and comments added.
//!
//! Requests are offered in the order of the trace, at most one in a cycle; one that finds no room is
//! offered again, and those behind it wait.

use srp_archdesc::diagnostic::{Diagnostic, Span};
use srp_archdesc::dram::{DramModel, DramSpec};

use super::{Dram, DramCounters, Request};

/// Most requests of a trace.
pub const MAX_REQUESTS: usize = 1 << 26;

/// Latest cycle of a request.
pub const MAX_CYCLE: u64 = 1 << 62;

/// Most bytes of a request.
pub const MAX_REQUEST_BYTES: u64 = 4096;

/// Mistakes after which a trace is read no further.
const MAX_MISTAKES: usize = 20;

/// One line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offer {
    /// The request.
    pub request: Request,
    /// The cycle from which it is offered.
    pub cycle: u64,
}

/// A trace without mistakes. Its requests are read as they are wanted: a list of them would be larger than its text.
#[derive(Clone, Copy, Debug)]
pub struct Trace<'t> {
    text: &'t str,
    bytes: u32,
    requests: usize,
}

impl<'t> Trace<'t> {
    /// How many requests it has.
    pub fn requests(&self) -> usize {
        self.requests
    }

    /// Its requests, in order.
    pub fn offers(&self) -> impl Iterator<Item = Offer> + use<'t> {
        let bytes = self.bytes;
        let lines = self.text.split_inclusive('\n');
        lines.filter_map(move |line| offer(line, bytes).ok().flatten())
    }
}

/// How a memory answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Replay {
    /// Cycles simulated.
    pub cycles: u64,
    /// Requests of the trace that were taken.
    pub taken: u64,
    /// Cycles in which the requester had to wait for room.
    pub refused_cycles: u64,
    /// Counts of the memory in these cycles.
    pub counters: DramCounters,
}

/// Bytes of a request where the trace does not say: one burst, or a line of 64 bytes in a memory
/// without bursts.
pub fn default_bytes(spec: &DramSpec) -> u32 {
    match &spec.model {
        DramModel::Fixed => 64,
        DramModel::Banked(banked) => banked.burst_bytes(spec.bits),
    }
}

/// Reads a trace; `file` is its name for messages, `bytes` the size of requests without one.
///
/// # Errors
///
/// The mistakes of its lines, in their order.
pub fn parse<'t>(file: &str, text: &'t str, bytes: u32) -> Result<Trace<'t>, Vec<Diagnostic>> {
    let mut requests = 0;
    let mut mistakes = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        match offer(line, bytes) {
            Ok(None) => {}
            Ok(Some(_)) if requests == MAX_REQUESTS => {
                let message = format!("more than {MAX_REQUESTS} requests");
                mistakes.push(Diagnostic::error("R0501", file, message));
                break;
            }
            Ok(Some(_)) => requests += 1,
            Err(mistake) => mistakes.push(mistake.diagnostic(file, start)),
        }
        if mistakes.len() == MAX_MISTAKES {
            break;
        }
        start += line.len();
    }
    match mistakes.is_empty() {
        true => Ok(Trace {
            text,
            bytes,
            requests,
        }),
        false => Err(mistakes),
    }
}

/// A mistake in a line, at these bytes of it.
struct Mistake {
    code: &'static str,
    message: String,
    label: &'static str,
    at: (usize, usize),
}

impl Mistake {
    fn diagnostic(self, file: &str, start: usize) -> Diagnostic {
        // Offsets of messages have 32 bits; texts beyond that are shown without a place.
        let offset = |at: usize| u32::try_from(start + at).ok();
        let error = Diagnostic::error(self.code, file, self.message)
            .help("a line is `ADDRESS READ|WRITE CYCLE [BYTES]`");
        match (offset(self.at.0), offset(self.at.1)) {
            (Some(from), Some(to)) => error.at(Span::new(from, to), self.label),
            _ => error,
        }
    }
}

/// The request on a line, if there is one.
fn offer(line: &str, bytes: u32) -> Result<Option<Offer>, Mistake> {
    let text = line.split('#').next().unwrap_or_default();
    let mut rest = text.split_ascii_whitespace();
    let place = |word: &str| {
        let from = word.as_ptr() as usize - line.as_ptr() as usize;
        (from, from + word.len())
    };
    let end = text.trim_end().len();
    let Some(address) = rest.next() else {
        return Ok(None);
    };
    let lacks = |what: &str| Mistake {
        code: "R0502",
        message: format!("the line lacks {what}"),
        label: "expected here",
        at: (end, end),
    };
    let number = |word: &str, what: &str, max: u64| {
        number(word).filter(|n| *n <= max).ok_or_else(|| Mistake {
            code: "R0503",
            message: format!("{what} is a number up to {max}"),
            label: "not such a number",
            at: place(word),
        })
    };
    let address = number(address, "an address", u64::from(u32::MAX))? as u32;
    let word = rest.next().ok_or_else(|| lacks("`READ` or `WRITE`"))?;
    let is_write = if word.eq_ignore_ascii_case("write") {
        true
    } else if word.eq_ignore_ascii_case("read") {
        false
    } else {
        return Err(Mistake {
            code: "R0504",
            message: "a request is `READ` or `WRITE`".to_owned(),
            label: "neither",
            at: place(word),
        });
    };
    let cycle = rest.next().ok_or_else(|| lacks("its cycle"))?;
    let cycle = number(cycle, "a cycle", MAX_CYCLE)?;
    let bytes = match rest.next() {
        Some(word) => (number(word, "the size of a request", MAX_REQUEST_BYTES)? as u32).max(1),
        None => bytes,
    };
    if let Some(word) = rest.next() {
        return Err(Mistake {
            code: "R0505",
            message: "there is more on the line than a request".to_owned(),
            label: "unexpected",
            at: place(word),
        });
    }
    let request = Request {
        address,
        bytes,
        is_write,
        source: 0,
    };
    Ok(Some(Offer { request, cycle }))
}

fn number(word: &str) -> Option<u64> {
    let hexadecimal = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X"));
    let (digits, radix) = match hexadecimal {
        Some(digits) => (digits, 16),
        None => (word, 10),
    };
    // `from_str_radix` takes a sign.
    let first = digits.chars().next()?;
    first.is_ascii_hexdigit().then_some(())?;
    u64::from_str_radix(digits, radix).ok()
}

/// Offers requests to a memory at rest, and simulates so many cycles, or until all
/// are answered.
pub fn replay(
    dram: &mut dyn Dram,
    offers: impl IntoIterator<Item = Offer>,
    cycles: Option<u64>,
) -> Replay {
    let end = cycles.unwrap_or(u64::MAX);
    let mut done = Vec::new();
    let (mut now, mut taken, mut refused_cycles) = (0u64, 0, 0);
    'trace: for offer in offers {
        now = now.max(offer.cycle);
        loop {
            if now >= end {
                break 'trace;
            }
            match dram.offer(now, offer.request) {
                Ok(()) => break,
                Err(from) => {
                    refused_cycles += from.min(end) - now;
                    now = from;
                }
            }
        }
        taken += 1;
        dram.advance(now, &mut done);
        done.clear();
        now += 1;
    }
    let cycles = match cycles {
        Some(cycles) => {
            if let Some(last) = cycles.checked_sub(1) {
                dram.advance(last, &mut done);
            }
            cycles
        }
        None => {
            let mut last = now.checked_sub(1);
            while let Some(event) = dram.next_event() {
                dram.advance(event, &mut done);
                last = last.max(done.last().map(|(over, _)| *over));
                done.clear();
            }
            last.map_or(0, |last| last + 1)
        }
    };
    Replay {
        cycles,
        taken,
        refused_cycles,
        counters: dram.counters(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_request() {
        let text = "0x40 READ 0\n# nothing\n\n 64 write 7 48 # half a line\r\n0X60 Read 8\n";
        let trace = parse("t", text, 32).expect("a trace");
        let line = |address, bytes, is_write, cycle| Offer {
            request: Request {
                address,
                bytes,
                is_write,
                source: 0,
            },
            cycle,
        };
        let expected = [
            line(64, 32, false, 0),
            line(64, 48, true, 7),
            line(96, 32, false, 8),
        ];
        assert_eq!(trace.requests(), 3);
        assert!(trace.offers().eq(expected));
    }

    #[test]
    fn mistakes_are_found_where_they_are() {
        let text =
            "0x40 READ\n0x1ffffffff READ 0\n0 TAKE 0\n0 READ -1\n0 READ 0 64 x\n0 READ 0 0x\n";
        let mistakes = parse("t", text, 32).expect_err("mistakes");
        let found: Vec<(&str, &str)> = (mistakes.iter())
            .map(|m| {
                let span = m.primary.as_ref().expect("a place").span;
                (m.code, &text[span.start as usize..span.end as usize])
            })
            .collect();
        let expected = [
            ("R0502", ""),
            ("R0503", "0x1ffffffff"),
            ("R0504", "TAKE"),
            ("R0503", "-1"),
            ("R0505", "x"),
            ("R0503", "0x"),
        ];
        assert_eq!(found, expected);
    }
}
