//! Which kinds of scattering a surface has.

/// A set of kinds: where light goes, and how sharply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lobes(u8);

impl Lobes {
    /// To the viewer's side.
    pub const REFLECTION: Self = Self(1);
    /// To the other side.
    pub const TRANSMISSION: Self = Self(1 << 1);
    /// Smoothly into all directions.
    pub const DIFFUSE: Self = Self(1 << 2);
    /// Into a lobe.
    pub const GLOSSY: Self = Self(1 << 3);
    /// Into single directions, which no light's sample ever meets.
    pub const DELTA: Self = Self(1 << 4);

    /// Those of both sets.
    #[inline(always)]
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all kinds of another set are in this one.
    #[inline(always)]
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}
