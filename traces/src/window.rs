//! Which cycles are recorded.

use std::ops::Range;

/// Most cycles of a window.
pub const MAX_CYCLES: u64 = 1 << 17;

/// Most records of a trace, of 24 bytes each: where a window has more, it ends there.
pub const MAX_RECORDS: usize = 1 << 24;

/// A window of cycles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Window {
    /// These cycles, of all cores or of one.
    Cycles {
        /// The cycles.
        cycles: Range<u64>,
        /// The core.
        core: Option<u32>,
    },
    /// A launch of a kernel on one core: its cycles on the array.
    Launch {
        /// The kernel's name.
        kernel: String,
        /// Which launch, the first being 1.
        number: u64,
        /// The core.
        core: u32,
    },
    /// The core that takes this tile of a frame, from the next cycle on until it asks for another.
    Tile(u32),
}

impl Window {
    /// Reads `A..B`, `A..B@CORE`, `kernel:NAME`, `kernel:NAME#N`, `kernel:NAME#N@CORE` or `tile:N`.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn parse(text: &str) -> Result<Window, String> {
        if let Some(name) = text.strip_prefix("kernel:") {
            return Window::launch(name);
        }
        if let Some(tile) = text.strip_prefix("tile:") {
            let tile = tile.parse();
            return tile.map(Window::Tile).map_err(|_| FORMS.to_owned());
        }
        let (text, core) = match text.split_once('@') {
            Some((text, core)) => (text, Some(core.parse().map_err(|_| FORMS)?)),
            None => (text, None),
        };
        let (first, end) = text.split_once("..").ok_or(FORMS)?;
        let number = |text: &str| text.trim().replace('_', "").parse::<u64>().ok();
        let (Some(first), Some(end)) = (number(first), number(end)) else {
            return Err(FORMS.to_owned());
        };
        match end.checked_sub(first) {
            None | Some(0) => Err(format!("{first}..{end} has no cycle")),
            Some(cycles) if cycles > MAX_CYCLES => Err(format!(
                "{first}..{end} are {cycles} cycles; a window has at most {MAX_CYCLES}, here \
                 {first}..{}",
                first + MAX_CYCLES
            )),
            Some(_) => Ok(Window::Cycles {
                cycles: first..end,
                core,
            }),
        }
    }

    fn launch(text: &str) -> Result<Window, String> {
        let (text, core) = text.split_once('@').unwrap_or((text, "0"));
        let (kernel, number) = text.split_once('#').unwrap_or((text, "1"));
        let number = number.parse().ok().filter(|&n: &u64| n > 0);
        match (number, core.parse()) {
            (Some(number), Ok(core)) if !kernel.is_empty() => Ok(Window::Launch {
                kernel: kernel.to_owned(),
                number,
                core,
            }),
            _ => Err(FORMS.to_owned()),
        }
    }
}

impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Window::Cycles { cycles, core } => {
                write!(f, "cycles {}..{}", cycles.start, cycles.end)?;
                core.map_or(Ok(()), |core| write!(f, " of core {core}"))
            }
            Window::Launch {
                kernel,
                number,
                core,
            } => write!(f, "launch {number} of kernel {kernel} on core {core}"),
            Window::Tile(tile) => write!(f, "tile {tile}"),
        }
    }
}

/// What a window looks like.
const FORMS: &str = "a window is A..B (cycles; @CORE behind them for those of one core), kernel:NAME#N (the N-th \
                     launch, from 1; @CORE behind it where there are several cores), or tile:N (of a frame)";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read_and_refused() {
        let launch = |kernel: &str, number, core| Window::Launch {
            kernel: kernel.to_owned(),
            number,
            core,
        };
        let cycles = |cycles, core| Window::Cycles { cycles, core };
        assert_eq!(Window::parse("5..9"), Ok(cycles(5..9, None)));
        assert_eq!(Window::parse("5..9@3"), Ok(cycles(5..9, Some(3))));
        let long = Window::parse("1_000..2_000");
        assert_eq!(long, Ok(cycles(1000..2000, None)));
        assert_eq!(Window::parse("kernel:f"), Ok(launch("f", 1, 0)));
        assert_eq!(Window::parse("kernel:f#3@2"), Ok(launch("f", 3, 2)));
        assert_eq!(Window::parse("tile:7"), Ok(Window::Tile(7)));
        for wrong in [
            "",
            "5",
            "9..5",
            "5..5",
            "5..9@",
            "kernel:",
            "kernel:f#0",
            "kernel:f#x",
            "tile:-1",
        ] {
            assert!(Window::parse(wrong).is_err(), "{wrong}");
        }
        let long = Window::parse("0..999999999").expect_err("it is too long");
        assert!(long.contains("131072"), "{long}");
    }
}
