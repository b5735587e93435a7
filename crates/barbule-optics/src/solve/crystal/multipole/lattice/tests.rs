//! Lattice sums against sums over rods one by one, in a medium so lossy that these converge.

use super::*;
use crate::solve::crystal::multipole::Wave;
use crate::solve::crystal::multipole::orders::Orders;

fn wave(kappa: Complex64) -> Wave {
    Wave { k0: 1.0, ky: 0.0, kappa, kappa0: 1.0, eps: Complex64::new(1.0, 0.0), eps0: 1.0 }
}

fn prepared(kappa: Complex64, alpha0: f64, period: f64, q_max: usize) -> (Orders, LatticeSums) {
    let (first, last) = window(kappa, alpha0, period);
    let orders = Orders::new(&wave(kappa), alpha0, period, first - 20, last + 20);
    let sums = LatticeSums::new(kappa, alpha0, period, &orders, q_max);
    (orders, sums)
}

/// Σ_s one by one over ±`images`.
fn one_by_one(kappa: Complex64, alpha0: f64, period: f64, x: f64, z: f64, q: i32, images: i32) -> Complex64 {
    let mut sum = Complex64::new(0.0, 0.0);
    for s in -images..=images {
        let dx = x - f64::from(s) * period;
        let r = dx.hypot(z);
        if r == 0.0 {
            continue;
        }
        let h = Cylinder::new(kappa * r, q.unsigned_abs() as usize + 2).unwrap().h[q.unsigned_abs() as usize];
        let sign = if q < 0 && q % 2 != 0 { -1.0 } else { 1.0 };
        sum += sign
            * h
            * Complex64::cis(alpha0 * f64::from(s) * period)
            * Complex64::cis(f64::from(q) * z.atan2(dx));
    }
    sum
}

#[test]
fn sums_at_the_origin_equal_sums_one_by_one() {
    for (kappa, alpha0, period) in [
        (Complex64::new(24.0, 1.5), 7.0, 0.2),
        (Complex64::new(31.0, 2.0), -17.0, 0.2),
        (Complex64::new(14.0, 2.0), 0.0, 0.16),
        (Complex64::new(31.0, 1.0), 12.0, 0.6),
    ] {
        let (_, sums) = prepared(kappa, alpha0, period, 40);
        for q in -40..=40 {
            let expected =
                one_by_one(kappa, alpha0, period, 0.0, 0.0, q, (37.0 / (kappa.im * period)) as i32 + 1);
            let largest = Cylinder::new(kappa * period, 41).unwrap().h[q.unsigned_abs() as usize].norm();
            let error = (sums.own(q) - expected).norm() / largest.max(1.0);
            assert!(error < 3e-13, "κ {kappa}, α {alpha0}, q {q}: {error:e}, {} {expected}", sums.own(q));
        }
    }
}

#[test]
fn displaced_sums_equal_sums_one_by_one() {
    let (kappa, alpha0, period) = (Complex64::new(25.0, 2.0), 9.0, 0.2);
    let (orders, sums) = prepared(kappa, alpha0, period, 40 + 2 * REST);
    for (x, z) in
        [(0.1, 0.0), (0.07, 0.02), (-0.09, 0.05), (0.31, -0.1), (0.02, 0.139), (0.05, 0.145), (-0.1, -0.18)]
    {
        let found = sums.displaced(&orders, x, z, 30).unwrap();
        for q in -30i32..=30 {
            let expected = one_by_one(kappa, alpha0, period, x, z, q, 100);
            let near = Cylinder::new(kappa * (x - period * (x / period).round()).hypot(z), 40).unwrap().h
                [q.unsigned_abs() as usize];
            let error = (found[(q + 30) as usize] - expected).norm() / near.norm();
            assert!(error < 1e-9, "({x}, {z}), q {q}: {error:e}");
        }
    }
}
