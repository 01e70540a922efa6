//! Effects: capabilities that the kernels can be built with.
//!
//! An effect is a capability. Kernels that are built for more than a scene needs make the same
//! picture, bit for bit, in more cycles; kernels that are built for less cannot make it.

mod set;

pub use set::{Effects, UnknownEffect};

/// Something that kernels can be built for; `SRP_EFFECT(name)` in C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// Normals interpolated between vertices.
    Normals,
    /// Diffuse colours from pictures.
    Texture,
    /// Surfaces that send out light.
    Emission,
    /// A point light.
    Light,
    /// Several lights.
    Lights,
    /// Phong's highlights.
    Highlight,
    /// Colours of highlights from pictures.
    HighlightTexture,
    /// Shadow rays.
    Shadow,
    /// Shadow rays that go on through transparent surfaces.
    TintedShadow,
    /// Mirror rays.
    Reflection,
    /// Rays through surfaces.
    Transparency,
    /// Surfaces with holes, from pictures.
    Alpha,
    /// Rays bent at surfaces.
    Refraction,
    /// Mirrors that depend on the angle.
    Fresnel,
    /// Ambient occlusion rays.
    Occlusion,
    /// Diffuse reflection rays.
    InterReflection,
    /// Several rays a pixel.
    Antialiasing,
    /// Smaller levels of pictures.
    Levels,
}

/// A line of the table of effects.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The effect.
    pub effect: Effect,
    /// Its name on command lines and in C.
    pub name: &'static str,
    /// Effects without which it is nothing.
    pub needs: &'static [Effect],
    /// Its action, in one line.
    pub what: &'static str,
}

const fn entry(
    effect: Effect,
    name: &'static str,
    needs: &'static [Effect],
    what: &'static str,
) -> Entry {
    Entry {
        effect,
        name,
        needs,
        what,
    }
}

/// All effects, in the order of [`Effect`].
pub const TABLE: [Entry; 18] = [
    entry(
        Effect::Normals,
        "normals",
        &[],
        "normals interpolated between vertices",
    ),
    entry(
        Effect::Texture,
        "texture",
        &[],
        "diffuse colours from pictures (map_Kd)",
    ),
    entry(
        Effect::Emission,
        "emission",
        &[],
        "surfaces that send out light (Ke)",
    ),
    entry(Effect::Light, "light", &[], "a point light"),
    entry(Effect::Lights, "lights", &[Effect::Light], "several lights"),
    entry(
        Effect::Highlight,
        "highlight",
        &[Effect::Light],
        "Phong's highlights (Ks, Ns)",
    ),
    entry(
        Effect::HighlightTexture,
        "highlight_texture",
        &[Effect::Highlight],
        "highlights from pictures (map_Ks)",
    ),
    entry(Effect::Shadow, "shadow", &[Effect::Light], "shadow rays"),
    entry(
        Effect::TintedShadow,
        "tinted_shadow",
        &[Effect::Shadow],
        "light through what is transparent",
    ),
    entry(
        Effect::Reflection,
        "reflection",
        &[],
        "mirror rays (illum 3 to 7)",
    ),
    entry(
        Effect::Transparency,
        "transparency",
        &[],
        "rays through surfaces (d, Tf, illum 4, 6, 7, 9)",
    ),
    entry(
        Effect::Alpha,
        "alpha",
        &[Effect::Transparency],
        "holes from pictures (map_d)",
    ),
    entry(
        Effect::Refraction,
        "refraction",
        &[Effect::Transparency],
        "rays bent at surfaces (Ni, illum 6, 7)",
    ),
    entry(
        Effect::Fresnel,
        "fresnel",
        &[Effect::Reflection],
        "mirrors that depend on the angle (illum 5, 7)",
    ),
    entry(
        Effect::Occlusion,
        "occlusion",
        &[],
        "ambient occlusion rays",
    ),
    entry(
        Effect::InterReflection,
        "inter_reflection",
        &[],
        "diffuse reflection rays",
    ),
    entry(
        Effect::Antialiasing,
        "antialiasing",
        &[],
        "several rays a pixel",
    ),
    entry(
        Effect::Levels,
        "levels",
        &[],
        "pictures seen from far, from smaller levels",
    ),
];

impl Effect {
    /// Its line of the table.
    pub fn entry(self) -> &'static Entry {
        &TABLE[self as usize]
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.entry().name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order_and_the_c_header_has_every_name() {
        let header = crate::header("effects.h").expect("it comes along").text;
        for (i, entry) in TABLE.iter().enumerate() {
            assert_eq!(entry.effect as usize, i);
            assert_eq!(entry.effect.entry().name, entry.name);
            assert!(header.contains(&format!("#define SRP_EFFECT_{} 1", entry.name)));
        }
        assert_eq!(header.matches("#ifndef SRP_EFFECT_").count(), TABLE.len());
    }
}
