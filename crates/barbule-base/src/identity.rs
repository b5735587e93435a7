//! Hashes that name a value by its content, whatever its types and fields are called in this program.
//!
//! A value is fed field by field: the tag of a field, the kind and the length of what follows, then its bytes. Tags are
//! literals, so renaming a type, field or variant changes no hash; [`VERSION`] is part of every hash and rises when
//! what is fed changes.

/// Version of what is fed; 1 were hashes of `Debug` texts, which nothing reads any more.
pub const VERSION: u64 = 2;

/// A value that has an identity.
pub trait Identify {
    /// Feeds everything that decides the value. Implementations take structs apart without `..`, so that a new field does not
    /// compile until it is fed or left out on purpose.
    fn feed(&self, to: &mut Hasher);
}

impl<T: Identify> Identify for &T {
    fn feed(&self, to: &mut Hasher) {
        T::feed(self, to);
    }
}

/// BLAKE3 over tagged fields, each with its kind and length, so that no two lists of fields feed the same bytes.
#[derive(Debug, Clone)]
pub struct Hasher(blake3::Hasher);

impl Hasher {
    /// Begins the identity of a kind of value, as in `lattice`.
    #[must_use]
    pub fn new(kind: &str) -> Self {
        let mut hasher = Self(blake3::Hasher::new());
        hasher.text("barbule", kind).count("identity", VERSION);
        hasher
    }

    /// A text.
    pub fn text(&mut self, tag: &str, value: &str) -> &mut Self {
        self.field(tag, b't', value.len());
        self.0.update(value.as_bytes());
        self
    }

    /// A whole number.
    pub fn count(&mut self, tag: &str, value: u64) -> &mut Self {
        self.field(tag, b'c', 1);
        self.0.update(&value.to_le_bytes());
        self
    }

    /// A number by its bits; −0 counts as 0.
    pub fn number(&mut self, tag: &str, value: f64) -> &mut Self {
        self.numbers(tag, &[value])
    }

    /// Numbers by their bits; −0 counts as 0.
    pub fn numbers(&mut self, tag: &str, values: &[f64]) -> &mut Self {
        self.field(tag, b'n', values.len());
        for value in values {
            self.0.update(&(value + 0.0).to_bits().to_le_bytes());
        }
        self
    }

    /// A part with fields of its own.
    pub fn part(&mut self, tag: &str, value: &impl Identify) -> &mut Self {
        self.list(tag, [value])
    }

    /// Parts in their order; an optional one is a list of none or one.
    pub fn list<I>(&mut self, tag: &str, values: I) -> &mut Self
    where
        I: IntoIterator<Item: Identify, IntoIter: ExactSizeIterator>,
    {
        let values = values.into_iter();
        self.field(tag, b'l', values.len());
        for value in values {
            value.feed(self);
            self.0.update(b".");
        }
        self
    }

    /// The hash of all that was fed.
    #[must_use]
    pub fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }

    /// The hash of all that was fed, in hexadecimal.
    #[must_use]
    pub fn hex(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }

    fn field(&mut self, tag: &str, kind: u8, length: usize) {
        self.0.update(&(tag.len() as u64).to_le_bytes());
        self.0.update(tag.as_bytes());
        self.0.update(&[kind]);
        self.0.update(&(length as u64).to_le_bytes());
    }
}

/// The identity of one value, in hexadecimal.
#[must_use]
pub fn hash(kind: &str, value: &impl Identify) -> String {
    let mut hasher = Hasher::new(kind);
    value.feed(&mut hasher);
    hasher.hex()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fed(feed: impl Fn(&mut Hasher)) -> String {
        let mut hasher = Hasher::new("test");
        feed(&mut hasher);
        hasher.hex()
    }

    #[test]
    fn zero_has_no_sign_and_every_border_between_fields_counts() {
        assert_eq!(fed(|h| _ = h.number("a", -0.0)), fed(|h| _ = h.number("a", 0.0)));
        let different = [
            fed(|h| _ = h.text("a", "bc")),
            fed(|h| _ = h.text("ab", "c")),
            fed(|h| _ = h.text("a", "b").text("c", "")),
            fed(|h| _ = h.numbers("a", &[1.0, 2.0])),
            fed(|h| _ = h.number("a", 1.0).number("a", 2.0)),
            fed(|h| _ = h.count("a", 1)),
            fed(|h| _ = h.count("a", 1f64.to_bits())),
            fed(|h| _ = h.number("a", 1.0)),
        ];
        for (index, one) in different.iter().enumerate() {
            assert!(!different[..index].contains(one), "{index}");
        }
    }
}
