//! The folder of a report: the picture of every trial, and a map of what is off in it.

use crate::failure::Failure;
use crate::files;
use srp_runtime::picture::Picture;
use srp_studies::accuracy::{Rendering, Trial};
use srp_toolchain::files::FileError;
use std::path::{Path, PathBuf};

/// Levels of difference that are white in a map.
const WHITE_AT: u8 = 32;

/// A folder of trials.
pub(super) struct Folder(PathBuf);

impl Folder {
    /// The folder, which is made where there is none.
    pub(super) fn open(path: &Path) -> Result<Folder, Failure> {
        files::make_folder(&path.join("trials"))?;
        files::check_writable(&path.join("report.html"))?;
        Ok(Folder(path.to_owned()))
    }

    /// A file of the folder.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn file(&self, trial: &Trial, kind: &str) -> PathBuf {
        let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let name = format!("{}-{}", trial.knob, trial.value);
        let mut name: String = name.chars().map(letter).collect();
        if name.len() > 80 {
            name = format!("{}-{}", &name[..60], srp_toolchain::hash(&name));
        }
        self.0.join("trials").join(format!("{name}.{kind}"))
    }

    /// Writes the picture of a trial, and a map of what is off.
    pub(super) fn write(&self, trial: &Trial, rendering: &Rendering) -> Result<(), FileError> {
        let Rendering { picture, levels } = rendering;
        let file = |kind| self.file(trial, kind);
        srp_toolchain::files::write(&file("png"), &picture.png())?;
        srp_toolchain::files::write(&file("map.png"), &map(picture, levels).png())
    }

    /// The map of a trial as PNG, if it is there.
    pub(super) fn map(&self, trial: &Trial) -> Option<Vec<u8>> {
        std::fs::read(self.file(trial, "map.png")).ok()
    }
}

/// Maps errors to colours, from black over red to white.
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
