//! The history of a pixel: every operation, ray and hit that its value was made of.
//!
//! It is a dynamic slice (Korel and Laski 1988) of a [window](crate::Trace) on one core, from the last store to the
//! pixel backwards, and thin (Sridharan, Fink and Bodík 2007): what a value was computed from is followed, through
//! registers, the SRAM, and the T&I unit from a hit to its ray. What an address or a guard was computed from is
//! followed too, but not from iteration to iteration, nor through what VLIW code keeps in memory: loop counters and the
//! queue of packets make no pixel. A counter is told where it is read, and not how it came to its number. Values from
//! before the window have no origin here.

mod links;
mod numbering;
mod slice;
mod watch;

use crate::event::{Event, What, is_access};
use crate::replay::replay;
use crate::trace::Trace;
use links::Links;
use numbering::{Numbering, Thing};
use srp_archdesc::isa::{Opcode, Ty};
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::spec::Position;
use srp_runtime::tni::arithmetic::Ray;
use srp_runtime::tni::{HitRecord, RAY_BYTES, RayCost};
use std::collections::BTreeMap;

pub use slice::Want;
pub use watch::{StoreWatch, Stored};

/// Something that a pixel was made of.
#[derive(Clone, Debug)]
pub struct Made {
    /// Its number; later things have larger ones.
    pub id: u32,
    /// The SRP cycle in which an operation is issued, or a ray is sent.
    pub cycle: u64,
    /// What it is.
    pub what: MadeWhat,
    /// What the pixel has of it.
    pub want: Want,
    /// The things of the history that it was made of, by their numbers.
    pub from: Vec<u32>,
}

/// What a pixel was made of.
#[derive(Clone, Debug)]
pub enum MadeWhat {
    /// An operation.
    Operation(Operation),
    /// A ray, and what it has found.
    Ray(Box<TracedRay>),
}

/// An operation with its values.
#[derive(Clone, Debug)]
pub struct Operation {
    /// Where it was done.
    pub place: Place,
    /// The operation.
    pub opcode: Opcode,
    /// Its place in the source.
    pub at: Position,
    /// Its operands, with their types.
    pub operands: Vec<(V4, Ty)>,
    /// Its result.
    pub result: Option<(V4, Ty)>,
    /// The address of an access that it makes; of a texture sample that of the descriptor.
    pub address: Option<u32>,
}

/// Where an operation is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// In VLIW code, in this bundle.
    Bundle(u32),
    /// On the array.
    Array {
        /// The kernel.
        kernel: u32,
        /// The launch, the core's first of that kernel being 1.
        launch: u64,
        /// The iteration.
        iteration: u64,
    },
}

/// A ray that was traced.
#[derive(Clone, Debug)]
pub struct TracedRay {
    /// Its packet, the core's first being 0.
    pub packet: u64,
    /// Its place in the ray buffer.
    pub index: u32,
    /// The ray.
    pub ray: Ray,
    /// The cycle in which its packet was taken back.
    pub returned: u64,
    /// What it has hit.
    pub hit: HitRecord,
    /// Its way through the T&I unit, and the SRP cycle in which it was over, if that was run cycle by cycle.
    pub cost: Option<(u64, RayCost)>,
}

/// The history of the four bytes at an address of the memory that all cores share. The trace is of one core, and
/// `launches` are those of each kernel before. Nothing, where nothing was stored there in the window.
pub fn history(trace: &Trace, launches: &[u64], address: u32) -> Vec<Made> {
    let links = Links::of(trace, launches);
    let mut collected = Collected {
        wanted: slice::slice(&links, links.writers(address)),
        made: BTreeMap::new(),
        rays: BTreeMap::new(),
    };
    drop(links);
    let mut numbering = Numbering::new(launches);
    replay(trace, &mut |event| {
        if let Some((first, thing)) = numbering.take(&event) {
            collected.take(&event, first, thing);
        }
    });
    collected.made.into_values().collect()
}

/// The things of a history, as far as they are known.
struct Collected {
    wanted: BTreeMap<u32, (Want, Vec<u32>)>,
    made: BTreeMap<u32, Made>,
    /// The numbers of rays, by packet and place.
    rays: BTreeMap<(u64, u32), u32>,
}

impl Collected {
    fn take(&mut self, event: &Event<'_>, first: u32, thing: Thing<'_>) {
        match (thing, event.what) {
            (Thing::Operation(place), What::Step(done)) => {
                let what = || MadeWhat::Operation(operation(place, &done));
                self.add(first, event.cycle, what);
            }
            (Thing::Operation(_), _) => {}
            (Thing::Packet(packet), _) => {
                let rays = packet.rays.chunks_exact(RAY_BYTES as usize);
                for (index, bytes) in (0..).zip(rays) {
                    let what = || MadeWhat::Ray(Box::new(sent(packet.number, index, bytes)));
                    self.add(first + index, event.cycle, what);
                    self.rays.insert((packet.number, index), first + index);
                }
            }
            (Thing::Hits(number, hits), _) => {
                for hit in hits {
                    if let Some(ray) = self.ray((number, hit.ray)) {
                        (ray.returned, ray.hit) = (event.cycle, *hit);
                    }
                }
            }
            (Thing::Cost(cost), _) => {
                if let Some(ray) = self.ray((cost.submission, cost.index)) {
                    ray.cost = Some((event.cycle, *cost));
                }
            }
        }
    }

    fn add(&mut self, id: u32, cycle: u64, what: impl FnOnce() -> MadeWhat) {
        if let Some((want, from)) = self.wanted.get(&id) {
            let (want, from, what) = (*want, from.clone(), what());
            let made = Made {
                id,
                cycle,
                want,
                from,
                what,
            };
            self.made.insert(id, made);
        }
    }

    fn ray(&mut self, of: (u64, u32)) -> Option<&mut TracedRay> {
        let id = self.rays.get(&of)?;
        match &mut self.made.get_mut(id)?.what {
            MadeWhat::Ray(ray) => Some(ray),
            MadeWhat::Operation(_) => None,
        }
    }
}

/// A ray as it is sent, which has found nothing yet.
fn sent(packet: u64, index: u32, bytes: &[u8]) -> TracedRay {
    let mut words = [0; 16];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().unwrap_or_default());
    }
    let ray = Ray::from_words(words);
    TracedRay {
        packet,
        index,
        ray,
        returned: 0,
        hit: HitRecord::from_words([0, 0, 0, u32::MAX, index, ray.flags]),
        cost: None,
    }
}

fn operation(place: Place, done: &crate::event::Done<'_>) -> Operation {
    let opcode = done.step.opcode().unwrap_or(Opcode::Mov);
    let kinds = opcode.info().operands.iter().map(|kind| kind.ty());
    Operation {
        place,
        opcode,
        at: done.step.at,
        operands: done.operands.into_iter().zip(kinds).collect(),
        result: done.step.ty.map(|ty| (done.value, ty)),
        address: done.address().filter(|_| is_access(done.step)),
    }
}
