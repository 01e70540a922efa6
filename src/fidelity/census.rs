//! What has been simulated of a frame, kept in the cache folder: whole frames by level, and samples.

use super::Shot;
use super::clock::Took;
use crate::failure::Failure;
use crate::files;
use serde::{Deserialize, Serialize};
use srp_studies::fidelity::Fidelity;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A whole frame at a level.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Level {
    /// Time of the host.
    pub(crate) took: Took,
    /// The values of its figures.
    pub(crate) values: Vec<f64>,
}

/// A sample of a frame.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Kept {
    /// Time of the host.
    pub(crate) took: Took,
    /// The part of the tiles that was measured.
    pub(crate) measured: f64,
    /// The values of its figures, and half their intervals.
    pub(crate) figures: Vec<(f64, Option<f64>)>,
}

/// What is known of a frame.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Census {
    levels: BTreeMap<String, Level>,
    samples: BTreeMap<String, Kept>,
    #[serde(skip)]
    path: PathBuf,
}

impl Census {
    /// What was kept of a frame with this name.
    pub(crate) fn of(shot: &Shot<'_>, name: &str) -> Census {
        let (width, height) = shot.size;
        let machine = srp_archdesc::xml::write(shot.arch);
        let made = srp_toolchain::BUILD_ID;
        let options = &shot.scene.options;
        let (camera, lights, effects) = (shot.camera, &shot.scene.lights, shot.effects);
        let triangles = shot.scene.triangles.len();
        let text = format!(
            "{name} {triangles} {width} {height} {options:?} {camera:?} {lights:?} {effects} {made:?} {machine}"
        );
        let key = srp_toolchain::hash(&text);
        let path = srp_toolchain::files::cache_folder()
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
        files::write(&self.path, text.as_bytes())
    }

    /// The frame at a level.
    pub(crate) fn level(&mut self, shot: &Shot<'_>, level: Fidelity) -> Result<Level, Failure> {
        if let Some(known) = self.levels.get(level.name()) {
            return Ok(known.clone());
        }
        let whole = shot.whole(level)?;
        let known = Level {
            took: whole.took,
            values: whole.figures.iter().map(|f| f.estimate.value).collect(),
        };
        self.levels.insert(level.name().to_owned(), known.clone());
        self.keep()?;
        Ok(known)
    }

    /// The sample of a seed.
    pub(crate) fn sample(
        &mut self,
        shot: &Shot<'_>,
        seed: u64,
        error: f64,
    ) -> Result<Kept, Failure> {
        let name = format!("{seed} {error}");
        if let Some(known) = self.samples.get(&name) {
            return Ok(known.clone());
        }
        let (sampled, took) = shot.sampled(seed, error)?;
        let known = Kept {
            took,
            measured: sampled.measured as f64 / sampled.tiles.max(1) as f64,
            // JSON has no infinity.
            figures: (sampled.figures.iter().map(|f| f.estimate))
                .map(|e| (e.value, Some(e.half_width).filter(|w| w.is_finite())))
                .collect(),
        };
        self.samples.insert(name, known.clone());
        self.keep()?;
        Ok(known)
    }
}
