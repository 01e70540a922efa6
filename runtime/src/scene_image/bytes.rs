//! Values as the bytes that are written to system memory.

use std::collections::BTreeMap;

use glam::Vec3;
use srp_archdesc::ops::semantics::texture::{CLAMP, LEVELS_SHIFT};
use srp_kernels::layout::{LIGHT, MATERIAL, SCENE, TEXTURE_MAP, TRIANGLE};

use super::parts::Parts;
use super::structure::{Bytes, Writer};
use super::tiling::Tiling;
use super::{FAR, OFFSET, detail, lights};
use crate::scene::{Camera, Fresnel, Light, Map, Material, Scene, Surface, Triangle};

impl Bytes {
    pub(super) fn header(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        parts: &Parts,
        tiling: &Tiling,
        (widening, least_normal): (f32, f32),
    ) {
        let fan = camera.ray_fan(tiling.frame.0, tiling.frame.1);
        let mut at = Writer {
            image: self,
            address: parts.header,
            structure: &SCENE,
        };
        let spread = detail::spread(fan.right, scene.options.samples);
        at.vector("eye", camera.position, spread.to_bits());
        at.vector("corner", fan.corner, 0);
        at.vector("right", fan.right, 0);
        at.vector("down", fan.down, 0);
        at.vector("background", Vec3::from(scene.background), 0);
        at.vector("ambient", Vec3::from(scene.ambient), 0);
        let light = lights(scene).next();
        let (position, colour) = light.map_or((Vec3::ZERO, [0.0; 3]), |l| (l.position, l.colour));
        at.vector("light", position, 1.0f32.to_bits());
        at.vector("colour", Vec3::from(colour), 0);
        for (name, word) in [
            ("width", tiling.frame.0),
            ("height", tiling.frame.1),
            ("tile_width", tiling.tile.0),
            ("tile_height", tiling.tile.1),
            ("tiles_x", tiling.across),
            ("tiles_y", tiling.down),
            ("stride", tiling.stride()),
            ("framebuffer", parts.framebuffer as u32),
            ("triangles", parts.triangles as u32),
            ("triangle_count", scene.triangles.len() as u32),
            ("materials", parts.materials as u32),
            ("material_count", scene.materials.len() as u32),
            ("light_count", lights(scene).count() as u32),
            ("lights", parts.lights as u32),
            ("bounces", scene.options.bounces),
            ("samples", scene.options.samples),
            ("occlusion", scene.options.occlusion),
            ("occlusion_radius", scene.options.occlusion_radius.to_bits()),
            ("inter_reflections", scene.options.inter_reflections),
            ("scale", scale(scene).to_bits()),
            ("widening", widening.to_bits()),
            ("least_normal", least_normal.to_bits()),
            ("far", FAR.to_bits()),
            ("offset", OFFSET.to_bits()),
        ] {
            at.word(name, word);
        }
    }

    pub(super) fn material(
        &mut self,
        address: u64,
        (scene, m): (&Scene, &Material),
        maps: &BTreeMap<Map, u64>,
    ) {
        let mut at = Writer {
            image: self,
            address,
            structure: &MATERIAL,
        };
        let surface = Surface::of(m);
        let fresnel: f32 = match surface.fresnel {
            Fresnel::None => 0.0,
            Fresnel::Conductor => 1.0,
            Fresnel::Dielectric => 2.0,
        };
        let exponent = surface.exponent.to_bits();
        let descriptor = |map: Option<Map>| map.map_or(0, |map| maps[&map] as u32);
        let map_kd = descriptor(m.diffuse_map);
        at.vector("kd", Vec3::from(surface.diffuse), map_kd);
        at.vector("ks", Vec3::from(surface.specular), exponent);
        let goes_on = surface.mirrors() || surface.transmits() || m.dissolve_map.is_some();
        let goes_on = f32::from(u8::from(goes_on));
        at.vector("ke", Vec3::from(surface.emission), goes_on.to_bits());
        at.vector("mirror", Vec3::from(surface.mirror), fresnel.to_bits());
        let index = surface.index.to_bits();
        at.vector("through", Vec3::from(surface.through), index);
        at.word("illum", u32::from(m.illumination));
        at.word("map_kd", map_kd);
        at.word("map_ks", descriptor(m.specular_map));
        at.word("map_d", descriptor(m.dissolve_map));
        let level = |map| detail::more_than_first(scene, m, map).to_bits();
        at.word("ks_level", level(m.specular_map));
        at.word("d_level", level(m.dissolve_map));
    }

    pub(super) fn texture_map(&mut self, address: u64, map: Map, scene: &Scene, parts: &Parts) {
        let texture = &scene.textures[map.texture as usize];
        let mut at = Writer {
            image: self,
            address,
            structure: &TEXTURE_MAP,
        };
        at.word("texels", parts.texels[map.texture as usize] as u32);
        at.word("width", texture.width);
        at.word("height", texture.height);
        let clamp = if map.clamp { CLAMP } else { 0 };
        at.word("flags", clamp | texture.smaller_levels() << LEVELS_SHIFT);
    }

    pub(super) fn light(&mut self, address: u64, light: &Light) {
        let mut at = Writer {
            image: self,
            address,
            structure: &LIGHT,
        };
        at.vector("position", light.position, 1.0f32.to_bits());
        at.vector("colour", Vec3::from(light.colour), 0);
    }

    pub(super) fn triangle(&mut self, address: u64, scene: &Scene, t: &Triangle) {
        let mut at = Writer {
            image: self,
            address,
            structure: &TRIANGLE,
        };
        let normal = t.geometric_normal();
        at.vector("n0", t.normals[0], t.material);
        at.vector("n1", t.normals[1], u32::from(t.is_flat()));
        at.vector("n2", t.normals[2], 0);
        at.vector("v0", t.positions[0], normal.x.to_bits());
        at.vector("v1", t.positions[1], normal.y.to_bits());
        at.vector("v2", t.positions[2], normal.z.to_bits());
        let [st0, st1, st2] = t.uvs;
        at.vector("st01", st0.extend(st1.x), st1.y.to_bits());
        at.vector("st2", st2.extend(detail::of_triangle(scene, t)), 0);
    }
}

/// The power of two that brings the extent of a scene and its lights to 1 or a little more.
fn scale(scene: &Scene) -> f32 {
    let corners = crate::scene::bounds(&scene.triangles).unwrap_or_default();
    let start = [corners.0, corners.1];
    let lights = lights(scene).map(|l| l.position);
    let (lo, hi) = lights.fold((start[0], start[1]), |(lo, hi), p| (lo.min(p), hi.max(p)));
    let size = (hi.as_dvec3() - lo.as_dvec3()).max_element();
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    f32::from_bits(((127 - exponent.clamp(-100, 100)) as u32) << 23)
}
