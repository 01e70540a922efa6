//! The memory below the cores: its contents and its timing.
//!
//! The two are separate. The contents are one flat array of bytes ([`SystemMemory`]), always up
//! to date; caches ([`cache`]), bus and DRAM ([`path`], [`dram`]) only say when an access is over.

pub mod cache;
pub mod dram;
pub mod path;
pub mod unloaded;

/// First address of system memory. Below it there is none, so that an address of the SRAM, which
/// starts at 0, is never one of system memory.
pub const BASE: u32 = 0x8000_0000;

/// Most bytes of system memory.
pub const MAX_BYTES: usize = 1 << 30;

/// The contents of system memory: bytes from [`BASE`] on, little endian.
#[derive(Clone, Debug)]
pub struct SystemMemory {
    bytes: Vec<u8>,
    /// First address that cores may write to.
    writable_from: u32,
}

impl SystemMemory {
    /// Memory that holds `bytes`, at most [`MAX_BYTES`] of them.
    pub fn new(bytes: Vec<u8>) -> SystemMemory {
        assert!(bytes.len() <= MAX_BYTES, "system memory is bounded");
        SystemMemory {
            bytes,
            writable_from: BASE,
        }
    }

    /// The same memory, which cores may write only at `address` and above: a program gone astray must not
    /// change the tree under the T&I unit.
    pub fn writable_from(mut self, address: u32) -> SystemMemory {
        self.writable_from = address;
        self
    }

    /// Its size in bytes.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// True if it has no bytes.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// All of its bytes, from [`BASE`] on.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes that cores may write to.
    pub fn writable(&self) -> &[u8] {
        self.bytes.get(self.first_writable()..).unwrap_or_default()
    }

    /// The first address that cores may write to.
    pub fn first_writable_address(&self) -> u32 {
        self.writable_from
    }

    /// The same to write to.
    pub(crate) fn writable_mut(&mut self) -> &mut [u8] {
        let first = self.first_writable();
        self.bytes.get_mut(first..).unwrap_or_default()
    }

    fn first_writable(&self) -> usize {
        self.writable_from.saturating_sub(BASE) as usize
    }

    /// The bytes from `address` on, `size` of them; `None` where they are not all mapped.
    #[inline]
    pub fn get(&self, address: u32, size: u32) -> Option<&[u8]> {
        let start = address.checked_sub(BASE)? as usize;
        self.bytes.get(start..start + size as usize)
    }

    /// The same to write to; `None` also where that is not allowed.
    #[inline]
    pub fn get_mut(&mut self, address: u32, size: u32) -> Option<&mut [u8]> {
        if address < self.writable_from {
            return None;
        }
        let start = address.checked_sub(BASE)? as usize;
        self.bytes.get_mut(start..start + size as usize)
    }
}
