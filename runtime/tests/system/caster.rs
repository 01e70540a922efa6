//! An engine by hand that does what ray generation and shading do.

use glam::Vec3;
use srp_archdesc::ports;
use srp_runtime::core::{Activity, Bus, Core, Run, Trap};
use srp_runtime::memory::BASE;
use srp_runtime::tni::arithmetic::{NO_HIT, Ray};
use srp_runtime::tni::{HIT_BYTES, HitRecord, RAY_BYTES};

/// An engine that casts primary rays and paints each pixel by the normal it hits, one packet after
/// the other, with two packets in flight. It talks to the world only through the bus.
#[derive(Default)]
pub(super) struct Caster {
    step: Step,
    /// Tiles in flight, oldest first.
    tiles: Vec<u32>,
    sent: u32,
    no_more: bool,
    header: Vec<f32>,
}

#[derive(Clone, Copy, Default, PartialEq)]
enum Step {
    #[default]
    Header,
    Tile,
    Generate(u32),
    Start(u32),
    Collect,
    Shade,
}

pub(super) const RAYS: u32 = 64;
const HITS_AT: u32 = 3 * RAYS * RAY_BYTES;

impl Caster {
    fn float(&self, at: usize) -> f32 {
        self.header[at / 4]
    }

    fn word(&self, at: usize) -> u32 {
        self.float(at).to_bits()
    }

    fn vector(&self, at: usize) -> Vec3 {
        Vec3::new(self.float(at), self.float(at + 4), self.float(at + 8))
    }

    fn pixel(&self, tile: u32, i: u32) -> (u32, u32) {
        let (width, height) = (self.word(136), self.word(140));
        let (column, row) = (tile % self.word(144), tile / self.word(144));
        (column * width + i % width, row * height + i / width)
    }

    fn generate(&self, bus: &mut dyn Bus, tile: u32) {
        let buffer = (self.sent % 3) * RAYS * RAY_BYTES;
        for i in 0..RAYS {
            let (x, y) = self.pixel(tile, i);
            let direction =
                self.vector(16) + x as f32 * self.vector(32) + y as f32 * self.vector(48);
            let ray = Ray::new(
                self.vector(0).to_array(),
                direction.normalize().to_array(),
                0.0,
                self.float(188),
                0,
            );
            let at = (buffer + i * RAY_BYTES) as usize;
            for (bytes, word) in bus.sram()[at..].chunks_exact_mut(4).zip(ray.words()) {
                bytes.copy_from_slice(&word.to_le_bytes());
            }
        }
    }

    fn shade(&self, bus: &mut dyn Bus, buffer: u32, tile: u32) -> Option<()> {
        for i in 0..RAYS {
            let at = (HITS_AT + (buffer * RAYS + i) * HIT_BYTES) as usize;
            let mut words = [0; 6];
            for (word, bytes) in words.iter_mut().zip(bus.sram()[at..].chunks_exact(4)) {
                *word = u32::from_le_bytes(bytes.try_into().expect("4 bytes"));
            }
            let record = HitRecord::from_words(words);
            let colour = if record.hit.primitive == NO_HIT {
                self.vector(64)
            } else {
                let triangle = self.word(160) + 128 * record.hit.primitive;
                let mut normal = Vec3::ZERO;
                let weights = [
                    1.0 - record.hit.u - record.hit.v,
                    record.hit.u,
                    record.hit.v,
                ];
                for (k, weight) in weights.into_iter().enumerate() {
                    let lanes = bus.cached_load(triangle + 48 + 16 * k as u32, 16)?;
                    let n = [0, 1, 2].map(|i| f32::from_bits(lanes[i]));
                    normal += weight * Vec3::from(n);
                }
                0.5 * normal + 0.5
            };
            let [r, g, b] = colour.to_array().map(|c| u32::from((255.0 * c) as u8));
            let (x, y) = self.pixel(tile, record.ray);
            let address = self.word(156) + 4 * (y * self.word(152) + x);
            bus.cached_store(address, 4, [r | g << 8 | b << 16 | 255 << 24, 0, 0, 0])?;
        }
        Some(())
    }

    fn advance(&mut self, bus: &mut dyn Bus) -> Option<(Activity, u64)> {
        let waits = |port| Some((Activity::Wait(port), 1));
        match self.step {
            Step::Header => {
                let lanes = bus.cached_load(BASE + 4 * self.header.len() as u32, 16)?;
                self.header.extend(lanes.map(f32::from_bits));
                if self.header.len() * 4 == 224 {
                    self.step = Step::Tile;
                }
            }
            Step::Tile => {
                let tile = bus.port_in(ports::TILE)?;
                self.no_more = tile == u32::MAX;
                self.step = match (self.no_more, self.tiles.is_empty()) {
                    (false, _) => {
                        self.tiles.push(tile);
                        Step::Generate(tile)
                    }
                    (true, false) => Step::Collect,
                    (true, true) => return Some((Activity::Halted(0), 0)),
                };
            }
            Step::Generate(tile) => {
                self.generate(bus, tile);
                self.step = Step::Start(0);
                return Some((Activity::Array(0), 200));
            }
            Step::Start(n) => {
                let (port, value) = match n {
                    0 => (ports::TNI_RAYS, (self.sent % 3) * RAYS * RAY_BYTES),
                    1 => (
                        ports::TNI_HITS,
                        HITS_AT + (self.sent % 2) * RAYS * HIT_BYTES,
                    ),
                    _ => (ports::TNI_START, RAYS),
                };
                if !bus.port_out(port, value) {
                    return waits(port);
                }
                self.step = Step::Start(n + 1);
                if n == 2 {
                    self.sent += 1;
                    let full = self.tiles.len() == 2;
                    self.step = if full { Step::Collect } else { Step::Tile };
                }
            }
            Step::Collect => {
                if bus.port_in(ports::TNI_DONE).is_none() {
                    return waits(ports::TNI_DONE);
                }
                let counts = [
                    ports::TNI_SHADOW_MISSES,
                    ports::TNI_OTHER_HITS,
                    ports::TNI_OTHER_MISSES,
                ]
                .map(|port| bus.port_in(port).expect("counts do not wait"));
                assert_eq!(counts[0], 0);
                assert_eq!(counts[1] + counts[2], RAYS);
                self.step = Step::Shade;
            }
            Step::Shade => {
                let tile = self.tiles.remove(0);
                let buffer = (self.sent - 1 - self.tiles.len() as u32) % 2;
                self.shade(bus, buffer, tile)?;
                self.step = if self.no_more && self.tiles.is_empty() {
                    return Some((Activity::Halted(0), 0));
                } else if self.no_more {
                    Step::Collect
                } else {
                    Step::Tile
                };
                return Some((Activity::Array(1), 300));
            }
        }
        Some((Activity::Vliw, 1))
    }
}

impl Core for Caster {
    fn run(&mut self, bus: &mut dyn Bus, _budget: u64) -> Result<Run, Trap> {
        let (activity, cycles) = self.advance(bus).expect("every address is mapped");
        Ok(Run {
            cycles,
            activity,
            operations: cycles,
        })
    }
}
