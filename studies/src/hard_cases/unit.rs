//! The T&I unit of a machine over the triangles of a case.

use crate::tni::drive;
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::{self, Bvh, Layout, TreeImage};
use srp_runtime::memory::SystemMemory;
use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use srp_runtime::tni::place_for;
use srp_runtime::tni::{Tracer, Tree};

/// The usual tree of some triangles.
pub(super) fn tree(triangles: &[Triangle]) -> Bvh {
    bvh::build(triangles, &bvh::Options::default())
}

/// A unit, and the tree that it reads.
pub(super) struct Unit<'a> {
    arch: &'a Arch,
    image: TreeImage,
    memory: SystemMemory,
    tree: Tree,
}

impl<'a> Unit<'a> {
    /// A unit over a tree of the triangles.
    pub(super) fn of(arch: &'a Arch, triangles: &[Triangle], tree: &Bvh) -> Unit<'a> {
        let image = bvh::lay_out(tree, triangles, Layout::of(&arch.system.tni));
        let (memory, tree) = place_for(&arch.system, &image);
        Unit {
            arch,
            image,
            memory,
            tree,
        }
    }

    /// Returns a tracer that traces rays as the unit does, without its time.
    pub(super) fn tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.arch.system.tni, &self.tree, &self.memory)
    }

    /// Returns the unit's answer, simulated cycle by cycle.
    pub(super) fn answer(&self, ray: &Ray) -> Option<Hit> {
        let outcome = drive(&self.arch.system, &self.image, std::slice::from_ref(ray));
        outcome.hits.first().map(|record| record.hit)
    }
}
