//! Where an address goes: channel, bank, row and burst of the row.

use serde::{Deserialize, Serialize};
use srp_archdesc::dram::{AddressPart, BankedSpec, DramSpec};

/// The place of one burst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// Channel.
    pub channel: u32,
    /// Bank of the channel.
    pub bank: u32,
    /// Row of the bank.
    pub row: u32,
    /// Burst of the row.
    pub column: u32,
}

/// One field: `bits` bits of the burst's number from bit `from` on become bits of a part from bit
/// `to` on.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Field {
    part: AddressPart,
    from: u32,
    to: u32,
    mask: u32,
}

/// The way from addresses to places.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Mapping {
    fields: Vec<Field>,
    burst_shift: u32,
}

impl Mapping {
    /// That of a memory.
    pub fn new(memory: &DramSpec, spec: &BankedSpec) -> Mapping {
        let mut fields = Vec::new();
        let mut from = 0;
        let mut filled = [0; 4];
        for field in spec.mapping.iter().rev() {
            let to = &mut filled[field.part as usize];
            // Fields beyond the width of a burst's number hold nothing.
            if field.bits > 0 && from < u32::BITS {
                fields.push(Field {
                    part: field.part,
                    from,
                    to: *to,
                    mask: u32::MAX >> (u32::BITS - field.bits.min(u32::BITS)),
                });
            }
            *to += field.bits;
            from += field.bits;
        }
        Mapping {
            fields,
            burst_shift: spec.burst_bytes(memory.bits).ilog2(),
        }
    }

    /// The number of the burst that the byte at `address` lies in.
    #[inline]
    pub fn burst(&self, address: u32) -> u32 {
        address >> self.burst_shift
    }

    /// Where a burst lies.
    #[inline]
    pub fn place(&self, burst: u32) -> Place {
        let mut parts = [0; 4];
        for field in &self.fields {
            parts[field.part as usize] |= (burst >> field.from & field.mask) << field.to;
        }
        Place {
            channel: parts[AddressPart::Channel as usize],
            bank: parts[AddressPart::Bank as usize],
            row: parts[AddressPart::Row as usize],
            column: parts[AddressPart::Column as usize],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_archdesc::dram::{DramModel, presets};

    fn mapping(preset: &str) -> Mapping {
        let named = presets().into_iter().find(|p| p.name == preset);
        let memory = named.expect("a preset").spec;
        match &memory.model {
            DramModel::Banked(spec) => Mapping::new(&memory, spec),
            DramModel::Fixed => panic!("a memory with banks"),
        }
    }

    #[test]
    fn parts_lie_where_the_mapping_says() {
        // Row, channel, bank, column, 32 bytes.
        let lpddr3 = mapping("lpddr3-1600");
        let address = 0x5a << (1 + 3 + 7 + 5) | 1 << 15 | 6 << 12 | 0x45 << 5 | 31;
        let place = lpddr3.place(lpddr3.burst(address));
        let expected = Place {
            channel: 1,
            bank: 6,
            row: 0x5a,
            column: 0x45,
        };
        assert_eq!(place, expected);
    }

    #[test]
    fn a_part_may_have_several_fields() {
        // Row, bank, column, channel, column, 16 bytes.
        let gddr3 = mapping("paper-gddr3-1GHz");
        let place = |address| gddr3.place(gddr3.burst(address));
        let channels: Vec<u32> = (0..4).map(|i| place(64 * i).channel).collect();
        assert_eq!(channels, [0, 1, 0, 1]);
        let columns: Vec<u32> = (0..16).map(|i| place(16 * i).column).collect();
        assert_eq!(columns, [0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7]);
        assert_eq!((place(4096).bank, place(4096 * 4).row), (1, 1));
        // What lies above the capacity of 128 MiB wraps.
        assert_eq!(place(0x8000_0000 + 64), place(64));
    }
}
