//! Writing the structures that `kernels/scene.h` declares, by field name.

use glam::Vec3;
use srp_kernels::layout::Structure;

use crate::memory::BASE;

/// Memory in the making; addresses are those of the finished memory.
pub(super) struct Bytes(pub(super) Vec<u8>);

impl Bytes {
    pub(super) fn put(&mut self, address: u64, bytes: &[u8]) {
        let start = (address - u64::from(BASE)) as usize;
        self.0[start..start + bytes.len()].copy_from_slice(bytes);
    }
}

/// A structure in memory, written field by field.
pub(super) struct Writer<'a> {
    pub(super) image: &'a mut Bytes,
    pub(super) address: u64,
    pub(super) structure: &'a Structure,
}

impl Writer<'_> {
    pub(super) fn word(&mut self, name: &str, word: u32) {
        self.put(name, &word.to_le_bytes());
    }

    /// A `float4`, its last lane as bits.
    pub(super) fn vector(&mut self, name: &str, v: Vec3, lane_3: u32) {
        let mut bytes = [0; 16];
        let words = v.to_array().map(f32::to_bits).into_iter().chain([lane_3]);
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        self.put(name, &bytes);
    }

    fn put(&mut self, name: &str, bytes: &[u8]) {
        let offset = self.structure.offset(name);
        self.image.put(self.address + u64::from(offset), bytes);
    }
}

#[cfg(test)]
mod tests {
    use srp_kernels::layout::{HIT, RAY};

    #[test]
    fn the_unit_takes_and_gives_what_the_header_declares() {
        assert_eq!((RAY.bytes, RAY.fields.len()), (crate::tni::RAY_BYTES, 4));
        let names: Vec<&str> = HIT.fields.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["t", "u", "v", "primitive", "ray", "flags"]);
        assert_eq!(HIT.bytes, crate::tni::HIT_BYTES);
    }
}
