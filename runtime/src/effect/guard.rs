//! The guard, which stops a frame before a simulator meets something that it was not built for.

use std::fmt;

use super::{Effect, Effects, find};
use crate::scene::{Scene, Surface};
use crate::tni::HitRecord;
use crate::tni::arithmetic::ANY_HIT;

/// An effect that a scene calls for and a simulator was not built for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The effect.
    pub effect: Effect,
    /// The witness: a material and where it is defined, or a property of the scene.
    pub by: String,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "this simulator was built without the effect `{}`, which is called for by {}",
            self.effect.name(),
            self.by
        )
    }
}

impl std::error::Error for Missing {}

/// Knows for each face the effect that shading it needs and the simulator lacks, if any.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    missing: Vec<Missing>,
    /// For each triangle, by rays that are not shadow rays and by those that are: one more than the index of
    /// the missing effect, or 0.
    of_triangle: Vec<[u32; 2]>,
}

impl Guard {
    /// The guard of a simulator that is built for `built`. A missing effect that has nothing to do with a
    /// surface, such as a second light, is an error at once.
    pub fn of(scene: &Scene, built: Effects) -> Result<Guard, Missing> {
        let on_surfaces = [
            Effect::Normals,
            Effect::Texture,
            Effect::HighlightTexture,
            Effect::Alpha,
            Effect::Emission,
            Effect::Highlight,
            Effect::TintedShadow,
            Effect::Reflection,
            Effect::Transparency,
            Effect::Refraction,
            Effect::Fresnel,
        ];
        let findings = find(scene);
        let missing = |effect: Effect| !built.contains(effect);
        let absent = findings.iter().filter(|f| f.on && missing(f.effect));
        let mut absent = absent.peekable();
        if absent.peek().is_none() {
            return Ok(Guard::default());
        }
        for finding in absent {
            if !on_surfaces.contains(&finding.effect) {
                return Err(Missing {
                    effect: finding.effect,
                    by: format!("the scene: {}", finding.why),
                });
            }
        }
        let needed: Effects = findings.into_iter().collect();
        let mut guard = Guard::default();
        let materials: Vec<[u32; 2]> = (0..scene.materials.len())
            .map(|i| guard.material(scene, i, needed, built))
            .collect();
        for triangle in &scene.triangles {
            let mut of = materials[triangle.material as usize];
            if of[0] == 0 && missing(Effect::Normals) && !triangle.is_flat() {
                of[0] = guard.add(scene, triangle.material as usize, Effect::Normals, "vn");
            }
            guard.of_triangle.push(of);
        }
        Ok(guard)
    }

    fn material(&mut self, scene: &Scene, i: usize, needed: Effects, built: Effects) -> [u32; 2] {
        let material = &scene.materials[i];
        let surface = Surface::of(material);
        let emits = material.emits();
        let holes = scene.has_holes(material.dissolve_map);
        let passes = surface.transmits() || holes;
        let seen = [
            (scene.colours_diffuse(material), Effect::Texture, "map_Kd"),
            (
                scene.colours_specular(material),
                Effect::HighlightTexture,
                "map_Ks",
            ),
            (holes, Effect::Alpha, "map_d"),
            (emits, Effect::Emission, "Ke"),
            (surface.shines(), Effect::Highlight, "Ks"),
            (surface.mirrors(), Effect::Reflection, "illum"),
            (
                surface.mirrors() && surface.fresnel != crate::scene::Fresnel::None,
                Effect::Fresnel,
                "illum",
            ),
            (passes, Effect::Transparency, "Tf"),
            (passes && surface.index != 1.0, Effect::Refraction, "Ni"),
        ];
        let shaded = [(passes, Effect::TintedShadow, "Tf")];
        let mut first = |of: &[(bool, Effect, &str)]| {
            let missing = |e: Effect| needed.contains(e) && !built.contains(e);
            let found = of.iter().find(|(is, effect, _)| *is && missing(*effect));
            found.map_or(0, |&(_, effect, keyword)| {
                self.add(scene, i, effect, keyword)
            })
        };
        [first(&seen), first(&shaded)]
    }

    fn add(&mut self, scene: &Scene, material: usize, effect: Effect, keyword: &str) -> u32 {
        let material = &scene.materials[material];
        let place = match &material.origin {
            Some(origin) => format!(", {}:{}", origin.file, origin.line_of(keyword)),
            None => String::new(),
        };
        let missing = Missing {
            effect,
            by: format!("the material `{}`{place}", material.name),
        };
        let known = self.missing.iter().position(|m| *m == missing);
        let index = known.unwrap_or_else(|| {
            self.missing.push(missing);
            self.missing.len() - 1
        });
        index as u32 + 1
    }

    /// True if there is nothing to be guarded.
    pub fn is_idle(&self) -> bool {
        self.of_triangle.is_empty()
    }

    /// Finds the first of these hits that the simulator cannot shade. Returns the missing effect.
    pub fn check(&self, hits: &[HitRecord]) -> Option<&Missing> {
        hits.iter().find_map(|record| {
            let of = self.of_triangle.get(record.hit.primitive as usize)?;
            let index = of[usize::from(record.flags & ANY_HIT != 0)].checked_sub(1)?;
            self.missing.get(index as usize)
        })
    }
}
