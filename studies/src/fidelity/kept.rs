//! Frames that were run before, from the session's cache: whole frames by level, and samples.

use super::host_time::{HostTime, Start};
use super::{Fidelity, FrameFigure, Prepared, untimed};
use crate::Error;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use srp_ir::dre::write_scheduled;
use srp_toolchain::cache::{Key, Kind, key};

/// A whole frame at a level.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Level {
    /// Time of the host.
    pub(super) took: HostTime,
    /// The values of its figures.
    pub(super) values: Vec<f64>,
}

/// A sample of a frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Sample {
    /// Time of the host.
    pub(super) took: HostTime,
    /// The part of the tiles that was measured.
    pub(super) measured: f64,
    /// The values of its figures, and half their intervals.
    pub(super) figures: Vec<(f64, f64)>,
}

/// A frame, and what is known of it.
pub(super) struct Kept<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    /// The scheduled program as text, which is part of all keys.
    program: String,
}

impl<'a> Kept<'a> {
    /// Writes the program as text, for the keys of the frame.
    pub(super) fn of(prepared: &'a Prepared<'a>) -> Kept<'a> {
        Kept {
            program: write_scheduled(prepared.program, &prepared.frame.arch),
            prepared,
        }
    }

    fn key(&self) -> key::Builder {
        self.prepared.key(Kind::Frames, &self.program)
    }

    fn known<T: Serialize + DeserializeOwned>(
        &self,
        key: Key,
        make: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        let session = self.prepared.session;
        if let Some(known) = session.cache.get(key, session.watch) {
            return Ok(known);
        }
        let made = make()?;
        session.cache.put(key, &made, session.watch);
        Ok(made)
    }

    /// The frame at a level.
    pub(super) fn level(&self, level: Fidelity) -> Result<Level, Error> {
        let key = self.key().text("level").text(level.name()).finish();
        self.known(key, || {
            let whole = self.prepared.whole(level)?;
            Ok(Level {
                took: whole.took,
                values: values(&whole.figures),
            })
        })
    }

    /// The counts of the frame without a clock, as [`untimed`] finds them: its program is neither divided nor
    /// scheduled.
    pub(super) fn untimed(&self) -> Result<Level, Error> {
        let Prepared {
            frame,
            image,
            session,
            ..
        } = self.prepared;
        let key = self.key().text("untimed").finish();
        self.known(key, || {
            let (program, _) = frame.build.program(&frame.arch)?;
            let start = Start::now(session.watch);
            let untimed = untimed(image, &program, &frame.arch, &frame.guard, session)?;
            Ok(Level {
                took: start.taken(),
                values: values(&untimed.figures),
            })
        })
    }

    /// The sample of a seed.
    pub(super) fn sample(&self, seed: u64, error: f64) -> Result<Sample, Error> {
        let key = self.key().text("sample").value(&(seed, error)).finish();
        self.known(key, || {
            let (sampled, took) = self.prepared.sampled(seed, error)?;
            let figures = sampled.figures.iter().map(|f| f.estimate);
            Ok(Sample {
                took,
                measured: sampled.measured as f64 / sampled.tiles.max(1) as f64,
                figures: figures.map(|e| (e.value, e.half_width)).collect(),
            })
        })
    }
}

fn values(figures: &[FrameFigure]) -> Vec<f64> {
    figures.iter().map(|f| f.estimate.value).collect()
}
