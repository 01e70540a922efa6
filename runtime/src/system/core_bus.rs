//! The bus of an engine: its core as the engine sees it, and the parts that cores share.

use srp_archdesc::ports;
use std::ops::Range;

use super::TileQueue;
use super::code::CodeLayout;
use super::core_unit::{Periphery, Ports};
use super::observer::{CoreView, Observer, SentPacket, TakenTile};
use super::sharing::Sharing;
use super::warm::WarmCaches;
use crate::core::{Bus, Lanes};
use crate::memory::SystemMemory;
use crate::memory::path::Clock;
use crate::tni::{Buffers, RAY_BYTES, SubmitError, Unit};

/// The parts that all cores share.
pub(super) struct Shared<'o> {
    pub(super) memory: SystemMemory,
    pub(super) sharing: Sharing,
    pub(super) tiles: TileQueue,
    pub(super) code: CodeLayout,
    pub(super) srp: Clock,
    pub(super) tni: Clock,
    pub(super) observer: Option<&'o mut dyn Observer>,
}

impl Shared<'_> {
    /// Tells the observer, where there is one, of an event.
    #[inline]
    pub(super) fn tell(
        &mut self,
        core: &Periphery,
        cycle: u64,
        event: impl FnOnce(&mut dyn Observer, &CoreView<'_>),
    ) {
        if let Some(observer) = &mut self.observer {
            event(&mut **observer, &core.view(cycle));
        }
    }

    /// The first SRP cycle in which the oldest packet of a T&I unit is back, where that is known.
    pub(super) fn back(&self, unit: &Unit) -> Option<u64> {
        let cycle = unit.back()?;
        Some(self.srp.cycle_from(self.tni.start(cycle)))
    }
}

/// A core as its engine sees it in a cycle.
pub(super) struct CoreBus<'a, 'o> {
    pub(super) now: u64,
    pub(super) core: &'a mut Periphery,
    pub(super) shared: &'a mut Shared<'o>,
}

/// True if an access of this size may be made at this address.
fn is_aligned(address: u32, bytes: u32) -> bool {
    matches!(bytes, 1 | 2 | 4 | 16) && address.is_multiple_of(bytes)
}

impl CoreBus<'_, '_> {
    /// Makes the caches hold this; what was written goes to memory.
    fn hold(&mut self, caches: &WarmCaches) {
        let core = &mut self.core;
        core.data.flush();
        core.data.cache.hold_lines_of(&caches.data);
        core.texture.lines.cache.hold_lines_of(&caches.texture);
        core.tni.hold(&caches.tni);
    }

    /// Takes the next tile.
    fn take_tile(&mut self) -> u32 {
        let taken = self.shared.tiles.take(self.core.number);
        let told = taken.as_ref().map(|&(place, ref queued)| TakenTile {
            place,
            tile: queued.tile,
        });
        self.shared
            .tell(self.core, self.now, |o, core| o.tile_taken(core, told));
        let Some((_, queued)) = taken else {
            return u32::MAX;
        };
        if let Some(caches) = &queued.caches {
            self.hold(caches);
        }
        queued.tile
    }

    /// Sends a packet to the T&I unit; whether that takes it.
    fn send_packet(&mut self, count: u32) -> bool {
        let CoreBus { now, core, shared } = self;
        let Ports { rays, hits, .. } = core.ports;
        let buffers = Buffers { rays, hits, count };
        let cycle = shared.tni.cycle_from(shared.srp.start(*now));
        match core
            .tni
            .submit(cycle, buffers, &shared.memory, &mut core.sram)
        {
            Ok(()) => {}
            Err(SubmitError::Busy) => return false,
            // The system stops after this run.
            Err(fault) => {
                core.ports.fault = Some(fault);
                return true;
            }
        }
        core.banks.rays_leave(count);
        let packet = core.ports.sent;
        core.ports.sent += 1;
        shared.tell(core, *now, |observer, view| {
            let buffer = core.sram.get(rays as usize..).unwrap_or_default();
            let sent = SentPacket {
                number: packet,
                buffers,
                rays: &buffer[..buffer.len().min(count as usize * RAY_BYTES as usize)],
            };
            observer.packet_sent(view, &sent);
        });
        if !core.tni.waits_for_lines() {
            while let Some(request) = core.next_line() {
                shared.tell(core, *now, |o, view| o.requested(view, &request));
            }
        }
        true
    }

    /// Takes the hits of the oldest packet, where it is back: its shadow hits.
    fn take_packet(&mut self) -> Option<u32> {
        let CoreBus { now, core, shared } = self;
        if shared.back(&core.tni).is_some_and(|back| back > *now) {
            return None;
        }
        let mut finished = core.tni.take_finished()?;
        let packet = core.ports.returned;
        core.ports.returned += 1;
        core.ports.runs = finished.runs;
        core.banks.hits_arrive(finished.hits.len());
        shared.tell(core, *now, |observer, view| {
            observer.packet_returned(view, packet, &finished.hits);
        });
        core.ports.taken.append(&mut finished.hits);
        Some(core.ports.runs.shadow_hits)
    }

    /// A value in system memory, zero-extended.
    fn words(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        let Shared {
            memory, sharing, ..
        } = self.shared;
        let source = memory.get(address, bytes)?;
        sharing.used(self.core.number, address, bytes, false);
        let mut padded = [0; 16];
        padded[..bytes as usize].copy_from_slice(source);
        let word = |i: usize| {
            let bytes = padded[4 * i..4 * i + 4].try_into();
            u32::from_le_bytes(bytes.expect("a word has 4 bytes"))
        };
        Some([word(0), word(1), word(2), word(3)])
    }
}

impl Bus for CoreBus<'_, '_> {
    fn sram(&mut self) -> &mut [u8] {
        &mut self.core.sram
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        if !is_aligned(address, bytes) {
            return None;
        }
        let value = self.words(address, bytes)?;
        self.core.data.load(address);
        Some(value)
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        if !is_aligned(address, bytes) {
            return None;
        }
        let target = self.shared.memory.get_mut(address, bytes)?;
        for (byte, value) in target
            .iter_mut()
            .zip(value.iter().flat_map(|w| w.to_le_bytes()))
        {
            *byte = value;
        }
        let core = &mut self.core;
        (self.shared.sharing).used(core.number, address, bytes, true);
        core.data.store(address, bytes);
        self.shared.tell(self.core, self.now, |o, core| {
            o.stored(core, address, bytes)
        });
        Some(())
    }

    fn prefetch(&mut self, address: u32) {
        if self.shared.memory.get(address, 1).is_some() {
            self.core.data.prefetch(address);
        }
    }

    fn conflict(&mut self, cycles: u32) {
        self.core.banks.conflict(cycles);
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        if !is_aligned(address, 16) {
            return None;
        }
        let words = self.words(address, 16)?;
        self.core.texture.descriptor(address);
        Some(words)
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        let mut texels = Lanes::default();
        for (texel, address) in texels.iter_mut().zip(addresses) {
            let word = is_aligned(address, 4).then(|| self.words(address, 4));
            *texel = word.flatten().ok_or(address)?[0];
        }
        self.core.texture.texels(addresses);
        Ok(texels)
    }

    fn fetch(&mut self, bundle: u32) -> Range<u32> {
        self.core.code.fetch(bundle, &self.shared.code)
    }

    fn launch(&mut self, kernel: u32) {
        self.core.code.launch(kernel, &self.shared.code);
    }

    /// Also true when the program has ended, so that the engine goes no further.
    fn stalled(&self) -> bool {
        let Periphery {
            data,
            texture,
            code,
            ports,
            banks,
            ..
        } = &*self.core;
        let waits = data.ends_run() || texture.lines.ends_run() || code.waits().is_some();
        waits || banks.owed > 0 || ports.exit.is_some()
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        let runs = &self.core.ports.runs;
        match port {
            ports::TILE => Some(self.take_tile()),
            ports::TNI_DONE => self.take_packet(),
            ports::TNI_SHADOW_MISSES => Some(runs.shadow_misses),
            ports::TNI_OTHER_HITS => Some(runs.other_hits),
            ports::TNI_OTHER_MISSES => Some(runs.other_misses),
            ports::CORE => Some(self.core.number),
            _ => None,
        }
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        let ports = &mut self.core.ports;
        match port {
            ports::TNI_RAYS => ports.rays = value,
            ports::TNI_HITS => ports.hits = value,
            ports::TNI_START => return self.send_packet(value),
            ports::PUTCHAR => ports.output.push(value as u8),
            ports::EXIT => ports.exit = Some(value as i32),
            _ => return false,
        }
        true
    }
}
