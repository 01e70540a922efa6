//! What has been simulated of a frame, kept in the cache folder: whole frames by level, and all tiles in
//! batches, from which trials draw.

use super::clock::Watch;
use super::{First, Shot};
use crate::failure::Failure;
use crate::talk::Progress;
use crate::{files, interrupt, variant};
use serde::{Deserialize, Serialize};
use srp_runtime::fidelity::Fidelity;
use srp_runtime::system::sampled::{self, Batch, Figure};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Seed of the batches that trials draw from.
const SEED: u64 = 0x5eed;

/// Batches between two times of writing.
const CHUNK: usize = 8;

/// A whole frame at a level.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Level {
    /// Seconds on the host.
    pub(crate) seconds: f64,
    /// The values of its figures.
    pub(crate) values: Vec<f64>,
}

/// What is known of a frame.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Census {
    levels: BTreeMap<String, Level>,
    batches: Vec<Batch>,
    batch_seconds: f64,
    #[serde(skip)]
    path: PathBuf,
}

impl Census {
    /// What was kept of a frame with this name.
    pub(crate) fn of(shot: &Shot<'_>, name: &str) -> Census {
        let (width, height) = shot.size;
        let machine = srp_archdesc::xml::write(shot.arch);
        let made = variant::tools();
        let options = &shot.scene.options;
        let (camera, lights, effects) = (shot.camera, &shot.scene.lights, shot.effects);
        let triangles = shot.scene.triangles.len();
        let text = format!(
            "{name} {triangles} {width} {height} {options:?} {camera:?} {lights:?} {effects} {made:?} {machine}"
        );
        let key = variant::hash(&text);
        let path = files::cache_folder()
            .join("fidelity")
            .join(format!("{key}.json"));
        let kept = files::read_text(&path).ok();
        let kept = kept.and_then(|text| serde_json::from_str::<Census>(&text).ok());
        Census {
            path,
            ..kept.unwrap_or_default()
        }
    }

    fn keep(&self) -> Result<(), Failure> {
        let text = serde_json::to_string(self).map_err(Failure::message)?;
        if let Some(folder) = self.path.parent() {
            files::make_folder(folder)?;
        }
        Ok(files::write(&self.path, text.as_bytes())?)
    }

    /// The frame at a level.
    pub(crate) fn level(&mut self, shot: &Shot<'_>, level: Fidelity) -> Result<Level, Failure> {
        if let Some(known) = self.levels.get(level.name()) {
            return Ok(known.clone());
        }
        let whole = shot.whole(level)?;
        let known = Level {
            seconds: whole.seconds,
            values: whole.figures.iter().map(|f| f.estimate.value).collect(),
        };
        self.levels.insert(level.name().to_owned(), known.clone());
        self.keep()?;
        Ok(known)
    }

    /// Measures all tiles in batches. Returns them, and the seconds that a tile took.
    pub(crate) fn batches(
        &mut self,
        shot: &Shot<'_>,
        first: &First,
    ) -> Result<(&[Batch], f64), Failure> {
        let all = sampled::batches(&first.tiles, SEED);
        let count = |batches: &[Vec<u32>]| batches.iter().map(Vec::len).sum::<usize>();
        let progress = Progress::steps("all tiles", count(&all) as u64);
        while self.batches.len() < all.len() {
            let from = self.batches.len();
            let chunk = &all[from..all.len().min(from + CHUNK * shot.threads.max(1))];
            let before = count(&all[..from]);
            let at = |done: usize| progress.at((before + done) as u64);
            let watch = Watch::start();
            let more = interrupt::looked_for(|| {
                shot.framed(first, &at, |frame| sampled::run(frame, &first.tiles, chunk))
            });
            let more = more.map_err(Failure::message)?;
            self.batches.extend(more.ok_or(Failure::Interrupted)?);
            self.batch_seconds += watch.seconds();
            self.keep()?;
        }
        let seconds = self.batch_seconds / count(&all).max(1) as f64;
        Ok((&self.batches, seconds))
    }
}

/// Values of figures.
pub(crate) fn values(figures: &[Figure]) -> Vec<f64> {
    figures.iter().map(|f| f.estimate.value).collect()
}
