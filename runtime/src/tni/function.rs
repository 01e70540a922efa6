//! The function of the unit, apart from its timing: the tests on boxes and triangles of a tree in memory,
//! and a ray's whole way through it.

use std::sync::Arc;

use srp_archdesc::system::TniSpec;

use super::Tree;
use super::arithmetic::{ANY_HIT, Hit, NEAREST, Prepared, Ray};
use super::decoded::Decoded;
use super::walk::{Next, StackCounters, Walk};
use crate::bvh::{NodeRef, PairRecord, TRIANGLE_BYTES, TriangleRecord};
use crate::memory::SystemMemory;

/// A tree in memory, and the arithmetic of the unit that reads it.
#[derive(Clone, Copy)]
pub(super) struct Function<'a> {
    pub(super) spec: &'a TniSpec,
    pub(super) tree: &'a Tree,
    pub(super) memory: &'a SystemMemory,
}

impl Function<'_> {
    /// Bytes from the first word of a pair of siblings to the last.
    pub(super) fn pair_bytes(&self) -> u32 {
        self.spec.node_bytes + self.spec.node_format.bytes()
    }

    /// Address of the pair of siblings whose first is node `index`.
    pub(super) fn pair_address(&self, index: u32) -> u32 {
        self.tree.nodes + index * self.spec.node_bytes
    }

    /// Address of triangle record `index`.
    pub(super) fn triangle_address(&self, index: u32) -> u32 {
        self.tree.triangles + index * self.spec.triangle_bytes
    }

    /// The children of an inner node.
    #[inline]
    pub(super) fn pair(&self, node: NodeRef) -> PairRecord {
        let bytes = self
            .memory
            .get(self.pair_address(node.index), self.pair_bytes());
        let bytes = bytes.expect("a tree refers to its own nodes, and nothing writes to them");
        PairRecord::read(bytes, self.spec.node_bytes as usize, self.spec.node_format)
    }

    /// The children of an inner node, and where the ray enters their boxes no farther than `limit`.
    #[inline]
    pub(super) fn boxes(
        &self,
        node: NodeRef,
        ray: &Prepared,
        limit: f32,
    ) -> ([NodeRef; 2], [Option<f32>; 2]) {
        let pair = self.pair(node);
        let enter = [0, 1].map(|side| ray.meets(&pair.min[side], &pair.max[side], limit));
        (pair.child, enter)
    }

    /// Tests triangle record `index` of a leaf whose box the ray enters at `enter`. Returns the
    /// triangle's number, the result of the test, and whether that is now the nearest hit.
    #[inline]
    pub(super) fn test(
        &self,
        index: u32,
        ray: &Prepared,
        enter: f32,
        nearest: &mut Hit,
    ) -> (u32, Option<Hit>, bool) {
        let bytes = self
            .memory
            .get(self.triangle_address(index), TRIANGLE_BYTES);
        let bytes = bytes.expect("a tree refers to its own triangles, and nothing writes to them");
        let record = TriangleRecord::read(bytes);
        let hit = ray.intersect(&record, self.spec.intersection, self.spec.rcp);
        let taken = hit.is_some_and(|hit| nearest.take_nearer(hit, enter));
        (record.primitive(), hit, taken)
    }

    /// The visit of an inner node.
    #[inline]
    fn step(&self, node: NodeRef) -> Step {
        Step::Pair {
            address: self.pair_address(node.index),
            bytes: self.pair_bytes(),
        }
    }

    /// Tests all triangles of a leaf; whether the ray needs nothing more.
    #[inline]
    fn visit_leaf(
        &self,
        node: NodeRef,
        ray: &Ray,
        prepared: &Prepared,
        enter: f32,
        traced: &mut Traced,
        tell: &mut impl FnMut(Step),
    ) -> bool {
        traced.leaf_visits += 1;
        tell(Step::Leaf);
        for index in node.index..node.index + node.count {
            traced.triangle_tests += 1;
            tell(Step::Triangle {
                address: self.triangle_address(index),
                bytes: TRIANGLE_BYTES,
            });
            self.test(index, prepared, enter, &mut traced.hit);
            if self.is_settled(ray.flags, &traced.hit) {
                return true;
            }
        }
        false
    }

    /// True if a ray with these flags needs no other hit than the one it has.
    #[inline]
    pub(super) fn is_settled(&self, flags: u32, hit: &Hit) -> bool {
        self.spec.any_hit && flags & (ANY_HIT | NEAREST) == ANY_HIT && hit.is_hit()
    }
}

/// The hit of a ray, and the work of finding it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traced {
    /// The hit.
    pub hit: Hit,
    /// Visits of inner nodes.
    pub inner_visits: u32,
    /// Visits of leaves.
    pub leaf_visits: u32,
    /// Ray–triangle tests.
    pub triangle_tests: u32,
}

/// A step on a ray's way, with the addresses that it reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The visit of an inner node.
    Pair {
        /// Address of the record of its children.
        address: u32,
        /// Bytes of both.
        bytes: u32,
    },
    /// The visit of a leaf.
    Leaf,
    /// A ray–triangle test.
    Triangle {
        /// Address of the triangle's record.
        address: u32,
        /// Bytes of it.
        bytes: u32,
    },
}

/// Traces rays as the unit does, bit for bit, without its time.
#[derive(Clone)]
pub struct Tracer<'a> {
    function: Function<'a>,
    decoded: Arc<Decoded>,
    /// Nodes put aside, and where the ray enters their boxes.
    stack: Vec<(NodeRef, f32)>,
    /// How the unit finds its way with a stack that the tree is too deep for.
    walk: Option<Walk>,
}

impl<'a> Tracer<'a> {
    /// A tracer over a tree in memory.
    pub fn new(spec: &'a TniSpec, tree: &'a Tree, memory: &'a SystemMemory) -> Tracer<'a> {
        let decoded = Decoded::shared(spec, tree, memory);
        Tracer::over(spec, tree, memory, decoded)
    }

    /// A tracer over a tree that has been read.
    pub(super) fn over(
        spec: &'a TniSpec,
        tree: &'a Tree,
        memory: &'a SystemMemory,
        decoded: Arc<Decoded>,
    ) -> Tracer<'a> {
        let fits = decoded.depth <= spec.stack_depth as usize;
        Tracer {
            function: Function { spec, tree, memory },
            stack: Vec::with_capacity(decoded.depth),
            walk: (!fits).then(|| Walk::new(spec.stack_depth)),
            decoded,
        }
    }

    /// Traces a ray.
    pub fn trace(&mut self, ray: &Ray) -> Traced {
        self.follow(ray, &mut |_| {})
    }

    /// Traces a ray, and tells every step of it before it is made.
    #[inline]
    pub fn follow(&mut self, ray: &Ray, tell: &mut impl FnMut(Step)) -> Traced {
        let mut traced = Traced {
            hit: Hit::none(ray.tmax),
            inner_visits: 0,
            leaf_visits: 0,
            triangle_tests: 0,
        };
        if let (Some(prepared), Some(root)) = (Prepared::of(ray), self.function.tree.root) {
            match self.walk.take() {
                None => self.descend(ray, &prepared, root, &mut traced, tell),
                Some(mut walk) => {
                    self.walk_by_trail(&mut walk, ray, &prepared, root, &mut traced, tell);
                    self.walk = Some(walk);
                }
            }
        }
        traced
    }

    /// The way of a ray with all the stack that it needs: the nearer child first, the other from the
    /// stack unless something nearer was hit meanwhile. It is that of [`walk_by_trail`](Self::walk_by_trail).
    #[inline]
    fn descend(
        &mut self,
        ray: &Ray,
        prepared: &Prepared,
        root: NodeRef,
        traced: &mut Traced,
        tell: &mut impl FnMut(Step),
    ) {
        let Tracer {
            function,
            decoded,
            stack,
            ..
        } = self;
        stack.clear();
        let (mut node, mut enter) = (root, 0.0);
        loop {
            if node.is_leaf() {
                if function.visit_leaf(node, ray, prepared, enter, traced, tell) {
                    return;
                }
            } else {
                traced.inner_visits += 1;
                tell(function.step(node));
                let pair = decoded.pair(node);
                let [a, b] = prepared.meets_both(&pair.corners, traced.hit.t);
                match (a, b) {
                    (Some(a), Some(b)) => {
                        let near = usize::from(b < a);
                        let enters = [a, b];
                        stack.push((pair.child[1 - near], enters[1 - near]));
                        (node, enter) = (pair.child[near], enters[near]);
                        continue;
                    }
                    (Some(a), None) => {
                        (node, enter) = (pair.child[0], a);
                        continue;
                    }
                    (None, Some(b)) => {
                        (node, enter) = (pair.child[1], b);
                        continue;
                    }
                    (None, None) => {}
                }
            }
            loop {
                let Some(top) = stack.pop() else {
                    return;
                };
                if top.1 <= traced.hit.t {
                    (node, enter) = top;
                    break;
                }
            }
        }
    }

    /// The way of a ray with the unit's own stack and trail.
    fn walk_by_trail(
        &self,
        walk: &mut Walk,
        ray: &Ray,
        prepared: &Prepared,
        root: NodeRef,
        traced: &mut Traced,
        tell: &mut impl FnMut(Step),
    ) {
        let function = &self.function;
        let mut stacks = StackCounters::default();
        walk.start(root);
        let mut next = Next::Visit;
        while next == Next::Visit {
            let node = walk.node;
            next = if node.is_leaf() {
                if function.visit_leaf(node, ray, prepared, walk.enter, traced, tell) {
                    return;
                }
                walk.pop(traced.hit.t, &mut stacks).0
            } else {
                traced.inner_visits += 1;
                tell(function.step(node));
                let limit = traced.hit.t;
                let (children, enter) = function.boxes(node, prepared, limit);
                walk.descend(children, enter, limit, &mut stacks).0
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{self, Layout};
    use crate::scene::{Triangle, demo::demo};
    use srp_archdesc::datapath::Intersection;
    use srp_archdesc::system::NodeFormat;

    fn machine() -> TniSpec {
        let file = srp_archdesc::machines::SGRT;
        let arch = srp_archdesc::parse(file.name, file.xml).expect("the shipped machine is valid");
        arch.system.tni
    }

    /// The nearest hit, nodes being visited in an order that `random` decides.
    fn in_any_order(function: &Function<'_>, ray: &Ray, mut random: impl FnMut() -> u32) -> Hit {
        let mut hit = Hit::none(ray.tmax);
        let prepared = Prepared::of(ray).expect("a proper ray");
        let mut open = vec![(function.tree.root.expect("a tree"), 0.0)];
        while !open.is_empty() {
            let (node, enter) = open.swap_remove(random() as usize % open.len());
            if enter > hit.t {
                continue;
            }
            if node.is_leaf() {
                for i in node.index..node.index + node.count {
                    function.test(i, &prepared, enter, &mut hit);
                }
                continue;
            }
            let (children, enter) = function.boxes(node, &prepared, hit.t);
            for (child, enter) in children.into_iter().zip(enter) {
                open.extend(enter.map(|enter| (child, enter)));
            }
        }
        hit
    }

    #[test]
    fn a_stack_that_is_deep_enough_leads_the_way_of_the_units_own() {
        let triangles = demo().triangles;
        let spec = machine();
        let tree = bvh::build(&triangles, &bvh::Options::default());
        let image = bvh::lay_out(&tree, &triangles, Layout::of(&spec));
        let (memory, tree) = super::super::place::place(&image);
        let mut quick = Tracer::new(&spec, &tree, &memory);
        assert!(quick.walk.is_none(), "the machine's stack holds the tree");
        let mut own = quick.clone();
        own.walk = Some(Walk::new(spec.stack_depth));
        let mut state = 5u32;
        let mut unit = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut hits = 0;
        for i in 0..20_000u32 {
            let from = triangles[i as usize % triangles.len()].positions[0];
            let to = [unit(), unit(), unit()];
            let ray = Ray::new((from + 0.01).to_array(), to, 0.0, 1e30, i % 4);
            let steps = |tracer: &mut Tracer<'_>| {
                let mut steps = Vec::new();
                let traced = tracer.follow(&ray, &mut |step| {
                    steps.push(match step {
                        Step::Pair { address, .. } => address,
                        Step::Triangle { address, .. } => address + 1,
                        Step::Leaf => 0,
                    });
                });
                (traced, steps)
            };
            let (one, two) = (steps(&mut quick), steps(&mut own));
            assert_eq!(one, two, "{ray:?}");
            hits += u32::from(one.0.hit.is_hit());
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn the_order_of_visits_changes_no_hit() {
        let mut state = 7u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        let mut unit = move || random() as f32 / (1 << 24) as f32;
        // Coplanar, overlapping and grazing: where distances tie, or are off by much.
        let mut triangles: Vec<Triangle> = demo().triangles;
        triangles.truncate(400);
        let doubled: Vec<Triangle> = triangles.iter().rev().take(100).copied().collect();
        triangles.extend(doubled);
        let (lo, hi) = crate::scene::bounds(&triangles).expect("triangles");
        let formats = NodeFormat::ALL.iter().cycle();
        for (test, &node_format) in Intersection::ALL.into_iter().zip(formats) {
            let spec = TniSpec {
                intersection: test,
                node_format,
                node_bytes: node_format.bytes(),
                ..machine()
            };
            let tree = bvh::build(&triangles, &bvh::Options::default());
            let image = bvh::lay_out(&tree, &triangles, Layout::of(&spec));
            let (memory, tree) = super::super::place::place(&image);
            let function = Function {
                spec: &spec,
                tree: &tree,
                memory: &memory,
            };
            let mut tracer = Tracer::new(&spec, &tree, &memory);
            for i in 0..3000 {
                let mut point = || lo + (hi - lo) * glam::Vec3::new(unit(), unit(), unit());
                let (from, mut to) = (point(), point());
                // A third along a plane of the scene, a third at a vertex.
                match i % 3 {
                    0 => to.y = from.y,
                    1 => to = triangles[i % triangles.len()].positions[i % 2],
                    _ => {}
                }
                if from == to {
                    continue;
                }
                let ray = Ray::new(from.to_array(), (to - from).to_array(), 0.0, 1e30, 0);
                let expected = tracer.trace(&ray).hit;
                for _ in 0..3 {
                    let shuffled = in_any_order(&function, &ray, || (unit() * 16_777_216.0) as u32);
                    assert_eq!(shuffled, expected, "{}: {ray:?}", test.name());
                }
            }
        }
    }
}
