//! Scenes, their viewpoints, and the options for rendering them.

use crate::cache::{Key, Kind as Entry};
use crate::files::{self, Kind, Room};
use crate::{Error, Session};
use srp_archdesc::diagnostic::{Diagnostic, Messages};
use srp_archdesc::watch::{Event, Stage};
use srp_runtime::bvh::{self, Builder, Bvh};
use srp_runtime::effect::{self, Effects, Finding, Guard};
use srp_runtime::scene::camera::Camera;
use srp_runtime::scene::{self, Light, MAX_LIGHTS, Part, Scene};
use srp_runtime::scene_image::OFFSET;
use std::collections::BTreeSet;
use std::path::Path;

pub use crate::views::Views;

/// A scene, and the doubts about its files.
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Warnings about its files.
    pub warnings: Messages,
    /// Features that it asks for and the kernels do not have, a sentence each.
    pub unsupported: Vec<String>,
}

/// Reads a scene, or makes the default one.
///
/// # Errors
///
/// The scene's files cannot be read, or are wrong.
pub fn read(
    path: Option<&Path>,
    camera: Option<Camera>,
    session: &Session<'_>,
) -> Result<Loaded, Error> {
    let Some(path) = path else {
        let mut scene = scene::demo::demo();
        scene.camera = camera.unwrap_or(scene.camera);
        return Ok(Loaded {
            scene,
            warnings: Messages::default(),
            unsupported: Vec::new(),
        });
    };
    let _stage = Stage::unknown(session.watch, "reading the scene");
    let room = Room::of(path.parent(), session.outside);
    let mut outside = BTreeSet::new();
    let loaded = scene::read(path, camera, &mut |path, part| {
        let kind = match part {
            // The user names it.
            Part::Geometry => return files::load(path, Kind::Geometry),
            Part::Materials => Kind::Materials,
            Part::Picture => Kind::Picture,
        };
        let named = room.read(path, kind)?;
        if named.is_outside {
            outside.insert(path.to_owned());
        }
        Ok(named.bytes)
    });
    let mut loaded = loaded.map_err(Error::Messages)?;
    let doubts = far_away(path, &loaded.scene);
    loaded.warnings.diagnostics.extend(doubts);
    for path in outside {
        session.watch.tell(Event::Note(&format!(
            "note: {} is outside the folder of the scene that names it",
            path.display()
        )));
    }
    let unsupported = effect::unsupported(&loaded.scene);
    Ok(Loaded {
        unsupported: unsupported.iter().map(ToString::to_string).collect(),
        scene: loaded.scene,
        warnings: loaded.warnings,
    })
}

/// The part of a scene's size, one in so many, by which rays may begin off a surface before that is seen.
const OFF: f32 = 100.0;

/// A warning of a scene that is so far from the origin, for its size, that rays which go on from a surface begin visibly
/// off it.
fn far_away(path: &Path, scene: &Scene) -> Option<Diagnostic> {
    let (lo, hi) = scene::bounds(&scene.triangles)?;
    let size = (0.5 * hi - 0.5 * lo).max_element();
    let off = OFFSET * lo.abs().max(hi.abs()).max_element();
    (off * OFF > size).then(|| {
        let message = format!(
            "rays that go on begin {off} off surfaces of a scene that is {:?} long: it is far from the origin",
            2.0 * size
        );
        let help = "move it to the origin, or render it with --form offset=integer";
        Diagnostic::warning("R0120", &path.display().to_string(), message).help(help)
    })
}

/// How far light is followed, and the effects that the kernels are built for, where these are not the scene's
/// own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shading {
    /// A list of effects, as [`Effects::parse`] has it.
    pub effects: Option<String>,
    /// Rays through each pixel.
    pub samples: Option<u32>,
    /// Most secondary rays in a row.
    pub bounces: Option<u32>,
    /// Ambient occlusion rays from each point, and how far they reach; else a tenth of the scene.
    pub occlusion: Option<(u32, Option<f32>)>,
    /// Diffuse reflections in a row that are followed.
    pub inter_reflections: Option<u32>,
    /// Point lights, instead of the scene's.
    pub lights: Vec<Light>,
}

impl Shading {
    /// Changes a scene.
    ///
    /// # Errors
    ///
    /// The scene then has too many lights.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        let options = &mut scene.options;
        options.samples = self.samples.unwrap_or(options.samples);
        options.bounces = self.bounces.unwrap_or(options.bounces);
        options.inter_reflections = self.inter_reflections.unwrap_or(options.inter_reflections);
        if let Some((count, radius)) = self.occlusion {
            options.occlusion = count;
            let (lo, hi) = scene::bounds(&scene.triangles).unwrap_or_default();
            options.occlusion_radius = radius.unwrap_or(0.1 * (hi - lo).length());
        }
        if !self.lights.is_empty() {
            scene.lights.clone_from(&self.lights);
        }
        match scene.lights.len() > MAX_LIGHTS {
            true => Err(Error::Invalid(format!(
                "there are {} lights, and no more than {MAX_LIGHTS} are possible",
                scene.lights.len()
            ))),
            false => Ok(()),
        }
    }

    /// The effects that kernels are built for, and the guard that stops a frame which calls for more. Effects
    /// that the list removes with a sign are not guarded: the user does not want them, and `told` gets a note of each that
    /// the scene calls for.
    ///
    /// # Errors
    ///
    /// The list names an unknown effect, or leaves out one that the scene needs everywhere.
    pub fn effects(
        &self,
        scene: &Scene,
        told: &mut dyn FnMut(&str),
    ) -> Result<(Effects, Guard), Error> {
        let findings = effect::find(scene);
        let needed: Effects = findings.iter().cloned().collect();
        let Some(list) = &self.effects else {
            return Ok((needed, Guard::default()));
        };
        let (built, whole) = needed.parse(list)?;
        let guard = match whole {
            true => Guard::of(scene, built)?,
            false => {
                let left_out = |f: &&Finding| f.on && !built.contains(f.effect);
                for finding in findings.iter().filter(left_out) {
                    told(&format!(
                        "note: `{}` is left out, which is called for by the scene: {}",
                        finding.effect.name(),
                        finding.why
                    ));
                }
                Guard::default()
            }
        };
        Ok((built, guard))
    }
}

/// A name for a scene with its camera, lights and options: another has another.
pub fn hash(scene: &Scene) -> String {
    let key = Key::of(Entry::Frames).value(scene).finish();
    key.to_string()[..16].to_owned()
}

/// Builds the tree of a scene, with a note about its cost and depth.
pub fn build(scene: &Scene, options: &bvh::Options, session: &Session<'_>) -> Bvh {
    let stage = Stage::unknown(session.watch, "building the BVH");
    let bvh = bvh::build(
        &scene.triangles,
        &bvh::Options {
            view: Some(scene.camera),
            ..*options
        },
    );
    drop(stage);
    let note = |text: &str| session.watch.tell(Event::Note(text));
    if options.builder != Builder::Best && bvh.builder != options.builder {
        note("note: the tree was too deep for the T&I unit; the sweep's is used instead");
    }
    let without = match bvh.dropped {
        0 => String::new(),
        n => format!(", {n} without area left out"),
    };
    note(&format!(
        "{} triangles{without}, BVH by {}: SAH cost {:.1}, {} levels",
        scene.triangles.len(),
        bvh.builder.name(),
        bvh.sah_cost(options.traversal_cost),
        bvh.depth()
    ));
    bvh
}

#[cfg(test)]
mod tests {
    use super::far_away;
    use srp_runtime::scene::demo::demo;
    use std::path::Path;

    #[test]
    fn scenes_far_from_the_origin_are_doubted() {
        for (far, is_doubted) in [(0.0, false), (1e3, false), (3e6, true)] {
            let mut scene = demo();
            for triangle in &mut scene.triangles {
                triangle.positions = triangle.positions.map(|mut p| {
                    p.x += far;
                    p
                });
            }
            let doubt = far_away(Path::new("a.obj"), &scene);
            assert_eq!(doubt.is_some(), is_doubted, "{far}");
        }
    }
}
