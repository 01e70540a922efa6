//! Files of cameras.

use crate::files::{self, Kind, Outside};
use crate::{Error, json};
use serde::Deserialize;
use serde_json::value::RawValue;
use srp_archdesc::diagnostic::{Source, Span};
use srp_runtime::scene::camera::{Camera, View, Viewpoints};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The viewpoints of one scene in a file of cameras.
#[derive(Debug)]
pub struct Views {
    file: Source,
    name: String,
    /// The viewpoints.
    pub points: Viewpoints,
    /// Where the scene stands in the file, and each of its views.
    scene: Span,
    views: Vec<Span>,
}

/// A scene as it is written.
#[derive(Deserialize)]
struct Written<'t> {
    ao_radius: Option<f32>,
    up: [f32; 3],
    #[serde(borrow)]
    views: Vec<&'t RawValue>,
}

impl Views {
    /// Those under `name` in the file.
    ///
    /// # Errors
    ///
    /// The file cannot be read, is wrong, or has no such scene.
    pub fn read(path: &Path, name: &str) -> Result<Views, Error> {
        Views::of(read(path)?, name)
    }

    /// Those under `name` in a file that was read.
    ///
    /// # Errors
    ///
    /// The file is wrong, or has no such scene.
    pub fn of(file: Source, name: &str) -> Result<Views, Error> {
        let scenes = scenes(&file)?;
        let Some(scene) = scenes.get(name) else {
            let known: Vec<&str> = scenes
                .iter()
                .filter(|(_, scene)| scene.get().starts_with('{'))
                .map(|(known, _)| known.as_str())
                .collect();
            return Err(Error::Invalid(format!(
                "{}: there is no scene `{name}`; there are {}",
                file.name,
                known.join(", ")
            )));
        };
        let part = |raw: &RawValue| {
            let start = raw.get().as_ptr() as usize - file.text.as_ptr() as usize;
            Span::new(start as u32, (start + raw.get().len()) as u32)
        };
        let wrong = |raw: &RawValue, e| json::wrong(&file, part(raw).start as usize, &e);
        let written: Written<'_> =
            serde_json::from_str(scene.get()).map_err(|e| wrong(scene, e))?;
        let view = |raw: &&RawValue| -> Result<View, Error> {
            serde_json::from_str(raw.get()).map_err(|e| wrong(raw, e))
        };
        let points = Viewpoints {
            ao_radius: written.ao_radius,
            up: written.up,
            views: written.views.iter().map(view).collect::<Result<_, _>>()?,
        };
        let views = written.views.iter().map(|raw| part(raw)).collect();
        let scene = part(scene);
        Ok(Views {
            name: name.to_owned(),
            points,
            scene,
            views,
            file,
        })
    }

    /// Those that a file `cameras.json` beside the scene, or one folder above, has for it. Above is outside.
    ///
    /// # Errors
    ///
    /// Such a file cannot be read, or is wrong.
    pub fn beside(scene: &Path, outside: Outside) -> Result<Option<Views>, Error> {
        let Some(name) = scene.file_stem().and_then(|n| n.to_str()) else {
            return Ok(None);
        };
        let folders = match outside {
            Outside::Told => 2,
            Outside::Refused => 1,
        };
        for folder in scene.ancestors().skip(1).take(folders) {
            let path: PathBuf = folder.join("cameras.json");
            if !path.is_file() {
                continue;
            }
            let file = read(&path)?;
            if scenes(&file)?.contains_key(name) {
                return Views::of(file, name).map(Some);
            }
        }
        Ok(None)
    }

    /// The camera of view `number`.
    ///
    /// # Errors
    ///
    /// There is no such view, or its figures are none of a camera.
    pub fn camera(&self, number: usize) -> Result<Camera, Error> {
        self.points.camera(number).map_err(|e| {
            // What a camera says of itself is often on several lines; the first shows where.
            let whole = self.views.get(number).copied().unwrap_or(self.scene);
            let text = &self.file.text[whole.start as usize..whole.end as usize];
            let line = text.lines().next().map_or(0, str::len) as u32;
            let first = Span::new(whole.start, whole.start + line);
            json::at_byte(&self.file, first, &format!("scene `{}`: {e}", self.name))
        })
    }
}

fn read(path: &Path) -> Result<Source, Error> {
    let text = files::read_text(path, Kind::Cameras)?;
    Ok(Source::new(path.display().to_string(), text))
}

/// All scenes of a file of cameras, as they are written.
fn scenes(file: &Source) -> Result<BTreeMap<String, &RawValue>, Error> {
    json::read(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str, view: usize) -> String {
        let views = Views::of(Source::new("c.json", text), "a");
        let camera = views.and_then(|views| views.camera(view));
        camera.expect_err(text).to_string()
    }

    #[test]
    fn mistakes_have_places() {
        let good = "{\"position\":[0,0,3],\"forward\":[0,0,-1],\"fov_deg\":40}";
        let file = |view: &str| {
            format!("{{\"é\": 1,\n \"a\":{{\"up\":[0,1,0],\n  \"views\":[{good},\n   {view}]}}}}")
        };
        assert!(Views::of(Source::new("c.json", file(good)), "a").is_ok());
        let told = |text: &str, view, what: &str, at: &str| {
            let said = message(text, view);
            assert!(said.contains(what) && said.contains(at), "{said}");
        };
        told(&file(&good.replace("-1", "0")), 1, "is none", "c.json:4:4");
        told(&file(&good.replace("40", "400")), 1, "400", "c.json:4:4");
        told(
            &file(&good.replace("0,0,-1", "0,0")),
            1,
            "length 2",
            "c.json:4:",
        );
        told(
            &file("{\"position\":[0,0,3]}"),
            1,
            "missing field",
            "c.json:4:23",
        );
        told(&file(good), 2, "there is no view 2", "c.json:2:6");
        told(
            &file(good).replace("\"up\":[0,1,0],", ""),
            0,
            "`up`",
            "c.json:4:57",
        );
        told("{\"a\":{}", 0, "EOF", "c.json:1:");
        told("{\"é\": 1,\n \"a\":x}", 0, "expected value", "c.json:2:6");
    }
}
