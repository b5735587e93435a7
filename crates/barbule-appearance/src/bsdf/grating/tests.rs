use std::f64::consts::FRAC_1_SQRT_2;

use super::*;
use crate::math::rng::Stream;
use crate::scattering::grating::Orders;

/// Orders along x and y by their powers, a period of 2 µm.
fn powers(of: impl Fn(i64, i64) -> f32) -> Arc<Powers> {
    let orders = Orders { most: [6, 6], period_um: [2.0, 2.0] };
    let series = (-6..=6).flat_map(|j| (-6..=6).map(move |i| (i, j))).flat_map(|(i, j)| {
        // A quarter of it changes with κ.
        [0.75 * of(i, j), 0.25 * of(i, j)]
    });
    Arc::new(Powers::new(orders, 2.0 * TAU / 0.38, 2, series.collect()).unwrap())
}

/// A rough patch of this side, µm: one order in the mirror's direction, and haze to ± 1/µm about it.
fn patch(side_um: f64) -> Arc<Powers> {
    let most = (2.0 * side_um) as usize;
    let orders = Orders { most: [most; 2], period_um: [side_um; 2] };
    let at = |i: usize| (i as f64 - most as f64) / side_um;
    let power = |i: usize, j: usize| match (i == most && j == most, at(i).hypot(at(j))) {
        (true, _) => 0.3,
        (_, f) => 0.7 / (PI * side_um * side_um) * libm::exp(-f * f),
    };
    let all = (0..2 * most + 1).flat_map(|j| (0..2 * most + 1).map(move |i| power(i, j) as f32));
    Arc::new(Powers::new(orders, 2.0 * TAU / 0.38, 1, all.collect()).unwrap())
}

/// Whose orders are so close that a table stands for them.
pub(in crate::bsdf) fn rough() -> Grating {
    Grating::new(&patch(20.0), 2.0, 1.5, [0.2, 0.1, 0.3]).unwrap()
}

pub(in crate::bsdf) fn grating() -> Grating {
    let share = |i: i64, j: i64| match (i, j) {
        (0, 0) => 0.4,
        (1, 0) => 0.3,
        (0, -1 | 1) => 0.1,
        _ => 0.0,
    };
    Grating::new(&powers(share), 2.0, 1.5, [0.2, 0.1, 0.3]).unwrap()
}

fn mirror(coherence: f64) -> Grating {
    let orders = Orders { most: [0, 0], period_um: [2.0, 2.0] };
    let powers = Powers::new(orders, 2.0 * TAU / 0.38, 1, vec![1.0]).unwrap();
    Grating::new(&Arc::new(powers), coherence, 1.5, [0.0; 3]).unwrap()
}

/// ∫ f cosθ_i dω_i at the first wavelength over a square of direction cosines.
fn energy(surface: &Grating, wo: DVec3, nm: f64, about: [f64; 2], half: f64) -> f64 {
    let bsdf = surface.bind(&Hit::default(), wo, Lambdas::splat(nm));
    let steps = 300;
    let step = 2.0 * half / f64::from(steps);
    let mut sum = 0.0;
    for i in 0..steps {
        for j in 0..steps {
            let at = |i: i32, middle: f64| middle + (f64::from(i) + 0.5) * step - half;
            let (x, y) = (at(i, about[0]), at(j, about[1]));
            let up = 1.0 - x * x - y * y;
            if up > 0.0 {
                sum += bsdf.eval(DVec3::new(x, y, up.sqrt())).f[0] * step * step;
            }
        }
    }
    sum
}

#[test]
fn a_flat_one_is_a_mirror_with_a_lobe() {
    for nm in [420.0, 650.0] {
        for polar in [0.0, 0.6, 1.0_f64] {
            let wo = DVec3::new(polar.sin() * 0.6, polar.sin() * 0.8, polar.cos());
            let found = energy(&mirror(8.0), wo, nm, [-wo.x, -wo.y], 0.12);
            assert!((found / fresnel(wo.z, 1.5) - 1.0).abs() < 3e-3, "{nm} {polar}: {found}");
        }
    }
}

/// In its standard deviation λ s_f/√2 too.
#[test]
fn lobes_are_as_wide_as_the_coherence_says() {
    let (nm, coherence) = (500.0, 8.0);
    let surface = mirror(coherence);
    let bsdf = surface.bind(&Hit::default(), DVec3::Z, Lambdas::splat(nm));
    let (mut whole, mut second) = (0.0, 0.0);
    for i in -400..=400 {
        let x = 2e-4 * f64::from(i);
        let f = bsdf.eval(DVec3::new(x, 0.0, (1.0 - x * x).sqrt())).f[0];
        whole += f;
        second += f * x * x;
    }
    let expected = 0.5 / (TAU * coherence) * FRAC_1_SQRT_2;
    assert!(((second / whole).sqrt() / expected - 1.0).abs() < 0.01);
}

/// Sampled energies are those of the integral, and orders are where the grating equation says.
#[test]
fn orders_leave_where_the_grating_equation_says() {
    let surface = grating();
    let wo = DVec3::new(0.3, 0.0, (1.0_f64 - 0.09).sqrt());
    let nm = 600.0;
    let bsdf = surface.bind(&Hit::default(), wo, Lambdas::splat(nm));
    let at = |x: f64, y: f64| bsdf.eval(DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())).f[0];
    // ω_i,x = −ω_o,x − j λ/T.
    let order = at(-0.3 - 0.3, 0.0);
    assert!(order > 10.0 * at(-0.3 + 0.3, 0.0) && at(-0.3, 0.3) > 5.0 * at(-0.3 - 0.15, 0.15));
    let mut stream = Stream::new(4, &[]);
    let mut sum = 0.0;
    for _ in 0..40_000 {
        if let Some(sample) = bsdf.sample([stream.unit(), stream.unit(), stream.unit()]) {
            sum += sample.evaluation.f[0] * sample.evaluation.cosine / sample.evaluation.pdf[0] / 4e4;
        }
    }
    let whole = energy(&surface, wo, nm, [0.0; 2], 1.0);
    assert!((sum / whole - 1.0).abs() < 0.01, "{sum} {whole}");
}

/// Orders summed themselves and a table of them give the same light: in all, and in each direction within what tents make of a Gaussian of
/// their own width: in the middle of a lone order they are (6/5)^½ higher along either axis, since the table's window is so much narrower.
#[test]
fn a_table_stands_for_its_orders() {
    let powers = patch(20.0);
    for coherence in [4.0, 8.0, 16.25] {
        let deviation = of_powers(Coherence::Fixed(coherence).frequency_per_um(1.0));
        let orders = Places::new(&powers, deviation);
        assert_eq!(orders.columns(), powers.orders().counts()[0], "these are summed themselves");
        let table = Places::smoothed(&powers, deviation);
        let share = |places: &Places| vec![1.0; places.columns() * places.rows()];
        let (by_order, by_place) = (share(&orders), share(&table));
        let (mut apart, mut peak, mut sums) = (0.0_f32, 0.0_f32, [0.0; 2]);
        for i in -30..30 {
            for j in -30..30 {
                let f = [i, j].map(|k| f64::from(k) * 0.21 * deviation);
                let [of_orders, of_table] = [(&orders, &by_order), (&table, &by_place)]
                    .map(|(places, share)| places.sums(f, -3.0, share).unwrap_or_default()[0]);
                apart = apart.max((of_orders - of_table).abs());
                peak = peak.max(of_orders);
                sums[0] += of_orders;
                sums[1] += of_table;
            }
        }
        assert!(apart < 0.21 * peak, "{coherence} µm: {apart} of {peak}");
        assert!((sums[0] * orders.kept() as f32 / sums[1] - 1.0).abs() < 5e-3, "{coherence} µm: {sums:?}");
    }
}

/// Memory and places about a frequency have a bound whatever the coherence; patches too large for it are refused.
#[test]
fn any_coherence_is_rendered_from_bounded_tables() {
    let powers = patch(65.0);
    let orders = powers.orders().counts().map(|count| count as u64).iter().product::<u64>();
    for coherence in [0.5, 1.0, 4.0, 8.0, 12.8, 16.25, 65.0, 1000.0] {
        let bytes = Grating::bytes(&powers, coherence);
        assert!(bytes <= 4 * orders * (4 + PER_PLACE), "{coherence} µm: {bytes}");
    }
    for coherence in [16.25, 65.0, 1000.0] {
        assert_eq!(Grating::bytes(&powers, coherence), orders * PER_PLACE);
    }
    Grating::new(&patch(20.0), 1000.0, 1.5, [0.0; 3]).unwrap();
    let orders = Orders { most: [1700; 2], period_um: [300.0; 2] };
    let vast = Powers::new(orders, 2.0 * TAU / 0.38, 1, vec![0.0; 3401 * 3401]).unwrap();
    let said = Grating::new(&Arc::new(vast), 100.0, 1.5, [0.0; 3]).unwrap_err().to_string();
    assert!(said.contains("300 × 300 µm") && said.contains("give a smaller patch"), "{said}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let powers = powers(|_, _| 0.1);
    for (coherence, index, pigment) in [(0.0, 1.5, 0.0), (4.0, 1.0, 0.0), (4.0, 1.5, 2.0)] {
        assert!(Grating::new(&powers, coherence, index, [0.0, pigment, 0.0]).unwrap_err().is_input());
    }
}
