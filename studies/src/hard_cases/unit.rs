//! The T&I unit of a machine over the triangles of a case.

use crate::tni::drive;
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::{self, Bvh, Layout, TreeImage};
use srp_runtime::memory::SystemMemory;
use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use srp_runtime::tni::place_for;
use srp_runtime::tni::{Tracer, Tree};
use std::sync::OnceLock;

/// Triangles and their usual tree, which is built when it is first asked for: it is the same in every setting.
pub(super) struct Mesh {
    pub(super) triangles: Vec<Triangle>,
    tree: OnceLock<Bvh>,
}

impl Mesh {
    /// A mesh of some triangles.
    pub(super) fn of(triangles: Vec<Triangle>) -> Mesh {
        Mesh {
            triangles,
            tree: OnceLock::new(),
        }
    }

    /// Its tree.
    pub(super) fn tree(&self) -> &Bvh {
        let build = || bvh::build(&self.triangles, &bvh::Options::default());
        self.tree.get_or_init(build)
    }
}

/// A unit, and the tree that it reads.
pub(super) struct Unit<'a> {
    arch: &'a Arch,
    image: TreeImage,
    memory: SystemMemory,
    tree: Tree,
}

impl<'a> Unit<'a> {
    /// A unit over the tree of a mesh.
    pub(super) fn of(arch: &'a Arch, mesh: &Mesh) -> Unit<'a> {
        let image = bvh::lay_out(mesh.tree(), &mesh.triangles, Layout::of(&arch.system.tni));
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
