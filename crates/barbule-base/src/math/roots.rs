//! Square roots on the branch of waves.

use num_complex::Complex64;

/// The root with Im ≥ 0, and Re ≥ 0 where it is real: a wave e^{jqz} that decays along z, or goes there.
#[must_use]
pub fn decaying_root(square: Complex64) -> Complex64 {
    let value = square.sqrt();
    if value.im < 0.0 || (value.im == 0.0 && value.re < 0.0) { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_decay_or_go_forth() {
        for (square, root) in
            [((4.0, 0.0), (2.0, 0.0)), ((-4.0, 0.0), (0.0, 2.0)), ((-4.0, -0.0), (0.0, 2.0))]
        {
            let found = decaying_root(Complex64::new(square.0, square.1));
            assert_eq!((found.re.abs(), found.im), root);
        }
        let amplified = decaying_root(Complex64::new(3.0, -4.0));
        assert!((amplified - Complex64::new(-2.0, 1.0)).norm() < 1e-15);
    }
}
