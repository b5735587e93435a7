//! Reflection at a smooth boundary.

/// Unpolarized Fresnel reflectance from air onto a dielectric.
#[inline(always)]
pub(super) fn fresnel(cosine: f64, index: f64) -> f64 {
    let c = cosine.clamp(0.0, 1.0);
    let t = (1.0 - (1.0 - c * c) / (index * index)).max(0.0).sqrt();
    let s = (c - index * t) / (c + index * t);
    let p = (index * c - t) / (index * c + t);
    0.5 * (s * s + p * p)
}
