//! A picture as a few colours: each pixel the mean of those that are about alike.

use super::texture::Texture;
use crate::spectrum::colour::encode;

/// Steps of each of red, green and blue, as screens show them, within which colours are one.
const STEPS: usize = 32;
/// Colours that differ by fewer steps than this are not told apart.
const ALIKE: usize = 2;

/// Colours of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    /// Mean linear sRGB of each.
    pub colours: Vec<[f64; 3]>,
    /// Over the picture, value i (of 255) where the i-th colour is, counted from 1.
    pub places: Texture,
}

/// How often colours of one step are met, and their sum.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    count: f64,
    sum: [f64; 3],
}

/// Steps of red, green and blue.
fn steps(texel: [f32; 3]) -> [usize; 3] {
    texel.map(|value| ((encode(f64::from(value)) * STEPS as f64) as usize).min(STEPS - 1))
}

fn index([r, g, b]: [usize; 3]) -> usize {
    (r * STEPS + g) * STEPS + b
}

fn step_of(index: usize) -> [usize; 3] {
    [index / (STEPS * STEPS), index / STEPS % STEPS, index % STEPS]
}

/// The axis along which bins spread most, by their number times the square of their extent, and that measure; nothing where they
/// are alike.
fn spread(bins: &[usize], all: &[Bin]) -> Option<(usize, f64)> {
    let count: f64 = bins.iter().map(|&bin| all[bin].count).sum();
    (0..3)
        .filter_map(|axis| {
            let places = || bins.iter().map(|&bin| step_of(bin)[axis]);
            let extent = places().max()? - places().min()?;
            (extent >= ALIKE).then_some((axis, count * (extent * extent) as f64))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}

impl Palette {
    /// At most so many colours of a picture (1 to 255): its colours are halved at their mean along the axis of screen values on which
    /// they spread most, as long as they are not alike (Heckbert 1982).
    #[must_use]
    pub fn of(picture: &Texture, most: usize) -> Self {
        let mut all = vec![Bin::default(); STEPS * STEPS * STEPS];
        for texel in picture.texels.iter() {
            let bin = &mut all[index(steps(*texel))];
            bin.count += 1.0;
            bin.sum = std::array::from_fn(|k| bin.sum[k] + f64::from(texel[k]));
        }
        let mut groups: Vec<Vec<usize>> = vec![(0..all.len()).filter(|&bin| all[bin].count > 0.0).collect()];
        while groups.len() < most.clamp(1, 255) {
            let widest = groups.iter().enumerate().filter_map(|(i, bins)| Some((i, spread(bins, &all)?)));
            let Some((group, (axis, _))) = widest.max_by(|a, b| a.1.1.total_cmp(&b.1.1).then(b.0.cmp(&a.0)))
            else {
                break;
            };
            let bins = std::mem::take(&mut groups[group]);
            let count: f64 = bins.iter().map(|&bin| all[bin].count).sum();
            let mean =
                bins.iter().map(|&bin| all[bin].count * step_of(bin)[axis] as f64).sum::<f64>() / count;
            let (low, high) = bins.into_iter().partition(|&bin| step_of(bin)[axis] as f64 <= mean);
            groups[group] = low;
            groups.push(high);
        }
        let mut number = vec![0.0_f32; all.len()];
        let colour = |(i, bins): (usize, &Vec<usize>)| {
            bins.iter().for_each(|&bin| number[bin] = (i + 1) as f32 / 255.0);
            let count: f64 = bins.iter().map(|&bin| all[bin].count).sum();
            std::array::from_fn(|k| bins.iter().map(|&bin| all[bin].sum[k]).sum::<f64>() / count)
        };
        let colours = groups.iter().enumerate().map(colour).collect();
        let places = picture.texels.iter().map(|texel| [number[index(steps(*texel))]; 3]).collect();
        Self { colours, places: Texture { size: picture.size, texels: places } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two colours stay two, whatever is allowed; many become as many as are allowed, each near to what it stands for.
    #[test]
    fn colours_are_kept_while_there_is_room_for_them() {
        let (dark, pale) = ([0.02_f32, 0.01, 0.005], [0.6, 0.5, 0.3]);
        let two = Texture::new([2, 2], vec![dark, pale, pale, dark]).unwrap();
        let palette = Palette::of(&two, 24);
        assert_eq!(palette.colours.len(), 2);
        for (place, texel) in [([0.25, 0.75], dark), ([0.75, 0.75], pale), ([0.25, 0.25], pale)] {
            let colour = palette.colours[palette.places.value_at(place) - 1];
            assert!((0..3).all(|k| (colour[k] - f64::from(texel[k])).abs() < 1e-6), "{colour:?}");
        }
        let ramp: Vec<[f32; 3]> =
            (0..4096).map(|i| [(i % 64) as f32 / 63.0, (i / 64) as f32 / 63.0, 0.1]).collect();
        let ramp = Texture::new([64, 64], ramp).unwrap();
        let palette = Palette::of(&ramp, 24);
        assert_eq!((palette.colours.len(), palette.places.highest_value().unwrap()), (24, 24));
        let mut error = 0.0;
        for i in 0..4096 {
            let at = [(f64::from(i % 64) + 0.5) / 64.0, 1.0 - (f64::from(i / 64) + 0.5) / 64.0];
            let (is, kept) = (ramp.at(at), palette.colours[palette.places.value_at(at) - 1]);
            error += (0..2).map(|k| (encode(is[k]) - encode(kept[k])).powi(2)).sum::<f64>();
        }
        let error = (error / 4096.0).sqrt();
        assert!(error < 0.14, "{error}");
        assert_eq!(Palette::of(&ramp, 1).colours.len(), 1);
    }
}
