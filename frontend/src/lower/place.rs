//! Places: where they are, and reading and writing scalars there.

use super::function::{Lowering, Storage};
use super::leaf::{Access, has_union, leaves};
use super::scalar::Scalar;
use crate::ctype::{BitRange, Type, TypeId};
use crate::typed::{ExprId, ExprKind, LocalId, PlaceId, PlaceKind, Update, Variable};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{InstKind, Slot, SlotData, Symbol, Value};

/// Scalars that a variable may have to be split into a slot for each.
const MAX_SPLIT: usize = 16;

/// A scalar of a split variable and its slot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) offset: u32,
    pub(super) access: Access,
    pub(super) slot: Slot,
}

/// The base of a location.
#[derive(Clone, Copy, Debug)]
pub(super) enum Base {
    Slot(Slot),
    Symbol(Symbol),
    Pointer(Value),
    /// A split variable or temporary.
    Split(usize),
}

/// Where something is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Location {
    pub(super) base: Base,
    pub(super) offset: u32,
    /// In system memory.
    pub(super) global: bool,
}

impl Location {
    /// Returns the location that a pointer points to.
    pub(super) fn pointer(pointer: Value, global: bool) -> Location {
        Location {
            base: Base::Pointer(pointer),
            offset: 0,
            global,
        }
    }

    /// The same, further on.
    pub(super) fn plus(self, offset: u32) -> Location {
        Location {
            offset: self.offset.wrapping_add(offset),
            ..self
        }
    }
}

impl Lowering<'_> {
    /// A slot for each scalar of a type, where a variable of the type can be split. Without a name they are
    /// temporaries.
    pub(super) fn split_slots(&mut self, ty: TypeId, name: Option<&str>) -> Option<Vec<Part>> {
        let types = &self.checked.types;
        if has_union(types, ty) {
            return None;
        }
        let leaves = leaves(types, ty, MAX_SPLIT)?;
        let single = leaves.len() == 1;
        let parts = leaves.into_iter().map(|leaf| {
            let size = leaf.access.ty().bits() / 8;
            let mut data = SlotData::temporary(size, size);
            if let Some(name) = name {
                data.name = match single {
                    true => name.to_owned(),
                    false => format!("{name}+{}", leaf.offset),
                };
            }
            Part {
                offset: leaf.offset,
                access: leaf.access,
                slot: self.func.slots.push(data),
            }
        });
        Some(parts.collect())
    }

    /// Room for a value of a type: split where that can be.
    pub(super) fn temporary(&mut self, ty: TypeId) -> Location {
        let base = match self.split_slots(ty, None) {
            Some(parts) => {
                self.split.push(parts);
                Base::Split(self.split.len() - 1)
            }
            None => Base::Slot(self.temporary_slot(ty)),
        };
        Location {
            base,
            offset: 0,
            global: false,
        }
    }

    /// Room for a value of a type that has an address.
    pub(super) fn temporary_in_memory(&mut self, ty: TypeId) -> Location {
        Location {
            base: Base::Slot(self.temporary_slot(ty)),
            offset: 0,
            global: false,
        }
    }

    /// Where a variable is.
    pub(super) fn local(&mut self, local: LocalId) -> Location {
        let base = match self.storage[local] {
            Storage::Slot(slot) => Base::Slot(slot),
            Storage::Split(index) => Base::Split(index),
        };
        Location {
            base,
            offset: 0,
            global: false,
        }
    }

    /// Emits the location of a place, and the values it depends on.
    pub(super) fn location(&mut self, place: PlaceId) -> Location {
        let body = self.body;
        let data = &body.places[place];
        match &data.kind {
            PlaceKind::Local(local) => {
                let location = self.local(*local);
                match location.base {
                    Base::Slot(_) => self.named(Variable::Local(*local), data.ty.ty, location),
                    _ => location,
                }
            }
            PlaceKind::Literal(local, init) => {
                self.init(*local, init);
                self.local(*local)
            }
            PlaceKind::Object(object) => {
                let location = Location {
                    base: Base::Symbol(self.symbols.object(*object)),
                    offset: 0,
                    global: false,
                };
                self.named(Variable::Object(*object), data.ty.ty, location)
            }
            PlaceKind::Deref(pointer) => self.pointed(*pointer, data.ty.quals.global),
            PlaceKind::Member(outer, offset) | PlaceKind::Bits(outer, offset, _) => {
                self.location(*outer).plus(*offset)
            }
            PlaceKind::Lane(outer, index) => {
                let outer = self.location(*outer);
                match body.exprs[*index].kind {
                    ExprKind::Const(lane) => outer.plus(4 * lane as u32),
                    _ => {
                        let base = self.address(outer);
                        let index = self.value(*index);
                        let pointer = self.scaled(base, index, 4);
                        Location::pointer(pointer, outer.global)
                    }
                }
            }
            PlaceKind::Temporary(e) => self.aggregate(*e),
            PlaceKind::Stored(e) => {
                let ty = body.exprs[*e].ty;
                let from = self.aggregate(*e);
                let to = self.temporary_in_memory(ty);
                self.copy(to, from, ty);
                to
            }
        }
    }

    /// Where an array or struct is, known as its own if a loop around calls it independent.
    fn named(&mut self, variable: Variable, ty: TypeId, location: Location) -> Location {
        let is_pointer = matches!(self.checked.types.get(ty), Type::Pointer(_));
        if is_pointer || !self.is_independent(variable) {
            return location;
        }
        let address = self.address(location);
        Location::pointer(self.by(variable, address), location.global)
    }

    /// Marks a pointer read from or stored to a variable by an expression as the variable's own if a loop
    /// around calls the variable independent.
    pub(super) fn held(&mut self, e: ExprId, value: Scalar) -> Scalar {
        let (ExprKind::Load(place)
        | ExprKind::Assign(place, _)
        | ExprKind::Update(Update { place, .. })) = self.body.exprs[e].kind
        else {
            return value;
        };
        let variable = match self.body.places[place].kind {
            PlaceKind::Local(local) => Variable::Local(local),
            PlaceKind::Object(object) => Variable::Object(object),
            _ => return value,
        };
        match value {
            Scalar::Single(pointer) if self.is_pointer(e) && self.is_independent(variable) => {
                Scalar::Single(self.by(variable, pointer))
            }
            value => value,
        }
    }

    /// Returns the location that a pointer points to, with constant offsets folded into it.
    fn pointed(&mut self, pointer: ExprId, global: bool) -> Location {
        let (mut e, mut offset) = (pointer, 0u32);
        loop {
            match self.body.exprs[e].kind {
                ExprKind::Offset(p, i, scale) => match self.body.exprs[i].kind {
                    ExprKind::Const(i) => {
                        offset = offset.wrapping_add((i as u32).wrapping_mul(scale as u32));
                        e = p;
                    }
                    _ => break,
                },
                // A pointer to another type is the same address.
                ExprKind::Convert(inner) if self.is_pointer(e) && self.is_pointer(inner) => {
                    e = inner;
                }
                ExprKind::AddressOf(place) => return self.location(place).plus(offset),
                _ => break,
            }
        }
        let pointer = self.value(e);
        Location::pointer(pointer, global).plus(offset)
    }

    fn is_pointer(&self, e: ExprId) -> bool {
        let ty = self.body.exprs[e].ty;
        self.checked.types.pointee(ty).is_some()
    }

    /// `base + index · scale` in bytes.
    pub(super) fn scaled(&mut self, base: Value, index: Value, scale: i32) -> Value {
        let distance = match scale {
            1 => index,
            scale if scale > 0 && scale.count_ones() == 1 => {
                let count = self.word(scale.trailing_zeros());
                self.op(Opcode::Shl, &[index, count])
            }
            scale => {
                let factor = self.word(scale as u32);
                self.op(Opcode::Mul, &[index, factor])
            }
        };
        self.op(Opcode::Add, &[base, distance])
    }

    /// The address of a location.
    pub(super) fn address(&mut self, location: Location) -> Value {
        let offset = location.offset as i32;
        match location.base {
            Base::Slot(slot) => self.inst(InstKind::SlotAddr(slot, offset), Ty::Word),
            Base::Symbol(symbol) => self.inst(InstKind::SymbolAddr(symbol, offset), Ty::Word),
            Base::Pointer(pointer) if offset == 0 => pointer,
            Base::Pointer(pointer) => {
                let offset = self.word(location.offset);
                self.op(Opcode::Add, &[pointer, offset])
            }
            Base::Split(_) => unreachable!("a variable whose address is used is not split"),
        }
    }

    /// An address and an immediate that together give a location in memory.
    fn addressed(&mut self, location: Location) -> (Value, i32) {
        let base = Location {
            offset: 0,
            ..location
        };
        (self.address(base), location.offset as i32)
    }

    /// The part of a split variable at an offset.
    fn part(&self, index: usize, offset: u32) -> Part {
        let parts = &self.split[index];
        let at = parts.partition_point(|part| part.offset <= offset);
        parts[at - 1]
    }

    /// Reads a scalar or vector.
    pub(super) fn load(&mut self, location: Location, access: Access) -> Value {
        let guard = self.always();
        let Base::Split(index) = location.base else {
            let (address, imm) = self.addressed(location);
            return self.op_imm(access.load(location.global), &[guard, address], imm);
        };
        let part = self.part(index, location.offset);
        let whole = match part.access.ty() {
            Ty::Vec => Access::Vector,
            _ => Access::Word,
        };
        let address = self.inst(InstKind::SlotAddr(part.slot, 0), Ty::Word);
        let value = self.op_imm(whole.load(false), &[guard, address], 0);
        if whole == Access::Vector && access != Access::Vector {
            let lane = (location.offset - part.offset) / 4;
            return self.op_imm(Opcode::Vext, &[value], lane as i32);
        }
        value
    }

    /// Writes a scalar or vector.
    pub(super) fn store(&mut self, location: Location, access: Access, value: Value) {
        let guard = self.always();
        let Base::Split(index) = location.base else {
            let (address, imm) = self.addressed(location);
            self.effect_op(access.store(location.global), &[guard, address, value], imm);
            return;
        };
        let part = self.part(index, location.offset);
        let address = self.inst(InstKind::SlotAddr(part.slot, 0), Ty::Word);
        let (whole, value) = match (part.access.ty(), access) {
            (Ty::Vec, Access::Vector) => (Access::Vector, value),
            (Ty::Vec, _) => {
                let old = self.op_imm(Opcode::Lv, &[guard, address], 0);
                let lane = (location.offset - part.offset) / 4;
                let new = self.op_imm(Opcode::Vins, &[old, value], lane as i32);
                (Access::Vector, new)
            }
            _ => (Access::Word, value),
        };
        self.effect_op(whole.store(false), &[guard, address, value], 0);
    }

    /// How values of a type lie in memory.
    pub(super) fn access(&self, ty: TypeId) -> Access {
        Access::of(self.checked.types.get(ty))
    }

    /// Where the scalar of a place is.
    pub(super) fn field(&mut self, place: PlaceId) -> Field {
        let data = &self.body.places[place];
        let bits = match data.kind {
            PlaceKind::Bits(_, _, bits) => Some(bits),
            _ => None,
        };
        Field {
            location: self.location(place),
            ty: data.ty.ty,
            bits,
        }
    }

    /// Reads a scalar or vector of a type.
    pub(super) fn read_at(&mut self, location: Location, ty: TypeId) -> Scalar {
        if self.checked.types.is_wide(ty) {
            let low = self.load(location, Access::Word);
            return Scalar::Pair(low, self.load(location.plus(4), Access::Word));
        }
        let access = self.access(ty);
        Scalar::Single(self.load(location, access))
    }

    /// Writes a scalar or vector.
    pub(super) fn write_at(&mut self, location: Location, ty: TypeId, value: Scalar) {
        match value {
            Scalar::Single(value) => {
                let access = self.access(ty);
                self.store(location, access, value);
            }
            Scalar::Pair(low, high) => {
                self.store(location, Access::Word, low);
                self.store(location.plus(4), Access::Word, high);
            }
        }
    }

    /// Reads a scalar, vector or bit-field.
    pub(super) fn read(&mut self, field: Field) -> Scalar {
        let Some(bits) = field.bits else {
            return self.read_at(field.location, field.ty);
        };
        let unit = self.read_unit(field.location, bits);
        self.extract(unit, bits, field.ty)
    }

    /// Writes a scalar, vector or bit-field; returns the value that it then holds.
    pub(super) fn write(&mut self, field: Field, value: Scalar) -> Scalar {
        let Some(bits) = field.bits else {
            self.write_at(field.location, field.ty, value);
            return value;
        };
        let unit = self.read_unit(field.location, bits);
        let mask = bits.mask() << bits.shift;
        let Scalar::Pair(low, high) = unit else {
            let kept = self.word(!mask as u32);
            let kept = self.op(Opcode::And, &[unit.single(), kept]);
            let (own, by) = (self.word(bits.mask() as u32), self.word(bits.shift));
            let own = self.op(Opcode::And, &[value.single(), own]);
            let own = self.op(Opcode::Shl, &[own, by]);
            let new = self.op(Opcode::Or, &[kept, own]);
            self.store(field.location, unit_access(bits), new);
            return self.extract(value, BitRange { shift: 0, ..bits }, field.ty);
        };
        let shifted = self.pair_shift_by(true, false, value, bits.shift);
        let mut merged = Vec::new();
        for ((old, new), mask) in [low, high]
            .into_iter()
            .zip(shifted.values())
            .zip([mask, mask >> 32])
        {
            let (kept, own) = (self.word(!mask as u32), self.word(mask as u32));
            let kept = self.op(Opcode::And, &[old, kept]);
            let own = self.op(Opcode::And, &[new, own]);
            merged.push(self.op(Opcode::Or, &[kept, own]));
        }
        self.write_at(field.location, field.ty, Scalar::Pair(merged[0], merged[1]));
        self.extract(value, BitRange { shift: 0, ..bits }, field.ty)
    }

    /// The unit of memory that a bit-field lies in.
    fn read_unit(&mut self, location: Location, bits: BitRange) -> Scalar {
        if bits.unit == 8 {
            let low = self.load(location, Access::Word);
            return Scalar::Pair(low, self.load(location.plus(4), Access::Word));
        }
        Scalar::Single(self.load(location, unit_access(bits)))
    }

    /// A bit-field as a value of its type from its unit.
    fn extract(&mut self, unit: Scalar, bits: BitRange, ty: TypeId) -> Scalar {
        let signed = !self.checked.types.is_unsigned(ty);
        if let (8, Scalar::Pair(..)) = (bits.unit, unit) {
            let up = self.pair_shift_by(true, false, unit, 64 - bits.shift - bits.width);
            return self.pair_shift_by(false, signed, up, 64 - bits.width);
        }
        let value = self.bits_of(unit.single(), bits.shift, bits.width, signed);
        match self.checked.types.is_wide(ty) {
            true => self.widened(value, signed),
            false => Scalar::Single(value),
        }
    }
}

/// How the unit of a bit-field of at most a word is read and written.
fn unit_access(bits: BitRange) -> Access {
    match bits.unit {
        1 => Access::Byte(false),
        2 => Access::Half(false),
        _ => Access::Word,
    }
}

/// Where a scalar is, and which bits of its unit it is.
#[derive(Clone, Copy)]
pub(super) struct Field {
    location: Location,
    ty: TypeId,
    bits: Option<BitRange>,
}

impl Field {
    /// A bit-field in a unit that is there.
    pub(super) fn bits(location: Location, ty: TypeId, bits: BitRange) -> Field {
        Field {
            location,
            ty,
            bits: Some(bits),
        }
    }
}
