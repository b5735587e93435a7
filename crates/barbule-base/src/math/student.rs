//! Distributions of means and variances of few values.

use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

use super::normal;

/// From so many degrees of freedom on the first term of the expansion about the normal distribution (Abramowitz & Stegun 26.7.5) is
/// exact to 1e-5, where the incomplete beta function of the library is not.
const MANY: f64 = 1000.0;

/// The quantile of Student's t distribution of this many degrees of freedom, for 0 < `p` < 1; not a number of other arguments.
#[must_use]
pub fn quantile(p: f64, degrees: f64) -> f64 {
    if degrees > MANY && p > 0.0 && p < 1.0 {
        let z = normal::quantile(p);
        return z + (z * z * z + z) / (4.0 * degrees);
    }
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |t| t.inverse_cdf(p))
}

/// The half width of the two-sided interval of 95 % of a mean, in standard errors of this many degrees of freedom; infinite of none.
#[must_use]
pub fn interval_95(degrees: f64) -> f64 {
    if degrees > 0.0 { quantile(0.975, degrees) } else { f64::INFINITY }
}

/// The quantile of the F distribution of `above` and `below` degrees of freedom, for 0 < `p` < 1; not a number of other arguments.
#[must_use]
pub fn fisher_quantile(p: f64, above: f64, below: f64) -> f64 {
    FisherSnedecor::new(above, below).map_or(f64::NAN, |f| f.inverse_cdf(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of any textbook of statistics.
    #[test]
    fn quantiles_are_those_of_tables() {
        for (degrees, t) in [
            (1.0, 12.706_2),
            (4.0, 2.776_4),
            (10.0, 2.228_1),
            (999.0, 1.962_34),
            (1001.0, 1.962_34),
            (1e6, 1.959_96),
        ] {
            assert!((interval_95(degrees) - t).abs() < 1e-4, "{degrees}: {}", interval_95(degrees));
        }
        assert!((quantile(0.025, 10.0) + 2.228_1).abs() < 1e-4 && quantile(0.975, -1.0).is_nan());
        assert!((fisher_quantile(0.95, 3.0, 10.0) - 3.708_3).abs() < 1e-3);
    }
}
