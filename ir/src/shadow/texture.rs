//! Results of the texture unit in binary64: texels weighted by the exact coordinates, without
//! rounding to the bits of the unit's weights.

use super::arithmetic::Marked;
use super::{Decision, Flip, Mark, Marks, PLAIN, Shadows};
use crate::interp::{Done, World};
use srp_archdesc::ops::Value;
use srp_archdesc::ops::semantics::texture::{CLAMP, decoded, texel_address};

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

/// A texture.
struct Texture<'a, W> {
    descriptor: Value,
    axes: [Axis; 2],
    world: &'a mut W,
}

impl<W: World> Texture<'_, W> {
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
        let usable = |c: &f64| c.abs() < LARGEST;
        let Some(descriptor) = world.texture_descriptor(address) else {
            return PLAIN;
        };
        if !real.iter().chain(&shadow).all(usable) {
            return PLAIN;
        }
        let axis = |size: u32| Axis {
            size: size.clamp(1, 1 << 16),
            clamp: descriptor.0[3] & CLAMP != 0,
        };
        let axes = [axis(descriptor.0[1]), axis(descriptor.0[2])];
        for k in 0..2 {
            let first = |c: f64| axes[k].first(c, self.weight_bits);
            if first(real[k]) != first(shadow[k]) {
                let node = uv[k].1.node_of();
                self.flips.push(Flip {
                    decision: Decision::Texel,
                    source,
                    tag: self.tape.tag([node]),
                    values: uv.map(|(value, _)| value),
                    shadows: shadow,
                    nodes: [node, 0],
                });
                break;
            }
        }
        let mut texture = Texture {
            descriptor,
            axes,
            world,
        };
        // From the shadow to the value along one axis, then along the other: between texels slopes
        // change, so these are not slopes at a point.
        let corner = texture.at([real[0], shadow[1]]);
        let (Some(value), Some(corner), Some(exact)) =
            (texture.at(real), corner, texture.at(shadow))
        else {
            return PLAIN;
        };
        let nodes = uv.map(|(_, mark)| mark.node_of());
        let errors = nodes.map(|node| self.tape.error(node));
        let slope = |from: f64, to: f64, error: f64| match error == 0.0 {
            true => 0.0,
            false => (to - from) / error,
        };
        std::array::from_fn(|i| {
            let along_u = slope(exact[i], corner[i], errors[0]);
            let along_v = slope(corner[i], value[i], errors[1]);
            let result = f32::from_bits(result.0[i]);
            let parents = [(nodes[0], along_u), (nodes[1], along_v), (0, 0.0)];
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
