//! Rays and triangles without rounding errors to speak of: what the unit would find in binary64.

use glam::DVec3;

use crate::reference::geometry::Geometry;
use srp_runtime::scene::Triangle;

/// A ray in binary64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ExactRay {
    /// Where it starts.
    pub(super) origin: [f64; 3],
    /// Where it goes; of any length.
    pub(super) direction: [f64; 3],
    /// Hits count from beyond this distance.
    pub(super) tmin: f64,
    /// Hits count up to this distance.
    pub(super) tmax: f64,
}

/// Where a ray meets the plane of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// Distance in lengths of the direction, and the weights of vertices 1 and 2.
    pub(super) at: [f64; 3],
    /// How each of them changes where the ray is moved sideways by so much at that distance.
    pub(super) slopes: [[f64; 3]; 3],
}

impl Meeting {
    /// How far inside of the triangle it is, as its least weight.
    pub(super) fn inside(&self) -> f64 {
        let [_, u, v] = self.at;
        u.min(v).min(1.0 - u - v)
    }
}

/// The triangles of a scene.
pub(super) struct Exact {
    corners: Vec<[DVec3; 3]>,
    geometry: Geometry,
}

impl Exact {
    /// The triangles of a scene.
    pub(super) fn of(triangles: &[Triangle]) -> Exact {
        let corners = |t: &Triangle| t.positions.map(|p| p.as_dvec3());
        Exact {
            corners: triangles.iter().map(corners).collect(),
            geometry: Geometry::of(triangles),
        }
    }

    /// The triangle that a ray hits first, and the distance.
    pub(super) fn nearest(&self, ray: &ExactRay) -> Option<(u32, f64)> {
        let tmin = ray.tmin.max(0.0);
        let (origin, direction) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
        let usable = origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO;
        if !usable || ray.tmax.is_nan() || ray.tmax < tmin {
            return None;
        }
        let start = origin + direction * tmin;
        let hit = self.geometry.nearest(start, direction, ray.tmax - tmin)?;
        Some((hit.triangle as u32, hit.t + tmin))
    }

    /// Where a ray meets the plane of a triangle; `None` where it does not, or not there alone.
    pub(super) fn meet(&self, triangle: u32, ray: &ExactRay) -> Option<Meeting> {
        let &[a, b, c] = self.corners.get(triangle as usize)?;
        let (origin, direction) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let (along, square) = (normal.dot(direction), normal.dot(normal));
        let from = origin - a;
        let t = -normal.dot(from) / along;
        let point = from + direction * t;
        let rows = [ac.cross(normal) / square, normal.cross(ab) / square];
        let [u, v] = rows.map(|row| row.dot(point));
        let of_t = -normal / along;
        let [of_u, of_v] = rows.map(|row| row + of_t * row.dot(direction));
        let meeting = Meeting {
            at: [t, u, v],
            slopes: [of_t, of_u, of_v].map(|slope| slope.to_array()),
        };
        let finite = meeting.at.iter().chain(meeting.slopes.iter().flatten());
        finite.into_iter().all(|x| x.is_finite()).then_some(meeting)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_runtime::scene::demo::demo;

    #[test]
    fn slopes_are_differences() {
        let triangles = demo().triangles;
        let exact = Exact::of(&triangles);
        let ray = ExactRay {
            origin: [0.3, 1.2, 4.0],
            direction: [-0.1, -0.3, -1.0],
            tmin: 0.0,
            tmax: 1e30,
        };
        let (triangle, t) = exact.nearest(&ray).expect("it hits the scene");
        let meeting = exact.meet(triangle, &ray).expect("it is not in the plane");
        assert!((meeting.at[0] - t).abs() < 1e-12 && meeting.inside() >= 0.0);
        for axis in 0..3 {
            let step = 1e-6;
            // Moved at its origin, and turned: the same where it meets the plane.
            let mut moved = ray;
            moved.origin[axis] += step;
            let mut turned = ray;
            turned.direction[axis] += step / t;
            for other in [moved, turned] {
                let other = exact
                    .meet(triangle, &other)
                    .expect("it is not in the plane");
                for i in 0..3 {
                    let slope = (other.at[i] - meeting.at[i]) / step;
                    let expected = meeting.slopes[i][axis];
                    assert!((slope - expected).abs() < 1e-4 * (1.0 + expected.abs()));
                }
            }
        }
    }
}
