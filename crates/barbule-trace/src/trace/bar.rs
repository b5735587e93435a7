//! The scale bar that microscopes draw into a picture.

use image::{GrayImage, Luma};
use imageproc::region_labelling::{Connectivity, connected_components};

use super::field::{Grey, part};

/// A scale bar in a picture, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Left, top, right, bottom, the last two beyond it.
    pub bounds: [usize; 4],
    /// Its length.
    pub length: f64,
    /// The rows of the picture that are free of it, of what is written beside it, and of a strip of one grey in which it lies: from, to.
    pub free: [usize; 2],
}

/// A bar is at least so many times as long as it is high, and fills its bounds to this part.
const SLENDER: usize = 4;
const FILLED: f64 = 0.95;
/// The upper and the lower part of the picture in which bars lie.
const NEAR_BORDER: f64 = 0.25;
/// Rows beside a bar that are left out too: words have soft edges.
const MARGIN: usize = 4;
/// A row of a strip has its grey in this part of its pixels, words in the others, and to this part of the picture's range.
const STRIP: f64 = 0.6;
const SAME_GREY: f32 = 0.02;
/// What is higher, as a part of the picture, is no strip.
const MOST_STRIP: f64 = 0.35;

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
    let bar = found.into_iter().flatten().max_by(|a, b| a.length.total_cmp(&b.length))?;
    let free = match strip(picture, bar.bounds, high - low) {
        // The strip's rows say nothing of the section, and their grey would be taken for one of its classes.
        Some(edge) if bar.free[0] == 0 => [0, bar.free[1].min(edge.saturating_sub(MARGIN))],
        Some(edge) => [bar.free[0].max((edge + MARGIN).min(height)), height],
        None => bar.free,
    };
    Some(Bar { free, ..bar })
}

/// The row at which a strip of black or white begins or ends that reaches from side to side and holds the bar: its edge towards the picture's
/// middle. None where the bar is drawn into the picture itself.
fn strip(picture: &Grey, [left, top, right, bottom]: [usize; 4], range: f32) -> Option<usize> {
    let [width, height] = picture.size();
    let row = |y: usize| &picture.values[y * width..(y + 1) * width];
    let middle = row(top.midpoint(bottom));
    let mut beside: Vec<f64> = middle[..left].iter().chain(&middle[right..]).map(|v| f64::from(*v)).collect();
    let ground = part(&mut beside, 0.5) as f32;
    let is_ground = |v: f32| (v - ground).abs() <= SAME_GREY * range;
    // A bar is black or white, and the strip is the other: a layer of some grey is none.
    if (ground - middle[left.midpoint(right)]).abs() < 0.9 * range {
        return None;
    }
    let of_ground = beside.iter().filter(|v| is_ground(**v as f32)).count();
    if (of_ground as f64) < STRIP * beside.len() as f64 {
        return None;
    }
    let is_strip = |y: usize| row(y).iter().filter(|v| is_ground(**v)).count() as f64 >= STRIP * width as f64;
    let is_below = 2 * top > height;
    let rows = if is_below { top } else { height - bottom };
    // So many rows beyond the bar are the strip's, over lines that are ruled in it.
    let mut reach = 0;
    for beyond in 0..rows {
        let y = if is_below { top - 1 - beyond } else { bottom + beyond };
        if is_strip(y) {
            reach = beyond + 1;
        } else if beyond >= reach + MARGIN {
            break;
        }
    }
    let edge = if is_below { top - reach } else { bottom + reach };
    let high = if is_below { height - edge } else { edge };
    (high as f64 <= MOST_STRIP * height as f64).then_some(edge)
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
    let free =
        if 2 * top > height { [0, from.saturating_sub(MARGIN)] } else { [(to + MARGIN).min(height), height] };
    // The mean length of its rows, so that soft ends count in part.
    Some(Bar { bounds, length: area as f64 / (bottom - top) as f64, free })
}
