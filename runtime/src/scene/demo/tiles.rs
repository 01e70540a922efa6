//! The picture on the floor of the default scene: polished stone in two colours.

use crate::scene::Texture;

/// Texels of a side: two tiles. All of it is in the texture cache of most machines, and the camera is so near
/// that no smaller level is called for.
const SIDE: u32 = 64;

/// sRGB of the stones.
const STONES: [[f32; 3]; 2] = [[236.0, 231.0, 219.0], [120.0, 127.0, 140.0]];

/// sRGB of the joints.
const JOINT: [f32; 3] = [92.0, 88.0, 82.0];

/// Two by two tiles of stone, clouded and veined, that fit beside themselves.
pub(super) fn tiles() -> Texture {
    let texels = (0..SIDE * SIDE).map(|i| texel(i % SIDE, i / SIDE));
    Texture {
        name: "tiles".to_owned(),
        width: SIDE,
        height: SIDE,
        texels: texels.collect(),
        levels: false,
    }
}

fn texel(x: u32, y: u32) -> u32 {
    let half = SIDE / 2;
    let (column, row) = (x / half, y / half);
    let inside = |c: u32| (c % half).min(half - 1 - c % half);
    let from_edge = inside(x).min(inside(y));
    // Each tile is cut from another part of the stone.
    let (u, v) = (x + 19 * column, y + 29 * row);
    let clouds = [(16, 0.5), (8, 0.25), (4, 0.15), (2, 0.1)];
    let cloud: f32 = (clouds.iter())
        .map(|&(cell, share)| share * noise(u, v, cell))
        .sum();
    let vein = (1.0 - 14.0 * (cloud - 0.52).abs()).max(0.0);
    let stone = STONES[((column + row) % 2) as usize];
    let shade = 0.82 + 0.3 * cloud;
    let colour = |i: usize| {
        let polished = (stone[i] * shade + 26.0 * vein).min(255.0);
        match from_edge {
            0 => 0.5 * (JOINT[i] + polished),
            _ => polished,
        }
    };
    let [r, g, b] = [0, 1, 2].map(|i| (colour(i) + 0.5) as u8);
    u32::from_le_bytes([r, g, b, 255])
}

/// Values from 0 to 1 at the corners of cells, interpolated between them; they repeat with the picture.
fn noise(x: u32, y: u32, cell: u32) -> f32 {
    let count = SIDE / cell;
    let corner = |dx: u32, dy: u32| {
        let (x, y) = ((x / cell + dx) % count, (y / cell + dy) % count);
        let mut bits = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b) ^ cell;
        bits = (bits ^ bits >> 16).wrapping_mul(0x7feb_352d);
        bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
        (bits >> 8) as f32 / (1u32 << 24) as f32
    };
    let smooth = |c: u32| {
        let t = (c % cell) as f32 / cell as f32;
        t * t * (3.0 - 2.0 * t)
    };
    let (s, t) = (smooth(x), smooth(y));
    let between = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let low = between(corner(0, 0), corner(1, 0), s);
    let high = between(corner(0, 1), corner(1, 1), s);
    between(low, high, t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_has_two_stones_and_joints_between_them() {
        let picture = tiles();
        assert_eq!(picture.texels.len(), (SIDE * SIDE) as usize);
        let red = |x: u32, y: u32| picture.texel(x, y) & 255;
        let (near, far) = (SIDE / 4, 3 * SIDE / 4);
        assert!(red(near, near) > red(far, near) + 40 && red(far, far) > red(near, far) + 40);
        assert!(red(0, near) < red(near, near) - 40);
    }
}
