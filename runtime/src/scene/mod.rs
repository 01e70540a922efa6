//! [`Scene`]: triangles, materials, light and camera.
//!
//! A scene comes from an OBJ file ([`read`]) or from code ([`demo`]). Nothing here opens files:
//! the caller hands in a loader.

pub mod angle;
pub mod camera;
pub mod demo;
mod light;
mod lines;
mod load;
mod map;
mod mipmap;
mod mtl;
mod obj;
mod options;
mod read;
mod surface;
mod texture;

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use serde::Serialize;

pub use camera::Camera;
pub use light::default_lights;
pub use load::{Load, Part};
pub use mipmap::Level;
pub use options::{MAX_BOUNCES, MAX_LIGHTS, MAX_SAMPLES, Options};
pub use read::{Loaded, read};
pub use surface::{Fresnel, Surface};
pub use texture::{Channel, MAX_TEXTURE_SIDE, Map, Texture};

/// Largest absolute coordinate of a vertex. Beyond it, products of coordinates could overflow
/// binary32 in the T&I unit.
pub const MAX_COORDINATE: f32 = 1e18;

/// Most triangles of a scene: as many as fit in system memory beside everything else.
pub const MAX_TRIANGLES: usize = 4 << 20;

/// Most materials of a scene, and of one library.
pub const MAX_MATERIALS: usize = 1 << 16;

/// A scene to render.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// Its name, for reports.
    pub name: String,
    /// The triangles; their index is the primitive id of a hit. All coordinates are finite and at
    /// most [`MAX_COORDINATE`]; triangles may have no area.
    pub triangles: Vec<Triangle>,
    /// The materials; never empty.
    pub materials: Vec<Material>,
    /// The pictures that materials name.
    pub textures: Vec<Texture>,
    /// Point lights, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// Light that reaches every surface, rgb.
    pub ambient: [f32; 3],
    /// Colour where a ray leaves the scene, rgb.
    pub background: [f32; 3],
    /// The viewpoint.
    pub camera: Camera,
    /// How far light is followed.
    pub options: Options,
}

impl Scene {
    /// True if a material's picture changes its colour: one of a black colour does not.
    pub fn colours_diffuse(&self, material: &Material) -> bool {
        material.diffuse != [0.0; 3] && self.colours(material.diffuse_map)
    }

    /// True if a material's picture changes its highlight.
    pub fn colours_specular(&self, material: &Material) -> bool {
        material.specular != [0.0; 3] && self.colours(material.specular_map)
    }

    /// True if a texture changes colours: a white one does not.
    fn colours(&self, map: Option<Map>) -> bool {
        map.is_some_and(|map| self.has_texel(map, |texel| texel & 0xff_ffff != 0xff_ffff))
    }

    /// True if a texture has holes.
    pub fn has_holes(&self, map: Option<Map>) -> bool {
        map.is_some_and(|map| self.has_texel(map, |texel| texel >> 24 != 255))
    }

    /// True if a texture has smaller levels.
    pub fn has_levels(&self, map: Option<Map>) -> bool {
        let texture = map.and_then(|map| self.textures.get(map.texture as usize));
        texture.is_some_and(|t| t.smaller_levels() > 0)
    }

    fn has_texel(&self, map: Map, is: impl Fn(u32) -> bool) -> bool {
        let texture = self.textures.get(map.texture as usize);
        texture.is_some_and(|t| t.texels.iter().any(|&texel| is(texel)))
    }
}

/// One triangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Triangle {
    /// Its vertices.
    pub positions: [Vec3; 3],
    /// Shading normals at the vertices: of length 1, or 0 where the triangle has no area and the
    /// file gives none.
    pub normals: [Vec3; 3],
    /// Texture coordinates at the vertices; 0 where the file gives none.
    pub uvs: [Vec2; 3],
    /// Index of its material.
    pub material: u32,
}

impl Triangle {
    /// True if its normals at the vertices are that of its plane, so that there is nothing to interpolate.
    pub fn is_flat(&self) -> bool {
        let geometric = self.geometric_normal();
        self.normals.iter().all(|&n| n == geometric)
    }

    /// The unit normal of its plane, on the side from which the vertices run counter-clockwise;
    /// 0 where it has no area. Computed in binary64, so that neither tiny nor huge ones vanish.
    pub fn geometric_normal(&self) -> Vec3 {
        let [a, b, c] = self.positions.map(|p| p.as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    }
}

/// A material as MTL means it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Diffuse colour, `Kd`.
    pub diffuse: [f32; 3],
    /// Specular colour, `Ks`.
    pub specular: [f32; 3],
    /// Emitted colour, `Ke`.
    pub emission: [f32; 3],
    /// Specular exponent, `Ns`.
    pub exponent: f32,
    /// Dissolve, `d`: 1 is opaque.
    pub dissolve: f32,
    /// Index of refraction, `Ni`.
    pub refraction_index: f32,
    /// Transmission filter, `Tf`.
    pub filter: [f32; 3],
    /// Illumination model, `illum`.
    pub illumination: u8,
    /// Factor of its diffuse colour, `map_Kd`.
    pub diffuse_map: Option<Map>,
    /// Factor of its specular colour, `map_Ks`.
    pub specular_map: Option<Map>,
    /// Factor of its dissolve, `map_d`.
    pub dissolve_map: Option<Map>,
    /// Where it is defined; nowhere, if it is made by code.
    pub origin: Option<Origin>,
}

/// Where a material is defined.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Origin {
    /// The material library.
    pub file: String,
    /// Line of its `newmtl`, from 1.
    pub line: u32,
    /// Line of each of its statements, by keyword; the last, where there are several.
    pub statements: BTreeMap<String, u32>,
}

impl Origin {
    /// The line of a statement; that of the whole material, where it has none.
    pub fn line_of(&self, keyword: &str) -> u32 {
        self.statements.get(keyword).copied().unwrap_or(self.line)
    }
}

impl Material {
    /// An opaque, diffuse material.
    pub fn diffuse(name: impl Into<String>, colour: [f32; 3]) -> Material {
        Material {
            name: name.into(),
            diffuse: colour,
            specular: [0.0; 3],
            emission: [0.0; 3],
            exponent: 1.0,
            dissolve: 1.0,
            refraction_index: 1.0,
            filter: [1.0; 3],
            illumination: 1,
            diffuse_map: None,
            specular_map: None,
            dissolve_map: None,
            origin: None,
        }
    }

    /// Its textures.
    pub fn maps(&self) -> impl Iterator<Item = Map> {
        [self.diffuse_map, self.specular_map, self.dissolve_map]
            .into_iter()
            .flatten()
    }

    /// Its textures, to be changed.
    fn maps_mut(&mut self) -> impl Iterator<Item = &mut Map> {
        let maps = [
            &mut self.diffuse_map,
            &mut self.specular_map,
            &mut self.dissolve_map,
        ];
        maps.into_iter().flatten()
    }

    /// True if it sends out light.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&c| c > 0.0)
    }
}

impl Light {
    /// True if any light comes from it.
    pub fn emits(&self) -> bool {
        self.colour.iter().any(|&c| c > 0.0)
    }
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Light {
    /// Where it is.
    pub position: Vec3,
    /// Its rgb, the same at every distance.
    pub colour: [f32; 3],
}

/// The corners of the box round all vertices, lowest first; `None` where there are none.
pub fn bounds(triangles: &[Triangle]) -> Option<(Vec3, Vec3)> {
    let mut points = triangles.iter().flat_map(|t| t.positions);
    let first = points.next()?;
    Some(points.fold((first, first), |(lo, hi), p| (lo.min(p), hi.max(p))))
}
