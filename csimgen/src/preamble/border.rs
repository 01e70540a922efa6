//! The bus as an engine sees it in a cycle: accesses are checked here, the same way for all
//! engines.

use super::core_border::{Bus, TrapKind};
use super::ops::{V4, texture};
use std::ops::Range;

/// A fault of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The kind.
    pub kind: TrapKind,
    /// Where: a number in the program's list of positions.
    pub at: u32,
}

/// Why a bundle has not been issued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// It cannot be.
    Fault(Fault),
    /// A port is not ready.
    Wait(u32),
    /// It talks to a port, and cycles have passed that the bus does not know of yet.
    Behind,
}

impl Fault {
    /// The fault of code that must not be reached.
    pub fn unreachable(at: u32) -> Fault {
        Fault {
            kind: TrapKind::Unreachable,
            at,
        }
    }

    /// The fault of a stack that has run into the data below it.
    pub fn stack_overflow(at: u32) -> Fault {
        Fault {
            kind: TrapKind::StackOverflow,
            at,
        }
    }
}

/// The result of a division, which is a fault where there is none.
#[inline(always)]
pub fn divided<T>(result: Option<T>, at: u32) -> Result<T, Fault> {
    result.ok_or(Fault {
        kind: TrapKind::DivisionByZero,
        at,
    })
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Stop {
        Stop::Fault(fault)
    }
}

/// The banks of the SRAM: words of `width` bytes take turns among `count` of them, and each does one access a cycle. With
/// a `count` of 0 all accesses find theirs free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Banks {
    /// A power of two up to [`MAX_BANKS`], or 0.
    pub count: u32,
    /// A power of two.
    pub width: u32,
}

/// Most banks that an SRAM may have.
pub const MAX_BANKS: usize = 64;

/// The bus, with the facts about accesses that an engine needs.
#[derive(Debug)]
pub struct Border<'a, B: ?Sized> {
    bus: &'a mut B,
    first_address: u32,
    accessed: bool,
    banks: Banks,
    /// Accesses of this cycle to each bank, and to the one that has most.
    uses: [u16; MAX_BANKS],
    most: u16,
    /// Cycles that banks have cost so far.
    lost: u64,
}

impl<'a, B: Bus + ?Sized> Border<'a, B> {
    /// The border to `bus`; SRAM accesses below `first_address` are faults.
    #[inline(always)]
    pub fn new(bus: &'a mut B, first_address: u32, banks: Banks) -> Border<'a, B> {
        Border {
            bus,
            first_address,
            accessed: false,
            banks,
            uses: [0; MAX_BANKS],
            most: 0,
            lost: 0,
        }
    }

    /// Cycles for which banks of the SRAM have kept the core in the cycles since [`new`](Self::new).
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Ends a cycle. True if an access of it has stalled the core.
    #[inline(always)]
    pub fn cycle_stalled(&mut self) -> bool {
        if self.most > 0 {
            self.free_banks();
        }
        std::mem::take(&mut self.accessed) && self.bus.stalled()
    }

    fn free_banks(&mut self) {
        let lost = u32::from(std::mem::take(&mut self.most)) - 1;
        self.uses = [0; MAX_BANKS];
        if lost > 0 {
            self.lost += u64::from(lost);
            self.accessed = true;
            self.bus.conflict(lost);
        }
    }

    /// Takes the banks of an access.
    fn take_banks(&mut self, address: u32, bytes: u32) {
        let Banks { count, width } = self.banks;
        for word in address / width..=(address + (bytes - 1)) / width {
            let uses = &mut self.uses[(word % count) as usize];
            *uses = uses.saturating_add(1);
            self.most = self.most.max(*uses);
        }
    }

    /// `N` bytes of SRAM, or zeros where the guard is false.
    #[inline(always)]
    fn sram<const N: usize>(&mut self, address: u32, at: u32) -> Result<&mut [u8; N], Fault> {
        let first_address = self.first_address;
        let start = address as usize;
        let mapped = address >= first_address && address.is_multiple_of(N as u32);
        if self.banks.count > 0 && mapped {
            self.take_banks(address, N as u32);
        }
        let bytes = self.bus.sram().get_mut(start..start.wrapping_add(N));
        match bytes.and_then(|bytes| <&mut [u8; N]>::try_from(bytes).ok()) {
            Some(bytes) if mapped => Ok(bytes),
            _ => Err(access(address, N as u32, at)),
        }
    }

    /// Loads 1, 2 or 4 bytes of SRAM, zero-extended; zero where the guard is false.
    #[inline(always)]
    pub fn load<const N: usize>(
        &mut self,
        guard: bool,
        address: u32,
        offset: u32,
        at: u32,
    ) -> Result<u32, Fault> {
        if !guard {
            return Ok(0);
        }
        let bytes = self.sram::<N>(address.wrapping_add(offset), at)?;
        let mut word = [0; 4];
        word[..N].copy_from_slice(bytes);
        Ok(u32::from_le_bytes(word))
    }

    /// Loads a vector from SRAM; zero where the guard is false.
    #[inline(always)]
    pub fn load_vec(
        &mut self,
        guard: bool,
        address: u32,
        offset: u32,
        at: u32,
    ) -> Result<V4, Fault> {
        if !guard {
            return Ok(V4::default());
        }
        let bytes = self.sram::<16>(address.wrapping_add(offset), at)?;
        let (words, _) = bytes.as_chunks::<4>();
        Ok(V4(std::array::from_fn(|i| u32::from_le_bytes(words[i]))))
    }

    /// Stores the low 1, 2 or 4 bytes of a word into SRAM, if the guard is true.
    #[inline(always)]
    pub fn store<const N: usize>(
        &mut self,
        guard: bool,
        address: u32,
        value: u32,
        offset: u32,
        at: u32,
    ) -> Result<(), Fault> {
        if guard {
            let bytes = self.sram::<N>(address.wrapping_add(offset), at)?;
            bytes.copy_from_slice(&value.to_le_bytes()[..N]);
        }
        Ok(())
    }

    /// Stores a vector into SRAM, if the guard is true.
    #[inline(always)]
    pub fn store_vec(
        &mut self,
        guard: bool,
        address: u32,
        value: V4,
        offset: u32,
        at: u32,
    ) -> Result<(), Fault> {
        if guard {
            let bytes = self.sram::<16>(address.wrapping_add(offset), at)?;
            for (bytes, word) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(value.0) {
                *bytes = word.to_le_bytes();
            }
        }
        Ok(())
    }

    /// Loads `N` bytes of system memory, zero-extended; zero where the guard is false.
    #[inline(always)]
    pub fn cached_load<const N: usize>(
        &mut self,
        guard: bool,
        address: u32,
        offset: u32,
        at: u32,
    ) -> Result<V4, Fault> {
        if !guard {
            return Ok(V4::default());
        }
        let address = address.wrapping_add(offset);
        self.accessed = true;
        match self.bus.cached_load(address, N as u32) {
            Some(lanes) => Ok(V4(lanes)),
            None => Err(access(address, N as u32, at)),
        }
    }

    /// Stores the low `N` bytes of a value into system memory, if the guard is true.
    #[inline(always)]
    pub fn cached_store<const N: usize>(
        &mut self,
        guard: bool,
        address: u32,
        value: V4,
        offset: u32,
        at: u32,
    ) -> Result<(), Fault> {
        if !guard {
            return Ok(());
        }
        let address = address.wrapping_add(offset);
        self.accessed = true;
        match self.bus.cached_store(address, N as u32, value.0) {
            Some(()) => Ok(()),
            None => Err(access(address, N as u32, at)),
        }
    }

    /// Asks for a line of system memory ahead, if the guard is true.
    #[inline(always)]
    pub fn prefetch(&mut self, guard: bool, address: u32) {
        if guard {
            self.accessed = true;
            self.bus.prefetch(address);
        }
    }

    /// The texel that the texture unit returns; zero where the guard is false.
    pub fn texture(
        &mut self,
        guard: bool,
        descriptor: u32,
        uv: V4,
        weight_bits: u32,
        at: u32,
    ) -> Result<V4, Fault> {
        if !guard {
            return Ok(V4::default());
        }
        if descriptor == 0 {
            return Ok(texture::NO_TEXTURE);
        }
        self.accessed = true;
        let Some(words) = self.bus.texture_descriptor(descriptor) else {
            return Err(access(descriptor, 16, at));
        };
        let footprint = texture::footprint(V4(words), uv, weight_bits);
        match self.bus.texels(footprint.addresses) {
            Ok(texels) => Ok(texture::filter(V4(texels), footprint.weights, weight_bits)),
            Err(address) => Err(access(address, 4, at)),
        }
    }

    /// A bundle is issued: the bundles that can be next without asking again.
    pub fn fetch(&mut self, bundle: u32) -> Range<u32> {
        self.accessed = true;
        self.bus.fetch(bundle)
    }

    /// A kernel is launched.
    pub fn launch(&mut self, kernel: u32) {
        self.bus.launch(kernel);
    }

    /// Takes a word from an input port.
    pub fn port_in(&mut self, port: u32) -> Result<u32, Stop> {
        self.accessed = true;
        self.bus.port_in(port).ok_or(Stop::Wait(port))
    }

    /// Gives a word to an output port.
    pub fn port_out(&mut self, port: u32, value: u32) -> Result<(), Stop> {
        self.accessed = true;
        if self.bus.port_out(port, value) {
            Ok(())
        } else {
            Err(Stop::Wait(port))
        }
    }
}

#[cold]
fn access(address: u32, bytes: u32, at: u32) -> Fault {
    Fault {
        kind: TrapKind::Access { address, bytes },
        at,
    }
}
