//! The shadows of rays and hits, and what the stages of the T&I unit make of them.

use super::exact::{Exact, ExactRay, Meeting};
use crate::functional::{Stage, TileWorld};
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ports;
use srp_ir::interp::{Done, Observer, Values};
use srp_ir::program::Pos;
use srp_ir::shadow::tape::NO_TAG;
use srp_ir::shadow::{Mark, Shadows, Sources};
use srp_runtime::bvh::{TRIANGLE_BYTES, TriangleRecord};
use srp_runtime::tni::arithmetic::{ANY_HIT, Ray, staged, stages};
use srp_runtime::tni::{HIT_BYTES, HitRecord, RAY_BYTES};

/// Sources of the unit before its stages: what a hit depends on, the ray's own displacement; what
/// first order does not explain of it; the record of the triangle in memory; which triangle it is.
pub(super) const RAY: u32 = 0;
const BEND: u32 = 1;
const RECORD: u32 = 2;
pub(super) const DECISION: u32 = 3;
const FIRST_STAGE: u32 = 4;

/// Names of the sources of the unit, with those of its stages, and of the box that a hit is moved to.
pub(super) fn units(stages: &[&str]) -> Vec<String> {
    let before = [
        "ray",
        "ray beyond first order",
        "triangle record",
        "triangle test",
    ];
    let names = before.iter().chain(stages).chain(&["box"]);
    names.map(|name| format!("T&I: {name}")).collect()
}

/// The part of distances, and of the ray's coordinates, by which distances are near to a tie, and the weights by which
/// places are near to an edge, that binary64 cannot tell apart.
const TIE: f64 = 1e-11;

/// The difference up to which binary64 cannot tell distances of a ray apart: scenes are of any size.
fn slack(t: f64, ray: &ExactRay) -> f64 {
    let largest = |v: &[f64; 3]| v.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    TIE * (t.abs() + largest(&ray.origin) / largest(&ray.direction))
}

/// The T&I unit, for all tiles.
pub(super) struct Hardware<'a> {
    exact: &'a Exact,
    arch: &'a Arch,
    /// The record of each triangle.
    records: Vec<Option<TriangleRecord>>,
}

impl<'a> Hardware<'a> {
    pub(super) fn of(stage: &Stage<'a>, exact: &'a Exact, triangles: usize) -> Hardware<'a> {
        let image = stage.image;
        let mut records = vec![None; triangles];
        for i in 0..triangles as u32 {
            let address = image.tree.triangles + i * stage.arch.system.tni.triangle_bytes;
            let Some(bytes) = image.memory.get(address, TRIANGLE_BYTES) else {
                break;
            };
            let record = TriangleRecord::read(bytes);
            if let Some(place) = records.get_mut(record.primitive() as usize) {
                *place = Some(record);
            }
        }
        Hardware {
            exact,
            arch: stage.arch,
            records,
        }
    }
}

/// How far from its origin a ray hits what it begins on, as a part of the origin's distance from that
/// of the coordinates: some roundings of a distance with 12 bits.
const AT_ORIGIN: f64 = 1.0 / 1024.0;

/// A ray whose shadow hits something else.
#[derive(Clone, Debug)]
pub(super) struct Lost {
    /// True if any hit would have done.
    pub(super) any: bool,
    /// True if the unit has hit the surface where the ray begins.
    pub(super) at_origin: bool,
    pub(super) tag: u32,
    /// The triangles that the unit and the shadow hit.
    pub(super) real: Option<u32>,
    pub(super) shadow: Option<u32>,
    /// True if the shadow's answer is that of the ray as the unit was given it: then the unit itself decides
    /// otherwise.
    pub(super) by_unit: bool,
    /// The numbers that the decided place depends on: its three coordinates.
    pub(super) roots: Vec<(u32, [f64; 3])>,
}

/// The shadows of the run of a tile.
pub(super) struct FrameShadows<'a> {
    pub(super) shadows: Shadows<'a>,
    hardware: &'a Hardware<'a>,
    pub(super) lost: Vec<Lost>,
    /// Nodes beyond which their history is made short.
    most_nodes: usize,
}

/// A ray as the unit was given it, with the marks of its words.
struct Marked {
    ray: Ray,
    marks: [Mark; 16],
}

impl<'a> FrameShadows<'a> {
    pub(super) fn new(
        hardware: &'a Hardware<'a>,
        sources: &'a Sources,
        arch: &Arch,
        most_nodes: usize,
    ) -> FrameShadows<'a> {
        let sram = arch.system.sram_bytes;
        FrameShadows {
            shadows: Shadows::new(sources, sram, arch.precision.texture_weight_bits),
            hardware,
            lost: Vec::new(),
            most_nodes,
        }
    }

    /// The unit has answered a submission.
    fn answered(&mut self, world: &TileWorld<'_>) {
        let Some((rays, hits)) = world.submitted() else {
            return;
        };
        for (i, record) in (0..).zip(world.records()) {
            let address = rays + record.ray * RAY_BYTES;
            let words = std::array::from_fn(|k| world.sram_word(address + 4 * k as u32));
            let marked = Marked {
                ray: Ray::from_words(words),
                marks: std::array::from_fn(|k| self.shadows.sram_mark(address + 4 * k as u32)),
            };
            let at = hits + i * HIT_BYTES;
            for word in 0..HIT_BYTES / 4 {
                self.shadows.mark_sram(at + 4 * word, Mark::PLAIN);
            }
            for (k, mark) in (0..).zip(self.hit(&marked, record)) {
                self.shadows.mark_sram(at + 4 * k, mark);
            }
        }
    }

    /// The marks of distance and weights of a hit.
    fn hit(&mut self, marked: &Marked, record: &HitRecord) -> [Mark; 3] {
        let shadow = self.shadow_of(marked);
        let nodes = [0, 1, 2, 4, 5, 6].map(|k| marked.marks[k].node_of());
        let own = self.shadows.tape.tag(nodes);
        // A ray that comes from no hit is a camera's: it has the number of its pixel.
        let any = record.flags & ANY_HIT != 0;
        let tag = if own == NO_TAG && !any {
            record.ray
        } else {
            own
        };
        self.decide(marked, record, &shadow, tag);
        if !record.hit.is_hit() {
            return [marked.marks[7], Mark::PLAIN, Mark::PLAIN];
        }
        let primitive = record.hit.primitive;
        let exact = self.hardware.exact;
        let real = exact.meet(primitive, &exact_ray(&marked.ray));
        let (Some(real), Some(shadow)) = (real, exact.meet(primitive, &shadow)) else {
            return [Mark::PLAIN; 3];
        };
        self.attribute(marked, record, real, shadow, tag)
    }

    fn shadow_of(&self, marked: &Marked) -> ExactRay {
        let Ray {
            origin,
            direction,
            tmin,
            tmax,
            ..
        } = marked.ray;
        let tape = &self.shadows.tape;
        let shadow = |k: usize, value: f32| tape.shadow(marked.marks[k].node_of(), value);
        ExactRay {
            origin: std::array::from_fn(|k| shadow(k, origin[k])),
            direction: std::array::from_fn(|k| shadow(4 + k, direction[k])),
            tmin: shadow(3, tmin),
            tmax: shadow(7, tmax),
        }
    }

    /// Compares the hit of the unit with the shadow's.
    fn decide(&mut self, marked: &Marked, record: &HitRecord, shadow: &ExactRay, tag: u32) {
        let any = record.flags & ANY_HIT != 0;
        let only_any = any && self.hardware.arch.system.tni.any_hit;
        let real = record.hit.is_hit().then_some(record.hit.primitive);
        let found = self.hardware.exact.nearest(shadow);
        let same = |found: Option<(u32, f64)>, ray: &ExactRay| match (real, found) {
            (None, None) => true,
            (Some(_), Some(_)) if only_any => true,
            (Some(real), Some((nearest, t))) => real == nearest || self.ties(real, nearest, t, ray),
            (Some(real), None) => self.on_edge(real, ray),
            (None, Some((nearest, _))) => self.on_edge(nearest, ray),
        };
        if same(found, shadow) {
            return;
        }
        let given = exact_ray(&marked.ray);
        let by_unit = !same(self.hardware.exact.nearest(&given), &given);
        let t = found.map_or(f64::from(record.hit.t), |(_, t)| t);
        let mut roots = Vec::new();
        for axis in 0..3 {
            let mut weight = [0.0; 3];
            weight[axis] = 1.0;
            roots.push((marked.marks[axis].node_of(), weight));
            roots.push((marked.marks[4 + axis].node_of(), weight.map(|w| w * t)));
        }
        let length = |v: [f32; 3]| {
            v.iter()
                .map(|&x| f64::from(x) * f64::from(x))
                .sum::<f64>()
                .sqrt()
        };
        let ray = &marked.ray;
        let gone = f64::from(record.hit.t) * length(ray.direction);
        self.lost.push(Lost {
            any,
            at_origin: real.is_some() && gone <= AT_ORIGIN * length(ray.origin),
            tag,
            real,
            shadow: found.map(|(nearest, _)| nearest),
            by_unit,
            roots,
        });
    }

    /// True if a ray meets a triangle as near as another, on an edge of one of them or so that the order of
    /// their numbers decides, as far as binary64 can tell.
    fn ties(&self, real: u32, nearest: u32, t: f64, ray: &ExactRay) -> bool {
        let meet = |triangle| self.hardware.exact.meet(triangle, ray);
        let (Some(a), Some(b)) = (meet(real), meet(nearest)) else {
            return false;
        };
        let near = (a.at[0] - t).abs() <= slack(t, ray) && a.inside() >= -TIE;
        let edge = a.inside() <= TIE || b.inside() <= TIE;
        near && (edge || real < nearest)
    }

    /// True if it goes through an edge of a triangle, or ends there, as far as binary64 can tell.
    fn on_edge(&self, triangle: u32, ray: &ExactRay) -> bool {
        let Some(meeting) = self.hardware.exact.meet(triangle, ray) else {
            return false;
        };
        let t = meeting.at[0];
        let slack = slack(t, ray);
        let at_end = (t - ray.tmin.max(0.0)).abs() <= slack || (t - ray.tmax).abs() <= slack;
        meeting.inside().abs() <= TIE || at_end && meeting.inside() >= -TIE
    }

    /// Shares the error of a hit between its ray and the stages of the unit.
    fn attribute(
        &mut self,
        marked: &Marked,
        record: &HitRecord,
        real: Meeting,
        shadow: Meeting,
        tag: u32,
    ) -> [Mark; 3] {
        let tni = &self.hardware.arch.system.tni;
        let (test, rcp) = (tni.intersection, tni.rcp);
        let tape = &mut self.shadows.tape;
        let t = shadow.at[0];
        let moved: [u32; 3] = std::array::from_fn(|k| {
            let nodes = [marked.marks[k].node_of(), marked.marks[4 + k].node_of()];
            let error = tape.error(nodes[0]) + t * tape.error(nodes[1]);
            let value = marked.ray.origin[k] + record.hit.t * marked.ray.direction[k];
            tape.push(
                value,
                f64::from(value) - error,
                RAY,
                [(nodes[0], 1.0), (nodes[1], t), (0, 0.0)],
            )
        });
        let hit = record.hit;
        let triangle = self.hardware.records[hit.primitive as usize];
        let steps: Vec<[f64; 3]> = triangle.map_or(Vec::new(), |triangle| {
            (0..=stages(test).len())
                .map(|rounding| staged(&marked.ray, &triangle, test, rcp, rounding))
                .collect()
        });
        let last = FIRST_STAGE + stages(test).len() as u32;
        let values = [hit.t, hit.u, hit.v];
        std::array::from_fn(|i| {
            let parents = std::array::from_fn(|k| (moved[k], shadow.slopes[i][k]));
            // Between the stages there is no value: their nodes have the hit's, and their own errors.
            let value = f64::from(values[i]);
            let off = real.at[i] - shadow.at[i];
            let mut node = tape.push_tagged(values[i], value - off, BEND, parents, tag);
            let end = (last, value);
            let inner = (RECORD..).filter(|&source| source != DECISION).zip(&steps);
            for (source, at) in inner.map(|(source, at)| (source, at[i])).chain([end]) {
                let off = value - (at - shadow.at[i]);
                if at.is_finite() && value - off != tape.error(node) {
                    let parents = [(node, 1.0), (0, 0.0), (0, 0.0)];
                    node = tape.push_tagged(values[i], off, source, parents, tag);
                }
            }
            Mark::node(node)
        })
    }
}

/// A ray as the unit was given it.
fn exact_ray(ray: &Ray) -> ExactRay {
    ExactRay {
        origin: ray.origin.map(f64::from),
        direction: ray.direction.map(f64::from),
        tmin: f64::from(ray.tmin),
        tmax: f64::from(ray.tmax),
    }
}

impl<'w> Observer<TileWorld<'w>> for FrameShadows<'_> {
    fn enter(&mut self, base: usize, len: usize) {
        Observer::<TileWorld<'w>>::enter(&mut self.shadows, base, len);
    }

    fn constant(&mut self, to: usize) {
        Observer::<TileWorld<'w>>::constant(&mut self.shadows, to);
    }

    fn moved(&mut self, from: Values<'_>, to: Values<'_>) {
        Observer::<TileWorld<'w>>::moved(&mut self.shadows, from, to);
    }

    fn branch(&mut self, cond: usize, taken: bool, at: Pos) {
        Observer::<TileWorld<'w>>::branch(&mut self.shadows, cond, taken, at);
    }

    fn done(&mut self, done: &Done<'_>, world: &mut TileWorld<'w>) {
        self.shadows.done(done, world);
        if done.op == Opcode::Out && done.imm as u32 == ports::TNI_START {
            self.answered(world);
            if self.shadows.tape.len() > self.most_nodes {
                let roots = self.lost.iter_mut().flat_map(|lost| &mut lost.roots);
                self.shadows.collapse(roots.map(|(node, _)| node).collect());
            }
        }
    }
}
