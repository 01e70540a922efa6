//! The effect of a material on light: its MTL illumination model, evaluated once for the kernels.

use super::Material;

/// How the share of mirrored light depends on the angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fresnel {
    /// Not at all.
    None,
    /// From the mirror colour at normal incidence to white at a grazing angle (Schlick 1994).
    Conductor,
    /// By the index of refraction, without colour; light that is not mirrored is transmitted.
    Dielectric,
}

/// A material without its illumination model.
///
/// * `illum` 0 and 1 have no highlight; 3 and above mirror, with the colour `Ks`.
/// * 4, 6, 7 and 9 are glass: light goes through, filtered by `Tf`; 6 and 7 bend it by `Ni`. Where
///   `d` is below 1, so much of it is paint on the glass.
/// * 5 mirrors like a conductor, 7 like a dielectric.
/// * 8 and 9 are 3 and 4 without rays: 8 mirrors nothing, 9 only lets light through.
/// * Anything else with `d` below 1 is a veil: the rest goes straight through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Diffuse colour.
    pub diffuse: [f32; 3],
    /// Colour of the highlight.
    pub specular: [f32; 3],
    /// Phong exponent.
    pub exponent: f32,
    /// Light it sends out.
    pub emission: [f32; 3],
    /// Colour of the mirror; 0 for none, or a conductor that is black at normal incidence.
    pub mirror: [f32; 3],
    /// How the mirror depends on the angle.
    pub fresnel: Fresnel,
    /// Colour of the light that it transmits; 0 for none.
    pub through: [f32; 3],
    /// Index of refraction; 1 where light goes straight through.
    pub index: f32,
}

impl Surface {
    /// The surface of a material.
    pub fn of(m: &Material) -> Surface {
        let times = |colour: [f32; 3], factor: f32| colour.map(|c| c * factor);
        let glass = matches!(m.illumination, 4 | 6 | 7 | 9);
        let bends = matches!(m.illumination, 6 | 7) && m.refraction_index > 0.0;
        let mirrors = matches!(m.illumination, 3..=7);
        let index = if bends { m.refraction_index } else { 1.0 };
        let fresnel = match m.illumination {
            5 => Fresnel::Conductor,
            7 if index != 1.0 => Fresnel::Dielectric,
            _ => Fresnel::None,
        };
        let mirror = match fresnel {
            Fresnel::Dielectric => [1.0; 3],
            // A dielectric like what is round it mirrors nothing at any angle.
            _ if m.illumination == 7 => [0.0; 3],
            _ if mirrors => m.specular,
            _ => [0.0; 3],
        };
        let through = match (glass, m.dissolve < 1.0) {
            (true, false) => m.filter,
            (true, true) => times(m.filter, 1.0 - m.dissolve),
            (false, _) => [1.0 - m.dissolve; 3],
        };
        let specular = match m.illumination {
            0 | 1 => [0.0; 3],
            _ if glass => m.specular,
            _ => times(m.specular, m.dissolve),
        };
        Surface {
            diffuse: times(m.diffuse, m.dissolve),
            specular,
            exponent: m.exponent.max(0.0),
            emission: m.emission,
            mirror,
            fresnel,
            through,
            index,
        }
    }

    /// True if it mirrors anything at some angle: a conductor does, whatever its colour, at a grazing one.
    pub fn mirrors(&self) -> bool {
        self.fresnel == Fresnel::Conductor || self.mirror.iter().any(|&c| c > 0.0)
    }

    /// True if it lets light through.
    pub fn transmits(&self) -> bool {
        self.through.iter().any(|&c| c > 0.0)
    }

    /// True if it has a highlight.
    pub fn shines(&self) -> bool {
        self.specular.iter().any(|&c| c > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(illumination: u8, dissolve: f32) -> Surface {
        Surface::of(&Material {
            specular: [0.5; 3],
            filter: [1.0, 0.5, 0.25],
            refraction_index: 1.5,
            illumination,
            dissolve,
            ..Material::diffuse("m", [0.8; 3])
        })
    }

    #[test]
    fn illumination_models_say_what_is_mirrored_and_what_goes_through() {
        let models: Vec<_> = (0..=10).map(|i| surface(i, 1.0)).collect();
        let which = |f: fn(&Surface) -> bool| -> Vec<usize> {
            (0..=10).filter(|&i| f(&models[i])).collect()
        };
        assert_eq!(which(Surface::shines), (2..=10).collect::<Vec<_>>());
        assert_eq!(which(Surface::mirrors), [3, 4, 5, 6, 7]);
        assert_eq!(which(Surface::transmits), [4, 6, 7, 9]);
        assert_eq!(which(|s| s.index != 1.0), [6, 7]);
        assert_eq!(which(|s| s.fresnel != Fresnel::None), [5, 7]);
    }

    #[test]
    fn a_dielectric_of_index_1_is_not_there() {
        let surface = Surface::of(&Material {
            illumination: 7,
            refraction_index: 1.0,
            ..Material::diffuse("m", [0.0; 3])
        });
        assert!(!surface.mirrors() && surface.fresnel == Fresnel::None && surface.index == 1.0);
    }

    #[test]
    fn dissolve_is_a_veil_or_paint_on_glass() {
        let veil = surface(2, 0.25);
        assert_eq!((veil.diffuse, veil.through), ([0.2; 3], [0.75; 3]));
        let glass = surface(6, 0.25);
        assert_eq!(glass.through, [0.75, 0.375, 0.1875]);
        assert_eq!(glass.specular, [0.5; 3]);
    }
}
