//! How well colours are told apart: receptor noise.

use super::{Catches, Eye};

/// Which class of cones has the Weber fraction that is given; the noise of the others follows from their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// The one with the longest wavelengths, as pavo's `weber.ref = "longest"`.
    Longest,
    /// The one of which there are fewest.
    Rarest,
}

/// The noise of each class of cones: e = ω √(n_ref / n).
#[derive(Debug, Clone, PartialEq)]
pub struct Noise(Vec<f64>);

impl Noise {
    /// The noise of an eye's cones.
    #[must_use]
    pub fn of(eye: &Eye, reference: Reference) -> Self {
        let abundance: Vec<f64> = eye.cones.iter().map(|cone| cone.abundance).collect();
        Self::new(&abundance, eye.weber, reference)
    }

    /// The noise of cones of these numbers, rising in wavelength.
    #[must_use]
    pub fn new(abundance: &[f64], weber: f64, reference: Reference) -> Self {
        let reference = match reference {
            Reference::Longest => abundance.last().copied().unwrap_or(1.0),
            Reference::Rarest => abundance.iter().copied().fold(f64::INFINITY, f64::min),
        };
        Self(abundance.iter().map(|n| weber * (reference / n).sqrt()).collect())
    }

    /// Of each class of cones.
    #[must_use]
    pub fn each(&self) -> &[f64] {
        &self.0
    }

    /// ΔS of two colours in just noticeable differences (Vorobyev & Osorio 1998, *Proc. R. Soc. B* 265, 351), of any number of classes
    /// of cones; none where a catch is not above 0.
    ///
    /// With Δf = ln(q / q') and weights w = e⁻², it is √(Σ w (Δf − m)²) with m the weighted mean of Δf: how far apart the signals are
    /// in units of their noise, after the best guess of how bright each is. For two, three and four classes that is the closed form of
    /// the paper, for any number its form with matrices.
    #[must_use]
    pub fn delta_s(&self, one: &Catches, other: &Catches) -> Option<f64> {
        let signals: Vec<f64> =
            one.cones.iter().zip(&other.cones).map(|(a, b)| contrast(*a, *b)).collect::<Option<_>>()?;
        let weights = self.0.iter().map(|noise| 1.0 / (noise * noise));
        let total: f64 = weights.clone().sum();
        let mean = signals.iter().zip(weights.clone()).map(|(f, w)| f * w).sum::<f64>() / total;
        Some(signals.iter().zip(weights).map(|(f, w)| w * (f - mean) * (f - mean)).sum::<f64>().sqrt())
    }
}

/// ΔL of two colours in just noticeable differences, by the double cones (Siddiqi et al. 2004, *J. Exp. Biol.* 207, 2471): |ln(q / q')| / ω;
/// none without double cones or where a catch is not above 0.
#[must_use]
pub fn achromatic_difference(weber: f64, one: &Catches, other: &Catches) -> Option<f64> {
    Some(contrast(one.double?, other.double?)?.abs() / weber)
}

fn contrast(a: f64, b: f64) -> Option<f64> {
    (a > 0.0 && b > 0.0).then(|| (a / b).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn catches(cones: &[f64]) -> Catches {
        Catches { cones: cones.to_vec(), double: Some(cones[0]) }
    }

    /// Vorobyev & Osorio 1998, equation 5, written out for four cones.
    fn closed_form(e: &[f64], d: &[f64]) -> f64 {
        let square = |x: f64| x * x;
        let pair = |a: usize, b: usize, c: usize, f: usize| square(e[a] * e[b]) * square(d[f] - d[c]);
        let above = pair(0, 1, 2, 3)
            + pair(0, 2, 1, 3)
            + pair(0, 3, 1, 2)
            + pair(1, 2, 0, 3)
            + pair(1, 3, 0, 2)
            + pair(2, 3, 0, 1);
        let triple = |a: usize, b: usize, c: usize| square(e[a] * e[b] * e[c]);
        (above / (triple(0, 1, 2) + triple(0, 1, 3) + triple(0, 2, 3) + triple(1, 2, 3))).sqrt()
    }

    /// The form with matrices: differences A d of neighbours with the covariance A E Aᵀ, by elimination.
    fn matrix_form(e: &[f64], d: &[f64]) -> f64 {
        let n = e.len() - 1;
        let mut rows: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let covariance = |j: usize| match i.abs_diff(j) {
                    0 => e[i] * e[i] + e[i + 1] * e[i + 1],
                    1 => -e[i.max(j)] * e[i.max(j)],
                    _ => 0.0,
                };
                (0..n).map(covariance).chain([d[i] - d[i + 1]]).collect()
            })
            .collect();
        let x: Vec<f64> = rows.iter().map(|row| row[n]).collect();
        for i in 0..n {
            for k in 0..n {
                if k != i {
                    let pivot = rows[i].clone();
                    let factor = rows[k][i] / pivot[i];
                    rows[k].iter_mut().zip(&pivot).for_each(|(a, b)| *a -= factor * b);
                }
            }
        }
        (0..n).map(|i| x[i] * rows[i][n] / rows[i][i]).sum::<f64>().sqrt()
    }

    #[test]
    fn five_percent_more_for_the_long_cone_is_the_published_number() {
        let q = [0.1, 0.3, 0.5, 0.4];
        let more = [0.1, 0.3, 0.5, 0.42];
        let of = |reference| Noise::new(&[1.0, 2.0, 2.0, 4.0], 0.1, reference);
        let longest = of(Reference::Longest).delta_s(&catches(&q), &catches(&more)).unwrap();
        assert!((longest - 0.36366).abs() < 5e-6, "{longest}");
        // Four times as many long cones as of the rarest: half the noise.
        let rarest = of(Reference::Rarest).delta_s(&catches(&q), &catches(&more)).unwrap();
        assert!((rarest / longest - 2.0).abs() < 1e-12);
        assert_eq!(of(Reference::Longest).each()[3], 0.1);
        assert_eq!(of(Reference::Rarest).each()[0], 0.1);
    }

    #[test]
    fn it_is_the_closed_form_and_the_form_with_matrices() {
        let q = [0.02, 0.3, 0.51, 0.4, 0.09, 0.7];
        let other = [0.03, 0.27, 0.5, 0.46, 0.11, 0.69];
        let n = [1.0, 1.92, 2.68, 2.7, 0.4, 3.0];
        for count in 2..=6 {
            let noise = Noise::new(&n[..count], 0.07, Reference::Longest);
            let d: Vec<f64> = (0..count).map(|i| f64::ln(q[i] / other[i])).collect();
            let found = noise.delta_s(&catches(&q[..count]), &catches(&other[..count])).unwrap();
            let expected = matrix_form(noise.each(), &d);
            assert!((found / expected - 1.0).abs() < 1e-12, "{count}: {found} {expected}");
            if count == 4 {
                assert!((found / closed_form(noise.each(), &d) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn brightness_alone_is_no_colour_and_is_seen_by_double_cones() {
        let (q, twice) = (catches(&[0.1, 0.2, 0.3]), catches(&[0.2, 0.4, 0.6]));
        let noise = Noise::new(&[1.0, 1.0, 1.0], 0.1, Reference::Longest);
        assert!(noise.delta_s(&q, &twice).unwrap() < 1e-12);
        assert!((achromatic_difference(0.1, &q, &twice).unwrap() - 10.0 * 2_f64.ln()).abs() < 1e-12);
        let dark = catches(&[0.0, 0.2, 0.3]);
        assert_eq!((noise.delta_s(&q, &dark), achromatic_difference(0.1, &q, &dark)), (None, None));
        let single = Catches { double: None, ..q.clone() };
        assert_eq!(achromatic_difference(0.1, &single, &q), None);
    }
}
