//! Rays that slip between triangles: how many each test loses, and that two of them lose none.
//!
//! Rays are aimed at shared edges and vertices, and graze surfaces. A ray counts as lost where the
//! unit says that it hits nothing, and exact arithmetic that it meets a triangle. From inside a
//! closed mesh there is always one. From outside, outlines may be met by nothing but the ray itself;
//! a test that moves the ray by a rounding, as Woop's does, is right to miss them, and only the test
//! with an epsilon finds them all. `SRP_AIMED_RAYS` says how many rays are shot with each test.

#[path = "../../runtime/tests/support/mod.rs"]
mod support;

use glam::Vec3;
use srp_archdesc::arch::Approx;
use srp_archdesc::datapath::Intersection;
use srp_archdesc::system::TniSpec;
use srp_runtime::bvh::Builder;
use srp_runtime::memory::SystemMemory;
use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::Ray;
use srp_runtime::tni::place_for;
use srp_runtime::tni::{Tracer, Tree};
use srp_studies::exact;
use support::{Random, image_for, machine, triangle};

/// How a ray is aimed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Aim {
    Edge,
    Vertex,
    Grazing,
}

const AIMS: [Aim; 3] = [Aim::Edge, Aim::Vertex, Aim::Grazing];

/// Where rays come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum From {
    Inside,
    Outside,
}

/// Triangles, and for each corner the triangles that share its vertex.
struct Mesh {
    name: &'static str,
    triangles: Vec<Triangle>,
    sharing: Vec<[Vec<u32>; 3]>,
    centre: Vec3,
    /// About its radius.
    size: f32,
}

impl Mesh {
    fn new(name: &'static str, triangles: Vec<Triangle>, centre: Vec3, size: f32) -> Mesh {
        let mut at: std::collections::BTreeMap<[u32; 3], Vec<u32>> = Default::default();
        let key = |p: Vec3| p.to_array().map(f32::to_bits);
        for (i, t) in (0..).zip(&triangles) {
            for p in t.positions {
                at.entry(key(p)).or_default().push(i);
            }
        }
        let sharing = triangles
            .iter()
            .map(|t| t.positions.map(|p| at[&key(p)].clone()));
        Mesh {
            name,
            sharing: sharing.collect(),
            triangles,
            centre,
            size,
        }
    }

    /// A ray, and the triangles round what it is aimed at.
    fn aim(&self, how: Aim, from: From, random: &mut Random) -> (Ray, Vec<u32>) {
        let i = random.below(self.triangles.len());
        let corner = random.below(3);
        let [a, b, c] = [0, 1, 2].map(|k| self.triangles[i].positions[(corner + k) % 3]);
        let [at_a, at_b] = [0, 1].map(|k| &self.sharing[i][(corner + k) % 3]);
        let (to, round) = match how {
            Aim::Vertex => (a, at_a.clone()),
            _ => {
                let both = at_a.iter().filter(|t| at_b.contains(t));
                (a.lerp(b, random.unit()), both.copied().collect())
            }
        };
        let slope: f32 = [1e-1, 1e-2, 1e-3, 1e-4][random.below(4)];
        // Far away, no point is nearer to the surface than a rounding and still inside.
        let least = 8.0 * f32::EPSILON * self.centre.abs().max_element() / self.size;
        let from = match (how, from) {
            // Just below the surface, and along it.
            (Aim::Grazing, From::Inside) => ((a + b + c) / 3.0).lerp(self.centre, slope.max(least)),
            (Aim::Grazing, From::Outside) => {
                let along = (b - a).lerp(c - a, random.unit()).normalize_or_zero();
                let up = (b - a).cross(c - a).normalize_or_zero();
                to + 2.0 * self.size * (along + slope * up)
            }
            (_, From::Inside) => self.centre + 0.5 * self.size * random.direction(),
            (_, From::Outside) => to + 2.0 * self.size * (0.2 + random.unit()) * random.direction(),
        };
        let ray = Ray::new(from.to_array(), (to - from).to_array(), 0.0, f32::MAX, 0);
        (ray, round)
    }

    /// True if the ray meets any triangle in exact arithmetic; those round its aim come first.
    fn meets(&self, ray: &Ray, round: &[u32]) -> bool {
        let met = |t: &u32| exact::meets(ray, &self.triangles[*t as usize]);
        let mut may_be_met = self.triangles.iter().filter(|t| !surely_passes(ray, t));
        round.iter().any(met) || may_be_met.any(|t| exact::meets(ray, t))
    }
}

/// True if binary64 is enough to say that a ray's line passes a triangle: it has one edge on its left and one
/// on its right, by more than the rounding of these products can be.
fn surely_passes(ray: &Ray, triangle: &Triangle) -> bool {
    let origin = Vec3::from(ray.origin).as_dvec3();
    let direction = Vec3::from(ray.direction).as_dvec3();
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3() - origin);
    let (mut left, mut right) = (false, false);
    for (p, q) in [(c, b), (a, c), (b, a)] {
        let product = direction.dot(p.cross(q));
        let rounding = 64.0 * f64::EPSILON * direction.length() * p.length() * q.length();
        left |= product > rounding;
        right |= product < -rounding;
    }
    left && right
}

/// A sphere of `columns` by `rows` quadrilaterals.
fn sphere(columns: usize, rows: usize, radius: f32, centre: Vec3) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let up = std::f32::consts::PI * j as f32 / rows as f32;
        let round = std::f32::consts::TAU * (i % columns) as f32 / columns as f32;
        let flat = if j == 0 || j == rows { 0.0 } else { up.sin() };
        centre + radius * Vec3::new(flat * round.cos(), up.cos(), flat * round.sin())
    };
    let mut triangles = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [point(i, j), point(i, j + 1)];
            let [c, d] = [point(i + 1, j + 1), point(i + 1, j)];
            if j + 1 < rows {
                triangles.push(triangle([a, b, c]));
            }
            if j > 0 {
                triangles.push(triangle([a, c, d]));
            }
        }
    }
    triangles
}

/// A bumpy ground whose quadrilaterals are `width` wide and `height` high.
fn ground(columns: usize, rows: usize, (width, height): (f32, f32), at: Vec3) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let bump = ((i * 7 + j * 13) % 5) as f32 * 0.11 * width.min(height);
        at + Vec3::new(i as f32 * width, bump, j as f32 * height)
    };
    let mut triangles = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [point(i, j), point(i, j + 1)];
            let [c, d] = [point(i + 1, j + 1), point(i + 1, j)];
            triangles.extend([triangle([a, b, c]), triangle([a, c, d])]);
        }
    }
    triangles
}

const FAR: Vec3 = Vec3::new(1e4, -3e3, 7e3);

/// Closed and convex.
fn closed() -> Vec<Mesh> {
    let mesh = |name, (columns, rows), radius, centre| {
        Mesh::new(name, sphere(columns, rows, radius, centre), centre, radius)
    };
    vec![
        mesh("sphere", (24, 16), 1.0, Vec3::ZERO),
        mesh("needles", (300, 5), 1.0, Vec3::ZERO),
        mesh("slivers", (5, 900), 1.0, 0.5 * Vec3::ONE),
        mesh("far sphere", (24, 16), 1.0, FAR),
        mesh("large, far sphere", (64, 8), 1e3, 100.0 * FAR),
        mesh("small, far needles", (60, 4), 0.1, 0.1 * FAR),
    ]
}

/// Open grounds too, to be seen from outside.
fn all() -> Vec<Mesh> {
    let ground = |name, rows, height, at| {
        let triangles = ground(12, rows, (1.0, height), at);
        Mesh::new(name, triangles, at, 2.0)
    };
    let mut meshes = closed();
    meshes.push(ground("thin ground", 300, 1e-3, Vec3::ONE));
    meshes.push(ground("far ground", 20, 1.0, 0.1 * FAR));
    meshes
}

fn unit(intersection: Intersection, rcp: Approx) -> TniSpec {
    TniSpec {
        intersection,
        rcp,
        ..machine().tni
    }
}

/// Triangles in the memory of a machine with a unit.
fn placed(spec: &TniSpec, triangles: &[Triangle]) -> (SystemMemory, Tree) {
    let system = srp_archdesc::SystemSpec {
        tni: *spec,
        ..machine()
    };
    place_for(&system, &image_for(spec, triangles, Builder::Sweep))
}

fn count() -> usize {
    let all = std::env::var("SRP_AIMED_RAYS");
    all.map_or(100_000, |n| n.parse().expect("SRP_AIMED_RAYS is a number"))
}

/// Rays lost of those aimed in each way, and how many these were.
fn losses(spec: &TniSpec, from: From, seed: u64) -> ([usize; 3], usize) {
    let meshes = match from {
        From::Inside => closed(),
        From::Outside => all(),
    };
    let shots = count().div_ceil(AIMS.len() * meshes.len());
    let mut lost = [0; 3];
    for mesh in &meshes {
        let (memory, tree) = placed(spec, &mesh.triangles);
        let mut tracer = Tracer::new(spec, &tree, &memory);
        for (lost, aim) in lost.iter_mut().zip(AIMS) {
            let mut random = Random::new(seed);
            let mut here = 0;
            for _ in 0..shots {
                let (ray, round) = mesh.aim(aim, from, &mut random);
                let missed = !tracer.trace(&ray).hit.is_hit();
                here += usize::from(missed && mesh.meets(&ray, &round));
            }
            let (test, name) = (spec.intersection.name(), mesh.name);
            println!("{test}, {aim:?}, {name}: {here} of {shots}");
            *lost += here;
        }
    }
    (lost, shots * meshes.len())
}

#[test]
fn two_tests_lose_no_ray() {
    let scaled = unit(Intersection::AnchorWaldScaled, Approx::Exact);
    for from in [From::Inside, From::Outside] {
        let (lost, of) = losses(&scaled, from, 11);
        assert_eq!(lost, [0; 3], "of {of} each from {from:?}");
    }
    // Coarse reciprocals have an epsilon of their own.
    for (bits, from) in [(8, From::Inside), (12, From::Outside), (16, From::Inside)] {
        let coarse = unit(Intersection::AnchorWaldScaled, Approx::table(bits, 0));
        let (lost, _) = losses(&coarse, from, 15);
        assert_eq!(lost, [0; 3], "with a reciprocal of {bits} bits");
    }
    let woop = unit(Intersection::Woop, Approx::Exact);
    let (lost, of) = losses(&woop, From::Inside, 12);
    assert_eq!(lost, [0; 3], "of {of} each");
    // A quotient is the same for all weights of a triangle: one that is coarse moves the hit along
    // the ray, no more.
    let coarse = unit(Intersection::Woop, Approx::table(12, 0));
    let (lost, _) = losses(&coarse, From::Inside, 13);
    assert_eq!(lost, [0; 3], "with a reciprocal of 12 bits");
}

#[test]
fn the_papers_test_loses_a_tenth_of_aimed_rays_and_an_anchor_most_of_those_at_vertices() {
    let rates = |test| {
        let (lost, of) = losses(&unit(test, Approx::Exact), From::Inside, 14);
        lost.map(|n| 100.0 * n as f64 / of as f64)
    };
    let wald = rates(Intersection::Wald);
    let anchor = rates(Intersection::AnchorWald);
    println!("lost by wald {wald:.2?} %, by anchor-wald {anchor:.2?} %");
    assert!((3.0..16.0).contains(&wald[0]), "edges: {wald:?}");
    assert!((1.5..14.0).contains(&wald[1]), "vertices: {wald:?}");
    assert!(wald[2] > 1.0, "grazing: {wald:?}");
    assert!(anchor[1] < wald[1] / 3.0, "vertices: {anchor:?}");
}

#[test]
fn far_from_the_origin_the_papers_test_loses_random_rays() {
    let mut random = Random::new(14);
    let shots = count() / 5;
    for (distance, wald_loses) in [(1.0, 0.0..=0.001), (1e4, 0.05..=1.0), (1e6, 1.0..=9.0)] {
        let centre = distance * Vec3::new(0.8, -0.6, 0.4);
        let triangles = sphere(24, 16, 1.0, centre);
        for test in Intersection::ALL {
            let spec = unit(test, Approx::Exact);
            let (memory, tree) = placed(&spec, &triangles);
            let mut tracer = Tracer::new(&spec, &tree, &memory);
            let mut lost = 0;
            for _ in 0..shots {
                // From inside: whatever the direction, it hits.
                let from = centre + 0.3 * random.direction();
                let ray = Ray::new(
                    from.to_array(),
                    random.direction().to_array(),
                    0.0,
                    f32::MAX,
                    0,
                );
                lost += u32::from(!tracer.trace(&ray).hit.is_hit());
            }
            let rate = 100.0 * f64::from(lost) / shots as f64;
            println!("{}, {distance:e} away: {rate:.3} % lost", test.name());
            let may = match test {
                Intersection::Wald => wald_loses.clone(),
                _ => 0.0..=0.0,
            };
            assert!(may.contains(&rate), "{}: {rate} %", test.name());
        }
    }
}

/// A tube along z of so many quadrilaterals round and along, open at its ends, of radius 1 and from −`half` to
/// `half`.
fn tube(columns: usize, rows: usize, half: f32) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let round = std::f32::consts::TAU * (i % columns) as f32 / columns as f32;
        let along = 2.0 * j as f32 / rows as f32 - 1.0;
        Vec3::new(round.cos(), round.sin(), half * along)
    };
    let mut triangles = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [point(i, j), point(i + 1, j)];
            let [c, d] = [point(i + 1, j + 1), point(i, j + 1)];
            triangles.extend([triangle([a, b, c]), triangle([a, c, d])]);
        }
    }
    triangles
}

#[test]
fn in_a_tube_of_needles_a_test_that_moves_rays_loses_one_in_a_thousand() {
    let triangles = tube(900, 5, 1e4);
    let shots = count() / 5;
    for test in Intersection::ALL {
        let spec = unit(test, Approx::Exact);
        let (memory, tree) = placed(&spec, &triangles);
        let mut tracer = Tracer::new(&spec, &tree, &memory);
        let mut random = Random::new(21);
        let mut lost = 0;
        for _ in 0..shots {
            // Not aimed, and not out of the ends.
            let across = 0.3 * random.direction() * Vec3::new(1.0, 1.0, 0.0);
            let from = across + 1.6e4 * (random.unit() - 0.5) * Vec3::Z;
            let direction = 1e4 * random.direction();
            let ray = Ray::new(from.to_array(), direction.to_array(), 0.0, f32::MAX, 0);
            let missed = !tracer.trace(&ray).hit.is_hit();
            let met = |t: &Triangle| !surely_passes(&ray, t) && exact::meets(&ray, t);
            lost += usize::from(missed && triangles.iter().any(met));
        }
        println!(
            "{}: {lost} of {shots} lost in a tube of needles",
            test.name()
        );
        // Woop's moves the ray by a rounding of the vertices, to a needle whose box it does not meet.
        let may = match test {
            Intersection::Woop => shots / 1000,
            _ => 0,
        };
        assert!(lost <= may, "{}: {lost} of {shots}", test.name());
    }
}

/// How many of so many rays that pass a prism of slivers at a distance from an edge each test says to hit it; exact
/// arithmetic says that they all miss.
#[test]
fn only_the_scaled_epsilon_hits_what_a_ray_passes_by() {
    let triangles = tube(5, 900, 1.0);
    const RAYS: usize = 1000;
    println!("of {RAYS} rays that pass slivers at a part of their radius, hits:");
    for test in Intersection::ALL {
        let spec = unit(test, Approx::Exact);
        let (memory, tree) = placed(&spec, &triangles);
        let mut tracer = Tracer::new(&spec, &tree, &memory);
        let mut hits = Vec::new();
        for apart in [1e-6f32, 1e-5, 1e-4, 1e-3] {
            let mut random = Random::new(22);
            let (mut hit, mut shot) = (0, 0);
            while shot < RAYS {
                // Past the edge of the prism where it is widest, across its axis.
                let angle = std::f32::consts::TAU * random.below(5) as f32 / 5.0;
                let high = 1.6 * (random.unit() - 0.5);
                let width = 1.0 + apart;
                let edge = Vec3::new(width * angle.cos(), width * angle.sin(), high);
                let along = Vec3::new(-angle.sin(), angle.cos(), 0.0);
                let origin = edge - (2.0 + random.unit()) * along;
                let ray = Ray::new(
                    origin.to_array(),
                    (edge - origin).to_array(),
                    0.0,
                    f32::MAX,
                    0,
                );
                if triangles
                    .iter()
                    .any(|t| !surely_passes(&ray, t) && exact::meets(&ray, t))
                {
                    continue;
                }
                shot += 1;
                hit += u32::from(tracer.trace(&ray).hit.is_hit());
            }
            hits.push(hit);
        }
        println!("{:20} {hits:?} at 1e-6, 1e-5, 1e-4, 1e-3", test.name());
        match test {
            // Its slivers grow by a part of what rounding can do to the weights.
            Intersection::AnchorWaldScaled => assert!(hits[3] < 300, "{hits:?}"),
            // Its edges are relative to the origin of coordinates, and rounded so.
            Intersection::Wald => assert_eq!(hits[2..], [0; 2], "{hits:?}"),
            _ => assert_eq!(hits, [0; 4], "{}", test.name()),
        }
    }
}
