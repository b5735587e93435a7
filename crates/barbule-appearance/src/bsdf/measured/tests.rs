use std::f64::consts::{PI, TAU};

use super::*;
use crate::math::rng::Stream;

/// A lobe about the mirror direction, wide across x and narrow along it, leaning to one side and redder to the other; f in 1/sr.
fn lobe(w: DVec3, wo: DVec3, nm: f64) -> f64 {
    let m = (w + wo).normalize();
    let spread = (-(m.x / 0.25).powi(2) - ((m.y - 0.1) / 0.5).powi(2)).exp();
    (0.02 + 0.3 * spread) * (1.0 + 0.3 * m.y * (nm - 550.0) / 150.0) / PI
}

fn wide(m: DVec3) -> f64 {
    0.02 + (-(m.x / 0.35).powi(2) - (m.y / 0.6).powi(2)).exp()
}

const FINE: Resolution = Resolution { thetas: 16, phis: 17, values: 32, normals: [48, 32] };

fn nm() -> Vec<f64> {
    vec![400.0, 500.0, 600.0, 700.0]
}

fn arrays() -> RglArrays {
    let nm = nm();
    let values = |w: DVec3, wo: DVec3, to: &mut [f64]| {
        to.iter_mut().zip(&nm).for_each(|(value, nm)| *value = lobe(w, wo, *nm) * wo.z);
    };
    tabulate(&FINE, Channels::Wavelengths(nm.iter().map(|v| *v as f32).collect()), &wide, &values).unwrap()
}

pub(crate) fn rgl() -> Measured {
    Measured::new(Arc::new(MeasuredTables::Rgl(Box::new(Rgl::new(arrays()).unwrap()))))
}

/// A glossy lobe over a grey body as MERL's tables have it.
fn merl_values() -> Vec<f32> {
    let [halves, differences, azimuths] = MERL_SIZE;
    let mut values = Vec::new();
    for channel in 0..3 {
        for half in 0..halves {
            let theta = (half as f64 / halves as f64).powi(2) * PI / 2.0;
            let f = 0.05 * (1.0 + f64::from(channel)) + 0.5 * (-(theta / 0.3).powi(2)).exp();
            values.extend(vec![f as f32; differences * azimuths]);
        }
    }
    values
}

pub(crate) fn merl() -> Measured {
    Measured::new(Arc::new(MeasuredTables::Merl(Box::new(Merl::new(merl_values()).unwrap()))))
}

fn random_pair(random: &mut Stream) -> [DVec3; 2] {
    [(); 2].map(|()| {
        let (z, turn) = (random.uniform(0.3, 1.0), TAU * random.unit());
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * libm::cos(turn), r * libm::sin(turn), z)
    })
}

/// What is tabulated comes back, at its nodes' wavelengths and between, in a leaning lobe whose mirror image is far off.
#[test]
fn a_tabulated_lobe_comes_back() {
    let rgl = Rgl::new(arrays()).unwrap();
    let mut random = Stream::new(5, &[]);
    let (mut off, mut mirrored, mut all) = (0.0, 0.0, 0.0);
    for _ in 0..4000 {
        let [w, wo] = random_pair(&mut random);
        let nm = [400.0, 550.0];
        let mut found = [0.0; 2];
        rgl.values(&rgl.incident(w), wo, &nm, &mut found);
        let image = |v: DVec3| DVec3::new(v.x, -v.y, v.z);
        for (nm, found) in nm.into_iter().zip(found) {
            let own = lobe(w, wo, nm) * wo.z;
            off += (found - own).abs();
            mirrored += (found - lobe(image(w), image(wo), nm) * wo.z).abs();
            all += own;
        }
    }
    assert!(off / all < 0.01, "off by {}", off / all);
    assert!(mirrored / all > 0.1, "as near to the mirror image: {}", mirrored / all);
}

/// A file of half a circle, for what looks alike when it is turned by 180°, is the same as that of the whole.
#[test]
fn half_a_circle_stands_for_the_whole() {
    let even = |w: DVec3, wo: DVec3, nm: f64| {
        let turned = |v: DVec3| DVec3::new(-v.x, -v.y, v.z);
        0.5 * (lobe(w, wo, nm) + lobe(turned(w), turned(wo), nm))
    };
    let values = |w: DVec3, wo: DVec3, to: &mut [f64]| to[0] = even(w, wo, 500.0) * wo.z;
    let whole = tabulate(&FINE, Channels::Wavelengths(vec![500.0]), &wide, &values).unwrap();
    let mut half = whole.clone();
    let kept = FINE.phis.div_ceil(2);
    half.phi_i.truncate(kept);
    half.vndf.truncate(kept * FINE.thetas * FINE.normals[0] * FINE.normals[1]);
    half.luminance.truncate(kept * FINE.thetas * FINE.values * FINE.values);
    half.values.truncate(kept * FINE.thetas * FINE.values * FINE.values);
    let (whole, half) = (Rgl::new(whole).unwrap(), Rgl::new(half).unwrap());
    let mut random = Stream::new(6, &[]);
    let (mut off, mut all) = (0.0, 0.0);
    for _ in 0..500 {
        let [w, wo] = random_pair(&mut random);
        let mut found = [[0.0; 1]; 2];
        for (rgl, found) in [&whole, &half].into_iter().zip(&mut found) {
            rgl.values(&rgl.incident(w), wo, &[500.0], found);
        }
        off += (found[0][0] - found[1][0]).abs();
        all += found[0][0];
    }
    // They differ as two tables of the same do, whose points lie elsewhere.
    assert!(off / all < 0.01, "off by {}", off / all);
}

/// The nearest cell below, wherever the pair is turned to.
#[test]
fn merl_is_read_by_half_vector_and_difference() {
    let mut values = vec![0.25; 3 * MERL_SIZE.iter().product::<usize>()];
    let [halves, differences, azimuths] = MERL_SIZE;
    // θ_h 20°, θ_d 30°, φ_d 40°: one cell alone, of each channel another value.
    let cell = ((20f64 / 90.0).sqrt() * 90.0) as usize * differences * azimuths + 30 * azimuths + 40;
    for channel in 0..3 {
        values[channel * halves * differences * azimuths + cell] = channel as f32 + 1.0;
    }
    values[7] = -1.0;
    let merl = Merl::new(values).unwrap();
    let (theta_h, theta_d, phi_d) = (20.2f64.to_radians(), 30.5f64.to_radians(), 40.5f64.to_radians());
    for turn in [0.3, 2.0, -1.4] {
        let of_difference = |theta: f64, phi: f64| {
            let d = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let about_y = glam::DQuat::from_rotation_y(theta_h) * d;
            glam::DQuat::from_rotation_z(turn) * about_y
        };
        let (wo, w) = (of_difference(theta_d, phi_d), of_difference(theta_d, phi_d + PI));
        assert_eq!(merl.f(w, wo), [1.0, 2.0, 3.0]);
        assert_eq!(merl.f(wo, w), [1.0, 2.0, 3.0]);
    }
    assert!(Merl::new(vec![0.0; 5]).is_err());
    assert!(Merl::new(vec![0.0; 3 * 90 * 90 * 180]).is_err());
}

#[test]
fn files_that_do_not_fit_are_refused() {
    let refused = |spoil: &dyn Fn(&mut RglArrays)| {
        let mut arrays = arrays();
        spoil(&mut arrays);
        Rgl::new(arrays).unwrap_err().to_string()
    };
    assert!(refused(&|a| a.theta_i[1] = 9.0).contains("theta_i must rise"));
    assert!(refused(&|a| a.phi_i.reverse()).contains("phi_i must rise"));
    assert!(refused(&|a| a.values.truncate(9)).contains("values has 9 values"));
    assert!(refused(&|a| a.values[3] = f32::NAN).contains("not finite"));
    assert!(refused(&|a| a.ndf.size = [1, 1]).contains("ndf"));
    assert!(refused(&|a| a.vndf.fill(0.0)).contains("vndf: a density is zero"));
    assert!(refused(&|a| a.channels = Channels::Wavelengths(vec![])).contains("wavelengths"));
}
