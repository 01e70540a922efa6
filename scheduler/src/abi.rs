//! The contents of central registers where two pieces of scheduled code meet.
//!
//! Values pass between functions, and between control code and kernels, in the central file of
//! their type: the first word in word register 0, the second in 1, and so on, each file counted by
//! itself. The last registers of the word file are reserved.

use srp_archdesc::arch::{RegFile, Srp};
use srp_archdesc::isa::Ty;
use srp_ir::dre::scheduled::Reg;
use std::collections::BTreeMap;

/// Word registers at the end of the file that never hold a value: the stack pointer and the link
/// register.
pub const RESERVED_WORDS: u32 = 2;

/// The central file for values of type `ty`.
///
/// # Panics
///
/// If there is none, which only a machine without VLIW slots can be like.
pub fn file(srp: &Srp, ty: Ty) -> RegFile {
    srp.central(ty)
        .expect("a machine with VLIW slots has a central file for every type")
}

/// Registers of the central file of `ty` that can hold values: the first ones.
pub fn allocatable(srp: &Srp, ty: Ty) -> u32 {
    let file_of_type = file(srp, ty);
    let size = srp.files[file_of_type].size;
    // A machine may keep several types in one file.
    if file_of_type == file(srp, Ty::Word) {
        size.saturating_sub(RESERVED_WORDS)
    } else {
        size
    }
}

/// Values of each type, in the order of [`Ty::ALL`], that can wait in central registers for a loop on the array: none where
/// there is no such file.
pub fn live_ins(srp: &Srp) -> [u32; Ty::ALL.len()] {
    Ty::ALL.map(|ty| srp.central(ty).map_or(0, |_| allocatable(srp, ty)))
}

/// The stack pointer.
pub fn stack_pointer(srp: &Srp) -> Reg {
    let file = file(srp, Ty::Word);
    Reg {
        file,
        index: srp.files[file].size - 1,
    }
}

/// The link register.
pub fn link(srp: &Srp) -> Reg {
    let file = file(srp, Ty::Word);
    Reg {
        file,
        index: srp.files[file].size - 2,
    }
}

/// The registers that never hold a value; none on an array without a central file.
pub fn reserved(srp: &Srp) -> Vec<Reg> {
    let Some(file) = srp.central(Ty::Word) else {
        return Vec::new();
    };
    let size = srp.files[file].size;
    (size.saturating_sub(RESERVED_WORDS)..size)
        .map(|index| Reg { file, index })
        .collect()
}

/// Where values of these types pass; `None` for those that find no register, as all do where there
/// is no central file.
pub fn passing(srp: &Srp, types: impl IntoIterator<Item = Ty>) -> Vec<Option<Reg>> {
    let mut next = BTreeMap::new();
    let place = |ty: Ty| {
        let file = srp.central(ty)?;
        let index = next.entry(file).or_insert(0);
        let reg = (*index < allocatable(srp, ty)).then_some(Reg {
            file,
            index: *index,
        });
        *index += 1;
        reg
    };
    types.into_iter().map(place).collect()
}
