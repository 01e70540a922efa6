//! [`FlatWorld`]: two byte arrays and port queues, a world without time.

use super::{PortOut, World};
use crate::layout::Layout;
use srp_archdesc::isa::Space;
use srp_archdesc::ops::Value;
use srp_archdesc::ports;
use std::collections::{BTreeMap, VecDeque};

/// Where system memory begins.
pub const SYSTEM_BASE: u32 = 0x8000_0000;

/// Words kept of those given to output ports, so that a program that writes for ever takes no memory.
const MAX_KEPT: usize = 1 << 20;

/// SRAM and system memory as byte arrays, and queues for the ports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FlatWorld {
    /// SRAM from address 0.
    pub sram: Vec<u8>,
    /// System memory from [`SYSTEM_BASE`].
    pub memory: Vec<u8>,
    /// Words that wait at input ports.
    pub inputs: BTreeMap<u32, VecDeque<u32>>,
    /// Words given to output ports, but characters and the exit status: the first [`MAX_KEPT`] of all.
    pub outputs: BTreeMap<u32, Vec<u32>>,
    /// How many those are.
    kept: usize,
    /// Characters given to [`ports::PUTCHAR`].
    pub output: Vec<u8>,
}

impl FlatWorld {
    /// SRAM of `sram_bytes` with the image of the layout at its start, and no system memory.
    pub fn new(layout: &Layout, sram_bytes: u32) -> FlatWorld {
        let mut sram = layout.image.clone();
        sram.resize(sram.len().max(sram_bytes as usize), 0);
        FlatWorld {
            sram,
            ..FlatWorld::default()
        }
    }

    /// The bytes of an access, if they are mapped and aligned.
    fn bytes(&mut self, space: Space, address: u32, bytes: u32) -> Option<&mut [u8]> {
        let (memory, at) = match space {
            Space::Sram => (&mut self.sram, address),
            Space::Cached => (&mut self.memory, address.checked_sub(SYSTEM_BASE)?),
        };
        if !address.is_multiple_of(bytes) {
            return None;
        }
        if space == Space::Sram && address < crate::layout::FIRST_ADDRESS {
            return None;
        }
        let at = at as usize;
        memory.get_mut(at..at + bytes as usize)
    }
}

impl World for FlatWorld {
    fn load(&mut self, space: Space, address: u32, bytes: u32) -> Option<Value> {
        let bytes = self.bytes(space, address, bytes)?;
        let mut lanes = Value::default();
        for (i, &byte) in bytes.iter().enumerate() {
            lanes.0[i / 4] |= u32::from(byte) << (8 * (i % 4));
        }
        Some(lanes)
    }

    fn store(&mut self, space: Space, address: u32, bytes: u32, value: Value) -> Option<()> {
        let bytes = self.bytes(space, address, bytes)?;
        for (i, byte) in bytes.iter_mut().enumerate() {
            *byte = (value.0[i / 4] >> (8 * (i % 4))) as u8;
        }
        Some(())
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        self.inputs.get_mut(&port)?.pop_front()
    }

    fn port_out(&mut self, port: u32, value: u32) -> PortOut {
        match port {
            ports::EXIT => return PortOut::Exit(value as i32),
            ports::PUTCHAR => self.output.push(value as u8),
            _ if self.kept < MAX_KEPT => {
                self.kept += 1;
                self.outputs.entry(port).or_default().push(value);
            }
            _ => {}
        }
        PortOut::Taken
    }
}
