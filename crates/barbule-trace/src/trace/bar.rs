//! The scale bar that microscopes draw into a picture.

use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};

use super::field::Grey;

/// A scale bar in a picture, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Left, top, right, bottom, the last two beyond it.
    pub bounds: [usize; 4],
    /// Its length.
    pub length: f64,
    /// The rows of the picture that are free of it and of what is written beside it: from, to.
    pub free: [usize; 2],
}

/// A bar is at least so many times as long as it is high, and fills its bounds to this part.
const SLENDER: usize = 4;
const FILLED: f64 = 0.95;
/// The upper and the lower part of the picture in which bars lie.
const NEAR_BORDER: f64 = 0.25;

/// Looks for a level bar of black or white near the upper or the lower border; the longest if there are several.
#[must_use]
pub fn scale_bar(picture: &Grey) -> Option<Bar> {
    let [width, height] = picture.size();
    let (low, high) = picture.values.iter().fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let (dark, bright) = (low + 0.03 * (high - low), high - 0.03 * (high - low));
    let of = |is: &dyn Fn(f32) -> bool| {
        let mask = picture.values.iter().map(|v| if is(*v) { 255 } else { 0 }).collect();
        let image = GrayImage::from_raw(width as u32, height as u32, mask)?;
        let labels = connected_components(&image, Connectivity::Eight, Luma([0]));
        bar_of(labels.as_raw(), [width, height])
    };
    let found = [of(&|v| v <= dark), of(&|v| v >= bright)];
    found.into_iter().flatten().max_by(|a, b| a.length.total_cmp(&b.length))
}

fn bar_of(labels: &[u32], [width, height]: [usize; 2]) -> Option<Bar> {
    let count = labels.iter().max().map_or(0, |most| *most as usize + 1);
    let mut parts = vec![([width, height, 0, 0], 0_usize); count];
    for (at, label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let [x, y] = [at % width, at / width];
        let ([left, top, right, bottom], area) = &mut parts[*label as usize];
        (*left, *top, *right, *bottom) =
            ((*left).min(x), (*top).min(y), (*right).max(x + 1), (*bottom).max(y + 1));
        *area += 1;
    }
    let near = (NEAR_BORDER * height as f64) as usize;
    let is_bar = |([left, top, right, bottom], area): &([usize; 4], usize)| {
        if *area == 0 {
            return false;
        }
        let [long, high] = [right - left, bottom - top];
        // Part of a frame or of a panel it is not.
        let is_free = *left > 0 && *top > 0 && *right < width && *bottom < height;
        let is_slender =
            long >= SLENDER * high && long * 30 >= width && long * 10 <= 8 * width && high * 20 <= height;
        is_free
            && is_slender
            && *area as f64 >= FILLED * (long * high) as f64
            && (*bottom <= near || *top >= height - near)
    };
    let (bounds, area) =
        parts.iter().copied().filter(is_bar).max_by_key(|([left, _, right, _], _)| right - left)?;
    let [_, top, _, bottom] = bounds;
    // Words of the same grey stand above or below the bar, no farther than a tenth of the picture.
    let reach = height / 10;
    let (mut from, mut to) = (top, bottom);
    for ([_, t, _, b], area) in parts.iter().filter(|(_, area)| *area > 0) {
        let is_word = (b - t) * 8 <= height && *area < height * height / 64;
        if is_word && *t + reach > top && *b < bottom + reach {
            (from, to) = (from.min(*t), to.max(*b));
        }
    }
    let margin = 4;
    let free =
        if 2 * top > height { [0, from.saturating_sub(margin)] } else { [(to + margin).min(height), height] };
    // The mean length of its rows, so that soft ends count in part.
    Some(Bar { bounds, length: area as f64 / (bottom - top) as f64, free })
}
