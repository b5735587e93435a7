//! Barbules that lie either way round: beside every field stands its mirror image.
//!
//! In the mirror x → −x light from φ_i comes from −φ_i and leaves to −φ_o; e₁ stays what it is there, and e₂ points the
//! other way. So with E = (a, b) along e₁, e₂ at φ_o under the first polarization from −φ_i, the mirrored barbule scatters
//! (a, −b) to −φ_o from φ_i; under the second one (−a, b).

use num_complex::Complex;

use crate::scattering::statistics::Axes;

/// Splits the fields of one instance, `[φ_i of both signs][polarization][e₁, e₂][azimuth]`, into its own at φ_i ≥ 0 and those
/// of its mirror image; `points` are azimuths, `both` the axes that were simulated.
pub(super) fn with_image(
    mut fields: Vec<Complex<f32>>,
    both: &Axes,
    points: usize,
) -> [Vec<Complex<f32>>; 2] {
    let (cosines, per_phi) = (both.cos_phi().len(), 4 * points);
    let mut image = Vec::with_capacity(cosines * per_phi);
    for phi in 0..cosines {
        // Light from the normal plane is its own image.
        let other = if cosines + phi < both.phis() { cosines + phi } else { phi };
        for part in 0..4 {
            let start = other * per_phi + part * points;
            let [polarization, component] = [part / 2, part % 2];
            let sign = if polarization == component { 1.0 } else { -1.0 };
            image.extend(fields[start..start + points].iter().rev().map(|value| value * sign));
        }
    }
    fields.truncate(cosines * per_phi);
    fields.shrink_to_fit();
    [fields, image]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::statistics::Sides;
    use crate::spectrum::Wavelengths;

    #[test]
    fn images_are_reversed_and_across_the_polarization_negated() {
        let wavelengths = Wavelengths::new([500.0]).unwrap();
        let both = Axes::new(&wavelengths, vec![1.0], vec![0.5, 1.0]).unwrap().with_sides(Sides::Both);
        let points = 3;
        let fields: Vec<_> = (0..both.phis() * 4 * points).map(|n| Complex::new(n as f32, 1.0)).collect();
        let [own, image] = with_image(fields.clone(), &both, points);
        assert_eq!(own, fields[..24]);
        // From −60°, which is number 2; then from 0°.
        let real =
            |part: usize| image[part * points..(part + 1) * points].iter().map(|v| v.re).collect::<Vec<_>>();
        assert_eq!(real(0), [26.0, 25.0, 24.0]);
        assert_eq!(real(1), [-29.0, -28.0, -27.0]);
        assert_eq!(real(2), [-32.0, -31.0, -30.0]);
        assert_eq!(real(3), [35.0, 34.0, 33.0]);
        assert_eq!(real(4), [14.0, 13.0, 12.0]);
        assert_eq!(image.len(), own.len());
    }
}
