//! How far light is followed, which the command line states and no file of a scene does.

/// Most secondary rays in a row.
pub const MAX_BOUNCES: u32 = 16;

/// Most rays through a pixel, and most occlusion rays from a point.
pub const MAX_SAMPLES: u32 = 1024;

/// Most lights of a scene.
pub const MAX_LIGHTS: usize = 256;

/// How far light is followed.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Options {
    /// Most secondary rays in a row, at most [`MAX_BOUNCES`]; 0 for none.
    pub bounces: u32,
    /// Rays through each pixel, from 1 to [`MAX_SAMPLES`].
    pub samples: u32,
    /// Ambient occlusion rays from each point, at most [`MAX_SAMPLES`]; 0 for none.
    pub occlusion: u32,
    /// How far they reach: surfaces farther away do not block ambient light.
    pub occlusion_radius: f32,
    /// Diffuse reflections in a row that are followed; 0 for none.
    pub inter_reflections: u32,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            bounces: 4,
            samples: 1,
            occlusion: 0,
            occlusion_radius: 1.0,
            inter_reflections: 0,
        }
    }
}
