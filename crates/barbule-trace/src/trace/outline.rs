//! Outlines between pixels: where the smoothed picture crosses the grey in the middle of two classes.

use super::field::Grey;
use super::regions::Map;

/// A closed outline, px: corners in order, the last joined to the first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outline {
    /// Corners x, y.
    pub corners: Vec<[f64; 2]>,
}

impl Outline {
    /// Its area, px², and the middle of the area.
    #[must_use]
    pub fn area_and_middle(&self) -> (f64, [f64; 2]) {
        let Some(origin) = self.corners.first() else { return (0.0, [0.0; 2]) };
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for (a, b) in self.sides() {
            let [a, b] = [a, b].map(|p| [p[0] - origin[0], p[1] - origin[1]]);
            let cross = a[0] * b[1] - b[0] * a[1];
            twice += cross;
            (0..2).for_each(|i| moment[i] += cross * (a[i] + b[i]));
        }
        if twice == 0.0 {
            return (0.0, *origin);
        }
        (0.5 * twice.abs(), [0, 1].map(|i| origin[i] + moment[i] / (3.0 * twice)))
    }

    /// The diameter of the disc of the same area, px.
    #[must_use]
    pub fn diameter(&self) -> f64 {
        (4.0 * self.area_and_middle().0 / std::f64::consts::PI).sqrt()
    }

    fn sides(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// What it was before a Gaussian of deviation `blur` px rounded it. Blurring moves the contour in the middle of an edge as
    /// curvature flow does, and that takes 2π t off the area of any closed curve in the time t = `blur`²/2 (M. Gage, Duke
    /// Mathematical Journal 50, 1225, 1983).
    #[must_use]
    pub fn unblurred(mut self, blur: f64) -> Self {
        let (area, middle) = self.area_and_middle();
        if area > 0.0 {
            let factor = (1.0 + std::f64::consts::PI * blur * blur / area).sqrt();
            for corner in &mut self.corners {
                *corner = [0, 1].map(|i| middle[i] + factor * (corner[i] - middle[i]));
            }
        }
        self
    }

    /// Its length, px.
    fn length(&self) -> f64 {
        self.sides().map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
    }

    /// How round it is: 4π area / length², 1 for a disc.
    #[must_use]
    pub fn roundness(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.area_and_middle().0 / self.length().powi(2)
    }

    /// With corners at least `apart` px from each other.
    #[must_use]
    pub fn thinned(&self, apart: f64) -> Self {
        let mut corners: Vec<[f64; 2]> = Vec::new();
        for corner in &self.corners {
            let near = |last: &[f64; 2]| (last[0] - corner[0]).hypot(last[1] - corner[1]) < apart;
            if !corners.last().is_some_and(near) {
                corners.push(*corner);
            }
        }
        while corners.len() > 3
            && (corners[0][0] - corners[corners.len() - 1][0])
                .hypot(corners[0][1] - corners[corners.len() - 1][1])
                < apart
        {
            corners.pop();
        }
        Self { corners }
    }
}

/// Values on pixels of a part of the picture whose left upper pixel is `origin`.
struct Window {
    origin: [usize; 2],
    width: usize,
    height: usize,
    values: Vec<f64>,
}

/// The outline of the regions for which `is_inside` says so, within the bounds of `bounds` and a little beyond, at a level of the picture.
/// Pixels farther than two from the edge of these regions count as what their region is, whatever their grey: neither what is
/// inside nor what lies near changes the outline.
pub(super) fn around(
    grey: &Grey,
    map: &Map,
    bounds: [usize; 4],
    level: f64,
    inside_is_bright: bool,
    is_inside: &dyn Fn(usize) -> bool,
) -> Option<Outline> {
    const REACH: usize = 2;
    let grow = REACH + 2;
    let [left, top] = [bounds[0].saturating_sub(grow), bounds[1].saturating_sub(grow)];
    let [right, bottom] = [(bounds[2] + grow).min(map.width), (bounds[3] + grow).min(map.height)];
    let (width, height) = (right - left, bottom - top);
    let inside: Vec<bool> = (top..bottom)
        .flat_map(|y| (left..right).map(move |x| (x, y)))
        .map(|(x, y)| is_inside(map.labels[y * map.width + x] as usize))
        .collect();
    let sign = if inside_is_bright { 1.0 } else { -1.0 };
    // Above 0 inside.
    let values = (0..width * height)
        .map(|at| {
            let [x, y] = [at % width, at / width];
            let near = (y.saturating_sub(REACH)..(y + REACH + 1).min(height)).any(|j| {
                (x.saturating_sub(REACH)..(x + REACH + 1).min(width))
                    .any(|i| inside[j * width + i] != inside[at])
            });
            let value = sign * (grey.at(left + x, top + y) - level);
            if near {
                value
            } else if inside[at] {
                value.abs()
            } else {
                -value.abs()
            }
        })
        .collect();
    let window = Window { origin: [left, top], width, height, values };
    let longest = |a: &Outline, b: &Outline| a.area_and_middle().0.total_cmp(&b.area_and_middle().0);
    loops(&window).into_iter().max_by(longest).filter(|outline| outline.corners.len() >= 3)
}

/// The closed curves on which a window's values are 0, by marching squares with linear interpolation between the middles of pixels.
/// Beyond the window everything is outside.
fn loops(window: &Window) -> Vec<Outline> {
    let (w, h) = (window.width + 2, window.height + 2);
    let value = |x: usize, y: usize| {
        let is_in = (1..=window.width).contains(&x) && (1..=window.height).contains(&y);
        if is_in { window.values[(y - 1) * window.width + x - 1] } else { -1.0 }
    };
    let above = |x: usize, y: usize| value(x, y) > 0.0;
    let crossing = |[x, y]: [usize; 2], [i, j]: [usize; 2]| {
        let (a, b) = (value(x, y), value(i, j));
        let t = a / (a - b);
        let at = |from: usize, to: usize, origin: usize| {
            // Index 1 is the window's first pixel, whose middle is at half a pixel.
            origin as f64 - 0.5 + from as f64 + t * (to as f64 - from as f64)
        };
        [at(x, i, window.origin[0]), at(y, j, window.origin[1])]
    };
    // Edges of the grid are walked with the inside at the left. An edge is the pair of neighbouring middles that it divides:
    // number 2·cell for the one to the right, 2·cell + 1 for the one below.
    let mut next = std::collections::BTreeMap::<usize, (usize, [f64; 2])>::new();
    let right = |x: usize, y: usize| 2 * (y * w + x);
    let below = |x: usize, y: usize| 2 * (y * w + x) + 1;
    for y in 0..h - 1 {
        for x in 0..w - 1 {
            let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
            let sides = [right(x, y), below(x + 1, y), right(x, y + 1), below(x, y)];
            let is = corners.map(|[x, y]| above(x, y));
            // Sides clockwise; where the inside begins a curve leaves, where it ends one enters.
            let enters: Vec<usize> = (0..4).filter(|s| is[*s] && !is[(s + 1) % 4]).collect();
            let leaves: Vec<usize> = (0..4).filter(|s| !is[*s] && is[(s + 1) % 4]).collect();
            // Of a saddle the inside parts are joined if the mean is inside.
            let mean: f64 = corners.iter().map(|[x, y]| value(*x, *y)).sum();
            for (index, enter) in enters.iter().enumerate() {
                let leave = match leaves.len() {
                    1 => leaves[0],
                    _ if mean > 0.0 => (enter + 1) % 4,
                    _ => (enter + 3) % 4,
                };
                let leave = if leaves.contains(&leave) { leave } else { leaves[index] };
                next.insert(
                    sides[*enter],
                    (sides[leave], crossing(corners[*enter], corners[(enter + 1) % 4])),
                );
            }
        }
    }
    let mut found = Vec::new();
    while let Some((&start, _)) = next.iter().next() {
        let mut corners = Vec::new();
        let mut at = start;
        while let Some((to, corner)) = next.remove(&at) {
            corners.push(corner);
            at = to;
        }
        found.push(Outline { corners });
    }
    found
}

/// The deviation of the Gaussian that blurs the edges of outlines, px: that of the step which fits the mean of the picture across them,
/// between the greys `inside` and `outside`. `reach` is how far from the outline nothing else is near, px.
pub(super) fn blur_across(
    grey: &Grey,
    outlines: &[&Outline],
    [inside, outside]: [f64; 2],
    reach: f64,
) -> Option<f64> {
    const STEPS: usize = 9;
    let mut sums = [0.0; STEPS];
    let mut count = 0.0;
    let place = |step: usize| reach * (2.0 * step as f64 / (STEPS - 1) as f64 - 1.0);
    for outline in outlines {
        let (_, middle) = outline.area_and_middle();
        let corners = &outline.corners;
        let n = corners.len();
        for i in (0..n).step_by(2) {
            // The tangent over some corners, since single ones are noisy.
            let [a, b] = [corners[(i + n - 4 % n) % n], corners[(i + 4) % n]];
            let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
            let length = dx.hypot(dy);
            if length < 1e-9 {
                continue;
            }
            let mut normal = [dy / length, -dx / length];
            if normal[0] * (corners[i][0] - middle[0]) + normal[1] * (corners[i][1] - middle[1]) < 0.0 {
                normal = normal.map(|v| -v);
            }
            for (step, sum) in sums.iter_mut().enumerate() {
                let d = place(step);
                *sum += (grey.sample(corners[i][0] + d * normal[0], corners[i][1] + d * normal[1]) - outside)
                    / (inside - outside);
            }
            count += 1.0;
        }
    }
    if count < 20.0 {
        return None;
    }
    let misfit = |blur: f64| -> f64 {
        (0..STEPS)
            .map(|s| {
                (sums[s] / count - 0.5 * libm::erfc(place(s) / (blur * std::f64::consts::SQRT_2))).powi(2)
            })
            .sum()
    };
    // A golden section between what the sampling itself blurs and what no micrograph has.
    let (mut low, mut high) = (0.2, 15.0);
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    while high - low > 1e-3 {
        let [a, b] = [high - ratio * (high - low), low + ratio * (high - low)];
        if misfit(a) < misfit(b) { high = b } else { low = a }
    }
    Some(0.5 * (low + high))
}
