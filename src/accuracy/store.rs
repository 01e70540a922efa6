//! Where trials are kept, so that an interrupted run goes on where it was, with their pictures.

use super::setting::{Setting, Subject};
use super::trial::Trial;
use crate::failure::Failure;
use crate::files;
use serde::{Deserialize, Serialize};
use srp_runtime::picture::Picture;
use srp_runtime::scene::Scene;
use std::path::{Path, PathBuf};

/// Levels of difference that are white in a map.
const WHITE_AT: u8 = 32;

/// A folder of trials.
pub(super) struct Store {
    folder: PathBuf,
    /// Another for other machines, kernels, scenes and versions of the tools.
    key: String,
}

/// A trial in its file.
#[derive(Serialize, Deserialize)]
struct Kept {
    key: String,
    trial: Trial,
}

impl Store {
    /// The folder, which is made where there is none.
    pub(super) fn open(
        folder: &Path,
        base: &Subject,
        scene: &Scene,
        (width, height): (u32, u32),
    ) -> Result<Store, Failure> {
        files::make_folder(&folder.join("trials"))?;
        files::check_writable(&folder.join("report.html"))?;
        let machine = base.build.name(&base.arch);
        let scene = Scene {
            options: base.options,
            ..scene.clone()
        };
        let scene = srp_toolchain::hash(&format!("{scene:?}"));
        let tools = srp_toolchain::BUILD_ID;
        Ok(Store {
            folder: folder.to_owned(),
            key: format!("{machine} {scene} {width}x{height} {tools}"),
        })
    }

    /// A file of the folder.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn file(&self, knob: &str, value: &str, kind: &str) -> PathBuf {
        let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let mut name: String = format!("{knob}-{value}").chars().map(letter).collect();
        if name.len() > 80 {
            name = format!("{}-{}", &name[..60], srp_toolchain::hash(&name));
        }
        self.folder.join("trials").join(format!("{name}.{kind}"))
    }

    /// A setting's trial, if it was made before.
    pub(super) fn kept(&self, setting: &Setting) -> Option<Trial> {
        let text = files::read_text(&self.file(&setting.knob, &setting.value, "json")).ok()?;
        let kept: Kept = serde_json::from_str(&text).ok()?;
        (kept.key == self.key).then_some(kept.trial)
    }

    /// Keeps a trial, its picture, and a map of what is off.
    pub(super) fn keep(
        &self,
        setting: &Setting,
        trial: &Trial,
        picture: &Picture,
        levels: &[u8],
    ) -> Result<(), Failure> {
        let file = |kind| self.file(&setting.knob, &setting.value, kind);
        files::write(&file("png"), &picture.png())?;
        files::write(&file("map.png"), &map(picture, levels).png())?;
        let kept = Kept {
            key: self.key.clone(),
            trial: trial.clone(),
        };
        let text = serde_json::to_string_pretty(&kept).map_err(Failure::message)?;
        files::write(&file("json"), text.as_bytes())
    }

    /// The map of a trial as PNG, if it is there.
    pub(super) fn map(&self, trial: &Trial) -> Option<Vec<u8>> {
        std::fs::read(self.file(&trial.knob, &trial.value, "map.png")).ok()
    }
}

/// What is off, from black over red to white.
fn map(picture: &Picture, levels: &[u8]) -> Picture {
    let pixel = |&level: &u8| {
        let bright = u32::from(level) * 510 / u32::from(WHITE_AT);
        let over = bright.saturating_sub(255).min(255) as u8;
        [bright.min(255) as u8, over, over, 255]
    };
    Picture {
        width: picture.width,
        height: picture.height,
        rgba: levels.iter().flat_map(pixel).collect(),
    }
}
