//! Colours of curves and of maps that colour-blind readers can tell apart.

use super::drawing::{Ink, Stroke};

/// The colours of curves in their order (Okabe & Ito 2008, without their yellow, which is too light for lines).
pub const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [0, 0, 0], [86, 180, 233], [230, 159, 0]];

/// Dashes of curves in their order; solid first.
const DASHES: [&[f64]; 5] = [&[], &[7.0, 3.0], &[2.0, 2.5], &[9.0, 3.0, 2.0, 3.0], &[14.0, 4.0]];

/// The look of curve `i`: neighbours differ in hue and dash, and the first 35 in their pair.
#[must_use]
pub fn style(i: usize) -> Stroke {
    Stroke { ink: Ink::of(PALETTE[i % PALETTE.len()]), width: 1.6, dash: DASHES[i % DASHES.len()].to_vec() }
}

/// A scale of colours from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Map {
    /// Perceptually uniform, dark blue to yellow, for quantities from little to much.
    #[default]
    Viridis,
    /// The same for readers with any colour vision.
    Cividis,
    /// From blue through white to red, for differences about 0.5.
    Diverging,
    /// Black to white.
    Grey,
}

impl Map {
    /// The colour at `t`, clipped to 0…1; NaN is mid grey.
    #[must_use]
    pub fn at(self, t: f64) -> [u8; 3] {
        if t.is_nan() {
            return [128; 3];
        }
        let t = t.clamp(0.0, 1.0);
        let gradient = match self {
            Self::Viridis => colorous::VIRIDIS,
            Self::Cividis => colorous::CIVIDIS,
            // From red to blue in the crate.
            Self::Diverging => return colorous::RED_BLUE.eval_continuous(1.0 - t).into_array(),
            Self::Grey => return [(t * 255.0).round() as u8; 3],
        };
        gradient.eval_continuous(t).into_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_curves_differ_in_hue_and_dash() {
        for i in 0..34 {
            assert!(style(i).ink != style(i + 1).ink && style(i).dash != style(i + 1).dash);
        }
    }

    #[test]
    fn viridis_grows_lighter_all_the_way() {
        let light = |t: f64| {
            let [r, g, b] = Map::Viridis.at(t).map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((0..50).all(|i| light(f64::from(i + 1) / 50.0) > light(f64::from(i) / 50.0)));
        assert_eq!(Map::Viridis.at(f64::NAN), [128; 3]);
        assert_eq!(Map::Viridis.at(-5.0), Map::Viridis.at(0.0));
    }
}
