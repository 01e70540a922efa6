//! Results of the texture unit in binary64: texels weighted by the exact coordinates, without
//! rounding to the bits of the unit's weights.

use super::arithmetic::Marked;
use super::{Decision, Flip, Mark, Marks, PLAIN, Shadows};
use crate::interp::{Done, World};
use srp_archdesc::ops::Value;
use srp_archdesc::ops::semantics::texture::{CLAMP, at_level, decoded, levels, texel_address};

/// An axis of a texture.
#[derive(Clone, Copy)]
struct Axis {
    size: u32,
    clamp: bool,
}

/// Beyond this, a coordinate has no fraction in binary32.
const LARGEST: f64 = 8_388_608.0;

impl Axis {
    /// Where a coordinate stands among the texels.
    fn position(self, coordinate: f64) -> f64 {
        coordinate * f64::from(self.size) - 0.5
    }

    /// The texel with this number, which may be outside.
    fn texel(self, number: f64) -> u32 {
        let n = f64::from(self.size);
        let inside = match self.clamp {
            true => number.clamp(0.0, n - 1.0),
            false => number - n * (number / n).floor(),
        };
        (inside as u32).min(self.size - 1)
    }

    /// The first texel that the unit takes at a coordinate, its weights having so many bits.
    fn first(self, coordinate: f64, bits: u32) -> f64 {
        let n = f64::from(self.size);
        if bits == 0 {
            return (coordinate * n).floor();
        }
        let unit = f64::from(1u32 << bits);
        let rounded = (coordinate * n * unit + 0.5).floor();
        ((rounded - unit / 2.0) / unit).floor()
    }
}

/// The level that the unit takes at a level of detail, of a texture with so many smaller ones.
fn level(detail: f64, levels: u32) -> u32 {
    match detail > 0.0 {
        true => ((detail + 0.5).floor() as u32).min(levels),
        false => 0,
    }
}

/// A level of a texture.
struct Texture<'a, W> {
    descriptor: Value,
    axes: [Axis; 2],
    world: &'a mut W,
}

impl<'a, W: World> Texture<'a, W> {
    fn of(descriptor: Value, world: &'a mut W) -> Texture<'a, W> {
        let axis = |size: u32| Axis {
            size: size.clamp(1, 1 << 16),
            clamp: descriptor.0[3] & CLAMP != 0,
        };
        Texture {
            descriptor,
            axes: [axis(descriptor.0[1]), axis(descriptor.0[2])],
            world,
        }
    }

    /// The channels of a texel, 0 to 1.
    fn texel(&mut self, x: u32, y: u32) -> Option<[f64; 4]> {
        let texel = self.world.texel(texel_address(self.descriptor, x, y))?;
        let one = f64::from(1u32 << 24);
        Some(std::array::from_fn(|i| f64::from(decoded(texel, i)) / one))
    }

    /// The channels at a coordinate.
    fn at(&mut self, uv: [f64; 2]) -> Option<[f64; 4]> {
        let [x, y] = [0, 1].map(|k| self.axes[k].position(uv[k]));
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let [xs, ys] = [(0, x.floor()), (1, y.floor())]
            .map(|(k, first)| [0.0, 1.0].map(|step| self.axes[k].texel(first + step)));
        let mut sum = [0.0; 4];
        for (y, row) in ys.into_iter().zip([1.0 - fy, fy]) {
            for (x, share) in xs.into_iter().zip([1.0 - fx, fx]) {
                let texel = self.texel(x, y)?;
                for (sum, channel) in sum.iter_mut().zip(texel) {
                    *sum += row * share * channel;
                }
            }
        }
        Some(sum)
    }
}

impl Shadows<'_> {
    /// The marks of the texture unit's result.
    pub(super) fn sampled(
        &mut self,
        done: &Done<'_>,
        source: u32,
        marks: Marks,
        world: &mut impl World,
    ) -> Marks {
        let address = done.operands[1].as_word();
        let Some((_, result)) = done.result.filter(|_| address != 0) else {
            return PLAIN;
        };
        let uv: [Marked; 2] = [0, 1].map(|i| (f32::from_bits(done.operands[2].0[i]), marks[i]));
        let real = uv.map(|(value, _)| f64::from(value));
        let shadow = uv.map(|coordinate| self.shadow(coordinate));
        let detail: Marked = (f32::from_bits(done.operands[2].0[2]), marks[2]);
        let usable = |c: &f64| c.abs() < LARGEST;
        let Some(descriptor) = world.texture_descriptor(address) else {
            return PLAIN;
        };
        if !real.iter().chain(&shadow).all(usable) {
            return PLAIN;
        }
        let details = [f64::from(detail.0), self.shadow(detail)];
        let taken = details.map(|detail| level(detail, levels(descriptor)));
        let [descriptor, of_shadow] = taken.map(|level| at_level(descriptor, level));
        let mut texture = Texture::of(descriptor, world);
        let other = |k: usize, axes: [Axis; 2], bits: u32| {
            axes[k].first(real[k], bits) != axes[k].first(shadow[k], bits)
        };
        let moved = (0..2).find(|&k| other(k, texture.axes, self.weight_bits));
        let decided = match taken[0] != taken[1] {
            true => Some((detail.1, [detail.0, 0.0], [details[1], 0.0])),
            false => moved.map(|k| (uv[k].1, uv.map(|(value, _)| value), shadow)),
        };
        if let Some((mark, values, shadows)) = decided {
            let node = mark.node_of();
            self.flips.push(Flip {
                decision: Decision::Texel,
                source,
                tag: self.tape.tag([node]),
                values,
                shadows,
                nodes: [node, 0],
            });
        }
        // From the shadow to the value along one axis, along the other, and between levels: slopes change
        // between texels, so these are not slopes at a point.
        let value = texture.at(real);
        let corner = texture.at([real[0], shadow[1]]);
        let level = texture.at(shadow);
        let exact = Texture::of(of_shadow, texture.world).at(shadow);
        let (Some(value), Some(corner), Some(level), Some(exact)) = (value, corner, level, exact)
        else {
            return PLAIN;
        };
        let nodes = [uv[0].1, uv[1].1, detail.1].map(Mark::node_of);
        let errors = nodes.map(|node| self.tape.error(node));
        let slope = |from: f64, to: f64, error: f64| match error == 0.0 {
            true => 0.0,
            false => (to - from) / error,
        };
        std::array::from_fn(|i| {
            let slopes = [
                slope(level[i], corner[i], errors[0]),
                slope(corner[i], value[i], errors[1]),
                slope(exact[i], level[i], errors[2]),
            ];
            let result = f32::from_bits(result.0[i]);
            let parents = [0, 1, 2].map(|k| (nodes[k], slopes[k]));
            Mark::node(self.tape.push(result, exact[i], source, parents))
        })
    }

    /// A float is rounded down to a whole number, which the shadow may not be rounded to.
    pub(super) fn floored(&mut self, source: u32, value: Marked) {
        let shadow = self.shadow(value);
        if value.0.is_finite() && shadow.floor() != f64::from(value.0.floor()) {
            let node = value.1.node_of();
            self.flips.push(Flip {
                decision: Decision::Integer,
                source,
                tag: self.tape.tag([node]),
                values: [value.0, 0.0],
                shadows: [shadow, 0.0],
                nodes: [node, 0],
            });
        }
    }
}
