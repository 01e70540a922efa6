//! Numbers for all that is done in a window: the same each time it is replayed.

use super::Place;
use crate::event::{Event, Outside, Packet, Turn, What};
use srp_archdesc::isa::Opcode;
use srp_csimgen::spec::{Origin, Step};
use srp_runtime::tni::{HitRecord, RayCost};

/// Something that has to do with numbers.
pub(super) enum Thing<'t> {
    /// An operation, which gets a number.
    Operation(Place),
    /// A packet of rays, each of which gets a number.
    Packet(&'t Packet),
    /// The hits of a packet.
    Hits(u64, &'t [HitRecord]),
    /// The way of a ray.
    Cost(&'t RayCost),
}

/// Gives out numbers.
pub(super) struct Numbering {
    next: u32,
    /// Launches of each kernel so far.
    launches: Vec<u64>,
    /// The kernel on the array, and the iteration that has begun last.
    on_array: Option<(u32, u64)>,
    bundle: u32,
}

impl Numbering {
    /// Launches of each kernel before the window.
    pub(super) fn new(launches: &[u64]) -> Numbering {
        Numbering {
            next: 0,
            launches: launches.to_vec(),
            on_array: None,
            bundle: 0,
        }
    }

    /// Goes on by an event. What has to do with numbers, and the first of its own.
    pub(super) fn take<'t>(&mut self, event: &Event<'t>) -> Option<(u32, Thing<'t>)> {
        let (count, thing) = match event.what {
            What::Turn(turn) => {
                self.turn(turn);
                return None;
            }
            What::Step(done) if is_operation(done.step) => {
                let place = match self.on_array {
                    None => Place::Bundle(self.bundle),
                    Some((kernel, begun)) => Place::Array {
                        kernel,
                        launch: self.launches.get(kernel as usize).copied().unwrap_or(0),
                        iteration: done.iteration.unwrap_or(begun),
                    },
                };
                (1, Thing::Operation(place))
            }
            What::Outside(Outside::PacketSent(packet)) => {
                (packet.buffers.count, Thing::Packet(packet))
            }
            What::Outside(Outside::PacketReturned(number, hits)) => (0, Thing::Hits(*number, hits)),
            What::Outside(Outside::Ray(cost)) => (0, Thing::Cost(cost)),
            _ => return None,
        };
        let first = self.next;
        self.next += count;
        Some((first, thing))
    }

    fn turn(&mut self, turn: Turn) {
        match turn {
            Turn::Bundle(bundle) => {
                self.bundle = bundle;
                self.on_array = None;
            }
            Turn::Context {
                kernel, iteration, ..
            } => {
                if self.on_array.is_none_or(|(on, _)| on != kernel) {
                    let needed = self.launches.len().max(kernel as usize + 1);
                    self.launches.resize(needed, 0);
                    self.launches[kernel as usize] += 1;
                }
                self.on_array = Some((kernel, iteration));
            }
        }
    }
}

/// True if a step makes a value, or writes one to memory, and does not only bring it to another place.
pub(super) fn is_operation(step: &Step) -> bool {
    let is_move = matches!(
        step.opcode(),
        None | Some(Opcode::Mov | Opcode::Pmov | Opcode::Vmov)
    );
    matches!(step.origin, Origin::Unit { .. }) && !is_move
}
