//! Pictures on surfaces: bilinear filtering of the level that is nearest to the level of detail.

use glam::{DVec2, DVec3};
use srp_runtime::scene::{Level, Map, Scene};

/// The pictures of a scene with their smaller levels.
pub(super) struct Pictures<'a> {
    scene: &'a Scene,
    smaller: Vec<Vec<Level>>,
}

/// log2 of a number at powers of two, and a straight line between them.
pub(super) fn octaves(x: f64) -> f64 {
    x.to_bits() as f64 / (1u64 << 52) as f64 - 1023.0
}

impl<'a> Pictures<'a> {
    pub(super) fn of(scene: &'a Scene) -> Pictures<'a> {
        Pictures {
            scene,
            smaller: scene
                .textures
                .iter()
                .map(|t| t.smaller().collect())
                .collect(),
        }
    }

    /// The texel at a coordinate: linear rgb, and alpha. `detail` is the level of detail for a picture of one
    /// texel; NaN counts as 0.
    pub(super) fn sample(&self, map: Map, uv: DVec2, detail: f64) -> (DVec3, f64) {
        let texture = &self.scene.textures[map.texture as usize];
        let smaller = &self.smaller[map.texture as usize];
        let texels = f64::from(texture.width) * f64::from(texture.height);
        let detail = detail + libm::log2(texels) / 2.0;
        // A cast rounds down, and NaN is 0.
        let level = ((detail + 0.5).max(0.0) as usize).min(smaller.len());
        match level.checked_sub(1) {
            None => {
                let size = [texture.width, texture.height];
                bilinear(size, &texture.texels, map.clamp, uv)
            }
            Some(index) => {
                let level = &smaller[index];
                bilinear([level.width, level.height], &level.texels, map.clamp, uv)
            }
        }
    }
}

/// The mean of the four texels nearest to a coordinate.
fn bilinear(size: [u32; 2], texels: &[u32], clamp: bool, uv: DVec2) -> (DVec3, f64) {
    let mut near = [[0; 2]; 2];
    let mut share = [0.0; 2];
    for axis in 0..2 {
        let n = f64::from(size[axis]);
        let c = if clamp {
            uv[axis].clamp(-1.0, 2.0)
        } else {
            uv[axis]
        };
        let position = c * n - 0.5;
        share[axis] = position - position.floor();
        for (k, texel) in near[axis].iter_mut().enumerate() {
            let i = position.floor() + k as f64;
            *texel = if clamp {
                i.clamp(0.0, n - 1.0)
            } else {
                i.rem_euclid(n)
            } as usize;
        }
    }
    let (mut colour, mut alpha) = (DVec3::ZERO, 0.0);
    for (j, &y) in near[1].iter().enumerate() {
        for (i, &x) in near[0].iter().enumerate() {
            let [r, g, b, a] = texels[y * size[0] as usize + x]
                .to_le_bytes()
                .map(|c| f64::from(c) / 255.0);
            let part = |k: usize, f: f64| if k == 1 { f } else { 1.0 - f };
            let weight = part(i, share[0]) * part(j, share[1]);
            colour += weight * DVec3::new(linear(r), linear(g), linear(b));
            alpha += weight * a;
        }
    }
    (colour, alpha)
}

fn linear(s: f64) -> f64 {
    if s <= 0.04045 {
        s / 12.92
    } else {
        libm::pow((s + 0.055) / 1.055, 2.4)
    }
}
