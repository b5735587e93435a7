//! Numbers in words, lengths of scales, and places of labels.

/// A time that is not known exactly, as in `about 40 s` or `about 3 min`.
pub(super) fn about(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "under 1 s".to_owned(),
        s if s < 10.0 => format!("about {s:.0} s"),
        s if s < 100.0 => format!("about {:.0} s", 5.0 * (s / 5.0).round()),
        s if s < 5400.0 => format!("about {:.0} min", s / 60.0),
        s => format!("about {:.1} h", s / 3600.0),
    }
}

/// The longest of 1, 2 and 5 times a power of ten that is no longer than this.
pub(super) fn round_below(length: f64) -> f64 {
    if !(length.is_finite() && length > 0.0) {
        return 1.0;
    }
    let power = 10_f64.powf(length.log10().floor());
    [5.0, 2.0].into_iter().map(|times| times * power).find(|round| *round <= length).unwrap_or(power)
}

/// A length of µm in the unit in which people read it.
pub(super) fn length(um: f64) -> String {
    // 0.1 µm is easier to read than 100 nm beside layers' thicknesses only from there on.
    if um < 0.9995 { format!("{} nm", digits(1e3 * um)) } else { format!("{} µm", digits(um)) }
}

/// A number with three digits that matter.
pub(super) fn digits(value: f64) -> String {
    let size = value.abs();
    let decimals = match size {
        s if s >= 99.95 || s == 0.0 => 0,
        s if s >= 9.995 => 1,
        s if s >= 0.9995 => 2,
        s if s >= 0.01 => 3,
        _ => return format!("{value:.2e}"),
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A part as a percentage, as in `45 %`.
pub(super) fn percent(part: f64) -> String {
    format!("{} %", digits(100.0 * part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rough() {
        assert_eq!(
            [0.4, 3.2, 43.0, 600.0, 9000.0].map(about),
            ["under 1 s", "about 3 s", "about 45 s", "about 10 min", "about 2.5 h"]
        );
    }

    #[test]
    fn scales_have_round_lengths() {
        assert_eq!([0.3, 0.19, 7.0, 12.0, 1.0].map(round_below), [0.2, 0.1, 5.0, 10.0, 1.0]);
        assert_eq!([0.0, f64::NAN, f64::INFINITY].map(round_below), [1.0; 3]);
        assert_eq!([0.2, 0.05, 2.0, 10.0].map(length), ["200 nm", "50 nm", "2 µm", "10 µm"]);
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!(
            [0.0, 1234.6, 45.25, 4.5, 0.123_45, 1.0].map(digits),
            ["0", "1235", "45.2", "4.5", "0.123", "1"]
        );
        assert_eq!((digits(-12.34).as_str(), digits(0.000_12).as_str()), ("-12.3", "1.20e-4"));
        assert_eq!(percent(0.4567), "45.7 %");
    }
}
