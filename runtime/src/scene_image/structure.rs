//! The structures that `kernels/scene.h` declares: where each field lies, and writing one by field name.

use glam::Vec3;

use super::bytes::Bytes;

/// A field of a structure: name and byte offset.
type Fields = [(&'static str, u32)];

/// `srp_scene`.
pub(super) const SCENE: &Fields = &[
    ("eye", 0),
    ("corner", 16),
    ("right", 32),
    ("down", 48),
    ("background", 64),
    ("ambient", 80),
    ("light", 96),
    ("colour", 112),
    ("width", 128),
    ("height", 132),
    ("tile_width", 136),
    ("tile_height", 140),
    ("tiles_x", 144),
    ("tiles_y", 148),
    ("stride", 152),
    ("framebuffer", 156),
    ("triangles", 160),
    ("triangle_count", 164),
    ("materials", 168),
    ("material_count", 172),
    ("least_normal", 176),
    ("light_count", 180),
    ("widening", 184),
    ("far", 188),
    ("offset", 192),
    ("lights", 196),
    ("bounces", 200),
    ("samples", 204),
    ("occlusion", 208),
    ("occlusion_radius", 212),
    ("inter_reflections", 216),
    ("scale", 220),
];
pub(super) const SCENE_BYTES: u32 = 224;

/// `srp_triangle`.
pub(super) const TRIANGLE: &Fields = &[
    ("v0", 0),
    ("v1", 16),
    ("v2", 32),
    ("n0", 48),
    ("n1", 64),
    ("n2", 80),
    ("st01", 96),
    ("st2", 112),
];
pub(super) const TRIANGLE_BYTES: u32 = 128;

/// `srp_material`.
pub(super) const MATERIAL: &Fields = &[
    ("kd", 0),
    ("ks", 16),
    ("ke", 32),
    ("illum", 48),
    ("map_kd", 52),
    ("map_ks", 56),
    ("map_d", 60),
    ("mirror", 64),
    ("through", 80),
    ("padding", 96),
];
pub(super) const MATERIAL_BYTES: u32 = 128;

/// `srp_light`.
pub(super) const LIGHT: &Fields = &[("position", 0), ("colour", 16)];
pub(super) const LIGHT_BYTES: u32 = 32;

/// `srp_texture_map`.
pub(super) const TEXTURE_MAP: &Fields =
    &[("texels", 0), ("width", 4), ("height", 8), ("flags", 12)];
pub(super) const TEXTURE_MAP_BYTES: u32 = 16;

/// A structure in memory, written field by field.
pub(super) struct Structure<'a> {
    pub(super) image: &'a mut Bytes,
    pub(super) address: u64,
    pub(super) fields: &'a Fields,
}

impl Structure<'_> {
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
        let field = self.fields.iter().find(|(n, _)| *n == name);
        let (_, offset) = field.expect("only fields of the tables are written");
        self.image.put(self.address + u64::from(*offset), bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fields and size of a structure of the C header, by the rules of C: a `float4` takes and is
    /// aligned to 16 bytes, anything else to 4.
    fn of_header(name: &str) -> (Vec<(String, u32)>, u32) {
        let header = include_str!("../../../kernels/scene.h");
        let end = header
            .find(&format!("}} {name};"))
            .expect("the structure is declared");
        let start = header[..end]
            .rfind("typedef struct {")
            .expect("it is a typedef");
        let mut body = header[start + "typedef struct {".len()..end].to_owned();
        while let Some(comment) = body.find("/*") {
            let close = body[comment..].find("*/").expect("comments end") + 2;
            body.replace_range(comment..comment + close, "");
        }
        let mut fields = Vec::new();
        let mut offset = 0u32;
        for declaration in body.split(';').map(str::trim).filter(|d| !d.is_empty()) {
            let (ty, names) = declaration.split_once(' ').expect("type and names");
            let size = if ty == "float4" { 16 } else { 4 };
            for name in names.split(',').map(str::trim) {
                let (name, count) = match name.split_once('[') {
                    Some((name, count)) => {
                        (name, count.trim_end_matches(']').parse().expect("a number"))
                    }
                    None => (name, 1),
                };
                offset = offset.next_multiple_of(size);
                fields.push((name.to_owned(), offset));
                offset += size * count;
            }
        }
        (fields, offset)
    }

    #[test]
    fn the_c_header_declares_what_is_written() {
        for (name, fields, bytes) in [
            ("srp_scene", SCENE, SCENE_BYTES),
            ("srp_triangle", TRIANGLE, TRIANGLE_BYTES),
            ("srp_material", MATERIAL, MATERIAL_BYTES),
            ("srp_light", LIGHT, LIGHT_BYTES),
            ("srp_texture_map", TEXTURE_MAP, TEXTURE_MAP_BYTES),
        ] {
            let expected: Vec<_> = fields.iter().map(|(n, o)| ((*n).to_owned(), *o)).collect();
            assert_eq!(of_header(name), (expected, bytes), "{name}");
        }
        let (ray, bytes) = of_header("srp_ray");
        assert_eq!(ray.len(), 4);
        assert_eq!(bytes, crate::tni::RAY_BYTES);
        let (hit, bytes) = of_header("srp_hit");
        let names: Vec<&str> = hit.iter().map(|(n, _)| n.as_str()).collect();
        assert_eq!(names, ["t", "u", "v", "primitive", "ray", "flags"]);
        assert_eq!(bytes, crate::tni::HIT_BYTES);
    }
}
