//! Where a feather has pigment: bars across it, a pale tip.

use crate::math::rng::split_mix;

/// Pigment over a vane. Lengths are mm. A place's coordinate is where its barb leaves the shaft, and so much further as bars lean
/// along the barbs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pattern {
    /// Distance between dark bars; without bars, 0.
    pub spacing: f64,
    /// Share of that distance that is dark.
    pub dark_share: f64,
    /// How far the coordinate grows on a mm along a barb: 0, bars follow the barbs.
    pub lean: f64,
    /// Where the pale tip begins; infinity: there is none.
    pub tip: f64,
    /// Standard deviation of the edges from barbule to barbule.
    pub edge: f64,
    /// Pigment of pale places over that of dark ones.
    pub pale: f64,
}

impl Pattern {
    /// Whether a barbule or a piece of ramus of this name is dark, on a barb that leaves the shaft at `station` and `arc` along it.
    #[inline]
    #[must_use]
    pub fn is_dark(&self, station: f64, arc: f64, name: u64) -> bool {
        let bits = split_mix(name ^ 0x2545_f491_4f6c_dd1d);
        let part = |k: u32| (bits >> (16 * k) & 0xffff) as f64;
        // Of deviation 1: the sum of two uniform numbers.
        let tent = (part(0) + part(1) - 65_535.0) * (6.0_f64 / 4_294_967_295.0).sqrt();
        let at = station + self.lean * arc + self.edge * tent;
        let is_bar = self.spacing <= 0.0 || (at / self.spacing).rem_euclid(1.0) < self.dark_share;
        at < self.tip && is_bar
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_take_their_share_and_tips_are_pale() {
        let bars = Pattern { spacing: 8.0, dark_share: 0.3, lean: 0.4, tip: 90.0, edge: 0.3, pale: 0.1 };
        let count = 80_000;
        let dark =
            (0..count).filter(|n| bars.is_dark(0.001 * f64::from(*n), 0.0, u64::from(*n as u32))).count();
        assert!((dark as f64 / f64::from(count) - 0.3).abs() < 0.005, "{dark}");
        assert!((0..1000).all(|n| !bars.is_dark(95.0, 0.0, n)
            && bars.is_dark(57.2, 0.0, n)
            && bars.is_dark(56.2, 2.5, n)));
    }
}
