//! Which effects a scene calls for, and how one can tell.
//!
//! Only reachable things count: materials of faces that have an area, lights that send out light. A finding names
//! the witness: for an effect that is on, the first material, its line and the number of faces; for one that is off,
//! the count that proves its absence.

use super::{Effect, Effects, TABLE};
use crate::bvh;
use crate::scene::{Fresnel, Material, Scene, Surface, Triangle};

/// An effect, if a scene calls for it, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The effect.
    pub effect: Effect,
    /// True if the scene calls for it.
    pub on: bool,
    /// The witness.
    pub why: String,
}

/// A material that faces use.
struct Used {
    index: usize,
    surface: Surface,
    faces: usize,
}

/// The facts about a scene from which findings follow.
struct View<'a> {
    scene: &'a Scene,
    used: Vec<Used>,
    lights: usize,
    /// Faces that have an area.
    faces: usize,
    curved: usize,
}

/// All effects, in the order of the table, and whether a scene calls for them.
pub fn find(scene: &Scene) -> Vec<Finding> {
    let view = View::of(scene);
    let mut set = Effects::NONE;
    let mut findings = Vec::with_capacity(TABLE.len());
    for entry in &TABLE {
        let absent = entry.needs.iter().find(|&&e| !set.contains(e));
        let (on, why) = match absent {
            Some(&e) => (
                false,
                format!("there is nothing for it without `{}`", e.name()),
            ),
            None => view.look_for(entry.effect),
        };
        if on {
            set = set.with(entry.effect);
        }
        findings.push(Finding {
            effect: entry.effect,
            on,
            why,
        });
    }
    findings
}

/// The effects that a scene calls for.
impl FromIterator<Finding> for Effects {
    fn from_iter<I: IntoIterator<Item = Finding>>(findings: I) -> Effects {
        let on = findings.into_iter().filter(|f| f.on);
        on.map(|f| f.effect).collect()
    }
}

/// Why a scene calls for nothing that secondary rays do.
const NO_RAYS: &str = "no secondary rays are asked for (--bounces 0)";

impl View<'_> {
    fn of(scene: &Scene) -> View<'_> {
        let mut faces = vec![0; scene.materials.len()];
        let can_be_hit = || scene.triangles.iter().filter(|t| bvh::has_area(t));
        for triangle in can_be_hit() {
            faces[triangle.material as usize] += 1;
        }
        let materials = scene.materials.iter().zip(faces).enumerate();
        let used = materials.filter(|(_, (_, faces))| *faces > 0);
        View {
            scene,
            used: used
                .map(|(index, (material, faces))| Used {
                    index,
                    surface: Surface::of(material),
                    faces,
                })
                .collect(),
            lights: scene.lights.iter().filter(|l| l.emits()).count(),
            faces: can_be_hit().count(),
            curved: can_be_hit().filter(|t| !t.is_flat()).count(),
        }
    }

    fn look_for(&self, effect: Effect) -> (bool, String) {
        let options = &self.scene.options;
        match effect {
            Effect::Normals => self.normals(),
            Effect::Texture => self.pictures("map_Kd", |m| self.scene.colours_diffuse(m)),
            Effect::HighlightTexture => self.pictures("map_Ks", |m| self.scene.colours_specular(m)),
            Effect::Alpha => self.pictures("map_d", |m| self.scene.has_holes(m.dissolve_map)),
            Effect::Emission => self.materials(&["Ke"], |s| s.emission.iter().any(|&c| c > 0.0)),
            Effect::Light => self.count(1),
            Effect::Lights => self.count(2),
            Effect::Highlight => self.materials(&["Ks", "illum"], Surface::shines),
            Effect::Shadow => match self.faces {
                0 => (false, "there are no faces to stand in the light".to_owned()),
                n => (true, format!("{} may stand in the light", faces(n))),
            },
            Effect::TintedShadow => self.passing(),
            // What is not there sends no light, though nothing behind it is seen.
            Effect::Transparency if options.bounces == 0 => {
                let (on, text) = self.pictures("map_d", |m| self.scene.has_holes(m.dissolve_map));
                match on {
                    true => (on, text),
                    false => (on, format!("no material has holes, and {NO_RAYS}")),
                }
            }
            Effect::Reflection | Effect::Fresnel | Effect::Refraction if options.bounces == 0 => {
                (false, NO_RAYS.to_owned())
            }
            // What bends light mirrors all of it beyond the critical angle.
            Effect::Reflection => {
                self.materials(&["illum", "Ks", "Ni"], |s| s.mirrors() || bends(s))
            }
            Effect::Transparency => self.used(&["map_d", "Tf", "d", "illum"], |u| {
                self.passes(u) || u.surface.fresnel == Fresnel::Dielectric
            }),
            Effect::Refraction => self.materials(&["Ni", "illum"], bends),
            Effect::Fresnel => {
                self.materials(&["illum"], |s| s.mirrors() && s.fresnel != Fresnel::None)
            }
            Effect::Occlusion => asked("--occlusion", options.occlusion, 1),
            Effect::InterReflection => match options.bounces {
                0 => asked("--bounces", 0, 1),
                _ => asked("--inter-reflections", options.inter_reflections, 1),
            },
            Effect::Antialiasing => asked("--samples", options.samples, 2),
            Effect::Levels => self.pictures("map_Kd", |m| self.has_levels(m)),
        }
    }

    /// True if a picture that changes a material has smaller levels.
    fn has_levels(&self, material: &Material) -> bool {
        let (scene, m) = (self.scene, material);
        let has = |map, counts| counts && scene.has_levels(map);
        let shines = Surface::of(m).shines();
        has(m.diffuse_map, scene.colours_diffuse(m))
            || has(m.specular_map, shines && scene.colours_specular(m))
            || has(m.dissolve_map, scene.has_holes(m.dissolve_map))
    }

    fn normals(&self) -> (bool, String) {
        let all = self.faces;
        let is_curved = |t: &&Triangle| bvh::has_area(t) && !t.is_flat();
        let Some(first) = self.scene.triangles.iter().find(is_curved) else {
            return (false, format!("0 of {all} faces have normals of their own"));
        };
        let material = self.name_of(first.material as usize, &[]);
        let count = self.curved;
        (
            true,
            format!("{count} of {all} faces, the first of {material}"),
        )
    }

    fn count(&self, least: usize) -> (bool, String) {
        let (emit, all) = (self.lights, self.scene.lights.len());
        let text = format!("{emit} of {all} lights send out light");
        match emit >= least || least == 1 {
            true => (emit >= least, text),
            false => (false, format!("{text}, and it is for {least} at least")),
        }
    }

    /// True if light goes through a used material, or through holes in it; with the witness.
    fn passing(&self) -> (bool, String) {
        self.used(&["map_d", "Tf", "d", "illum"], |u| self.passes(u))
    }

    fn passes(&self, used: &Used) -> bool {
        let map = self.scene.materials[used.index].dissolve_map;
        used.surface.transmits() || self.scene.has_holes(map)
    }

    /// True if a used material has a picture; with the witness.
    fn pictures(&self, keyword: &str, is: impl Fn(&Material) -> bool) -> (bool, String) {
        self.used(&[keyword], |u| is(&self.scene.materials[u.index]))
    }

    /// True if there is a used material with a surface of a kind; with the witness.
    fn materials(&self, keywords: &[&str], is: impl Fn(&Surface) -> bool) -> (bool, String) {
        self.used(keywords, |u| is(&u.surface))
    }

    /// True if there is a used material of a kind. The first such material is the witness, with the first of
    /// the keywords that it states.
    fn used(&self, keywords: &[&str], is: impl Fn(&Used) -> bool) -> (bool, String) {
        let found: Vec<&Used> = self.used.iter().filter(|u| is(u)).collect();
        let (used, all) = (self.used.len(), self.scene.materials.len());
        let Some(first) = found.first() else {
            return (false, format!("0 of {used} used materials, of {all}"));
        };
        let faces: usize = found.iter().map(|u| u.faces).sum();
        let name = self.name_of(first.index, keywords);
        let others = match found.len() {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        (true, format!("{name}{others}, {}", self::faces(faces)))
    }

    fn name_of(&self, index: usize, keywords: &[&str]) -> String {
        let material = &self.scene.materials[index];
        let mut text = format!("`{}`", material.name);
        if let Some(origin) = &material.origin {
            let stated = keywords
                .iter()
                .find(|&&k| origin.statements.contains_key(k));
            let line = stated.map_or(origin.line, |k| origin.line_of(k));
            text.push_str(&format!(" ({}:{line})", origin.file));
        }
        text
    }
}

fn faces(count: usize) -> String {
    match count {
        1 => "1 face".to_owned(),
        n => format!("{n} faces"),
    }
}

/// True if light bends at a surface, or would where it goes no further: how much of it a dielectric mirrors follows from
/// the angle behind it.
fn bends(surface: &Surface) -> bool {
    let passes = surface.transmits() || surface.fresnel == Fresnel::Dielectric;
    passes && surface.index != 1.0
}

fn asked(option: &str, value: u32, least: u32) -> (bool, String) {
    (value >= least, format!("{option} {value}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Light, Map, Material, demo::demo};
    use glam::Vec3;

    /// Something that makes a scene call for an effect, and nothing else does there.
    type Change = fn(&mut Scene);

    /// The default scene with flat, dull, opaque faces and a light.
    fn plain() -> Scene {
        let mut scene = demo();
        for triangle in &mut scene.triangles {
            triangle.normals = [triangle.geometric_normal(); 3];
            triangle.material = 0;
        }
        scene.materials = vec![Material::diffuse("plain", [0.5; 3])];
        scene
    }

    fn effects(scene: &Scene) -> String {
        find(scene).into_iter().collect::<Effects>().to_string()
    }

    #[test]
    fn a_witness_more_switches_an_effect_on_and_unused_ones_do_not() {
        assert_eq!(effects(&plain()), "light,shadow");
        let changes: [(&str, Change); 13] = [
            ("texture,light,shadow", |s| {
                s.materials[1].diffuse_map = Some(Map::default())
            }),
            ("light,shadow", |s| {
                s.materials[1].diffuse_map = Some(Map::default());
                s.textures[0].texels.fill(u32::MAX);
            }),
            ("light,shadow", |s| {
                s.materials[1].diffuse = [0.0; 3];
                s.materials[1].diffuse_map = Some(Map::default());
            }),
            ("light,shadow", |s| {
                s.materials[1].specular = [0.5; 3];
                s.materials[1].specular_map = Some(Map::default());
                s.textures[0].levels = true;
            }),
            ("light,shadow", |s| {
                s.materials[1].dissolve = 0.5;
                let last = s.triangles.last_mut().expect("it has faces");
                last.positions[2] = last.positions[0];
            }),
            ("light,shadow", |s| s.materials[1].specular = [0.5; 3]),
            ("emission,light,shadow", |s| {
                s.materials[1].emission = [1.0; 3]
            }),
            ("light,highlight,shadow", |s| {
                s.materials[1].specular = [0.5; 3];
                s.materials[1].illumination = 2;
            }),
            ("light,highlight,shadow,reflection", |s| {
                s.materials[1].specular = [0.5; 3];
                s.materials[1].illumination = 3;
            }),
            ("light,shadow,tinted_shadow,transparency", |s| {
                s.materials[1].dissolve = 0.5;
            }),
            (
                "light,shadow,tinted_shadow,reflection,transparency,refraction,fresnel",
                |s| {
                    s.materials[1].illumination = 7;
                    s.materials[1].refraction_index = 1.5;
                },
            ),
            // What it mirrors follows from how it would bend what it lets through none of.
            (
                "light,shadow,reflection,transparency,refraction,fresnel",
                |s| {
                    s.materials[1].illumination = 7;
                    s.materials[1].refraction_index = 1.5;
                    s.materials[1].filter = [0.0; 3];
                },
            ),
            ("light,shadow,tinted_shadow", |s| {
                s.materials[1].dissolve = 0.5;
                s.options.bounces = 0;
            }),
        ];
        for (expected, change) in changes {
            let mut scene = plain();
            scene.materials.push(Material::diffuse("special", [0.5; 3]));
            change(&mut scene);
            assert_eq!(effects(&scene), "light,shadow", "nobody uses it");
            let last = scene.triangles.len() - 1;
            scene.triangles[last].material = 1;
            assert_eq!(effects(&scene), expected);
        }
    }

    #[test]
    fn lights_that_are_black_and_options_that_are_off_switch_nothing_on() {
        let mut scene = plain();
        let black = Light {
            position: Vec3::ONE,
            colour: [0.0; 3],
        };
        scene.lights.push(black);
        assert_eq!(effects(&scene), "light,shadow");
        scene.lights[0].colour = [0.0; 3];
        assert_eq!(effects(&scene), "none");
        scene.lights = vec![
            Light {
                colour: [1.0; 3],
                ..black
            };
            2
        ];
        assert_eq!(effects(&scene), "light,lights,shadow");
        scene.options.samples = 2;
        scene.options.occlusion = 1;
        scene.options.inter_reflections = 1;
        let expected = "light,lights,shadow,occlusion,inter_reflection,antialiasing";
        assert_eq!(effects(&scene), expected);
        scene.triangles[0].normals[1] = Vec3::X;
        assert!(effects(&scene).starts_with("normals,"));
    }
}
