//! What a difference between two reflectances looks like, and so what may have caused it.
//!
//! Four things move a spectrum in ways that can be told apart: another thickness stretches it over the wavelengths, another instrument
//! or white standard multiplies it, more disorder (or a coarser instrument) smooths it, gloss and stray light lift it. Each alone, and
//! then in company, is fitted to the difference, and said by how much of it each takes away. It is a hint: a structure of another kind
//! can look like a sum of them.

use super::Spectrum;

/// A way in which a measured curve differs from a simulated one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The whole curve is at longer or shorter wavelengths.
    Shift,
    /// It is a multiple.
    Level,
    /// It is smoother, or sharper.
    Width,
    /// A constant is added.
    Offset,
}

/// All of them, in the order in which equally good ones are preferred.
const CAUSES: [Cause; 4] = [Cause::Shift, Cause::Level, Cause::Width, Cause::Offset];

/// What must be done to the simulated curve for it to be like the measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Relative shift of the wavelengths: 0.02 is 2 % longer.
    pub shift: f64,
    /// Factor.
    pub level: f64,
    /// Standard deviation of the Gaussian that smooths the simulated curve, nm; negative where the measured one needs it.
    pub broadening_nm: f64,
    /// What is added, as a part of 1.
    pub offset: f64,
}

impl Change {
    const NONE: Self = Self { shift: 0.0, level: 1.0, broadening_nm: 0.0, offset: 0.0 };
}

/// The causes of a difference, the foremost first.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    /// The causes that each take away a good part of what those before leave.
    pub causes: Vec<Cause>,
    /// What they change.
    pub change: Change,
    /// The part of the squared difference that they take away.
    pub explained: f64,
    /// The part that the first one takes away alone.
    pub first_explains: f64,
}

/// Shifts that are tried: ± 15 %, in steps of 0.25 %, less than a nanometre and a half.
const SHIFTS: i32 = 60;
const SHIFT: f64 = 0.0025;
/// Broadenings that are tried, nm: a Gaussian's standard deviation.
const BROADENINGS: i32 = 20;
const BROADENING_NM: f64 = 3.0;
/// A further cause must take away this part of what is left.
const WORTH: f64 = 0.5;
/// Causes that explain less than this say nothing.
const LEAST: f64 = 0.5;
/// More of them would fit anything.
const MOST_CAUSES: usize = 2;

impl Residual {
    /// Looks for the causes of measured − simulated at the simulated wavelengths that lie within the measured ones; none where
    /// fewer than eight do, or the curves do not differ.
    #[must_use]
    pub fn of(simulated: &Spectrum, measured: &Spectrum) -> Option<Self> {
        let tried = Tried::new(simulated, measured)?;
        let start = tried.left(&[])?.1;
        if start <= 1e-24 {
            return None;
        }
        let mut found =
            Self { causes: Vec::new(), change: Change::NONE, explained: 0.0, first_explains: 0.0 };
        let mut left = start;
        while found.causes.len() < MOST_CAUSES {
            let further = CAUSES.iter().filter(|cause| !found.causes.contains(cause));
            let with = further.filter_map(|&cause| {
                let causes: Vec<Cause> = found.causes.iter().copied().chain([cause]).collect();
                let (change, left) = tried.left(&causes)?;
                Some((causes, change, left))
            });
            let Some((causes, change, after)) = with.min_by(|a, b| a.2.total_cmp(&b.2)) else { break };
            // The first is the hint; those after it must be worth a word.
            let worth = if found.causes.is_empty() { LEAST } else { WORTH };
            if 1.0 - after / left < worth {
                break;
            }
            if causes.len() == 1 {
                found.first_explains = 1.0 - after / start;
            }
            (found.causes, found.change, left) = (causes, change, after);
            found.explained = 1.0 - left / start;
        }
        Some(found)
    }

    /// One line for people: a hint, and by how much of the squared difference it holds.
    #[must_use]
    pub fn words(&self) -> String {
        let [first, rest @ ..] = &self.causes[..] else {
            return "neither a shift nor a level, a width or an offset explains half of the difference: perhaps another structure".into();
        };
        let percent = |part: f64| format!("{:.0} %", 100.0 * part);
        let mut text =
            format!("{} explains {} of the difference", self.word(*first), percent(self.first_explains));
        if let [second] = rest {
            text += &format!(", with {} {}", self.word(*second), percent(self.explained));
        }
        text
    }

    fn word(&self, cause: Cause) -> String {
        let Change { shift, level, broadening_nm, offset } = self.change;
        match cause {
            Cause::Shift => {
                let layers = if shift > 0.0 {
                    "thicker layers or a higher index"
                } else {
                    "thinner layers or a lower index"
                };
                format!("a shift by {:+.1} % ({layers})", 100.0 * shift)
            }
            Cause::Level => {
                format!("a level × {level:.2} (cones, white standard, how much of the vane shows)")
            }
            Cause::Width if broadening_nm > 0.0 => {
                format!("smoothing by {broadening_nm:.0} nm (sizes that vary more, wider cones)")
            }
            Cause::Width => format!("sharpening by {:.0} nm (sizes that vary less)", -broadening_nm),
            Cause::Offset => format!("an offset of {:+.1} % (gloss, stray light)", 100.0 * offset),
        }
    }

    /// The foremost cause as one word.
    #[must_use]
    pub fn cause(&self) -> Option<&'static str> {
        self.causes.first().map(|cause| match cause {
            Cause::Shift => "shift",
            Cause::Level => "level",
            Cause::Width => "width",
            Cause::Offset => "offset",
        })
    }
}

/// Both curves at the wavelengths where they are compared, smoothed by each broadening that is tried.
struct Tried {
    nm: Vec<f64>,
    /// For each broadening from −`BROADENINGS` on: the simulated curve, at all its wavelengths, and the measured values.
    pairs: Vec<(Spectrum, Vec<f64>)>,
}

impl Tried {
    fn new(simulated: &Spectrum, measured: &Spectrum) -> Option<Self> {
        let (from, to) = measured.wavelengths().range_nm();
        let nm: Vec<f64> =
            simulated.wavelengths().iter().copied().filter(|nm| (from..=to).contains(nm)).collect();
        if nm.len() < 8 {
            return None;
        }
        let pairs = (-BROADENINGS..=BROADENINGS).map(|step| {
            let width_nm = BROADENING_NM * f64::from(step);
            let of = |curve: &Spectrum, width_nm: f64| smoothed(curve, width_nm.max(0.0));
            let measured = of(measured, -width_nm);
            (of(simulated, width_nm), nm.iter().map(|&nm| measured.held(nm)).collect())
        });
        Some(Self { pairs: pairs.collect(), nm })
    }

    /// The change by these causes that leaves the least squares of what was measured, and those squares as a part of the
    /// squares of the measured curve; none where nothing can be solved for.
    fn left(&self, causes: &[Cause]) -> Option<(Change, f64)> {
        let may = |cause: Cause| causes.contains(&cause);
        let shifts = if may(Cause::Shift) { SHIFTS } else { 0 };
        let widths = if may(Cause::Width) { BROADENINGS } else { 0 };
        let mut best: Option<(Change, f64)> = None;
        let mut values = vec![0.0; self.nm.len()];
        for width in -widths..=widths {
            let (simulated, measured) = &self.pairs[(width + BROADENINGS) as usize];
            for step in -shifts..=shifts {
                let shift = SHIFT * f64::from(step);
                for (value, nm) in values.iter_mut().zip(&self.nm) {
                    *value = simulated.held(nm / (1.0 + shift));
                }
                let line = Line { level: may(Cause::Level), offset: may(Cause::Offset) };
                let (level, offset) = line.fitted(&values, measured);
                let squares = |a: f64| a * a;
                let left: f64 =
                    values.iter().zip(measured).map(|(s, m)| squares(level * s + offset - m)).sum();
                let size: f64 = measured.iter().map(|m| squares(*m)).sum();
                let part = left / size;
                if part.is_finite() && best.is_none_or(|(_, least)| part < least) {
                    let broadening_nm = BROADENING_NM * f64::from(width);
                    best = Some((Change { shift, level, broadening_nm, offset }, part));
                }
            }
        }
        best
    }
}

/// Which of the two numbers of a straight line may be fitted; otherwise they are 1 and 0.
struct Line {
    level: bool,
    offset: bool,
}

impl Line {
    /// Factor and constant of the least squares of factor · x + constant − y, with a constant that leaves neither curve less light than
    /// none: at most all of the least y, at least minus all of the least x.
    fn fitted(&self, x: &[f64], y: &[f64]) -> (f64, f64) {
        let count = x.len() as f64;
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min).max(0.0);
        let (mean_x, mean_y) = (x.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
        let factor = |x0: f64, y0: f64| {
            let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - x0) * (y - y0)).sum();
            let xx: f64 = x.iter().map(|x| (x - x0) * (x - x0)).sum();
            if xx > 0.0 { xy / xx } else { 1.0 }
        };
        let level = match (self.level, self.offset) {
            (false, _) => 1.0,
            (true, false) => return (factor(0.0, 0.0), 0.0),
            (true, true) => factor(mean_x, mean_y),
        };
        if !self.offset {
            return (level, 0.0);
        }
        let free = mean_y - level * mean_x;
        let offset = free.clamp(-least(x), least(y));
        (if self.level && offset != free { factor(0.0, offset) } else { level }, offset)
    }
}

/// A curve smoothed by a Gaussian of this standard deviation, over its own samples; as it is at 0.
fn smoothed(curve: &Spectrum, width_nm: f64) -> Spectrum {
    if width_nm <= 0.0 {
        return curve.clone();
    }
    let nm = curve.wavelengths().nm();
    // Each sample stands for half the way to its neighbours.
    let share = |i: usize| nm[(i + 1).min(nm.len() - 1)] - nm[i.saturating_sub(1)];
    let at = |centre: f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (i, value) in curve.values().iter().enumerate() {
            let distance = (nm[i] - centre) / width_nm;
            if distance.abs() < 5.0 {
                let weight = share(i) * libm::exp(-0.5 * distance * distance);
                sum += weight * value;
                weights += weight;
            }
        }
        sum / weights
    };
    let values = nm.iter().map(|&centre| at(centre)).collect();
    Spectrum::new(curve.wavelengths().clone(), values).unwrap_or_else(|_| curve.clone())
}

#[cfg(test)]
mod tests {
    use super::super::Wavelengths;
    use super::*;

    /// Two orders on a slope, as of a film.
    fn film(shift: f64, width: f64, level: f64, offset: f64) -> Spectrum {
        let nm: Vec<f64> = (300..=700).step_by(4).map(f64::from).collect();
        let bell = |x: f64, at: f64, w: f64| {
            let w = (w * w + width * width).sqrt();
            // The area stays when a bell is smoothed.
            w.recip() * (-0.5 * ((x / (1.0 + shift) - at) / w).powi(2)).exp()
        };
        let value =
            |x: &f64| offset + level * (0.03 + 3.0 * bell(*x, 380.0, 24.0) + 6.0 * bell(*x, 540.0, 40.0));
        Spectrum::new(Wavelengths::new(nm.clone()).unwrap(), nm.iter().map(value).collect()).unwrap()
    }

    #[test]
    fn each_cause_is_found_with_its_amount() {
        let simulated = film(0.0, 0.0, 1.0, 0.0);
        let planted = [
            (film(0.02, 0.0, 1.0, 0.0), Cause::Shift),
            (film(-0.05, 0.0, 1.0, 0.0), Cause::Shift),
            (film(0.0, 0.0, 0.7, 0.0), Cause::Level),
            (film(0.0, 21.0, 1.0, 0.0), Cause::Width),
            (film(0.0, 0.0, 1.0, 0.02), Cause::Offset),
        ];
        for (measured, cause) in &planted {
            let found = Residual::of(&simulated, measured).unwrap();
            assert_eq!(found.causes.first(), Some(cause), "{found:?}");
            assert!(found.first_explains > 0.95, "{found:?}");
        }
        let of = |index: usize| Residual::of(&simulated, &planted[index].0).unwrap().change;
        assert!((of(0).shift - 0.02).abs() < 0.003 && (of(1).shift + 0.05).abs() < 0.003);
        assert!((of(2).level - 0.7).abs() < 0.01 && (of(4).offset - 0.02).abs() < 1e-3);
        assert!((of(3).broadening_nm - 21.0).abs() < 3.1, "{:?}", of(3));
        // The other way round the measured curve is the sharper one.
        let sharper = Residual::of(&planted[3].0, &simulated).unwrap();
        assert_eq!(sharper.causes, [Cause::Width]);
        assert!((sharper.change.broadening_nm + 21.0).abs() < 3.1 && sharper.words().contains("sharpening"));
    }

    #[test]
    fn two_causes_are_told_in_the_order_of_what_they_explain() {
        let found = Residual::of(&film(0.0, 0.0, 1.0, 0.0), &film(0.06, 0.0, 0.8, 0.0)).unwrap();
        assert_eq!(found.causes, [Cause::Shift, Cause::Level], "{found:?}");
        assert!(found.explained > 0.98 && found.first_explains < found.explained, "{found:?}");
        let words = found.words();
        assert!(words.starts_with("a shift by +6.0 %") && words.contains("× 0.80"), "{words}");
    }

    #[test]
    fn a_curve_of_another_shape_is_not_explained_and_an_equal_one_has_no_cause() {
        let simulated = film(0.0, 0.0, 1.0, 0.0);
        assert_eq!(Residual::of(&simulated, &simulated), None);
        let nm = simulated.wavelengths();
        // As many orders again, as of a film twice as thick.
        let fringes = nm.iter().map(|nm| 0.1 + 0.08 * (6000.0 / nm * std::f64::consts::TAU).cos()).collect();
        let other = Spectrum::new(nm.clone(), fringes).unwrap();
        let found = Residual::of(&simulated, &other).unwrap();
        assert!(found.causes.is_empty() && found.cause().is_none(), "{found:?}");
        assert!(found.words().contains("another structure"));
    }

    #[test]
    fn smoothing_keeps_constants_and_adds_variances() {
        let flat = Spectrum::new(Wavelengths::usual(), vec![0.3; 50]).unwrap();
        assert!(smoothed(&flat, 20.0).values().iter().all(|v| (v - 0.3).abs() < 1e-12));
        let (sharp, wide) = (film(0.0, 0.0, 1.0, 0.0), film(0.0, 15.0, 1.0, 0.0));
        let off = |a: &Spectrum| {
            a.values()
                .iter()
                .zip(wide.values())
                .skip(20)
                .take(60)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        assert!(off(&smoothed(&sharp, 15.0)) < 1e-3, "{}", off(&smoothed(&sharp, 15.0)));
    }
}
