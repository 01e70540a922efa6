//! The integer types: sizes, signs, and the value of bits in each.

/// The integer types.
///
/// As with GCC, a bit-field wider than an `int` has a type of exactly its width and is computed in
/// it. Programs cannot name that type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // each is its C name
pub enum Int {
    Char,
    SChar,
    UChar,
    Short,
    UShort,
    Int,
    UInt,
    Long,
    ULong,
    LongLong,
    ULongLong,
    /// Of a signed bit-field of 33 to 63 bits.
    Bits(u8),
    /// Of an unsigned bit-field of 33 to 63 bits.
    UBits(u8),
}

impl Int {
    /// Size in bytes.
    pub fn size(self) -> u32 {
        match self {
            Int::Char | Int::SChar | Int::UChar => 1,
            Int::Short | Int::UShort => 2,
            Int::Int | Int::UInt | Int::Long | Int::ULong => 4,
            Int::LongLong | Int::ULongLong | Int::Bits(_) | Int::UBits(_) => 8,
        }
    }

    /// How many bits its values have.
    pub fn width(self) -> u32 {
        match self {
            Int::Bits(width) | Int::UBits(width) => width.into(),
            _ => 8 * self.size(),
        }
    }

    /// True if it has negative values.
    pub fn signed(self) -> bool {
        !matches!(
            self,
            Int::UChar | Int::UShort | Int::UInt | Int::ULong | Int::ULongLong | Int::UBits(_)
        )
    }

    /// A value as it is in this type: cut to its size and extended again, to a word where it is
    /// smaller than one.
    pub fn wrap(self, value: u64) -> u64 {
        let word = match self {
            Int::Char | Int::SChar => value as i8 as u32,
            Int::UChar => u32::from(value as u8),
            Int::Short => value as i16 as u32,
            Int::UShort => u32::from(value as u16),
            Int::Int | Int::UInt | Int::Long | Int::ULong => value as u32,
            Int::LongLong | Int::ULongLong => return value,
            Int::Bits(width) => {
                let up = 64 - u32::from(width);
                return ((value << up) as i64 >> up) as u64;
            }
            Int::UBits(width) => return value & u64::MAX >> (64 - u32::from(width)),
        };
        u64::from(word)
    }

    /// The number that the bits of a constant of this type stand for.
    pub fn number(self, bits: u64) -> i128 {
        match (self.size(), self.signed()) {
            (8, true) => i128::from(bits as i64),
            (_, true) => i128::from(bits as i32),
            _ => i128::from(bits),
        }
    }

    /// The integer type of this size in bytes.
    pub fn of_size(size: u32, signed: bool) -> Int {
        match (size, signed) {
            (1, true) => Int::SChar,
            (1, false) => Int::UChar,
            (2, true) => Int::Short,
            (2, false) => Int::UShort,
            (8, true) => Int::LongLong,
            (8, false) => Int::ULongLong,
            (_, true) => Int::Int,
            (_, false) => Int::UInt,
        }
    }

    /// The integer type of so many bits, from 33 to 64.
    pub fn of_width(width: u32, signed: bool) -> Int {
        match (width, signed) {
            (64.., signed) => Int::of_size(8, signed),
            (width, true) => Int::Bits(width as u8),
            (width, false) => Int::UBits(width as u8),
        }
    }

    /// Its name in C.
    pub(super) fn name(self) -> &'static str {
        match self {
            Int::Char => "char",
            Int::SChar => "signed char",
            Int::UChar => "unsigned char",
            Int::Short => "short",
            Int::UShort => "unsigned short",
            Int::Int => "int",
            Int::UInt => "unsigned int",
            Int::Long => "long",
            Int::ULong => "unsigned long",
            Int::LongLong => "long long",
            Int::ULongLong => "unsigned long long",
            Int::Bits(_) => "a wide bit-field",
            Int::UBits(_) => "an unsigned wide bit-field",
        }
    }
}
