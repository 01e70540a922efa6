//! Amounts as people write them: `2000`, `2e3`, `500M`, `2G`.

/// The units of bytes, the largest first: their letters, and how many bytes they are.
const UNITS: [(char, u64); 3] = [('G', 1 << 30), ('M', 1 << 20), ('K', 1 << 10)];

/// A whole number, which may have an exponent, and behind it K, M or G for powers of 1024. `None` of other texts, and
/// of numbers beyond 2⁶⁴ − 1.
pub fn parse(text: &str) -> Option<u64> {
    let text = text.trim();
    let unit_of =
        |&(letter, _): &(char, u64)| text.ends_with([letter, letter.to_ascii_lowercase()]);
    let (number, unit) = match UNITS.into_iter().find(unit_of) {
        Some((_, bytes)) => (text[..text.len() - 1].trim_end(), bytes),
        None => (text, 1),
    };
    let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let is_plain = |digits: &str| digits.bytes().all(|b| b.is_ascii_digit());
    if !is_plain(digits) || !is_plain(exponent) {
        return None;
    }
    let power = 10_u64.checked_pow(exponent.parse().ok()?)?;
    let number = digits.parse::<u64>().ok()?.checked_mul(power)?;
    number.checked_mul(unit)
}

/// A number of bytes with the largest unit that it is a multiple of.
pub fn of_bytes(bytes: u64) -> String {
    let unit = UNITS.iter().find(|(_, unit)| bytes.is_multiple_of(*unit));
    unit.map_or_else(
        || bytes.to_string(),
        |(letter, unit)| format!("{}{letter}", bytes / unit),
    )
}

#[cfg(test)]
mod tests {
    use super::{of_bytes, parse};

    #[test]
    fn amounts_are_read_or_refused() {
        let right = [
            ("7", 7),
            ("2e3", 2000),
            (" 500 M ", 500 << 20),
            ("1536m", 1536 << 20),
            ("16777215G", 16_777_215 << 30),
        ];
        for (text, amount) in right {
            assert_eq!(parse(text), Some(amount), "{text}");
        }
        for wrong in [
            "",
            "G",
            "e3",
            "2e",
            "-1",
            "+1",
            "1.5",
            "2T",
            "1e99",
            "17179869184G",
            "99999999999999999999",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
        for text in ["1G", "1536M", "2K", "7"] {
            assert_eq!(parse(text).map(of_bytes).as_deref(), Some(text));
        }
    }
}
