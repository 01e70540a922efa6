//! Objects in system memory, which the misses of a frame's caches are for, and materials, which the rays of its T&I
//! units hit.

use super::lines::Lines;
use super::model::{
    AccessProfile, CodeProfile, FrameProfile, Line, LineEnergy, MaterialProfile, ObjectProfile,
    PipelineProfile,
};
use super::timeline::Cache;
use crate::energy::{self, Use};
use srp_archdesc::arch::Arch;
use srp_archdesc::system::SystemSpec;
use srp_csimgen::Turn;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image::{Object, SceneImage, objects};
use srp_runtime::system::{MemoryRequest, Report, Requester};
use srp_runtime::tni::{HitRecord, Levels, PipeCounters, RayCost, Visited};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// The scene of a frame: its objects in memory, and the materials of its triangles.
pub struct Surroundings {
    objects: Vec<Object>,
    materials: Vec<String>,
    of_triangles: Vec<u32>,
    levels: Levels,
}

impl Surroundings {
    /// The surroundings of a frame of a scene that lies in memory as in this image.
    pub fn of(image: &SceneImage, scene: &Scene, system: &SystemSpec) -> Surroundings {
        Surroundings {
            levels: Levels::of(&system.tni, &image.tree, &image.memory),
            objects: objects(image, scene),
            materials: scene.materials.iter().map(|m| m.name.clone()).collect(),
            of_triangles: scene.triangles.iter().map(|t| t.material).collect(),
        }
    }

    /// The number of the object at an address.
    fn object(&self, address: u32) -> Option<usize> {
        let starts = |object: &Object| object.addresses.start <= address;
        let behind = self.objects.partition_point(starts);
        let number = behind.checked_sub(1)?;
        self.objects[number]
            .addresses
            .contains(&address)
            .then_some(number)
    }
}

/// Adds up what caches and T&I units work for.
pub(super) struct Work {
    surroundings: Surroundings,
    objects: Vec<ObjectProfile>,
    /// By line and object.
    accesses: BTreeMap<(Line, usize), Access>,
    /// The materials, and last what rays hit nothing of.
    materials: Vec<MaterialProfile>,
    cores: Vec<OfCore>,
}

/// Lines of memory that a source line asked for, of one object.
#[derive(Clone, Copy, Default)]
struct Access {
    misses: u64,
    bytes: u64,
    stall: u64,
}

/// Misses and packets under way for a core.
#[derive(Default)]
struct OfCore {
    /// The object that each source line asked for last, by cache.
    asked: BTreeMap<(Cache, Line), usize>,
    /// The object that each cache asked for last.
    last: BTreeMap<Cache, usize>,
    /// Costs of rays whose packets are not back, by submission.
    costs: BTreeMap<u64, Vec<RayCost>>,
}

impl Work {
    pub(super) fn of(surroundings: Surroundings, cores: u32) -> Work {
        let object = |object: &Object| ObjectProfile {
            object: object.name.clone(),
            bytes: u64::from(object.addresses.end - object.addresses.start),
            ..ObjectProfile::default()
        };
        let material = |name: &str| MaterialProfile {
            material: name.to_owned(),
            ..MaterialProfile::default()
        };
        let names = surroundings.materials.iter().map(String::as_str);
        Work {
            objects: surroundings.objects.iter().map(object).collect(),
            accesses: BTreeMap::new(),
            materials: names.chain([""]).map(material).collect(),
            cores: (0..cores).map(|_| OfCore::default()).collect(),
            surroundings,
        }
    }

    /// A request to the memory; one that reads comes with the last turn of the core, whose load it is for.
    pub(super) fn requested(
        &mut self,
        core: u32,
        request: &MemoryRequest,
        turn: Option<Turn>,
        lines: &Lines,
    ) {
        // A line of memory may begin before the frame buffer does, which is all that cores write.
        let number = match request.is_write {
            true => self.objects.len().checked_sub(1),
            false => self.surroundings.object(request.address),
        };
        let Some(number) = number else {
            return;
        };
        let (object, bytes) = (&mut self.objects[number], u64::from(request.bytes));
        if request.is_write {
            object.written += bytes;
            return;
        }
        let cache = match request.requester {
            Requester::DataCache => Cache::Data,
            Requester::TextureCache => Cache::Texture,
            // What they read is no part of the scene.
            Requester::InstructionCache | Requester::ConfigurationMemory => return,
            Requester::Tni(_) => {
                object.by_tni += bytes;
                let levels = &mut self.surroundings.levels;
                levels.read(request.address, request.bytes);
                return;
            }
        };
        match cache {
            Cache::Data => object.by_data += bytes,
            Cache::Texture => object.by_texture += bytes,
        }
        let core = &mut self.cores[core as usize];
        core.last.insert(cache, number);
        if let Some(turn) = turn {
            let line = lines.asked(turn, cache == Cache::Data);
            let access = self.accesses.entry((line.clone(), number)).or_default();
            access.misses += 1;
            access.bytes += bytes;
            core.asked.insert((cache, line), number);
        }
    }

    /// A core has stood still for a line's load.
    pub(super) fn stood_still(&mut self, core: u32, cache: Cache, line: Line, cycles: u64) {
        let core = &self.cores[core as usize];
        let asked = core.asked.get(&(cache, line.clone()));
        let Some(&number) = asked.or_else(|| core.last.get(&cache)) else {
            return;
        };
        self.objects[number].stall += cycles;
        self.accesses.entry((line, number)).or_default().stall += cycles;
    }

    /// Rays have visited parts of the tree.
    pub(super) fn visited(&mut self, visited: &[Visited]) {
        self.surroundings.levels.visit(visited);
    }

    pub(super) fn ray_returned(&mut self, core: u32, cost: &RayCost) {
        let costs = &mut self.cores[core as usize].costs;
        costs.entry(cost.submission).or_default().push(*cost);
    }

    pub(super) fn packet_returned(&mut self, core: u32, packet: u64, hits: &[HitRecord]) {
        let costs = self.cores[core as usize].costs.remove(&packet);
        let costs = costs.unwrap_or_default();
        let nothing = self.materials.len() - 1;
        let by_ray: BTreeMap<u32, &RayCost> = costs.iter().map(|c| (c.index, c)).collect();
        for hit in hits {
            let Some(cost) = by_ray.get(&hit.ray) else {
                continue;
            };
            let triangle = self
                .surroundings
                .of_triangles
                .get(hit.hit.primitive as usize);
            let number = triangle.map_or(nothing, |&material| material as usize);
            let of = &mut self.materials[number.min(nothing)];
            of.rays += 1;
            of.cycles += cost.cycles;
            of.visits += u64::from(cost.visits);
            of.tests += u64::from(cost.tests);
        }
    }

    /// The whole, the largest first.
    pub(super) fn profile(&self) -> FrameProfile {
        let mut objects = self.objects.clone();
        objects.retain(|o| o.stall + o.by_data + o.by_texture + o.by_tni + o.written > 0);
        objects
            .sort_by_key(|o| Reverse((o.stall, o.by_data + o.by_texture + o.by_tni + o.written)));
        let access = |(&(ref line, number), access): (&(Line, usize), &Access)| AccessProfile {
            file: line.0.clone(),
            line: line.1,
            object: self.objects[number].object.clone(),
            misses: access.misses,
            bytes: access.bytes,
            stall: access.stall,
        };
        let mut accesses: Vec<AccessProfile> = self.accesses.iter().map(access).collect();
        accesses.sort_by_key(|a| Reverse((a.stall, a.bytes)));
        let mut materials = self.materials.clone();
        materials.retain(|m| m.rays > 0);
        materials.sort_by_key(|m| Reverse(m.cycles));
        FrameProfile {
            objects,
            accesses,
            materials,
            levels: self.surroundings.levels.counts().to_vec(),
            energy: Vec::new(),
            energy_of_lines: Vec::new(),
            pipelines: Vec::new(),
        }
    }
}

/// The energy of a frame by what took it, most first, with the objects that moved to and from memory.
pub(super) fn energy(
    objects: &[ObjectProfile],
    report: &Report,
    program: &ScheduledDre,
    arch: &Arch,
) -> Vec<Use> {
    let moved = |o: &ObjectProfile| Use {
        of: format!("memory: {}", o.object),
        mj: energy::moved(o.by_data + o.by_texture + o.by_tni + o.written),
    };
    let mut all = energy::uses(report, program, arch);
    all.extend(objects.iter().map(moved));
    all.retain(|of| of.mj > 0.0);
    all.sort_by(|a, b| b.mj.total_cmp(&a.mj));
    all
}

/// The energy of what lines of the source do. Bundles take equal parts of that of VLIW code, as in the account.
pub(super) fn energy_of_lines(
    code: &[CodeProfile],
    accesses: &[AccessProfile],
    report: &Report,
    program: &ScheduledDre,
    arch: &Arch,
) -> Vec<LineEnergy> {
    let mut lines: BTreeMap<Line, f64> = BTreeMap::new();
    for (pos, mj) in energy::of_loops(report, program, arch) {
        let line = match pos.line {
            0 => Line::default(),
            number => (program.files[pos.file].clone(), number),
        };
        *lines.entry(line).or_default() += mj;
    }
    let bundles = |of: &CodeProfile| of.parts.vliw + of.parts.empty;
    let all: u64 = code.iter().map(bundles).sum();
    let each = energy::of_vliw_code(report, program, arch) / all.max(1) as f64;
    for of in code {
        let line = lines.entry((of.file.clone(), of.line)).or_default();
        *line += each * bundles(of) as f64;
    }
    for access in accesses {
        let line = lines.entry((access.file.clone(), access.line)).or_default();
        *line += energy::moved(access.bytes);
    }
    let lines = lines.into_iter().filter(|&(_, mj)| mj > 0.0);
    lines
        .map(|((file, line), mj)| LineEnergy { file, line, mj })
        .collect()
}

/// The pipelines of all T&I units, in the order of a ray's way.
pub(super) fn pipelines(report: &Report, system: &SystemSpec) -> Vec<PipelineProfile> {
    let counts = report.tni();
    let (trvs, ists) = (system.tni.trvs, system.tni.ists);
    let all = [
        ("TRV_PRE", trvs, counts.pre),
        ("TRV_AABB", trvs, counts.aabb),
        ("TRV_POST", trvs, counts.post),
        ("IST", ists, counts.ist),
    ];
    let pipeline = |(name, count, pipes): (&str, u32, PipeCounters)| PipelineProfile {
        pipeline: name.to_owned(),
        count,
        account: pipes.account,
    };
    all.into_iter().map(pipeline).collect()
}
