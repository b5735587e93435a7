//! Numbers in equal steps, as people type them: `start:stop:step`, the stop included where steps lead there.

/// Half a millionth of a step forgives decimal steps such as 0.1.
const SLACK: f64 = 1e-6;

/// Digits after the first that numbers between are rounded to, as people could have meant them, so that 0.1 + 2·0.1 is 0.3.
const DIGITS: usize = 12;

/// Up to here every whole number is one of double precision.
const MOST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// How many steps lead from `start` to `stop`, the last one in part; `None` if the step is 0 or leads away.
#[must_use]
pub fn steps_between(start: f64, stop: f64, step: f64) -> Option<f64> {
    let count = (stop - start) / step;
    (count >= 0.0 && step != 0.0).then_some(count)
}

/// `start` and what the whole ones of `count` steps lead to, of [`steps_between`].
pub fn stepped(start: f64, step: f64, count: f64) -> impl Iterator<Item = f64> {
    (0..=(count + SLACK).floor() as usize).map(move |i| decimal(start + i as f64 * step))
}

/// A number as people could have meant it: [`rounded`] to 13 digits, whole ones that are exact as they are.
#[must_use]
pub fn decimal(value: f64) -> f64 {
    if value.fract() == 0.0 && value.abs() <= MOST_WHOLE { value } else { rounded(value, DIGITS) }
}

/// A number to so many digits after the first.
#[must_use]
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(start: f64, stop: f64, step: f64) -> Vec<f64> {
        stepped(start, step, steps_between(start, stop, step).unwrap()).collect()
    }

    #[test]
    fn steps_are_the_numbers_that_were_meant_and_end_where_they_lead() {
        assert_eq!(values(0.0, 0.5, 0.1), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        assert_eq!(values(-0.3, 0.3, 0.2), [-0.3, -0.1, 0.1, 0.3]);
        assert_eq!(values(3.0, 1.0, -1.0), [3.0, 2.0, 1.0]);
        assert_eq!(values(1.0, 2.0, 0.4), [1.0, 1.4, 1.8]);
        assert_eq!(values(5.0, 5.0, 1.0), [5.0]);
        let tenths = values(300.0, 830.0, 0.1);
        assert_eq!(tenths.len(), 5301);
        assert!(tenths.iter().enumerate().all(|(i, nm)| *nm == (3000 + i) as f64 / 10.0));
    }

    #[test]
    fn whole_numbers_are_kept_to_the_bit() {
        assert!(values(300.0, 830.0, 1.0).into_iter().eq((300..=830).map(f64::from)));
        let large = 9_007_199_254_740_991.0;
        assert_eq!(values(large - 1.0, large, 1.0), [large - 1.0, large]);
    }

    #[test]
    fn steps_of_nothing_and_steps_away_lead_nowhere() {
        for (stop, step) in [(2.0, 0.0), (2.0, -0.0), (2.0, -1.0), (0.0, 1.0), (1.0, 0.0)] {
            assert_eq!(steps_between(1.0, stop, step), None, "1:{stop}:{step}");
        }
    }
}
