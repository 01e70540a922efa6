//! Keys: digests over everything that a result depends on.
//!
//! A key is made of whole values, never of some of their fields, so that a field that is added to a
//! machine or an option is in the key without anybody thinking of it.

use super::Kind;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Names one result.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    kind: Kind,
    digest: [u8; 32],
}

impl Key {
    /// Bytes of a digest.
    pub const BYTES: usize = 32;

    /// Begins a key of this kind.
    pub fn of(kind: Kind) -> Builder {
        let mut hasher = blake3::Hasher::new();
        hasher.update(kind.name().as_bytes());
        Builder { kind, hasher }
    }

    /// The kind of result that it names.
    pub const fn kind(self) -> Kind {
        self.kind
    }

    /// The digest.
    pub const fn digest(&self) -> &[u8; 32] {
        &self.digest
    }

    /// The key of this kind with a digest in hexadecimal digits.
    pub(super) fn parse(kind: Kind, hex: &str) -> Option<Key> {
        let digest = blake3::Hash::from_hex(hex).ok()?;
        Some(Key {
            kind,
            digest: *digest.as_bytes(),
        })
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&blake3::Hash::from_bytes(self.digest).to_hex())
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{self}", self.kind.name())
    }
}

/// A key in the making. Every part goes in with its length, so that no two lists of parts look the
/// same.
pub struct Builder {
    kind: Kind,
    hasher: blake3::Hasher,
}

impl Builder {
    /// Adds bytes.
    pub fn bytes(mut self, bytes: &[u8]) -> Builder {
        self.hasher.update(&(bytes.len() as u64).to_le_bytes());
        self.hasher.update(bytes);
        self
    }

    /// Adds a text.
    pub fn text(self, text: &str) -> Builder {
        self.bytes(text.as_bytes())
    }

    /// Adds a value, all of it.
    ///
    /// # Panics
    ///
    /// Where the value cannot be serialised, which is a mistake in its type.
    pub fn value(self, value: &impl Serialize) -> Builder {
        let bytes = postcard::to_allocvec(value).expect("values of keys can be serialised");
        self.bytes(&bytes)
    }

    /// The key.
    pub fn finish(self) -> Key {
        Key {
            kind: self.kind,
            digest: *self.hasher.finalize().as_bytes(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_do_not_run_together() {
        let key = |a: &str, b: &str| Key::of(Kind::Loops).text(a).text(b).finish();
        assert_ne!(key("ab", "c"), key("a", "bc"));
        assert_ne!(key("", "x"), key("x", ""));
        assert_eq!(key("a", "b"), key("a", "b"));
        let other = Key::of(Kind::Trials).text("a").text("b").finish();
        assert_ne!(other.digest(), key("a", "b").digest());
    }

    #[test]
    fn floats_that_are_not_numbers_differ() {
        let key = |x: f32| Key::of(Kind::Loops).value(&x).finish();
        assert_ne!(key(f32::NAN), key(f32::INFINITY));
        assert_ne!(key(0.0), key(-0.0));
    }

    #[test]
    fn keys_read_back() {
        let key = Key::of(Kind::Frames).finish();
        assert_eq!(Key::parse(Kind::Frames, &key.to_string()), Some(key));
        assert_eq!(Key::parse(Kind::Frames, "no key"), None);
    }
}
