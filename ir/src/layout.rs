//! Where globals live: one answer for the interpreter, the scheduler and the debugger.

use crate::dre::scheduled::{DataSymbol, FUNC_BASE};
use crate::program::{Global, Program, Symbol};
use srp_archdesc::entity::{Entity, EntityMap};

/// Addresses below this are never mapped, so that a null pointer traps.
pub const FIRST_ADDRESS: u32 = 64;

/// Bytes at both ends of the mapped SRAM that hold no object, so that a load this near to an object
/// never traps.
pub const RED_ZONE: u32 = 64;

/// Bytes that the stack has at least; globals that leave less do not fit.
pub const MIN_STACK: u32 = 4096;

/// Globals in SRAM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The address of each global.
    pub addresses: EntityMap<Global, u32>,
    /// Initial contents of SRAM from address 0 to the end of the globals.
    pub image: Vec<u8>,
    /// Top of the stack, which grows downwards to the end of the image.
    pub stack_top: u32,
}

/// The globals do not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// Bytes that the globals and the smallest stack need.
    pub needed: u64,
    /// Bytes of SRAM.
    pub available: u32,
    /// The largest global, and its bytes.
    pub largest: Option<(String, u32)>,
}

impl std::fmt::Display for TooLarge {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (needed, available) = (self.needed, self.available);
        write!(
            f,
            "the program's globals and a stack of {MIN_STACK} bytes need {needed} bytes of SRAM"
        )?;
        if let Some((name, bytes)) = &self.largest {
            write!(f, ", `{name}` alone {bytes} of them")?;
        }
        write!(
            f,
            "; the machine has {available}: give it a larger `<sram size=\"…\"/>`"
        )
    }
}

impl std::error::Error for TooLarge {}

impl Layout {
    /// Lays out the globals of `program` in their order in an SRAM of `sram_bytes` bytes.
    pub fn of(program: &Program, sram_bytes: u32) -> Result<Layout, TooLarge> {
        let mut next = u64::from(FIRST_ADDRESS + RED_ZONE);
        let mut addresses = EntityMap::new();
        for global in program.globals.values() {
            next = next.next_multiple_of(u64::from(global.align.max(1)));
            addresses.push(u32::try_from(next).unwrap_or(u32::MAX));
            next += u64::from(global.size);
        }
        let end = next.next_multiple_of(16);
        let needed = end + u64::from(MIN_STACK + RED_ZONE);
        if needed > u64::from(sram_bytes) {
            let largest = program
                .globals
                .values()
                .rev()
                .max_by_key(|global| global.size);
            return Err(TooLarge {
                needed,
                available: sram_bytes,
                largest: largest.map(|global| (global.name.clone(), global.size)),
            });
        }
        let mut layout = Layout {
            addresses,
            image: vec![0; end as usize],
            stack_top: (sram_bytes & !15) - RED_ZONE,
        };
        for (global, data) in program.globals.iter() {
            let at = layout.addresses[global] as usize;
            layout.image[at..at + data.init.len()].copy_from_slice(&data.init);
            for reloc in &data.relocs {
                let word = layout
                    .address(reloc.symbol)
                    .wrapping_add_signed(reloc.addend);
                let at = at + reloc.offset as usize;
                layout.image[at..at + 4].copy_from_slice(&word.to_le_bytes());
            }
        }
        Ok(layout)
    }

    /// The address of a symbol.
    pub fn address(&self, symbol: Symbol) -> u32 {
        match symbol {
            Symbol::Global(global) => self.addresses[global],
            Symbol::Func(func) => FUNC_BASE + 4 * func.index() as u32,
        }
    }

    /// The globals by name, in address order.
    pub fn symbols(&self, program: &Program) -> Vec<DataSymbol> {
        let symbol = |(global, address): (Global, &u32)| {
            let data = &program.globals[global];
            DataSymbol {
                name: data.name.clone(),
                address: *address,
                size: data.size,
            }
        };
        self.addresses.iter().map(symbol).collect()
    }
}
