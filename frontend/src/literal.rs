//! Constants: numbers, characters and strings as C writes them.

use crate::bytes::byte_of;
use crate::message::{CONSTANT_RANGE, Code, LEXICAL, UNSUPPORTED};
use std::rc::Rc;

/// An integer constant as written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntConst {
    /// Its value.
    pub value: u64,
    /// It has a `u` suffix.
    pub unsigned: bool,
    /// How many `l` its suffix has.
    pub longs: u8,
    /// It is written in decimal, so that without suffix it is never unsigned.
    pub decimal: bool,
}

/// The bits of a floating constant, by its suffix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloatConst {
    /// `f`: binary32.
    Single(u32),
    /// None: binary64, and what it would be with `f`.
    Double {
        /// As binary64.
        double: u64,
        /// As binary32.
        single: u32,
    },
    /// `l`: kept as binary64.
    LongDouble {
        /// As binary64.
        double: u64,
        /// As binary32.
        single: u32,
    },
}

/// A constant.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Literal {
    Int(IntConst),
    Float(FloatConst),
    Str(Rc<[u8]>),
    WideStr(Rc<[u32]>),
}

/// Why a spelling is no constant.
pub(crate) struct Bad {
    pub(crate) code: Code,
    pub(crate) text: String,
}

fn bad<T>(code: Code, text: impl Into<String>) -> Result<T, Bad> {
    Err(Bad {
        code,
        text: text.into(),
    })
}

/// An integer or floating constant.
pub(crate) fn number(text: &str) -> Result<Literal, Bad> {
    let lower = text.to_ascii_lowercase();
    let hex = lower.starts_with("0x");
    let floating = lower.contains('.')
        || lower.contains(if hex { 'p' } else { 'e' }) && !lower.starts_with("0b");
    if floating {
        float(&lower, hex).map(Literal::Float)
    } else {
        integer(&lower, text).map(Literal::Int)
    }
}

fn integer(lower: &str, text: &str) -> Result<IntConst, Bad> {
    let (digits, radix) = if let Some(hex) = lower.strip_prefix("0x") {
        (hex, 16)
    } else if let Some(binary) = lower.strip_prefix("0b") {
        (binary, 2)
    } else if lower.len() > 1 && lower.starts_with('0') {
        (&lower[1..], 8)
    } else {
        (lower, 10)
    };
    let end = digits
        .find(|c: char| !c.is_digit(radix.max(10)))
        .unwrap_or(digits.len());
    let (digits, suffix) = digits.split_at(end);
    let (unsigned, longs) = match suffix {
        "" => (false, 0),
        "u" => (true, 0),
        "l" => (false, 1),
        "ul" | "lu" => (true, 1),
        "ll" => (false, 2),
        "ull" | "llu" => (true, 2),
        _ => return bad(LEXICAL, format!("`{text}` is not a number")),
    };
    let octal_zero = radix == 8 && digits.is_empty();
    if digits.is_empty() && !octal_zero || digits.chars().any(|c| !c.is_digit(radix)) {
        return bad(LEXICAL, format!("`{text}` is not a number"));
    }
    let value = if octal_zero {
        Ok(0)
    } else {
        u64::from_str_radix(digits, radix)
    };
    match value {
        Ok(value) => Ok(IntConst {
            value,
            unsigned,
            longs,
            decimal: radix == 10,
        }),
        Err(_) => bad(CONSTANT_RANGE, format!("`{text}` does not fit in 64 bits")),
    }
}

fn float(lower: &str, hex: bool) -> Result<FloatConst, Bad> {
    let malformed = || bad(LEXICAL, format!("`{lower}` is not a number"));
    let (digits, suffix) = match lower.as_bytes().last() {
        Some(b'f') if !hex || lower.contains('p') => (&lower[..lower.len() - 1], 'f'),
        Some(b'l') => (&lower[..lower.len() - 1], 'l'),
        _ => (lower, ' '),
    };
    let (single, double) = if hex {
        match hex_float(digits) {
            Some(bits) => bits,
            None => return malformed(),
        }
    } else {
        let c_digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '+' | '-');
        let ends = digits
            .chars()
            .last()
            .is_some_and(|c| c.is_ascii_digit() || c == '.');
        match (digits.parse::<f32>(), digits.parse::<f64>()) {
            (Ok(single), Ok(double)) if digits.chars().all(c_digits) && ends => (single, double),
            _ => return malformed(),
        }
    };
    match suffix {
        'f' if single.is_infinite() => bad(
            CONSTANT_RANGE,
            format!("`{lower}` is too large for a float"),
        ),
        'f' => Ok(FloatConst::Single(single.to_bits())),
        'l' => Ok(FloatConst::LongDouble {
            double: double.to_bits(),
            single: single.to_bits(),
        }),
        _ => Ok(FloatConst::Double {
            double: double.to_bits(),
            single: single.to_bits(),
        }),
    }
}

/// The value of `0x…p…`, rounded once to each format.
fn hex_float(text: &str) -> Option<(f32, f64)> {
    let (mantissa, exponent) = text.strip_prefix("0x")?.split_once('p')?;
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    if whole.is_empty() && fraction.is_empty() {
        return None;
    }
    let exponent: i32 = exponent.parse::<i32>().ok()?.clamp(-100_000, 100_000);
    // 60 bits and a sticky one below.
    let (mut bits, mut scale, mut sticky) = (0u64, exponent, false);
    for (i, c) in whole.chars().chain(fraction.chars()).enumerate() {
        let digit = u64::from(c.to_digit(16)?);
        let in_fraction = i >= whole.len();
        if bits >> 56 == 0 {
            bits = bits << 4 | digit;
            scale = scale.saturating_sub(if in_fraction { 4 } else { 0 });
        } else {
            sticky |= digit != 0;
            scale = scale.saturating_add(if in_fraction { 0 } else { 4 });
        }
    }
    let bits = bits << 1 | u64::from(sticky);
    let scale = scale.saturating_sub(1);
    let single = assemble(bits, scale, 24, -149, 128);
    let double = assemble(bits, scale, 53, -1074, 1024);
    // The single is exact in binary64.
    Some((single as f32, double))
}

/// `bits · 2^scale` rounded to nearest even with `precision` bits and no bit below `2^lowest`;
/// infinite from `2^top` on.
fn assemble(bits: u64, scale: i32, precision: i32, lowest: i32, top: i32) -> f64 {
    if bits == 0 {
        return 0.0;
    }
    let length = 64 - bits.leading_zeros() as i32;
    let drop = (length - precision).max(lowest - scale).max(0);
    let (kept, exponent) = if drop == 0 {
        (bits, scale)
    } else if drop > 64 {
        (0, 0)
    } else {
        let wide = u128::from(bits);
        let kept = (wide >> drop) as u64;
        let rest = wide & ((1u128 << drop) - 1);
        let half = 1u128 << (drop - 1);
        let up = rest > half || rest == half && kept & 1 == 1;
        (kept + u64::from(up), scale + drop)
    };
    if kept == 0 {
        return 0.0;
    }
    if 64 - kept.leading_zeros() as i32 + exponent > top {
        return f64::INFINITY;
    }
    scaled(kept as f64, exponent)
}

/// `value · 2^exponent` where the result is exact.
fn scaled(mut value: f64, mut exponent: i32) -> f64 {
    while exponent > 0 {
        let step = exponent.min(1000);
        value *= f64::from_bits(((1023 + step) as u64) << 52);
        exponent -= step;
    }
    while exponent < 0 {
        let step = (-exponent).min(1000);
        value *= f64::from_bits(((1023 - step) as u64) << 52);
        exponent += step;
    }
    value
}

/// The value of a character constant with its quotes.
pub(crate) fn character(text: &str) -> Result<i32, Bad> {
    let (wide, units) = unquote(text)?;
    match units.as_slice() {
        [] => bad(LEXICAL, "a character constant needs a character"),
        [unit] if wide => Ok(*unit as i32),
        [unit] => Ok(i32::from(*unit as u8 as i8)),
        // Several characters are the bytes of an `int`, the last one lowest.
        units if !wide && units.len() <= 4 => {
            let value = units
                .iter()
                .fold(0u32, |value, &unit| value << 8 | unit & 0xff);
            Ok(value as i32)
        }
        _ => bad(LEXICAL, "too many characters in a character constant"),
    }
}

/// A string literal with its quotes.
pub(crate) fn string(text: &str) -> Result<Literal, Bad> {
    let (wide, units) = unquote(text)?;
    Ok(match wide {
        true => Literal::WideStr(units.into()),
        false => Literal::Str(units.iter().map(|&unit| unit as u8).collect()),
    })
}

/// The characters between quotes: bytes, or code points where the first is true.
fn unquote(text: &str) -> Result<(bool, Vec<u32>), Bad> {
    let quote = text.find(['"', '\'']).unwrap_or(0);
    let wide = match &text[..quote] {
        "" | "u8" => false,
        "L" | "U" => true,
        other => {
            let text = format!("characters with the prefix `{other}` are not supported");
            return bad(UNSUPPORTED, text);
        }
    };
    let mut chars = text[quote + 1..text.len() - 1].chars().peekable();
    let mut units = Vec::new();
    while let Some(c) = chars.next() {
        if c != '\\' {
            if let Some(byte) = byte_of(c) {
                units.push(byte.into());
            } else if wide {
                units.push(c as u32);
            } else {
                units.extend(c.encode_utf8(&mut [0; 4]).bytes().map(u32::from));
            }
            continue;
        }
        if let Some(count @ ('u' | 'U')) = chars.peek().copied() {
            chars.next();
            let c = universal(&mut chars, if count == 'u' { 4 } else { 8 })?;
            match wide {
                true => units.push(c as u32),
                false => units.extend(c.encode_utf8(&mut [0; 4]).bytes().map(u32::from)),
            }
            continue;
        }
        units.push(escape(&mut chars, wide)?);
    }
    Ok((wide, units))
}

/// The character of `\\u` or `\\U` with so many digits.
fn universal(
    chars: &mut std::iter::Peekable<std::str::Chars<'_>>,
    digits: u32,
) -> Result<char, Bad> {
    let mut value = 0;
    for _ in 0..digits {
        match chars.next_if(|d| d.is_ascii_hexdigit()) {
            Some(d) => value = value << 4 | d.to_digit(16).unwrap_or(0),
            None => return bad(LEXICAL, format!("the character needs {digits} digits")),
        }
    }
    match char::from_u32(value) {
        Some(c) => Ok(c),
        None => bad(LEXICAL, "there is no such character"),
    }
}

/// The character of an escape sequence after its backslash.
fn escape(chars: &mut std::iter::Peekable<std::str::Chars<'_>>, wide: bool) -> Result<u32, Bad> {
    let largest = if wide { u32::MAX } else { 0xff };
    let simple = match chars.next() {
        Some('n') => b'\n',
        Some('t') => b'\t',
        Some('r') => b'\r',
        Some('a') => 7,
        Some('b') => 8,
        Some('f') => 12,
        Some('v') => 11,
        Some('e') => 27,
        Some(c @ ('\\' | '\'' | '"' | '?')) => c as u8,
        Some(c @ '0'..='7') => {
            let mut value = c as u32 - 48;
            for _ in 0..2 {
                if let Some(d) = chars.next_if(|d| d.is_digit(8)) {
                    value = value * 8 + d as u32 - 48;
                }
            }
            return match value <= largest {
                true => Ok(value),
                false => bad(CONSTANT_RANGE, "the octal escape is above `\\377`"),
            };
        }
        Some('x') => {
            let mut value = None;
            while let Some(d) = chars.next_if(|d| d.is_ascii_hexdigit()) {
                let digit = u64::from(d.to_digit(16).unwrap_or(0));
                value = Some(u64::min(value.unwrap_or(0) * 16 + digit, 1 << 40));
            }
            return match value {
                Some(value) if value <= u64::from(largest) => Ok(value as u32),
                Some(_) => bad(CONSTANT_RANGE, "the hexadecimal escape is above `\\xff`"),
                None => bad(LEXICAL, "`\\x` needs hexadecimal digits"),
            };
        }
        Some(c) => return bad(LEXICAL, format!("`\\{c}` is no escape sequence")),
        None => return bad(LEXICAL, "`\\` at the end"),
    };
    Ok(u32::from(simple))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(text: &str) -> Option<u32> {
        match number(text) {
            Ok(Literal::Float(FloatConst::Single(bits))) => Some(bits),
            _ => None,
        }
    }

    #[test]
    fn floats_are_rounded_once() {
        assert_eq!(single("0.1f"), Some(0.1f32.to_bits()));
        assert_eq!(single("1.f"), Some(1f32.to_bits()));
        assert_eq!(single(".5e1F"), Some(5f32.to_bits()));
        // Just above halfway between two floats: rounding through binary64 would go down.
        assert_eq!(single("1.00000005960464477540f"), Some(0x3f80_0001));
        assert_eq!(single("0x1p-149f"), Some(1));
        assert_eq!(single("0x1p-150f"), Some(0));
        assert_eq!(single("0x1.000001p-150f"), Some(1));
        assert_eq!(single("0x1.8p1f"), Some(3f32.to_bits()));
        assert_eq!(single("0x1.000001000000000000001p0f"), Some(0x3f80_0001));
        assert_eq!(single("0x1.fffffep127f"), Some(f32::MAX.to_bits()));
        assert_eq!(single("0x1.ffffffp127f"), None);
        assert_eq!(single("1e39f"), None);
        for wrong in ["1.5x", "1e", "1e+f", "0x1.0", "inff", "1.0.0f", "0x.p1f"] {
            assert!(number(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn integers() {
        let value = |text: &str| match number(text) {
            Ok(Literal::Int(int)) => Some((int.value, int.unsigned, int.longs)),
            _ => None,
        };
        assert_eq!(value("0"), Some((0, false, 0)));
        assert_eq!(value("017u"), Some((15, true, 0)));
        assert_eq!(value("0xFFul"), Some((255, true, 1)));
        assert_eq!(value("0b101"), Some((5, false, 0)));
        for wrong in ["08", "12ab", "0x", "1lul", "18446744073709551616", "0u8"] {
            assert_eq!(value(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn characters_are_signed_bytes() {
        assert_eq!(character(r"'\xff'").ok(), Some(-1));
        assert_eq!(character(r"'\0'").ok(), Some(0));
        assert_eq!(character("'ab'").ok(), Some(0x6162));
        assert_eq!(character("L'\\xffff'").ok(), Some(0xffff));
        let text = string(r#""a\101\n""#).ok();
        assert_eq!(text, Some(Literal::Str(b"aA\n".as_slice().into())));
    }
}
