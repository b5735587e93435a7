//! Films: layers over a rough base. Facets of a GGX surface reflect what the transfer matrix says of the whole stack ([`film`])
//! at each wavelength and at the angle between light and facet, in place of Fresnel's reflectance of one boundary:
//!
//! ```text
//! f = R(λ, θ_d) D(h)/(4 cosθ_i cosθ_o (1 + Λ_i + Λ_o)) + ρ(λ) I(ω_i) I(ω_o)/(π (1 − Ē)),   I = 1 − E − A,
//! ```
//!
//! with R the mean of both polarizations, E(ω) the albedo of the first term, Ē its mean, and A(ω) what the layers absorb at the
//! facets that ω sees. Beneath may be a diffuse body of reflectance ρ, lit by what is neither reflected nor absorbed: as
//! [`Keratin`](super::Keratin)'s, whose formula it is where no layer absorbs. The whole is E + ρ I (1 − Ē − Ā)/(1 − Ē) ≤ 1.
//!
//! Approximated are four things of the body. What a second facet would reflect enters it. Light on the way out is absorbed as on
//! the way in. The film's reflection from within is not counted apart: as Kelemen & Szirmay-Kalos (2001) have it, bodies are as
//! bright as their ρ. And where the last medium absorbs, as melanin does, the body lies at its top.
//!
//! Both sides are the same.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::hit::Hit;
use super::lobes::Lobes;
use super::microfacet::{FacetRoughness, Ggx};
use super::reflectance::Reflectance;
use super::{Bsdf, Model};
use crate::film::{Polarization, response_at};
use crate::math::elementary::sin_cos_turns;
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::spectrum::sensor::Band;
use crate::stack::Stack;
use crate::{Error, Result};

/// Largest error of a table half way between two steps of the wavelength, or of the cosine, times the cosine: near grazing, where a
/// clear film's lines are ever sharper, facets get little light.
const TOLERANCE: f64 = 5e-4;

/// Coarsest steps of the cosine.
const LEAST_STEPS: usize = 64;

/// Most values of a table.
const MOST_VALUES: usize = 1 << 21;

/// The steps of one axis are chosen by lines at so many places of the other.
const LINES: usize = 24;

/// Places of the azimuth for which anisotropic surfaces know what enters a body.
const AZIMUTHS: usize = 5;

/// A rough surface with layers on it.
#[derive(Debug, Clone)]
pub struct ThinFilm {
    ggx: Ggx,
    reflected: Table,
    body: Option<Body>,
}

/// What is diffuse beneath the layers.
#[derive(Debug, Clone)]
struct Body {
    reflectance: Reflectance,
    /// I(ω) at even steps of the squared sine of the azimuth from x; one for isotropic surfaces.
    entering: Vec<Table>,
    /// 1/(π (1 − Ē)), at the table's wavelengths.
    scale: Arc<[f64]>,
}

impl ThinFilm {
    /// Whose wavelengths its tables serve.
    pub const BAND: Band = Band::HUMAN;

    /// - `stack`: first the medium outside, last what the layers lie on
    /// - `roughness`: each 0.02 … 1
    /// - `body`: what is diffuse beneath; `None`: nothing comes back
    ///
    /// # Errors
    /// A roughness out of range; a stack whose thicknesses spread, or that is too thick for a table; a medium without an index
    /// between 380 and 720 nm.
    pub fn new(stack: &Stack, roughness: FacetRoughness, body: Option<Reflectance>) -> Result<Self> {
        if !roughness.is_allowed() {
            let FacetRoughness { along, across } = roughness;
            return Err(Error::input(format!(
                "a film of roughness {across} across and {along} along: give 0.02 to 1 for both"
            )));
        }
        if stack.is_random() {
            return Err(Error::input(
                "thicknesses of a surface's film have no spread; leave out what is behind ±",
            ));
        }
        let (ggx, grid) = (Ggx::new(roughness), Grid::of(stack)?);
        let [reflected, absorbed] = grid.tables(stack)?;
        let azimuths = if roughness.along == roughness.across { 1 } else { AZIMUTHS };
        let body = body.map(|reflectance| Body::new(reflectance, ggx, &reflected, &absorbed, azimuths));
        Ok(Self { ggx, reflected, body })
    }

    /// What the layers reflect of unpolarized light at the cosine of an angle between light and facet.
    #[must_use]
    pub fn reflected(&self, cosine: f64, wavelengths: Lambdas) -> [f64; WAVES] {
        self.reflected.at(cosine.clamp(0.0, 1.0), &self.reflected.grid.waves(wavelengths))
    }

    /// At a hit, seen from `wo`.
    #[inline]
    pub(super) fn bind(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'_> {
        let side = hit.side(wo);
        let waves = self.reflected.grid.waves(wavelengths);
        let (mut under, mut gloss) = ([0.0; WAVES], [1.0; WAVES]);
        if let Some(body) = &self.body {
            let (entering, scale) = (body.entering(side.wo, &waves), between(&body.scale, &waves));
            let (rho, mirror) = (body.reflectance.at_each(wavelengths), self.reflected.at(side.wo.z, &waves));
            for k in 0..WAVES {
                let diffuse = rho[k] * entering[k];
                under[k] = diffuse * scale[k];
                gloss[k] = (mirror[k] / (mirror[k] + diffuse).max(1e-9)).clamp(0.1, 0.9);
            }
        }
        let lambda_o = self.ggx.lambda(side.wo);
        Bsdf::new(Model::ThinFilm(Bound { film: self, waves, lambda_o, under, gloss }), side)
    }
}

impl Body {
    fn new(reflectance: Reflectance, ggx: Ggx, reflected: &Table, absorbed: &Table, azimuths: usize) -> Self {
        let grid = reflected.grid;
        let mut mean = vec![0.0; grid.wavelengths()];
        let entering = (0..azimuths)
            .map(|azimuth| {
                let rows: Vec<[Vec<f64>; 2]> = (0..=grid.steps)
                    .into_par_iter()
                    .map(|node| {
                        let seen =
                            Seen::new(ggx, direction(azimuth, azimuths, grid.cosine(node)), grid.steps);
                        let albedo = reflected.sum(&seen.reflected);
                        let lost = absorbed.sum(&seen.all);
                        let entering = albedo.iter().zip(lost).map(|(e, a)| (1.0 - e - a).max(0.0)).collect();
                        [albedo, entering]
                    })
                    .collect();
                let share = azimuth_share(azimuth, azimuths);
                for (node, [albedo, _]) in rows.iter().enumerate() {
                    let weight = share * grid.cosine_share(node);
                    mean.iter_mut().zip(albedo).for_each(|(mean, e)| *mean += weight * e);
                }
                let values = rows.into_iter().flat_map(|[_, entering]| entering).collect();
                Table { grid, values }
            })
            .collect();
        // A film that reflects all lets nothing in that could come out.
        let scale = mean.iter().map(|e| 1.0 / (PI * (1.0 - e).max(1e-9))).collect();
        Self { reflectance, entering, scale }
    }

    /// I(ω), linear in the squared sine of the azimuth, in which what depends on twice the azimuth is linear.
    #[inline]
    fn entering(&self, w: DVec3, waves: &Waves) -> [f64; WAVES] {
        let [isotropic] = &self.entering[..] else {
            let across = w.x * w.x + w.y * w.y;
            let (below, rest) = split(w.y * w.y / across.max(1e-30), self.entering.len() - 1);
            let [low, high] = [below, below + 1].map(|azimuth| self.entering[azimuth].at(w.z, waves));
            return std::array::from_fn(|k| low[k] + (high[k] - low[k]) * rest);
        };
        isotropic.at(w.z, waves)
    }
}

/// The direction of a place of the azimuth, by its cosine.
fn direction(azimuth: usize, azimuths: usize, cosine: f64) -> DVec3 {
    let cosine = cosine.max(1e-3);
    let (sine, squared) = ((1.0 - cosine * cosine).sqrt(), azimuth as f64 / (azimuths - 1).max(1) as f64);
    DVec3::new(sine * (1.0 - squared).sqrt(), sine * squared.sqrt(), cosine)
}

/// Share of all azimuths that one place stands for: the mean of its hat over them.
fn azimuth_share(azimuth: usize, azimuths: usize) -> f64 {
    const PARTS: usize = 1000;
    let hat = |part: usize| {
        let sine = libm::sin(PI / 2.0 * (part as f64 + 0.5) / PARTS as f64);
        (1.0 - (sine * sine * (azimuths - 1) as f64 - azimuth as f64).abs()).max(0.0)
    };
    if azimuths == 1 { 1.0 } else { (0..PARTS).map(hat).sum::<f64>() / PARTS as f64 }
}

/// How often a direction sees facets under each cosine of a table: weights of its rows.
struct Seen {
    /// Of those that it sees.
    all: Vec<f64>,
    /// Of those from which its mirror direction is seen, too.
    reflected: Vec<f64>,
}

impl Seen {
    /// By a 32 × 32 midpoint rule over visible normals.
    fn new(ggx: Ggx, w: DVec3, steps: usize) -> Self {
        const SIDE: usize = 32;
        const EACH: f64 = 1.0 / (SIDE * SIDE) as f64;
        let (mut all, mut reflected) = (vec![0.0; steps + 1], vec![0.0; steps + 1]);
        for i in 0..SIDE * SIDE {
            let at = |k: usize| (k as f64 + 0.5) / SIDE as f64;
            let h = ggx.visible_normal(w, at(i % SIDE), at(i / SIDE));
            let out = 2.0 * w.dot(h) * h - w;
            let (row, rest) = split(w.dot(h), steps);
            let seen = if out.z > 0.0 {
                let (lambda, lambda_out) = (ggx.lambda(w), ggx.lambda(out));
                EACH * (1.0 + lambda) / (1.0 + lambda + lambda_out)
            } else {
                0.0
            };
            for (row, part) in [(row, 1.0 - rest), (row + 1, rest)] {
                all[row] += EACH * part;
                reflected[row] += seen * part;
            }
        }
        Self { all, reflected }
    }
}

/// Even steps of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid {
    /// Of the wavelength, in one nm.
    per_nm: usize,
    /// Of the cosine, from 0 to 1.
    steps: usize,
}

/// Where wavelengths lie in a table: the column before, and how far it is to the next.
type Waves = [(usize, f64); WAVES];

impl Grid {
    /// The coarsest one in which lines across are straight to [`TOLERANCE`].
    fn of(stack: &Stack) -> Result<Self> {
        let mut grid = Self { per_nm: 1, steps: LEAST_STEPS };
        let spread = |i: usize| (i as f64 + 0.5) / LINES as f64;
        let nm = |i: usize| ThinFilm::BAND.low_nm() + ThinFilm::BAND.width_nm() * spread(i);
        loop {
            let finer = Self { per_nm: 2 * grid.per_nm, ..grid };
            let columns: Vec<Vec<[f64; 2]>> = (0..finer.wavelengths())
                .into_par_iter()
                .map(|column| powers(stack, finer.nm(column), (0..LINES).map(spread)))
                .collect::<Result<_>>()?;
            let line = |line: usize| columns.iter().map(move |column| column[line]);
            if (0..LINES).all(|at| is_straight(line(at), |_| spread(at))) {
                break;
            }
            grid = finer.checked()?;
        }
        loop {
            let finer = Self { steps: 2 * grid.steps, ..grid };
            let lines: Vec<Vec<[f64; 2]>> = (0..LINES)
                .into_par_iter()
                .map(|line| powers(stack, nm(line), (0..=finer.steps).map(|node| finer.cosine(node))))
                .collect::<Result<_>>()?;
            if lines.into_iter().all(|line| is_straight(line.into_iter(), |node| finer.cosine(node))) {
                return Ok(grid);
            }
            grid = finer.checked()?;
        }
    }

    fn checked(self) -> Result<Self> {
        if self.wavelengths() * (self.steps + 1) <= MOST_VALUES {
            return Ok(self);
        }
        Err(Error::input(
            "the film's colours change too fast with wavelength and angle for its table; give layers of a few µm together, and a first medium that is not denser than the last",
        ))
    }

    fn wavelengths(self) -> usize {
        ThinFilm::BAND.width_nm() as usize * self.per_nm + 1
    }

    fn nm(self, column: usize) -> f64 {
        ThinFilm::BAND.low_nm() + column as f64 / self.per_nm as f64
    }

    fn cosine(self, node: usize) -> f64 {
        node as f64 / self.steps as f64
    }

    /// Share of a cosine's hat in the cosine-weighted mean over the hemisphere.
    fn cosine_share(self, node: usize) -> f64 {
        let h = 1.0 / self.steps as f64;
        match node {
            0 => h * h / 3.0,
            node if node == self.steps => h - h * h / 3.0,
            _ => 2.0 * h * self.cosine(node),
        }
    }

    #[inline]
    fn waves(self, wavelengths: Lambdas) -> Waves {
        let last = self.wavelengths() - 1;
        let place = |nm: f64| {
            let at = ((nm - ThinFilm::BAND.low_nm()) * self.per_nm as f64).clamp(0.0, last as f64);
            let column = (at as usize).min(last - 1);
            (column, at - column as f64)
        };
        wavelengths.nm().map(place)
    }

    /// What is reflected, and what the layers absorb.
    fn tables(self, stack: &Stack) -> Result<[Table; 2]> {
        let columns: Vec<Vec<[f64; 2]>> = (0..self.wavelengths())
            .into_par_iter()
            .map(|column| powers(stack, self.nm(column), (0..=self.steps).map(|node| self.cosine(node))))
            .collect::<Result<_>>()?;
        Ok([0, 1].map(|which| {
            let row = |node: usize| columns.iter().map(move |column| column[node][which]);
            Table { grid: self, values: (0..=self.steps).flat_map(row).collect() }
        }))
    }
}

/// A share of the power, linear between steps of the wavelength and of the cosine. Shape: `[cosine, wavelength]`.
#[derive(Debug, Clone)]
struct Table {
    grid: Grid,
    values: Arc<[f64]>,
}

impl Table {
    #[inline]
    fn at(&self, cosine: f64, waves: &Waves) -> [f64; WAVES] {
        let (row, rest) = split(cosine, self.grid.steps);
        let length = self.grid.wavelengths();
        let (low, high) = self.values[row * length..(row + 2) * length].split_at(length);
        let (low, high) = (between(low, waves), between(high, waves));
        std::array::from_fn(|k| low[k] + (high[k] - low[k]) * rest)
    }

    /// The sum of its rows, each times its weight.
    fn sum(&self, weights: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.grid.wavelengths()];
        let rows = self.values.chunks_exact(sum.len()).zip(weights).filter(|(_, weight)| **weight > 0.0);
        for (row, weight) in rows {
            sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }
}

/// The even step before a number from 0 to 1, and how far it is to the next.
#[inline]
fn split(value: f64, steps: usize) -> (usize, f64) {
    let at = value.clamp(0.0, 1.0) * steps as f64;
    let below = (at as usize).min(steps - 1);
    (below, at - below as f64)
}

/// Values of one row.
#[inline]
fn between(row: &[f64], waves: &Waves) -> [f64; WAVES] {
    waves.map(|(column, rest)| row[column] + (row[column + 1] - row[column]) * rest)
}

/// Whether every second value of a line lies as near to the mean of its neighbours as is allowed at its cosine.
fn is_straight(line: impl Iterator<Item = [f64; 2]>, cosine: impl Fn(usize) -> f64) -> bool {
    let line: Vec<_> = line.collect();
    (1..line.len()).step_by(2).all(|i| {
        let bend = |which: usize| line[i][which] - 0.5 * (line[i - 1][which] + line[i + 1][which]);
        (0..2).all(|which| cosine(i) * bend(which).abs() <= TOLERANCE)
    })
}

/// What a stack reflects of unpolarized light, and what its layers absorb, at each cosine.
fn powers(stack: &Stack, nm: f64, cosines: impl Iterator<Item = f64>) -> Result<Vec<[f64; 2]>> {
    let indices = stack.indices(nm)?;
    cosines
        .map(|cosine| {
            if cosine == 0.0 {
                return Ok([1.0, 0.0]);
            }
            let of = |polarization| {
                response_at(&indices, stack.thickness_nm(), nm, libm::acos(cosine), polarization)
            };
            let (s, p) = (of(Polarization::S)?, of(Polarization::P)?);
            Ok([0.5 * (s.reflected + p.reflected), (0.5 * (s.absorbed + p.absorbed)).max(0.0)])
        })
        .collect()
}

/// A film at the wavelengths of a path, seen from one direction.
pub(super) struct Bound<'a> {
    film: &'a ThinFilm,
    waves: Waves,
    /// Smith's Λ of the viewer's direction.
    lambda_o: f64,
    /// ρ I(ω_o)/(π (1 − Ē)); 0 without a body.
    under: [f64; WAVES],
    /// Share of the samples spent on the facets.
    gloss: [f64; WAVES],
}

impl Bound<'_> {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        let gloss = Lobes::REFLECTION.and(Lobes::GLOSSY);
        if self.film.body.is_some() { gloss.and(Lobes::DIFFUSE) } else { gloss }
    }

    #[inline(never)] // one copy for all callers, which are inlined into one function
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let (film, waves) = (self.film, &self.waves);
        let h = (wi + wo).normalize();
        let visible = film.ggx.distribution(h) / (4.0 * wo.z);
        let share = visible / (wi.z * (1.0 + self.lambda_o + film.ggx.lambda(wi)));
        let mut f = film.reflected.at(wi.dot(h), waves).map(|reflected| reflected * share);
        let seen = visible / (1.0 + self.lambda_o);
        let Some(body) = &film.body else { return (f, [seen; WAVES]) };
        let entering = body.entering(wi, waves);
        for k in 0..WAVES {
            f[k] += self.under[k] * entering[k];
        }
        (f, self.gloss.map(|gloss| gloss * seen + (1.0 - gloss) * wi.z / PI))
    }

    #[inline]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        if u[2] < self.gloss[0] {
            let h = self.film.ggx.visible_normal(wo, u[0], u[1]);
            let wi = 2.0 * wo.dot(h) * h - wo;
            return (wi.z > 0.0).then_some((wi, Lobes::REFLECTION.and(Lobes::GLOSSY)));
        }
        let (sine, [sin_azimuth, cos_azimuth]) = (u[0].sqrt(), sin_cos_turns(u[1]));
        let wi = DVec3::new(sine * cos_azimuth, sine * sin_azimuth, (1.0 - u[0]).max(0.0).sqrt());
        Some((wi, Lobes::REFLECTION.and(Lobes::DIFFUSE)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Surface;
    use crate::film::reflect;
    use crate::fresnel::fresnel;
    use crate::material::Library;
    use crate::math::rng::Stream;

    const STACKS: [&str; 5] = [
        "air/keratin:400/melanin:600/keratin",
        "air/1.54:140/air",
        "air/keratin:300/1.33",
        "air/keratin:90/6*(melanin:100/air:60)/keratin",
        "air/keratin:200/copper",
    ];

    fn stack(text: &str) -> Stack {
        Stack::parse(text, &Library::builtin()).unwrap()
    }

    fn film(text: &str, roughness: f64) -> ThinFilm {
        ThinFilm::new(&stack(text), FacetRoughness::even(roughness), None).unwrap()
    }

    /// The film's reflectance from the value of its surface at the mirror direction.
    fn mirrored(film: &ThinFilm, nm: f64, cosine: f64) -> f64 {
        let wo = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let surface = Surface::ThinFilm(film.clone());
        let f = surface.bind(&Hit::default(), wo, Lambdas::splat(nm)).eval(DVec3::new(-wo.x, 0.0, wo.z)).f[0];
        f * 4.0 * cosine * cosine * (1.0 + 2.0 * film.ggx.lambda(wo)) / film.ggx.distribution(DVec3::Z)
    }

    fn exact(stack: &Stack, nm: f64, cosine: f64) -> f64 {
        let indices = stack.indices(nm).unwrap();
        let power = |polarization| {
            reflect(&indices, stack.thickness_nm(), nm, cosine.acos(), polarization).unwrap().norm_sqr()
        };
        Polarization::BOTH.map(power).iter().sum::<f64>() / 2.0
    }

    /// As smooth as may be it reflects what the transfer matrix says: rounding at the table's steps, and between them what two
    /// linear interpolations leave.
    #[test]
    fn facets_reflect_as_the_exact_film() {
        let mut stream = Stream::new(31, &[]);
        for text in STACKS {
            let (film, stack) = (film(text, 0.02), stack(text));
            for nm in [380.0, 447.0, 550.0, 633.0, 720.0] {
                for step in 1..=16 {
                    let cosine = f64::from(step) / 16.0;
                    let error = mirrored(&film, nm, cosine) - exact(&stack, nm, cosine);
                    assert!(error.abs() < 1e-12, "{text} {nm} {cosine}: {error}");
                }
            }
            for _ in 0..2000 {
                let (nm, cosine) = (stream.uniform(380.0, 720.0), stream.uniform(0.05, 1.0));
                let error = mirrored(&film, nm, cosine) - exact(&stack, nm, cosine);
                assert!(cosine * error.abs() < 2.0 * TOLERANCE, "{text} {nm} {cosine}: {error}");
            }
        }
    }

    /// A layer of no thickness leaves the boundary of the base.
    #[test]
    fn no_film_is_a_boundary() {
        let film = film("air/keratin:0/1.5", 0.3);
        for step in 1..=8 {
            let cosine = f64::from(step) / 8.0;
            assert!((mirrored(&film, 500.0, cosine) - fresnel(cosine, 1.5)).abs() < 1e-12);
        }
    }

    /// A film in air reflects most where 2 n d cosθ_t = 3λ/2.
    #[test]
    fn colours_go_to_shorter_waves_with_the_angle() {
        let film = film("air/1.5:300/air", 0.1);
        let peak = |cosine: f64| {
            let reflected = |nm: &f64| mirrored(&film, *nm, cosine);
            (380..=720).map(f64::from).max_by(|a, b| reflected(a).total_cmp(&reflected(b))).unwrap()
        };
        for cosine in [1.0, 0.75, 0.5] {
            let within = (1.0 - (1.0 - cosine * cosine) / 2.25_f64).sqrt();
            assert!((peak(cosine) - 600.0 * within).abs() <= 1.0, "{cosine}: {}", peak(cosine));
        }
    }

    #[test]
    fn films_without_a_table_are_refused() {
        let message = |text: &str, alpha: f64| {
            ThinFilm::new(&stack(text), FacetRoughness::even(alpha), None).unwrap_err().to_string()
        };
        assert!(message("air/keratin:400/air", 0.01).contains("0.02 to 1"));
        assert!(message("air/keratin:400±5%/air", 0.1).contains("no spread"));
        assert!(message("air/keratin:100000/air", 0.1).contains("a few µm"));
        assert!(message("1.5/keratin:300/air", 0.1).contains("not denser"));
        assert!(message("melanin/air:100/keratin", 0.1).contains("start the stack with a lossless medium"));
    }
}
