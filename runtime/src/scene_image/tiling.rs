//! How a frame is divided into tiles.

/// Width and height of a tile for packets of `rays` rays: about a square, as many pixels as a packet
/// has rays or less. The width is a power of two, for the kernels divide by it.
pub fn tile_size(rays: u32) -> (u32, u32) {
    let rays = rays.max(1);
    let width = 1 << (rays.ilog2() / 2);
    (width, rays / width)
}

/// How a frame is divided into tiles.
pub(super) struct Tiling {
    pub(super) frame: (u32, u32),
    pub(super) tile: (u32, u32),
    pub(super) across: u32,
    pub(super) down: u32,
}

impl Tiling {
    pub(super) fn of(frame: (u32, u32), rays: u32) -> Tiling {
        let tile = tile_size(rays);
        Tiling {
            frame,
            tile,
            across: frame.0.div_ceil(tile.0),
            down: frame.1.div_ceil(tile.1),
        }
    }

    pub(super) fn stride(&self) -> u32 {
        self.across * self.tile.0
    }

    pub(super) fn rows(&self) -> u32 {
        self.down * self.tile.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_hold_a_tile() {
        for rays in 1..200 {
            let (width, height) = tile_size(rays);
            assert!(width.is_power_of_two() && width <= height);
            assert!((0..width).contains(&(rays - width * height)), "{rays}");
        }
        assert_eq!(tile_size(63), (4, 15));
        assert_eq!(tile_size(64), (8, 8));
        assert_eq!(tile_size(128), (8, 16));
    }
}
