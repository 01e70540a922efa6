//! The cost of a tree, measured on rays.
//!
//! The surface-area heuristic weighs random lines that nothing stops. Rays start on surfaces and end at the next one, and
//! trees whose costs by the heuristic are a few percent apart are often the other way round on them (Aila, Karras and
//! Laine, "On Quality Metrics of Bounding Volume Hierarchies", 2013). So trees are compared on rays: those of a view,
//! and from where they end, or else from all over the surfaces.

use glam::DVec3;
use obvhs::bvh2::Bvh2;

use crate::scene::Triangle;
use crate::scene::camera::Camera;

/// Width and height of the view: so many rays that the standard error of a mean is about 1 %, and that of a difference
/// between two trees, which the same rays visit, much less.
const VIEW: (u32, u32) = (64, 48);

struct Ray {
    /// The triangle on which it starts.
    on: Option<u32>,
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
}

/// Rays among the triangles of a scene, which must have an area; the same every time.
pub(super) struct Rays(Vec<Ray>);

/// A generator of numbers from 0 to 1 (PCG, O'Neill 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        let state = self.0;
        self.0 = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let shifted = (((state >> 18) ^ state) >> 27) as u32;
        f64::from(shifted.rotate_right((state >> 59) as u32)) / f64::from(u32::MAX)
    }

    /// A direction on the sphere.
    fn direction(&mut self) -> DVec3 {
        loop {
            let [x, y, z] = [(); 3].map(|()| 2.0 * self.next() - 1.0);
            let length = x * x + y * y + z * z;
            if (1e-4..=1.0).contains(&length) {
                return DVec3::new(x, y, z) / length.sqrt();
            }
        }
    }
}

impl Rays {
    /// Rays of a view, and of each that meets a surface one from there in any direction. `tree` is any tree of the
    /// triangles.
    pub(super) fn of_view(view: &Camera, tree: &Bvh2, triangles: &[&Triangle]) -> Rays {
        let (across, down) = VIEW;
        let fan = view.ray_fan(across, down);
        let mut numbers = Numbers(1);
        let mut rays = Vec::new();
        let mut open = Vec::new();
        for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x as f32, y as f32))) {
            let direction = (fan.corner + fan.right * x + fan.down * y)
                .as_dvec3()
                .normalize();
            let ray = Ray::new(view.position.as_dvec3(), direction, None);
            let (distance, on, _) = ray.trace(tree, triangles, &mut open);
            let point = ray.origin + ray.direction * distance;
            rays.push(ray);
            if on.is_some() {
                rays.push(Ray::new(point, numbers.direction(), on));
            }
        }
        Rays(rays)
    }

    /// Rays from surfaces in any direction, dealt in proportion to area.
    pub(super) fn of_surfaces(triangles: &[&Triangle]) -> Rays {
        let mut numbers = Numbers(1);
        let mut areas = Vec::with_capacity(triangles.len());
        let mut sum = 0.0;
        for triangle in triangles {
            let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
            sum += (b - a).cross(c - a).length();
            areas.push(sum);
        }
        let mut ray = |_| {
            let at = numbers.next() * sum;
            let on = areas
                .partition_point(|&area| area < at)
                .min(areas.len() - 1);
            let [a, b, c] = triangles[on].positions.map(|p| p.as_dvec3());
            let (mut u, mut v) = (numbers.next(), numbers.next());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let point = a + (b - a) * u + (c - a) * v;
            Ray::new(point, numbers.direction(), Some(on as u32))
        };
        Rays((0..2 * VIEW.0 * VIEW.1).map(&mut ray).collect())
    }

    /// The mean cost of a ray: its visits of inner nodes, each of `visit`, and its triangle tests, each of 1.
    pub(super) fn cost(&self, tree: &Bvh2, triangles: &[&Triangle], visit: f32) -> f64 {
        let mut open = Vec::new();
        let work = self
            .0
            .iter()
            .map(|ray| ray.trace(tree, triangles, &mut open).2);
        let (visits, tests) = work.fold((0, 0), |sum, of_ray| (sum.0 + of_ray.0, sum.1 + of_ray.1));
        (f64::from(visit) * visits as f64 + tests as f64) / self.0.len().max(1) as f64
    }
}

impl Ray {
    fn new(origin: DVec3, direction: DVec3, on: Option<u32>) -> Ray {
        Ray {
            on,
            origin,
            direction,
            inverse: direction.recip(),
        }
    }

    /// Traces the ray, the nearer child first. Returns the distance and the triangle of its nearest hit, and how many
    /// inner nodes it visits and triangles it is tested against. `open` is empty before and after.
    fn trace(
        &self,
        tree: &Bvh2,
        triangles: &[&Triangle],
        open: &mut Vec<(f64, u32)>,
    ) -> (f64, Option<u32>, (u64, u64)) {
        let (mut visits, mut tests) = (0, 0);
        let (mut nearest, mut hit) = (f64::INFINITY, None);
        open.push((0.0, 0));
        while let Some((entry, index)) = open.pop() {
            if entry > nearest {
                continue;
            }
            let node = &tree.nodes[index as usize];
            if node.is_leaf() {
                let first = node.first_index as usize;
                let of_leaf = &tree.primitive_indices[first..first + node.prim_count as usize];
                tests += of_leaf.len() as u64;
                for &triangle in of_leaf
                    .iter()
                    .filter(|&&triangle| Some(triangle) != self.on)
                {
                    let distance = self.hit(triangles[triangle as usize]);
                    if distance < nearest {
                        (nearest, hit) = (distance, Some(triangle));
                    }
                }
                continue;
            }
            visits += 1;
            let mut children =
                [node.first_index, node.first_index + 1].map(|i| (self.entry(tree, i), i));
            if children[0].0 < children[1].0 {
                children.reverse();
            }
            open.extend(children.into_iter().filter(|(entry, _)| *entry < nearest));
        }
        (nearest, hit, (visits, tests))
    }

    /// The distance at which the ray enters the box of a node; infinite where it misses it.
    fn entry(&self, tree: &Bvh2, node: u32) -> f64 {
        let bounds = tree.nodes[node as usize].aabb();
        let one = (bounds.min.as_dvec3() - self.origin) * self.inverse;
        let other = (bounds.max.as_dvec3() - self.origin) * self.inverse;
        let entry = one.min(other).max_element().max(0.0);
        match one.max(other).min_element() >= entry {
            true => entry,
            false => f64::INFINITY,
        }
    }

    /// The distance of a triangle along the ray; infinite where it misses it (Möller and Trumbore 1997).
    fn hit(&self, triangle: &Triangle) -> f64 {
        let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
        let (b, c) = (b - a, c - a);
        let p = self.direction.cross(c);
        let scale = b.dot(p).recip();
        let to = self.origin - a;
        let u = to.dot(p) * scale;
        let q = to.cross(b);
        let v = self.direction.dot(q) * scale;
        let t = c.dot(q) * scale;
        match u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 {
            true => t,
            false => f64::INFINITY,
        }
    }
}
