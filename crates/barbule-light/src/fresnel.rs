//! Reflectance of single boundaries.

/// Unpolarized Fresnel reflectance from air onto a dielectric; incidence by its cosine.
#[inline(always)]
#[must_use]
pub fn fresnel(cosine: f64, index: f64) -> f64 {
    let c = cosine.clamp(0.0, 1.0);
    let t = (1.0 - (1.0 - c * c) / (index * index)).max(0.0).sqrt();
    let s = (c - index * t) / (c + index * t);
    let p = (index * c - t) / (index * c + t);
    0.5 * (s * s + p * p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_is_four_percent_at_normal_incidence_and_one_at_grazing() {
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-15);
        assert!((fresnel(0.0, 1.5) - 1.0).abs() < 1e-15);
        // Brewster's angle: half of s.
        let cosine = 1.0 / (1.0_f64 + 1.5 * 1.5).sqrt();
        let s: f64 = (1.0 - 2.25) / (1.0 + 2.25);
        assert!((fresnel(cosine, 1.5) - 0.5 * s * s).abs() < 1e-12);
    }
}
