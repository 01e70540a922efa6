//! The registers of a core when its program has ended, by which anybody can compare engines.

use super::at_end::AtEnd;
use crate::failure::Failure;
use crate::{document, files};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Ty;
use srp_csimgen::spec::Role;
use srp_toolchain::envelope::{About, Contents};
use srp_traces::names::Names;
use std::fmt::Write;
use std::path::Path;

/// The registers of a core.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Registers {
    /// Register files and output registers, in the order of the machine. What is on its way in a kernel is in none.
    stores: Vec<StoreRegisters>,
}

impl Contents for Registers {
    const FORMAT: &'static str = "srp-registers";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp run --registers FILE.json`";
}

/// The registers of a file, or the output register of a unit.
#[derive(Serialize, JsonSchema)]
struct StoreRegisters {
    /// Its name in the machine file.
    name: String,
    /// How many there are.
    size: u32,
    /// Those that are not 0.
    registers: Vec<Register>,
}

/// A register.
#[derive(Serialize, JsonSchema)]
struct Register {
    /// Its number in the file; in one that rotates, from the iteration begun last.
    number: u32,
    /// Its words in hexadecimal, the lowest lane first: one, or four of a vector.
    bits: Vec<String>,
}

impl Registers {
    /// Those of a core after its run.
    pub(super) fn of(at_end: &AtEnd, arch: &Arch) -> Registers {
        let AtEnd { spec, core } = at_end;
        let names = Names::of(spec, arch);
        let cells = core.snapshot().cells;
        let stores = spec.stores.iter().enumerate();
        let own = stores.filter(|(_, store)| !matches!(store.role, Role::Flight(_)));
        let stores = own.map(|(number, store)| {
            let registers = (0..store.size).filter_map(|number| {
                let lanes = &cells[(store.base + number) as usize].0;
                let lanes = match store.ty {
                    Ty::Vec => &lanes[..],
                    Ty::Word | Ty::Pred => &lanes[..1],
                };
                let is_zero = lanes.iter().all(|&word| word == 0);
                (!is_zero).then(|| Register {
                    number,
                    bits: lanes.iter().map(|word| format!("{word:08x}")).collect(),
                })
            });
            StoreRegisters {
                name: names.stores[number].clone(),
                size: store.size,
                registers: registers.collect(),
            }
        });
        Registers {
            stores: stores.collect(),
        }
    }

    /// Writes them: JSON where the name of the file ends in .json, else a line each; `-` is standard output.
    pub(super) fn write(&self, path: &Path, arch: &Arch) -> Result<(), Failure> {
        let text = match path.extension().is_some_and(|e| e == "json") {
            true => document::json(About::machine(arch), self)?,
            false => self.text(),
        };
        files::write(path, text.as_bytes())
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for store in &self.stores {
            for register in &store.registers {
                let _ = match store.size {
                    1 => write!(text, "{}", store.name),
                    _ => write!(text, "{}[{}]", store.name, register.number),
                };
                let _ = writeln!(text, " {}", register.bits.join(" "));
            }
        }
        text
    }
}
