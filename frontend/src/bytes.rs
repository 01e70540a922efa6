//! Sources that are not UTF-8, such as those in Latin-1.
//!
//! A byte that is no part of a character stands in the text as a character of its own, from
//! U+EF80 to U+EFFF; constants have the byte again. Comments may hold any bytes, then, and strings keep
//! theirs. A source's own characters of that range are taken apart into bytes, so that nothing is lost.

/// The character that stands for byte 0; those of bytes from 0x80 on are used.
const ZERO: u32 = 0xef00;

/// The text of a source.
pub fn decode(bytes: Vec<u8>) -> String {
    let bytes = match String::from_utf8(bytes) {
        Ok(text) if text.chars().all(|c| byte_of(c).is_none()) => return text,
        Ok(text) => text.into_bytes(),
        Err(error) => error.into_bytes(),
    };
    let stands_for = |byte: &u8| char::from_u32(ZERO + u32::from(*byte)).unwrap_or('?');
    let mut text = String::new();
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            match byte_of(c) {
                None => text.push(c),
                Some(_) => {
                    let mut own = [0; 4];
                    text.extend(c.encode_utf8(&mut own).as_bytes().iter().map(stands_for));
                }
            }
        }
        text.extend(chunk.invalid().iter().map(stands_for));
    }
    text
}

/// The byte that a character of a source stands for.
pub(crate) fn byte_of(c: char) -> Option<u8> {
    let byte = u32::from(c).checked_sub(ZERO)?;
    u8::try_from(byte).ok().filter(|&byte| byte >= 0x80)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        let all: Vec<u8> = (0..=255).chain(*b"\xc3\xa9\xee\xbe\x80\xff").collect();
        let text = decode(all.clone());
        let back = text.chars().flat_map(|c| match byte_of(c) {
            Some(byte) => vec![byte],
            None => c.to_string().into_bytes(),
        });
        assert_eq!(back.collect::<Vec<u8>>(), all);
        assert_eq!(decode("né".into()), "né");
    }
}
