//! Scalars of one word and of two: arithmetic on pairs of words, conversions, and calls of the
//! library's functions where that is too long to be done in place.

use super::function::Lowering;
use crate::ctype::{Int, Type, TypeId};
use crate::operator::{self, Class, Support};
use crate::typed::{BinaryOp, Relation};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{Callee, InstKind, Value};

/// The value of a scalar or vector expression.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scalar {
    /// A word or vector.
    Single(Value),
    /// Low and high word of 64 bits.
    Pair(Value, Value),
}

impl Scalar {
    /// The word or vector; the low word of a pair.
    pub(super) fn single(self) -> Value {
        match self {
            Scalar::Single(value) | Scalar::Pair(value, _) => value,
        }
    }

    /// Both words of a pair; a word that is no pair stands for both.
    fn pair(self) -> (Value, Value) {
        match self {
            Scalar::Single(value) => (value, value),
            Scalar::Pair(low, high) => (low, high),
        }
    }

    /// Its values, as it passes.
    pub(super) fn values(self) -> Vec<Value> {
        match self {
            Scalar::Single(value) => vec![value],
            Scalar::Pair(low, high) => vec![low, high],
        }
    }

    /// The scalar that passes as these values.
    pub(super) fn of(values: &[Value]) -> Option<Scalar> {
        match *values {
            [value] => Some(Scalar::Single(value)),
            [low, high] => Some(Scalar::Pair(low, high)),
            _ => None,
        }
    }
}

impl Lowering<'_> {
    /// A constant of a scalar type.
    pub(super) fn scalar_constant(&mut self, bits: u64, ty: TypeId) -> Scalar {
        let low = self.word(bits as u32);
        match self.checked.types.is_wide(ty) {
            true => Scalar::Pair(low, self.word((bits >> 32) as u32)),
            false => Scalar::Single(low),
        }
    }

    /// Calls a function of the library.
    pub(super) fn support(&mut self, support: Support, args: &[Value], results: usize) -> Scalar {
        let function = self.checked.support[&support];
        let kind = InstKind::Call {
            callee: Callee::Func(self.symbols.func(function)),
            args: args.to_vec(),
        };
        let inst = self
            .func
            .append(self.block, kind, &vec![Ty::Word; results], self.pos);
        let values = self.func.insts[inst].results.clone();
        Scalar::of(&values).expect("the library's functions return one or two words")
    }

    /// `l op r` on pairs of words; `r` is the count of a shift.
    pub(super) fn pair_binary(
        &mut self,
        op: BinaryOp,
        signed: bool,
        l: Scalar,
        r: Scalar,
    ) -> Scalar {
        let ((a, b), (c, d)) = (l.pair(), r.pair());
        let each = |lowering: &mut Self, op| {
            let (low, high) = (lowering.op(op, &[a, c]), lowering.op(op, &[b, d]));
            Scalar::Pair(low, high)
        };
        match op {
            BinaryOp::And => each(self, Opcode::And),
            BinaryOp::Or => each(self, Opcode::Or),
            BinaryOp::Xor => each(self, Opcode::Xor),
            BinaryOp::Add => {
                let low = self.op(Opcode::Add, &[a, c]);
                let carry = self.op(Opcode::Ltu, &[low, a]);
                let carry = self.op(Opcode::Ptoi, &[carry]);
                let high = self.op(Opcode::Add, &[b, d]);
                Scalar::Pair(low, self.op(Opcode::Add, &[high, carry]))
            }
            BinaryOp::Sub => {
                let low = self.op(Opcode::Sub, &[a, c]);
                let borrow = self.op(Opcode::Ltu, &[a, c]);
                let borrow = self.op(Opcode::Ptoi, &[borrow]);
                let high = self.op(Opcode::Sub, &[b, d]);
                Scalar::Pair(low, self.op(Opcode::Sub, &[high, borrow]))
            }
            BinaryOp::Mul => {
                let low = self.op(Opcode::Mul, &[a, c]);
                let high = self.op(Opcode::Mulhu, &[a, c]);
                let first = self.op(Opcode::Mul, &[a, d]);
                let second = self.op(Opcode::Mul, &[b, c]);
                let cross = self.op(Opcode::Add, &[first, second]);
                Scalar::Pair(low, self.op(Opcode::Add, &[high, cross]))
            }
            BinaryOp::Shl | BinaryOp::Shr => {
                let left = op == BinaryOp::Shl;
                match self.constant_word(c) {
                    Some(count) => self.pair_shift_by(left, signed, l, count % 64),
                    None => self.pair_shift(left, signed, l, c),
                }
            }
            BinaryOp::Div | BinaryOp::Rem => {
                unreachable!("the library divides pairs")
            }
        }
    }

    /// A pair shifted by a constant below 64.
    pub(super) fn pair_shift_by(
        &mut self,
        left: bool,
        signed: bool,
        value: Scalar,
        count: u32,
    ) -> Scalar {
        if count == 0 {
            return value;
        }
        let (low, high) = value.pair();
        let right = if signed { Opcode::Sar } else { Opcode::Shr };
        let by = self.word(count % 32);
        if count >= 32 {
            return match (left, signed) {
                (true, _) => {
                    let zero = self.word(0);
                    Scalar::Pair(zero, self.op(Opcode::Shl, &[low, by]))
                }
                (false, false) => {
                    let zero = self.word(0);
                    Scalar::Pair(self.op(Opcode::Shr, &[high, by]), zero)
                }
                (false, true) => {
                    let all = self.word(31);
                    let sign = self.op(Opcode::Sar, &[high, all]);
                    Scalar::Pair(self.op(Opcode::Sar, &[high, by]), sign)
                }
            };
        }
        let rest = self.word(32 - count);
        if left {
            let carried = self.op(Opcode::Shr, &[low, rest]);
            let high = self.op(Opcode::Shl, &[high, by]);
            let high = self.op(Opcode::Or, &[high, carried]);
            return Scalar::Pair(self.op(Opcode::Shl, &[low, by]), high);
        }
        let carried = self.op(Opcode::Shl, &[high, rest]);
        let low = self.op(Opcode::Shr, &[low, by]);
        let low = self.op(Opcode::Or, &[low, carried]);
        Scalar::Pair(low, self.op(right, &[high, by]))
    }

    /// A pair shifted by a count taken modulo 64. The opcodes take theirs modulo 32, so that what
    /// is carried goes one bit first and then the rest.
    fn pair_shift(&mut self, left: bool, signed: bool, value: Scalar, count: Value) -> Scalar {
        let (low, high) = value.pair();
        let one = self.word(1);
        let (zero, thirty_two, thirty_one) = (self.word(0), self.word(32), self.word(31));
        let far = self.op(Opcode::And, &[count, thirty_two]);
        let far = self.op(Opcode::Ne, &[far, zero]);
        let rest = self.op(Opcode::Xor, &[count, thirty_one]);
        if left {
            let carried = self.op(Opcode::Shr, &[low, one]);
            let carried = self.op(Opcode::Shr, &[carried, rest]);
            let near_low = self.op(Opcode::Shl, &[low, count]);
            let near_high = self.op(Opcode::Shl, &[high, count]);
            let near_high = self.op(Opcode::Or, &[near_high, carried]);
            let new_low = self.op(Opcode::Sel, &[far, zero, near_low]);
            return Scalar::Pair(new_low, self.op(Opcode::Sel, &[far, near_low, near_high]));
        }
        let right = if signed { Opcode::Sar } else { Opcode::Shr };
        let carried = self.op(Opcode::Shl, &[high, one]);
        let carried = self.op(Opcode::Shl, &[carried, rest]);
        let near_high = self.op(right, &[high, count]);
        let near_low = self.op(Opcode::Shr, &[low, count]);
        let near_low = self.op(Opcode::Or, &[near_low, carried]);
        let fill = match signed {
            true => self.op(Opcode::Sar, &[high, thirty_one]),
            false => zero,
        };
        let new_low = self.op(Opcode::Sel, &[far, near_high, near_low]);
        Scalar::Pair(new_low, self.op(Opcode::Sel, &[far, fill, near_high]))
    }

    /// A relation of scalars of a class as a predicate.
    pub(super) fn scalar_relation(
        &mut self,
        relation: Relation,
        class: Class,
        l: Scalar,
        r: Scalar,
    ) -> Value {
        match class {
            Class::Long => self.pair_relation(relation, true, l, r),
            Class::ULong => self.pair_relation(relation, false, l, r),
            Class::Double => {
                let (support, swap, invert) = operator::double_relation(relation);
                let (l, r) = if swap { (r, l) } else { (l, r) };
                let args = [l.values(), r.values()].concat();
                let truth = self.support(support, &args, 1).single();
                let zero = self.word(0);
                let op = if invert { Opcode::Eq } else { Opcode::Ne };
                self.op(op, &[truth, zero])
            }
            _ => self.relation(relation, class, l.single(), r.single()),
        }
    }

    fn pair_relation(&mut self, relation: Relation, signed: bool, l: Scalar, r: Scalar) -> Value {
        let swap = matches!(relation, Relation::Gt | Relation::Ge);
        let (l, r) = if swap { (r, l) } else { (l, r) };
        let ((a, b), (c, d)) = (l.pair(), r.pair());
        if let Relation::Eq | Relation::Ne = relation {
            let low = self.op(Opcode::Xor, &[a, c]);
            let high = self.op(Opcode::Xor, &[b, d]);
            let either = self.op(Opcode::Or, &[low, high]);
            let zero = self.word(0);
            let op = match relation {
                Relation::Eq => Opcode::Eq,
                _ => Opcode::Ne,
            };
            return self.op(op, &[either, zero]);
        }
        let low = match relation {
            Relation::Lt | Relation::Gt => Opcode::Ltu,
            _ => Opcode::Leu,
        };
        let less = if signed { Opcode::Lt } else { Opcode::Ltu };
        let low = self.op(low, &[a, c]);
        let same = self.op(Opcode::Eq, &[b, d]);
        let high = self.op(less, &[b, d]);
        let low = self.op(Opcode::Pand, &[same, low]);
        self.op(Opcode::Por, &[high, low])
    }

    /// Emits a predicate: true if a scalar is not zero.
    pub(super) fn scalar_not_zero(&mut self, value: Scalar, ty: TypeId) -> Value {
        let zero = self.word(0);
        match (value, self.class(ty)) {
            (Scalar::Single(value), class) => self.relation(Relation::Ne, class, value, zero),
            (Scalar::Pair(low, high), class) => {
                let high = match class {
                    // Both zeros are zero.
                    Class::Double => self.op(Opcode::Add, &[high, high]),
                    _ => high,
                };
                let either = self.op(Opcode::Or, &[low, high]);
                self.op(Opcode::Ne, &[either, zero])
            }
        }
    }

    /// A word as 64 bits.
    pub(super) fn widened(&mut self, low: Value, signed: bool) -> Scalar {
        let high = match signed {
            true => {
                let all = self.word(31);
                self.op(Opcode::Sar, &[low, all])
            }
            false => self.word(0),
        };
        Scalar::Pair(low, high)
    }

    /// A value of one scalar type in another, or of one vector type as the same bits of another.
    pub(super) fn convert(&mut self, value: Scalar, from: TypeId, to: TypeId) -> Scalar {
        let types = &self.checked.types;
        let (source, target) = (types.get(from), types.get(to));
        if *target == Type::Bool {
            if *source == Type::Bool {
                return value;
            }
            let truth = self.scalar_not_zero(value, from);
            return Scalar::Single(self.op(Opcode::Ptoi, &[truth]));
        }
        if let (Type::Int(a), Type::Int(b)) = (source, target)
            && b.size() <= 4
            && fits(*a, *b)
        {
            return Scalar::Single(value.single());
        }
        let wide = types.is_wide(to);
        if let Some(support) = operator::conversion_support(source, target) {
            let results = if wide { 2 } else { 1 };
            let made = self.support(support, &value.values(), results);
            return match target {
                Type::Int(int) if !wide => Scalar::Single(self.cut(made.single(), *int)),
                _ => self.cut_pair(made, to),
            };
        }
        if wide {
            return match value {
                Scalar::Pair(..) if self.is_contained(from, to) => value,
                Scalar::Pair(..) => self.cut_pair(value, to),
                Scalar::Single(low) => {
                    let value = self.widened(low, !types.is_unsigned(from));
                    self.cut_pair(value, to)
                }
            };
        }
        let value = match (value, operator::conversion(source, target)) {
            (Scalar::Single(value), Some(op)) => self.op(op, &[value]),
            (value, _) => value.single(),
        };
        Scalar::Single(match target {
            Type::Int(int) if *source != Type::Bool => self.cut(value, *int),
            _ => value,
        })
    }

    /// True if the second type has every value of the first, for integers of up to 64 bits.
    fn is_contained(&self, from: TypeId, to: TypeId) -> bool {
        match (self.checked.types.get(from), self.checked.types.get(to)) {
            (Type::Int(a), Type::Int(b)) => {
                b.width() == 64
                    || a.width() <= b.width() && a.signed() == b.signed()
                    || a.width() < b.width() && !a.signed()
            }
            _ => true,
        }
    }

    /// A pair cut to its type, where that has less than 64 bits.
    pub(super) fn cut_pair(&mut self, value: Scalar, ty: TypeId) -> Scalar {
        match *self.checked.types.get(ty) {
            Type::Int(int @ (Int::Bits(_) | Int::UBits(_))) => {
                let by = 64 - int.width();
                let up = self.pair_shift_by(true, false, value, by);
                self.pair_shift_by(false, int.signed(), up, by)
            }
            _ => value,
        }
    }

    /// A word cut to an integer type.
    pub(super) fn cut(&mut self, value: Value, int: Int) -> Value {
        let bits = 8 * int.size();
        match bits >= 32 {
            true => value,
            false => self.bits_of(value, 0, bits, int.signed()),
        }
    }

    /// `width` bits of a word from bit `shift` on, as a number.
    pub(super) fn bits_of(&mut self, word: Value, shift: u32, width: u32, signed: bool) -> Value {
        if width == 32 {
            return word;
        }
        if !signed {
            let word = match shift {
                0 => word,
                shift => {
                    let by = self.word(shift);
                    self.op(Opcode::Shr, &[word, by])
                }
            };
            let mask = self.word((1 << width) - 1);
            return self.op(Opcode::And, &[word, mask]);
        }
        let up = self.word(32 - width - shift);
        let high = self.op(Opcode::Shl, &[word, up]);
        let down = self.word(32 - width);
        self.op(Opcode::Sar, &[high, down])
    }
}

/// True if every value of `from` is a value of `to`, or has the same word there.
fn fits(from: Int, to: Int) -> bool {
    let same = from.signed() == to.signed();
    to.size() == 4 || from.size() <= to.size() && same || from.size() < to.size() && !from.signed()
}
