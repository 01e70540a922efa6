//! Viewpoints: a pinhole camera, its text form and its form in `cameras.json`.

use std::fmt;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::angle::turn;

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// Where it is.
    pub position: Vec3,
    /// Where it looks; of any length but 0.
    pub forward: Vec3,
    /// Up in the picture; not parallel to `forward`.
    pub up: Vec3,
    /// Field of view over the shorter axis of the picture, in degrees, above 0 and below 180.
    pub fov: f32,
}

/// The directions of a camera's rays for one picture size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayFan {
    /// Through the centre of the pixel in the upper left corner.
    pub corner: Vec3,
    /// From one pixel to the next on its right.
    pub right: Vec3,
    /// From one row to the next below.
    pub down: Vec3,
}

/// Why a camera cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CameraError(String);

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for CameraError {}

impl Camera {
    /// Reads `X,Y,Z/DX,DY,DZ/FOV`: position, direction, field of view in degrees. Up is y, or z
    /// for a camera that looks straight up or down.
    pub fn parse(text: &str) -> Result<Camera, CameraError> {
        let parts: Vec<&str> = text.split('/').collect();
        let [position, forward, fov] = parts[..] else {
            return Err(CameraError(format!(
                "camera `{text}` is not of the form X,Y,Z/DX,DY,DZ/FOV: it has {} parts instead of 3",
                parts.len()
            )));
        };
        let forward = vector(forward, "direction")?;
        let along_y = forward.x == 0.0 && forward.z == 0.0;
        Camera {
            position: vector(position, "position")?,
            forward,
            up: if along_y { Vec3::Z } else { Vec3::Y },
            fov: number(fov, "field of view")?,
        }
        .checked()
    }

    /// A camera at `position` that looks at `target`, y up.
    pub fn looking_at(position: Vec3, target: Vec3, fov: f32) -> Camera {
        Camera {
            position,
            forward: target - position,
            up: Vec3::Y,
            fov,
        }
    }

    /// The camera itself, where its numbers make one.
    pub fn checked(self) -> Result<Camera, CameraError> {
        let wrong = |what: String| Err(CameraError(format!("the camera's {what}")));
        if !self.position.is_finite() || self.position.abs().max_element() > super::MAX_COORDINATE {
            return wrong(format!("position {} is too far away", self.position));
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return wrong(format!(
                "field of view {} is not between 0 and 180 degrees",
                self.fov
            ));
        }
        let forward = self.forward.as_dvec3().normalize_or_zero();
        if !self.forward.is_finite() || forward == DVec3::ZERO {
            return wrong(format!("direction {} is none", self.forward));
        }
        let up = self.up.as_dvec3().normalize_or_zero();
        if !self.up.is_finite() || forward.cross(up).length() < 1e-6 {
            return wrong(format!(
                "up {} is along its direction {}",
                self.up, self.forward
            ));
        }
        Ok(self)
    }

    /// The directions of the rays through the pixel centres of a picture. `width` and `height`
    /// are at least 1.
    pub fn ray_fan(&self, width: u32, height: u32) -> RayFan {
        let forward = self.forward.as_dvec3().normalize();
        let right = forward.cross(self.up.as_dvec3()).normalize();
        let down = forward.cross(right);
        let (cos, sin) = turn(f64::from(self.fov) / 720.0);
        let half = sin / cos;
        let step = 2.0 * half / f64::from(width.min(height));
        let at = |pixel: f64, size: u32| (pixel + 0.5 - f64::from(size) / 2.0) * step;
        RayFan {
            corner: (forward + right * at(0.0, width) + down * at(0.0, height)).as_vec3(),
            right: (right * step).as_vec3(),
            down: (down * step).as_vec3(),
        }
    }
}

fn vector(text: &str, what: &str) -> Result<Vec3, CameraError> {
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, z] = parts[..] else {
        return Err(CameraError(format!(
            "the camera's {what} `{text}` has {} numbers instead of 3",
            parts.len()
        )));
    };
    Ok(Vec3::new(
        number(x, what)?,
        number(y, what)?,
        number(z, what)?,
    ))
}

fn number(text: &str, what: &str) -> Result<f32, CameraError> {
    match text.trim().parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(CameraError(format!(
            "`{}` in the camera's {what} is not a number",
            text.trim()
        ))),
    }
}

/// One scene of a `cameras.json`: the entry under the scene's name.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Viewpoints {
    /// Length of ambient-occlusion rays.
    pub ao_radius: Option<f32>,
    /// Up in every view.
    pub up: [f32; 3],
    /// The views.
    pub views: Vec<View>,
}

/// One view of a `cameras.json`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct View {
    /// Where the camera is.
    pub position: [f32; 3],
    /// Where it looks.
    pub forward: [f32; 3],
    /// Field of view over the shorter axis, degrees.
    pub fov_deg: f32,
}

impl Viewpoints {
    /// The camera of view `n`, from 0.
    pub fn camera(&self, n: usize) -> Result<Camera, CameraError> {
        let view = self.views.get(n).ok_or_else(|| {
            CameraError(format!(
                "there is no view {n}: the views are 0 to {}",
                self.views.len().saturating_sub(1)
            ))
        })?;
        Camera {
            position: Vec3::from(view.position),
            forward: Vec3::from(view.forward),
            up: Vec3::from(self.up),
            fov: view.fov_deg,
        }
        .checked()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_the_text_form() {
        let camera = Camera::parse("1,2,3/0,0,-1/60").expect("well formed");
        assert_eq!(camera.position, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(camera.forward, Vec3::NEG_Z);
        assert_eq!(camera.fov, 60.0);
    }

    #[test]
    fn refuses_what_is_no_camera() {
        let message = |text: &str| Camera::parse(text).expect_err(text).to_string();
        assert_eq!(
            message("1,2,3/0,0,-1"),
            "camera `1,2,3/0,0,-1` is not of the form X,Y,Z/DX,DY,DZ/FOV: it has 2 parts instead of 3"
        );
        assert_eq!(
            message("1,2/0,0,-1/60"),
            "the camera's position `1,2` has 2 numbers instead of 3"
        );
        assert_eq!(
            message("1,x,3/0,0,-1/60"),
            "`x` in the camera's position is not a number"
        );
        assert_eq!(
            message("1,2,3/0,0,0/60"),
            "the camera's direction [0, 0, 0] is none"
        );
        assert_eq!(
            message("1,2,3/0,0,1/180"),
            "the camera's field of view 180 is not between 0 and 180 degrees"
        );
        assert_eq!(
            message("1,2,3/nan,0,1/90"),
            "`nan` in the camera's direction is not a number"
        );
    }

    #[test]
    fn the_fan_spans_the_field_of_view_of_the_shorter_axis() {
        let camera = Camera::looking_at(Vec3::ZERO, Vec3::NEG_Z, 90.0);
        let fan = camera.ray_fan(4, 2);
        // The picture's edges are half a pixel outside the outermost centres.
        let top_left = fan.corner - 0.5 * (fan.right + fan.down);
        assert!((top_left - Vec3::new(-2.0, 1.0, -1.0)).length() < 1e-6);
        let bottom_right = top_left + 4.0 * fan.right + 2.0 * fan.down;
        assert!((bottom_right - Vec3::new(2.0, -1.0, -1.0)).length() < 1e-6);
    }
}
