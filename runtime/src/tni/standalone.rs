//! One T&I unit alone with its memory: rays in, hits and counters out.

use srp_archdesc::system::SystemSpec;

use super::arithmetic::{self, Ray};
use super::{Client, HIT_BYTES, HitRecord, RAY_BYTES, Runs, Tni, TniCounters, Tree};
use crate::bvh::{Layout, TreeImage};
use crate::memory::dram::{DramCounters, Request};
use crate::memory::path::{Clock, MemoryPath};
use crate::memory::{BASE, SystemMemory};

/// What became of the rays.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The hits, in the order of the rays.
    pub hits: Vec<HitRecord>,
    /// The runs of each packet, in order.
    pub runs: Vec<Runs>,
    /// What the unit did.
    pub counters: TniCounters,
    /// What the memory did.
    pub dram: DramCounters,
    /// Cycles of the unit from the first ray to the last hit.
    pub cycles: u64,
}

/// Runs `rays` through one unit of the machine, in packets of the machine's size, as fast as it
/// takes them. The caches start empty.
pub fn drive(spec: &SystemSpec, tree: &TreeImage, rays: &[Ray]) -> Answer {
    let (memory, tree) = place(tree, spec);
    let widening = arithmetic::widening(srp_archdesc::arch::Approx::Exact);
    let mut tni = Tni::new(&spec.tni, tree, widening, spec.buffers.ray_buffers);
    let mut path = MemoryPath::new(spec);
    let clock = Clock::new(spec.tni_mhz);

    let packet = spec.buffers.rays.max(1);
    let buffers = spec.buffers.ray_buffers.max(1);
    let hit_base = buffers * packet * RAY_BYTES;
    let mut sram = vec![0; (hit_base + buffers * packet * HIT_BYTES) as usize];
    let mut answer = Answer {
        hits: Vec::with_capacity(rays.len()),
        runs: Vec::new(),
        counters: TniCounters::default(),
        dram: DramCounters::default(),
        cycles: 0,
    };
    let mut packets = rays.chunks(packet as usize);
    let mut waiting = packets.next();
    let (mut sent, mut now) = (0, 0);
    while waiting.is_some() || answer.hits.len() < rays.len() {
        if let Some(chunk) = waiting {
            let buffer = sent % buffers;
            let (from, to) = (
                buffer * packet * RAY_BYTES,
                hit_base + buffer * packet * HIT_BYTES,
            );
            // The buffer is free once its last submission has been taken.
            if tni.submissions() < buffers as usize {
                write_rays(&mut sram[from as usize..], chunk);
                tni.submit(from, to, chunk.len() as u32, sram.len())
                    .expect("the buffers lie inside the SRAM, and the unit has room");
                sent += 1;
                waiting = packets.next();
            }
        }
        serve_memory(&mut tni, &mut path, clock.start(now), now);
        tni.tick(now, &memory, &mut sram);
        while let Some((client, address, bytes)) = tni.take_request() {
            path.request(clock.start(now), request(client, address, bytes));
        }
        while let Some(runs) = tni.take_finished() {
            let buffer = answer.runs.len() as u32 % buffers;
            let at = (hit_base + buffer * packet * HIT_BYTES) as usize;
            take_hits(&sram[at..], &runs, &mut answer.hits);
            answer.runs.push(runs);
        }
        now += 1;
    }
    answer.counters = tni.counters();
    answer.dram = path.counters();
    answer.cycles = now;
    answer
}

/// The tree in a memory of its own.
fn place(tree: &TreeImage, spec: &SystemSpec) -> (SystemMemory, Tree) {
    let Layout {
        node_bytes,
        triangle_bytes,
    } = tree.layout;
    assert!(
        node_bytes == spec.tni.node_bytes && triangle_bytes == spec.tni.triangle_bytes,
        "the tree is laid out for the machine"
    );
    let mut bytes = tree.nodes.clone();
    bytes.resize(bytes.len().next_multiple_of(64), 0);
    let triangles = BASE + bytes.len() as u32;
    bytes.extend_from_slice(&tree.triangles);
    let placed = Tree {
        root: tree.root,
        nodes: BASE,
        triangles,
    };
    (SystemMemory::new(bytes), placed)
}

fn serve_memory(tni: &mut Tni, path: &mut MemoryPath, time: u64, now: u64) {
    while let Some(answer) = path.answer(time) {
        let client = match answer.source {
            0 => Client::TrvL2,
            i => Client::IstL1(i - 1),
        };
        tni.fill(now, client, answer.address);
    }
}

fn request(client: Client, address: u32, bytes: u32) -> Request {
    Request {
        address,
        bytes,
        is_write: false,
        source: match client {
            Client::TrvL2 => 0,
            Client::IstL1(i) => i + 1,
        },
    }
}

fn write_rays(sram: &mut [u8], rays: &[Ray]) {
    let words = rays.iter().flat_map(|ray| ray.words());
    for (bytes, word) in sram.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
}

/// Appends the hits of a packet in the order of its rays.
fn take_hits(sram: &[u8], runs: &Runs, hits: &mut Vec<HitRecord>) {
    let count = runs.shadow_hits + runs.shadow_misses + runs.other_hits + runs.other_misses;
    let mut packet: Vec<HitRecord> = sram
        .chunks_exact(HIT_BYTES as usize)
        .take(count as usize)
        .map(|bytes| {
            let mut words = [0; 6];
            for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
                *word = u32::from_le_bytes(bytes.try_into().expect("chunks of 4 bytes"));
            }
            HitRecord::from_words(words)
        })
        .collect();
    packet.sort_by_key(|record| record.ray);
    hits.append(&mut packet);
}
