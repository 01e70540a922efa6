//! The bounding volume hierarchy: its builders, its cost, and its layout in memory.
//!
//! Every builder gives an `obvhs` [`Bvh2`], so that its validation, reinsertion and collapse serve
//! them all. The paper's builder is the full-sweep surface-area heuristic of Wald (2007), which
//! `obvhs` does not have: [`sweep`].

mod layout;
mod measure;
mod node;
mod record;
mod sweep;

use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use self::measure::Rays;
use crate::scene::Triangle;
use crate::scene::camera::Camera;

pub use layout::{Layout, TreeImage, lay_out};
pub use node::{NodeRef, PairRecord};
pub use record::{AnchorWords, TRIANGLE_BYTES, TriangleRecord, WaldWords, WoopWords};
pub use sweep::sweep;

/// Deepest level of a node, the root being level 0. The T&I unit keeps one trail bit a level.
pub const MAX_DEPTH: usize = 96;

/// Most triangles of a leaf.
pub const MAX_LEAF: u32 = 255;

/// Who builds the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Builder {
    /// That of the others whose tree costs least, measured on rays.
    #[default]
    Best,
    /// Full-sweep SAH (Wald 2007), as in the paper.
    Sweep,
    /// The same, then improved by reinsertion of subtrees (Meister and Bittner 2018).
    SweepReinsertion,
    /// Parallel locally-ordered clustering (Meister and Bittner 2018), then reinsertion.
    Ploc,
}

impl Builder {
    /// All of them.
    pub const ALL: [Builder; 4] = [
        Builder::Best,
        Builder::Sweep,
        Builder::SweepReinsertion,
        Builder::Ploc,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Builder::Best => "best",
            Builder::Sweep => "sweep",
            Builder::SweepReinsertion => "sweep+reinsertion",
            Builder::Ploc => "ploc",
        }
    }

    /// The builder with this [`name`](Self::name).
    pub fn parse(name: &str) -> Option<Builder> {
        Builder::ALL.into_iter().find(|b| b.name() == name)
    }
}

/// How to build.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Who builds.
    pub builder: Builder,
    /// Most triangles of a leaf, 1 to [`MAX_LEAF`].
    pub max_leaf: u32,
    /// Cost of visiting an inner node, in ray–triangle tests.
    pub traversal_cost: f32,
    /// The view whose rays decide for [`Builder::Best`]; without one, rays from all over the surfaces do.
    pub view: Option<Camera>,
}

impl Default for Options {
    /// The best tree with leaves of at most 4 triangles. A visit costs about as much as a test in the
    /// T&I unit's fixed pipelines.
    fn default() -> Options {
        Options {
            builder: Builder::Best,
            max_leaf: 4,
            traversal_cost: 1.0,
            view: None,
        }
    }
}

/// A tree over the triangles of a scene.
#[derive(Clone)]
pub struct Bvh {
    /// The tree. No nodes where there are no triangles; otherwise node 0 is the root, and
    /// siblings are neighbours. Boxes are the exact bounds of the triangles below. Triangles without area, which no
    /// ray hits, are not in it.
    pub tree: Bvh2,
    /// Who has built it: where the tree of the one asked for is deeper than [`MAX_DEPTH`], the sweep, whose tree never
    /// is.
    pub builder: Builder,
    /// Triangles that are not in the tree, for they have no area.
    pub dropped: usize,
}

impl Bvh {
    /// Levels below the root.
    pub fn depth(&self) -> usize {
        depth(&self.tree)
    }

    /// Cost of the tree by the surface-area heuristic: expected visits of inner nodes times
    /// `traversal_cost` plus expected ray–triangle tests, for a random line that meets the root.
    pub fn sah_cost(&self, traversal_cost: f32) -> f64 {
        let area = |i: usize| half_area(self.tree.nodes[i].aabb());
        let Some(root) = (!self.tree.nodes.is_empty()).then(|| area(0)) else {
            return 0.0;
        };
        if root <= 0.0 {
            return 0.0;
        }
        let cost = |i: usize| match self.tree.nodes[i].prim_count {
            0 => f64::from(traversal_cost) * area(i),
            n => f64::from(n) * area(i),
        };
        (0..self.tree.nodes.len()).map(cost).sum::<f64>() / root
    }
}

/// Builds the tree of a scene. Deterministic; any triangles do, none included, as long as their
/// coordinates are finite.
pub fn build(triangles: &[Triangle], options: &Options) -> Bvh {
    let solid = (0..)
        .zip(triangles)
        .filter(|(_, triangle)| has_area(triangle));
    let (numbers, solid): (Vec<u32>, Vec<&Triangle>) = solid.unzip();
    let boxes: Vec<Box3> = solid.iter().map(|triangle| Box3::of(triangle)).collect();
    let asked = match options.builder {
        Builder::Best => &[Builder::Sweep, Builder::SweepReinsertion, Builder::Ploc][..],
        _ => &[options.builder],
    };
    let built = asked.iter().map(|&builder| Bvh {
        tree: tree(&boxes, builder, options),
        builder,
        dropped: triangles.len() - boxes.len(),
    });
    let shallow: Vec<Bvh> = built.filter(|bvh| bvh.depth() <= MAX_DEPTH).collect();
    let least = match &shallow[..] {
        [first, _, ..] if !boxes.is_empty() => {
            let rays = match &options.view {
                Some(view) => Rays::of_view(view, &first.tree, &solid),
                None => Rays::of_surfaces(&solid),
            };
            let cost = |bvh: &Bvh| rays.cost(&bvh.tree, &solid, options.traversal_cost);
            let priced = shallow.into_iter().map(|bvh| (cost(&bvh), bvh));
            (priced.min_by(|(a, _), (b, _)| a.total_cmp(b))).map(|(_, bvh)| bvh)
        }
        _ => shallow.into_iter().next(),
    };
    let mut bvh = least.unwrap_or_else(|| Bvh {
        tree: tree(&boxes, Builder::Sweep, options),
        builder: Builder::Sweep,
        dropped: triangles.len() - boxes.len(),
    });
    for index in &mut bvh.tree.primitive_indices {
        *index = numbers[*index as usize];
    }
    bvh
}

/// The tree of one builder, however deep.
fn tree(boxes: &[Box3], builder: Builder, options: &Options) -> Bvh2 {
    let max_leaf = options.max_leaf.clamp(1, MAX_LEAF);
    // Reinsertion works best on single triangles, joined to leaves afterwards.
    let mut tree = match builder {
        Builder::SweepReinsertion => sweep(boxes, 1, options.traversal_cost),
        Builder::Ploc => PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Medium,
            boxes,
            (0..boxes.len() as u32).collect(),
            SortPrecision::U64,
            3,
        ),
        Builder::Sweep | Builder::Best => return sweep(boxes, max_leaf, options.traversal_cost),
    };
    if boxes.len() > 1 {
        ReinsertionOptimizer::default().run(&mut tree, 0.2, None);
        collapse(&mut tree, max_leaf, options.traversal_cost);
    }
    tree
}

/// False for a triangle that no ray hits ([`TriangleRecord`]), whose box would only make others larger.
pub(crate) fn has_area(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
    (b - a).cross(c - a) != glam::DVec3::ZERO
}

/// The box round one triangle.
#[derive(Clone, Copy, Debug)]
pub struct Box3(Aabb);

impl Box3 {
    /// The exact bounds of a triangle.
    pub fn of(triangle: &Triangle) -> Box3 {
        let [a, b, c] = triangle.positions.map(Vec3A::from);
        Box3(Aabb::new(a.min(b).min(c), a.max(b).max(c)))
    }
}

impl Boundable for Box3 {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// Half the surface of a box, in binary64: binary32 would overflow.
fn half_area(b: &Aabb) -> f64 {
    let d = (b.max.as_dvec3() - b.min.as_dvec3()).max(glam::DVec3::ZERO);
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Levels below the root, without recursion: a tree of another builder may be a chain.
fn depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0usize, 0usize)];
    while let Some((node, level)) = open.pop() {
        deepest = deepest.max(level);
        if let Some(n) = tree.nodes.get(node)
            && !n.is_leaf()
        {
            let first = n.first_index as usize;
            open.push((first, level + 1));
            open.push((first + 1, level + 1));
        }
    }
    deepest
}

/// The words that bytes begin with.
#[inline]
fn read_words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes[..4 * N].chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().expect("chunks of 4 bytes"));
    }
    words
}
