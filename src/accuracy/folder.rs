//! The folder of a report: the picture of every trial, a map of what is off in it, its machine, and the pictures in
//! binary64 that trials are held against.

use crate::failure::Failure;
use crate::files;
use srp_runtime::picture::Picture;
use srp_studies::accuracy::{Evidence, Rendering, Trial};
use srp_toolchain::files::FileError;
use std::path::{Path, PathBuf};

/// Levels of difference that are white in a map.
const WHITE_AT: u8 = 32;

/// A folder of trials.
pub(super) struct Folder(PathBuf);

impl Folder {
    /// The folder, which is made where there is none.
    pub(super) fn open(path: &Path) -> Result<Folder, Failure> {
        files::make_folder(path)?;
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

    /// Writes the picture of a trial, a map of what is off, and its machine; for the first trial and those
    /// with other samples the reference, too.
    pub(super) fn write(&self, trial: &Trial, evidence: &Evidence<'_>) -> Result<(), FileError> {
        let Rendering { picture, levels } = evidence.rendering;
        let write = srp_toolchain::files::write;
        let file = |kind| self.file(trial, kind);
        write(&file("png"), &picture.png())?;
        write(&file("map.png"), &map(picture, levels).png())?;
        let machine = srp_archdesc::xml::write(evidence.machine);
        write(&file("xml"), machine.as_bytes())?;
        let name = match (trial.knob.is_empty(), trial.is_sampling()) {
            (_, true) => "reference-finest",
            (true, false) => "reference",
            (false, false) => return Ok(()),
        };
        let channels: Vec<[f64; 3]> = (evidence.reference.iter())
            .map(|pixel| [pixel.x, pixel.y, pixel.z])
            .collect();
        let (raw, rounded) = (pfm(&channels, picture), bytes(&channels, picture));
        write(&self.path(&format!("{name}.pfm")), &raw)?;
        write(&self.path(&format!("{name}.png")), &rounded.png())
    }

    /// The map of a trial as PNG, if it is there.
    pub(super) fn map(&self, trial: &Trial) -> Option<Vec<u8>> {
        std::fs::read(self.file(trial, "map.png")).ok()
    }
}

/// A picture of floats as a portable float map: `PF`, width and height, −1 for little endian, then three binary32
/// a pixel, the lowest row first. Channels are levels from 0 to 255.
fn pfm(channels: &[[f64; 3]], like: &Picture) -> Vec<u8> {
    let mut file = format!("PF\n{} {}\n-1.0\n", like.width, like.height).into_bytes();
    for row in channels.chunks(like.width.max(1) as usize).rev() {
        let floats = row.iter().flatten().map(|&c| c as f32);
        file.extend(floats.flat_map(f32::to_le_bytes));
    }
    file
}

/// The same rounded to bytes, as trials are compared with it.
fn bytes(channels: &[[f64; 3]], like: &Picture) -> Picture {
    let pixel = |c: &[f64; 3]| {
        let [r, g, b] = c.map(|c| c.round().clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    };
    Picture {
        width: like.width,
        height: like.height,
        rgba: channels.iter().flat_map(pixel).collect(),
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
