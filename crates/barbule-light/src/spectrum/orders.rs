//! Which peaks of two curves belong to each other.
//!
//! Structures that interfere have a peak for each order, and which of them is highest changes with the angle, with the
//! range of wavelengths and from a model to what was measured. But from one angle to the next, and from one thickness to
//! another, the whole curve is stretched over the wavelengths, all its orders alike. So the stretch that makes two
//! curves most alike says which peak has become which.

use super::Spectrum;
use super::peaks::Peak;

/// Steps of ln λ at which curves are compared: 0.25 %, a nanometre at 400 nm.
const STEP: f64 = 0.0025;

/// Curves that are less alike at their best stretch belong to no common structure that could be told.
pub const LEAST_CORRELATION: f64 = 0.3;

/// The part of the shorter curve that two curves must have in common once one is stretched.
const LEAST_OVERLAP: f64 = 0.5;

/// Fewer common steps say nothing.
const FEWEST_STEPS: usize = 8;

/// A stretch whose score is as near as this to the best one's leaves open which of the two holds.
const AMBIGUOUS: f64 = 0.1;

/// A peak further than this from where the stretch puts it, in ln λ, is not the one that is meant.
const TOLERANCE: f64 = 0.08;

/// By which factors curves of different origin may differ: ± 30 %.
pub const ANY_STRETCH: [f64; 2] = [1.0 / 1.3, 1.3];

/// The index of a medium whose interference moves faster with the angle than that of any barbule's.
const FASTEST_INDEX: f64 = 1.3;

/// By how much a peak may move the other way between two angles: random individuals, shapes that are not flat.
const BACKWARDS: f64 = 1.05;

/// How one curve is stretched over the wavelengths to be most like another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// What is at λ in the first curve is at factor · λ in the second.
    pub factor: f64,
    /// Pearson's correlation of the two over what they then have in common, in steps of ln λ.
    pub correlation: f64,
}

/// The stretch of `from` that correlates it best with `to`, of factors within a range; none where the curves have too
/// little in common, or one of them is flat.
///
/// A correlation counts as the root of the part over which it holds, as its significance does; of equal ones the least
/// stretch is taken.
#[must_use]
pub fn stretch(from: &Spectrum, to: &Spectrum, factors: [f64; 2]) -> Option<Stretch> {
    Tried::new(from, to, factors).best()
}

/// A curve at whole steps of ln λ.
struct Stretchable {
    /// The number of the first step.
    first: i64,
    values: Vec<f64>,
}

impl Stretchable {
    fn of(curve: &Spectrum) -> Self {
        let (from, to) = curve.wavelengths().range_nm();
        let first = (libm::log(from) / STEP).ceil() as i64;
        let last = (libm::log(to) / STEP).floor() as i64;
        let values = (first..=last).map(|step| curve.held(libm::exp(step as f64 * STEP))).collect();
        Self { first, values }
    }

    /// Pearson's correlation once this curve is moved up by a number of steps, and over which part of the shorter one.
    fn correlation(&self, to: &Self, shift: i64) -> Option<(f64, f64)> {
        let ends =
            |curve: &Self, shift: i64| [curve.first + shift, curve.first + shift + curve.values.len() as i64];
        let ([a, b], [c, d]) = (ends(self, shift), ends(to, 0));
        let (first, end) = (a.max(c), b.min(d));
        let count = usize::try_from(end - first).ok().filter(|count| *count >= FEWEST_STEPS)?;
        let share = count as f64 / self.values.len().min(to.values.len()) as f64;
        if share < LEAST_OVERLAP {
            return None;
        }
        let part = |curve: &Self, shift: i64| {
            let start = (first - shift - curve.first) as usize;
            start..start + count
        };
        let (x, y) = (&self.values[part(self, shift)], &to.values[part(to, 0)]);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count as f64;
        let (mean_x, mean_y) = (mean(x), mean(y));
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(y) {
            let (x, y) = (x - mean_x, y - mean_y);
            xx += x * x;
            yy += y * y;
            xy += x * y;
        }
        // Rounding noise about a constant is no variation.
        let flat = |squares: f64, mean: f64| squares <= 1e-20 * mean * mean * count as f64;
        (!flat(xx, mean_x) && !flat(yy, mean_y)).then(|| (xy / (xx * yy).sqrt(), share))
    }
}

/// Stretches within a range of factors, from the least, and their scores.
struct Tried(Vec<(f64, Stretch)>);

impl Tried {
    fn new(from: &Spectrum, to: &Spectrum, factors: [f64; 2]) -> Self {
        let [from, to] = [from, to].map(Stretchable::of);
        let [low, high] = factors.map(|factor| (libm::log(factor) / STEP).round() as i64);
        let one = |shift: i64| {
            let (correlation, share) = from.correlation(&to, shift)?;
            Some((
                correlation * share.sqrt(),
                Stretch { factor: libm::exp(shift as f64 * STEP), correlation },
            ))
        };
        Self((low..=high).filter_map(one).collect())
    }

    /// The place of the highest score, of equal ones that of the least stretch.
    fn highest(&self) -> Option<usize> {
        let far = |at: usize| libm::log(self.0[at].1.factor).abs();
        (0..self.0.len()).max_by(|&a, &b| self.0[a].0.total_cmp(&self.0[b].0).then(far(b).total_cmp(&far(a))))
    }

    fn best(&self) -> Option<Stretch> {
        Some(self.0[self.highest()?].1)
    }

    /// The next best of those that are better than their neighbours, where it is nearly as good as the best.
    fn rival(&self) -> Option<Stretch> {
        let highest = self.highest()?;
        let score = |at: usize| self.0[at].0;
        let is_peak = |&at: &usize| {
            (at == 0 || score(at) > score(at - 1)) && (at + 1 == self.0.len() || score(at) > score(at + 1))
        };
        let others = (0..self.0.len()).filter(is_peak).filter(|at| *at != highest);
        let next = others.max_by(|&a, &b| score(a).total_cmp(&score(b)))?;
        (score(highest) - score(next) <= AMBIGUOUS).then(|| self.0[next].1)
    }
}

/// Why a curve has no peak that corresponds to another curve's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lost {
    /// It would lie here, nm, outside the wavelengths.
    Outside(f64),
    /// It would lie here, nm, but there is no peak.
    Gone(f64),
    /// The curves are too unlike at any stretch to say; their best correlation, where there is one.
    Unlike(Option<f64>),
}

/// The peak of a curve that another curve's peak has become.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correspondence {
    /// The peak, or why there is none.
    pub peak: Result<Peak, Lost>,
    /// The stretch by which it was found; none of the curve that is followed from.
    pub stretch: Option<Stretch>,
    /// Another peak, which it would be by another stretch that makes the curves nearly as alike.
    pub rival: Option<Peak>,
}

/// What a peak at `nm` of the curve `from` has become in `to`, whose peaks these are.
#[must_use]
pub fn corresponding(
    from: &Spectrum,
    nm: f64,
    to: &Spectrum,
    peaks: &[Peak],
    factors: [f64; 2],
) -> Correspondence {
    let tried = Tried::new(from, to, factors);
    let is_alike = |stretch: &Stretch| stretch.correlation >= LEAST_CORRELATION;
    let stretch = tried.best();
    let peak = match stretch.filter(is_alike) {
        None => Err(Lost::Unlike(stretch.map(|stretch| stretch.correlation))),
        Some(stretch) => nearest(to, nm * stretch.factor, peaks),
    };
    let other = tried.rival().filter(is_alike).and_then(|rival| nearest(to, nm * rival.factor, peaks).ok());
    let rival = other.filter(|other| peak.is_ok_and(|peak| peak.nm != other.nm));
    Correspondence { peak, stretch, rival }
}

/// The peak that is nearest to a wavelength, if it is near enough to be meant.
fn nearest(curve: &Spectrum, expected_nm: f64, peaks: &[Peak]) -> Result<Peak, Lost> {
    let away = |peak: &Peak| libm::log(peak.nm / expected_nm).abs();
    let near = peaks.iter().filter(|peak| !peak.at_end && away(peak) <= TOLERANCE);
    let (first, last) = curve.wavelengths().range_nm();
    near.copied().min_by(|a, b| away(a).total_cmp(&away(b))).ok_or_else(|| {
        // An expected place is known no better than the tolerance.
        let inside = first * (1.0 + TOLERANCE) <= expected_nm && expected_nm * (1.0 + TOLERANCE) <= last;
        if inside { Lost::Gone(expected_nm) } else { Lost::Outside(expected_nm) }
    })
}

/// Follows a peak through the angles of a series, within its order: outwards from the angle nearest to the normal, whose
/// peak it is, on either side of it from each angle to the next. One correspondence for each angle.
///
/// Between two angles the wavelengths of interference shrink at most as those in a medium of index 1.3 do, λ ∝ √(n² − sin²θ).
#[must_use]
pub fn follow(
    angles_deg: &[f64],
    curves: &[Spectrum],
    peaks: &[Vec<Peak>],
    start: Peak,
) -> Vec<Correspondence> {
    let from = nearest_to_normal(angles_deg);
    let alone = Correspondence { peak: Ok(start), stretch: None, rival: None };
    let mut found = vec![alone; angles_deg.len()];
    for side in [-1.0, 1.0] {
        let (mut last, mut last_nm) = (from, start.nm);
        for at in outwards(angles_deg).filter(|&at| at != from && (angles_deg[at] < 0.0) == (side < 0.0)) {
            let factors = [slowest(angles_deg[last], angles_deg[at]), BACKWARDS];
            found[at] = corresponding(&curves[last], last_nm, &curves[at], &peaks[at], factors);
            // Where it was not found it may be found again further out; from curves that are unlike nothing follows.
            match found[at].peak {
                Ok(peak) => (last, last_nm) = (at, peak.nm),
                Err(Lost::Outside(nm) | Lost::Gone(nm)) => (last, last_nm) = (at, nm),
                Err(Lost::Unlike(_)) => {}
            }
        }
    }
    found
}

/// The place of the angle nearest to the normal, of equal ones the first; of a series of none 0.
#[must_use]
pub fn nearest_to_normal(angles_deg: &[f64]) -> usize {
    outwards(angles_deg).next().unwrap_or_default()
}

/// The places of the angles from the normal outwards.
pub(super) fn outwards(angles_deg: &[f64]) -> impl Iterator<Item = usize> {
    let mut places: Vec<usize> = (0..angles_deg.len()).collect();
    places.sort_by(|&a, &b| angles_deg[a].abs().total_cmp(&angles_deg[b].abs()));
    places.into_iter()
}

/// The factor on interference's wavelengths between two angles where they move fastest.
fn slowest(from_deg: f64, to_deg: f64) -> f64 {
    let inside = |deg: f64| {
        let sine = libm::sin(deg.to_radians());
        libm::sqrt(FASTEST_INDEX * FASTEST_INDEX - sine * sine)
    };
    // A step's breadth of room, so that the same angle twice has one.
    inside(to_deg) / inside(from_deg) - STEP
}

#[cfg(test)]
mod tests {
    use super::super::Wavelengths;
    use super::super::peaks::{Origin, highest, peaks};
    use super::*;

    fn curve(range: [f64; 2], step: f64, value: impl Fn(f64) -> f64) -> Spectrum {
        let count = ((range[1] - range[0]) / step).round() as usize + 1;
        let nm: Vec<f64> = (0..count).map(|i| range[0] + i as f64 * step).collect();
        let values = nm.iter().map(|&x| value(x)).collect();
        Spectrum::new(Wavelengths::new(nm).unwrap(), values).unwrap()
    }

    /// A weak film of index 1.56 in air: R ∝ sin²(2π n d cosθ/λ), under an envelope that tilts with the angle so that short
    /// wavelengths are highest near the normal and long ones at large angles.
    fn film(thickness_nm: f64, deg: f64) -> impl Fn(f64) -> f64 {
        let path = 2.0 * thickness_nm * (1.56f64 * 1.56 - deg.to_radians().sin().powi(2)).sqrt();
        let tilt = (deg - 35.0) / 35.0;
        move |nm| {
            let phase = std::f64::consts::PI * path / nm;
            0.02 + 0.05 * phase.sin().powi(2) * (1.0 + 0.15 * tilt * (nm - 500.0) / 200.0)
        }
    }

    #[test]
    fn a_stretch_is_the_one_that_was_put_in() {
        let bell = |at: f64| move |nm: f64| 0.05 + 0.2 * (-0.5 * ((nm - at) / (0.07 * at)).powi(2)).exp();
        for factor in [0.8, 0.93, 1.0, 1.07, 1.25] {
            let (a, b) =
                (curve([300.0, 700.0], 4.0, bell(480.0)), curve([320.0, 720.0], 1.0, bell(480.0 * factor)));
            // What counts for a large common part draws far stretches a little towards 1.
            let found = stretch(&a, &b, ANY_STRETCH).unwrap();
            assert!(
                (found.factor / factor - 1.0).abs() < 0.008 && found.correlation > 0.99,
                "{factor}: {found:?}"
            );
        }
        let flat = curve([300.0, 700.0], 4.0, |_| 0.3);
        assert_eq!(stretch(&flat, &curve([300.0, 700.0], 4.0, bell(480.0)), ANY_STRETCH), None);
        let far = curve([700.0, 800.0], 4.0, bell(750.0));
        assert_eq!(stretch(&far, &curve([300.0, 400.0], 4.0, bell(350.0)), ANY_STRETCH), None);
    }

    /// Films of two and of four orders between 300 and 700 nm, in steps of 5°, 15° and 60°, to either side.
    #[test]
    fn a_films_peak_moves_by_its_law_whatever_order_is_highest() {
        let mut jumps = 0;
        for (thickness, at_normal) in [(320.0, 665.6), (800.0, 554.7)] {
            for angles in [
                vec![0.0, 15.0, 30.0, 45.0, 60.0],
                vec![60.0, 0.0],
                (-12..=12).map(|k| f64::from(5 * k)).collect(),
            ] {
                let curves: Vec<Spectrum> =
                    angles.iter().map(|&deg| curve([300.0, 700.0], 4.0, film(thickness, deg))).collect();
                let all: Vec<Vec<Peak>> =
                    curves.iter().map(|curve| peaks(curve, Origin::Computed, None)).collect();
                let normal = nearest_to_normal(&angles);
                let start = highest(&all[normal], Some([0.9 * at_normal, 1.1 * at_normal])).unwrap();
                assert!((start.nm / at_normal - 1.0).abs() < 0.06, "{start:?}");
                for (at, found) in follow(&angles, &curves, &all, start).into_iter().enumerate() {
                    let inside = (1.56f64 * 1.56 - angles[at].to_radians().sin().powi(2)).sqrt() / 1.56;
                    let peak = found.peak.unwrap();
                    assert!(
                        (peak.nm / (start.nm * inside) - 1.0).abs() < 0.03,
                        "{thickness} {}: {peak:?}",
                        angles[at]
                    );
                    jumps += usize::from(highest(&all[at], None) != Some(peak));
                }
            }
        }
        assert!(jumps > 10, "highest peaks jump between orders, or this test tests nothing: {jumps}");
    }

    #[test]
    fn what_leaves_the_range_is_lost_and_what_is_unlike_is_not_guessed() {
        let angles = [0.0, 30.0, 60.0];
        let curves = angles.map(|deg| curve([350.0, 700.0], 4.0, film(320.0, deg)));
        let all = curves.each_ref().map(|curve| peaks(curve, Origin::Computed, None));
        let violet = highest(&all[0], Some([350.0, 450.0])).unwrap();
        let found = follow(&angles, &curves, &all, violet);
        assert!((found[1].peak.unwrap().nm / violet.nm - 0.947).abs() < 0.02, "{found:?}");
        assert!(matches!(found[2].peak, Err(Lost::Outside(nm)) if nm < 350.0), "{found:?}");
        let (up, down) = (curve([300.0, 700.0], 4.0, |nm| nm), curve([300.0, 700.0], 4.0, |nm| -nm));
        let found = corresponding(&up, 500.0, &down, &[], ANY_STRETCH);
        assert!(matches!(found.peak, Err(Lost::Unlike(Some(r))) if r < -0.9), "{found:?}");
    }
}
