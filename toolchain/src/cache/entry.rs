//! The form of an entry: its bytes, then a trailer that identifies and protects them.
//!
//! The trailer comes last because a simulator is loaded from the file as it stands, and loaders do
//! not mind bytes behind a library.
//!
//! | bytes | |
//! |---|---|
//! | n | the bytes of the result |
//! | 32 | the key's digest |
//! | 32 | the digest of the n bytes |
//! | 8 | n, least significant byte first |
//! | 8 | `srpcach1` |

use super::Key;
use std::fmt;

/// The last bytes of every entry; another form has others.
const MAGIC: [u8; 8] = *b"srpcach1";

/// Bytes of a trailer.
const TRAILER: usize = Key::BYTES + 32 + 8 + MAGIC.len();

/// Why the bytes of an entry cannot be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// They end before the trailer, or the trailer is none.
    Trailer,
    /// They are an entry of another key.
    Key,
    /// They are fewer or more than the trailer says.
    Length,
    /// Their digest is another.
    Digest,
    /// They are whole, and no value of the kind that was put there.
    Shape,
    /// They are a program that breaks the rules of its machine.
    Rules,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Damage::Trailer => "it has no end",
            Damage::Key => "it belongs to something else",
            Damage::Length => "it has another length than it says",
            Damage::Digest => "its bytes have changed",
            Damage::Shape => "its bytes are no value",
            Damage::Rules => "its program breaks rules of its machine",
        })
    }
}

/// The trailer of an entry.
pub(super) fn trailer(key: Key, bytes: &[u8]) -> Vec<u8> {
    let mut trailer = Vec::with_capacity(TRAILER);
    trailer.extend_from_slice(key.digest());
    trailer.extend_from_slice(blake3::hash(bytes).as_bytes());
    trailer.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
    trailer.extend_from_slice(&MAGIC);
    trailer
}

/// Checks the bytes of a file and returns those of the result.
///
/// # Errors
///
/// They are not as the cache wrote them.
pub(super) fn open(key: Key, mut file: Vec<u8>) -> Result<Vec<u8>, Damage> {
    let length = file.len().checked_sub(TRAILER).ok_or(Damage::Trailer)?;
    let (bytes, trailer) = file.split_at(length);
    let (of_key, rest) = trailer.split_at(Key::BYTES);
    let (digest, rest) = rest.split_at(32);
    let (says, magic) = rest.split_at(8);
    if magic != MAGIC {
        return Err(Damage::Trailer);
    }
    if of_key != key.digest() {
        return Err(Damage::Key);
    }
    if says != (length as u64).to_le_bytes() {
        return Err(Damage::Length);
    }
    if digest != blake3::hash(bytes).as_bytes() {
        return Err(Damage::Digest);
    }
    file.truncate(length);
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::super::Kind;
    use super::*;

    fn entry(bytes: &[u8]) -> (Key, Vec<u8>) {
        let key = Key::of(Kind::Simulators).bytes(bytes).finish();
        (key, [bytes, &trailer(key, bytes)].concat())
    }

    #[test]
    fn whole_entries_open() {
        for bytes in [&b""[..], b"a", &[7; 1000]] {
            let (key, file) = entry(bytes);
            assert_eq!(open(key, file), Ok(bytes.to_vec()));
        }
    }

    #[test]
    fn every_damage_is_noticed() {
        let (key, file) = entry(b"some bytes");
        for cut in 0..file.len() {
            assert!(open(key, file[..cut].to_vec()).is_err(), "{cut} bytes");
        }
        for at in 0..file.len() {
            let mut file = file.clone();
            file[at] ^= 0x40;
            assert!(open(key, file).is_err(), "byte {at}");
        }
        let longer = [&b"x"[..], &file].concat();
        assert_eq!(open(key, longer), Err(Damage::Length));
        let (other, _) = entry(b"other bytes");
        assert_eq!(open(other, file), Err(Damage::Key));
    }
}
