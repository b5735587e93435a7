//! Cross sections drawn to scale: the whole barbule, a zoom, a legend, and the parameters of hummingbirds.

use crate::plot::{Anchor, Drawing, Ink, Item, PALETTE, Page, Stroke, text};
use crate::structure::{CrystalLayer, Hummingbird, Loop, Medium, Polyline, Section, Substance};

/// Usual and least width of the page, px.
const PAGE: f64 = 1000.0;
const NARROWEST: f64 = 320.0;
/// Parts of the page's width that the zoom may take.
const ZOOMS: [f64; 4] = [0.62, 0.5, 0.4, 0.3];
pub(super) const MARGIN: f64 = 30.0;
pub(super) const FONT: f64 = 15.0;
pub(super) const HEADING: f64 = 18.0;
/// Zooms show at most this much, µm; of a crystal, whose rods are small, less.
const ZOOM_UM: f64 = 5.0;
const CRYSTAL_ZOOM_UM: f64 = 3.0;
/// What is shown below a crystal, as a part of its depth.
const BELOW_CRYSTAL: f64 = 0.15;
/// Points closer than this on the page are left out, px.
const DETAIL: f64 = 0.3;
/// Width of the strips in which a mixture's shade is constant, px.
const STRIP: f64 = 2.0;
const FRAME: [u8; 3] = PALETTE[1];

/// A rectangle of a section and its place on the page.
struct View {
    /// Left, right, bottom, top in µm.
    window: [f64; 4],
    /// x, y of the upper left corner in px.
    at: [f64; 2],
    /// px per µm.
    scale: f64,
}

impl View {
    fn place(&self, x: f64, z: f64) -> [f64; 2] {
        [self.at[0] + (x - self.window[0]) * self.scale, self.at[1] + (self.window[3] - z) * self.scale]
    }

    /// A height past the clip's lower edge, so that no soft edge shows there.
    fn below(&self) -> f64 {
        self.window[2] - 3.0 / self.scale
    }

    fn area(&self) -> [f64; 4] {
        let [left, right, bottom, top] = self.window;
        [self.at[0], self.at[1], (right - left) * self.scale, (top - bottom) * self.scale]
    }
}

/// Draws a section; for a hummingbird with its parameters, also their sketch beside the section without its randomness.
#[must_use]
pub fn section(
    section: &Section,
    title: &str,
    sketch: Option<(&Hummingbird, &Section)>,
    page: &Page,
) -> Drawing {
    page.lay_out(FONT, |size| {
        let drawn = |width: f64, zoom: f64| {
            let sketch = sketch.map(|(parameters, regular)| hummingbird_sketch(parameters, regular, width));
            views(section, title, sketch, width, zoom)
        };
        let Some([width, height]) = size else { return drawn(PAGE, ZOOMS[0]) };
        // A smaller zoom, or less of the width, and so of the height, rather than much smaller words.
        let zooms = ZOOMS.into_iter().map(|zoom| (width.max(NARROWEST), zoom));
        let narrower = (1..=5).map(|tenths| (width * (1.0 - 0.1 * f64::from(tenths)), ZOOMS[2]));
        let size_of_words = |drawing: &Drawing| (height / drawing.height).min(width / drawing.width).min(1.0);
        let mut best = (0.0, Drawing::new(width, height));
        for (wide, zoom) in zooms.chain(narrower).filter(|(wide, _)| *wide >= NARROWEST) {
            let drawing = drawn(wide, zoom);
            let worth = size_of_words(&drawing) * (wide / width).sqrt();
            if worth > best.0 {
                best = (worth, drawing);
            }
        }
        best.1
    })
}

/// The whole section, a zoom that takes part of the width with its legend, and a sketch, on a page that is `width` px wide.
fn views(section: &Section, title: &str, sketch: Option<Drawing>, width: f64, zoom: f64) -> Drawing {
    let [left, right, low, high] = extent(section);
    let pad = 0.02 * (right - left);
    let wide = width - 2.0 * MARGIN;
    let window = [left - pad, right + pad, low - pad, high + pad];
    let scale = wide / (window[1] - window[0]);
    let window = whole_pixels(window, scale);
    let title = text::wrapped(title, HEADING, wide, 3);
    let top = 28.0 + 22.0 * title.len() as f64;
    let whole = View { window, at: [MARGIN, top], scale };
    let [x, y, _, tall] = whole.area();
    let zoom_window = zoom_window(section);
    let legend = legend(section, wide);
    // On a narrow page the legend has no room beside the zoom.
    let is_beside = legend.width + 30.0 <= (1.0 - zoom) * wide;
    let zoom_width = if is_beside { zoom * wide } else { wide };
    let zoom_scale = zoom_width / (zoom_window[1] - zoom_window[0]);
    let zoom_window = whole_pixels(zoom_window, zoom_scale);
    let zoom = View { window: zoom_window, at: [x, y + tall + 50.0], scale: zoom_scale };
    let [_, zoom_y, _, zoom_tall] = zoom.area();
    let legend_at = if is_beside { [x + zoom_width + 30.0, zoom_y] } else { [x, zoom_y + zoom_tall + 45.0] };
    let below =
        (zoom_y + zoom_tall + 55.0).max(legend_at[1] + legend.height + if is_beside { 55.0 } else { 10.0 });
    let mut page = Drawing::new(width, below + sketch.as_ref().map_or(0.0, |s| s.height + 10.0));
    for (line, text) in title.into_iter().enumerate() {
        page.text([MARGIN, 32.0 + 22.0 * line as f64], HEADING, Anchor::Start, text);
    }
    regions(&mut page, section, &whole);
    regions(&mut page, section, &zoom);
    // What shines through the soft edge of the view is covered.
    page.rectangle(whole.area(), None, Some(Stroke::solid(Ink::WHITE, 3.0)));
    let frame = Stroke::solid(Ink::of(FRAME), 1.5);
    let [a, b] = [whole.place(zoom_window[0], zoom_window[3]), whole.place(zoom_window[1], zoom_window[2])];
    page.rectangle([a[0], a[1], b[0] - a[0], b[1] - a[1]], None, Some(frame.clone()));
    page.rectangle(zoom.area(), None, Some(frame));
    scale_bar(&mut page, &whole);
    scale_bar(&mut page, &zoom);
    page.place(legend, legend_at);
    if let Some(sketch) = sketch {
        page.place(sketch, [MARGIN, below]);
    }
    page
}

/// A window whose height is a whole number of px, so that its lower edge is sharp.
fn whole_pixels([left, right, bottom, top]: [f64; 4], scale: f64) -> [f64; 4] {
    [left, right, top - ((top - bottom) * scale).ceil() / scale, top]
}

/// Left, right, bottom, top of everything, µm.
fn extent(section: &Section) -> [f64; 4] {
    let mut all = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
    let mut cover = |curve: &Polyline| {
        for (&x, &z) in curve.x_um.iter().zip(&curve.z_um) {
            all = [all[0].min(x), all[1].max(x), all[2].min(z), all[3].max(z)];
        }
    };
    section.boundaries.iter().for_each(&mut cover);
    section.inclusions.iter().for_each(|inclusion| cover(&inclusion.outline.corners()));
    let [left, right, mut low, high] = all;
    low -= shown_depth(section);
    // A flat interface alone still shows what is on both sides.
    let least = 0.04 * (right - left);
    if high - low < least { [left, right, low - least, high + least] } else { [left, right, low, high] }
}

/// How far below its top a section's crystal is shown, µm; 0 without one.
fn shown_depth(section: &Section) -> f64 {
    section.crystal.as_ref().map_or(0.0, |c| c.lattice.bottom_um() * (1.0 + BELOW_CRYSTAL))
}

/// A part near the middle that shows the layers under the top.
fn zoom_window(section: &Section) -> [f64; 4] {
    let [left, right, low, high] = extent(section);
    let most = if section.crystal.is_some() { CRYSTAL_ZOOM_UM } else { ZOOM_UM };
    let wide = (0.25 * (right - left)).min(most);
    let middle = 0.5 * (left + right);
    let [from, to] = [middle - 0.5 * wide, middle + 0.5 * wide];
    let top = section.top();
    let (mut upper, mut lower) = (high, low);
    if let Some(bottom) = section.boundaries.last() {
        let heights =
            |curve: &Polyline| (0..=50).map(|i| curve.height(from + wide * f64::from(i) / 50.0)).collect();
        let (tops, bottoms): (Vec<f64>, Vec<f64>) = (heights(top), heights(bottom));
        upper = tops.into_iter().fold(f64::NEG_INFINITY, f64::max);
        lower = bottoms.into_iter().fold(f64::INFINITY, f64::min) - shown_depth(section);
    }
    let pad = 0.03 * wide;
    let tall = (upper - lower + 2.0 * pad).clamp(0.2 * wide, 0.85 * wide);
    [from, to, upper + pad - tall, upper + pad]
}

/// Shade of a substance.
pub fn shade(substance: &Substance) -> [u8; 3] {
    match substance {
        Substance::Named(name) if name == "air" => [255, 255, 255],
        Substance::Named(name) if name == "keratin" => [205, 205, 205],
        Substance::Named(name) if name == "melanin" => [20, 20, 20],
        other => {
            // Any other medium has a colour of its own, the same in every figure.
            let hash = other.label().bytes().fold(7_usize, |h, b| h.wrapping_mul(31).wrapping_add(b.into()));
            let [r, g, b] = PALETTE[[0, 1, 2, 3, 5, 6][hash % 6]];
            let lighter = |c: u8| c / 2 + 100;
            [lighter(r), lighter(g), lighter(b)]
        }
    }
}

pub(super) fn blend(a: [u8; 3], b: [u8; 3], t: f64) -> [u8; 3] {
    let mix = |i: usize| (f64::from(a[i]) * (1.0 - t) + f64::from(b[i]) * t).round() as u8;
    [mix(0), mix(1), mix(2)]
}

fn shade_at(medium: &Medium, x: f64) -> [u8; 3] {
    match medium {
        Medium::Pure(substance) => shade(substance),
        Medium::Mixture { first, second, .. } => blend(shade(first), shade(second), medium.fraction(x)),
    }
}

/// Fills a view: each boundary paints what is below it, as far as the next one does not, over what was there; then come
/// the inclusions.
fn regions(page: &mut Drawing, section: &Section, view: &View) {
    let [left, right, bottom, top] = view.window;
    let mut items = Vec::new();
    fill(&mut items, &section.media[0], view, &[[left, top], [right, top]], view.below());
    for (index, (boundary, medium)) in section.boundaries.iter().zip(&section.media[1..]).enumerate() {
        let (from, to) = (boundary.x_um[0].max(left), boundary.x_um[boundary.x_um.len() - 1].min(right));
        // The last medium reaches over the soft edges of what it covers.
        let over = if index + 1 == section.boundaries.len() { 2.0 / view.scale } else { 0.0 };
        let (from, to) = (from - over, to + over);
        let highest = boundary.z_um.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        let ends = [from, to].map(|x| boundary.height(x));
        if from >= to || ends[0].max(ends[1]).max(highest) < view.below() {
            continue;
        }
        let mut run = vec![[from, boundary.height(from)]];
        for (&x, &z) in boundary.x_um.iter().zip(&boundary.z_um) {
            let last = run[run.len() - 1];
            let apart = (x - last[0]).abs().max((z - last[1]).abs()) * view.scale;
            if x > from && x < to && apart > DETAIL {
                run.push([x, z]);
            }
        }
        run.push([to, boundary.height(to)]);
        let next = section.boundaries.get(index + 1);
        fill(
            &mut items,
            medium,
            view,
            &run,
            next.map_or(view.below(), |next| painted_over(next, view, [from, to])),
        );
    }
    let mut loops: Vec<(usize, Item)> = Vec::new();
    for inclusion in &section.inclusions {
        let outline = inclusion.outline.corners();
        let inside = outline
            .x_um
            .iter()
            .zip(&outline.z_um)
            .any(|(x, z)| (left..=right).contains(x) && (bottom..=top).contains(z));
        let middle = 0.5 * (outline.x_um[0] + outline.x_um[outline.x_um.len() / 2]);
        if !inside && !(left..=right).contains(&middle) {
            continue;
        }
        let mut runs = vec![thinned(&outline, view)];
        runs.extend(inclusion.holes.iter().map(|hole| thinned(&hole.corners(), view)));
        let ink = Some(Ink::of(shade_at(&inclusion.medium, middle)));
        // What lies in another inclusion is painted after it: larger extents first.
        let wide = outline.x_um.iter().fold(f64::NEG_INFINITY, |a, &x| a.max(x))
            - outline.x_um.iter().fold(f64::INFINITY, |a, &x| a.min(x));
        let order = (1e9 / (1.0 + wide * 1e3)) as usize;
        loops.push((order, Item::Path { runs, closed: true, fill: ink, stroke: None }));
    }
    loops.sort_by_key(|(order, _)| *order);
    items.extend(loops.into_iter().map(|(_, item)| item));
    items.extend(section.crystal.iter().flat_map(|crystal| rods(crystal, section.top(), view)));
    page.items.push(Item::Clip { area: view.area(), items });
}

/// The height below which the boundary that comes next paints over everything between `from` and `to`.
fn painted_over(next: &Polyline, view: &View, [from, to]: [f64; 2]) -> f64 {
    let last = next.x_um.len() - 1;
    if next.x_um[0] > from.max(view.window[0]) || next.x_um[last] < to.min(view.window[1]) {
        return view.below();
    }
    // Past its soft edge.
    let lowest = next.z_um.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - 3.0 / view.scale;
    lowest.max(view.below())
}

/// The rods of a crystal that a view shows.
fn rods(crystal: &CrystalLayer, top: &Polyline, view: &View) -> Vec<Item> {
    let [left, right, bottom, high] = view.window;
    crystal
        .circles(top)
        .into_iter()
        .filter(|c| {
            let (x, z, r) = (c.x_um, c.z_um, c.radius_um);
            x + r > left && x - r < right && z + r > bottom && z - r < high
        })
        .filter_map(|c| {
            let outline = Loop::Circle { x_um: c.x_um, z_um: c.z_um, radius_um: c.radius_um };
            let ink = Ink::of(shade(&crystal.lattice.rods[c.rod].circles[c.circle].medium));
            let run = thinned(&outline.corners(), view);
            // Too small to be seen.
            let shows = run.len() > 2;
            shows.then(|| Item::Path { runs: vec![run], closed: true, fill: Some(ink), stroke: None })
        })
        .collect()
}

fn thinned(corners: &Polyline, view: &View) -> Vec<[f64; 2]> {
    let mut run: Vec<[f64; 2]> = Vec::new();
    for (&x, &z) in corners.x_um.iter().zip(&corners.z_um) {
        let at = view.place(x, z);
        let near = |last: &[f64; 2]| (last[0] - at[0]).abs().max((last[1] - at[1]).abs()) < DETAIL;
        if !run.last().is_some_and(near) {
            run.push(at);
        }
    }
    run
}

/// Paints everything below a curve down to a height, in strips where the medium varies.
fn fill(items: &mut Vec<Item>, medium: &Medium, view: &View, curve: &[[f64; 2]], bottom: f64) {
    let mut paint = |run: &[[f64; 2]], ink: [u8; 3]| {
        let mut path: Vec<[f64; 2]> = run.iter().map(|p| view.place(p[0], p[1])).collect();
        let (first, last) = (run[0][0], run[run.len() - 1][0]);
        path.extend([view.place(last, bottom), view.place(first, bottom)]);
        items.push(Item::Path { runs: vec![path], closed: true, fill: Some(Ink::of(ink)), stroke: None });
    };
    let Medium::Mixture { .. } = medium else {
        paint(curve, shade_at(medium, 0.0));
        return;
    };
    let line =
        Polyline { x_um: curve.iter().map(|p| p[0]).collect(), z_um: curve.iter().map(|p| p[1]).collect() };
    let (from, to) = (curve[0][0], curve[curve.len() - 1][0]);
    let step = STRIP / view.scale;
    let count = ((to - from) / step).ceil().max(1.0) as usize;
    let at = |strip: usize| from + (to - from) * strip as f64 / count as f64;
    let shade = |strip: usize| shade_at(medium, at(strip) + 0.5 * step);
    let (mut strip, mut next) = (0, 0);
    while strip < count {
        let (start, ink) = (at(strip), shade(strip));
        // Strips of one shade are painted together.
        strip = (strip + 1..count).find(|&other| shade(other) != ink).unwrap_or(count);
        // They reach under the next one, so that no seam shows.
        let end = (at(strip) + 0.6 * (to - from) / count as f64).min(to);
        while next < curve.len() && curve[next][0] <= start {
            next += 1;
        }
        let mut run = vec![[start, line.height(start)]];
        run.extend(curve[next..].iter().take_while(|p| p[0] < end));
        run.push([end, line.height(end)]);
        paint(&run, ink);
    }
}

/// A bar of a round length under a view.
fn scale_bar(page: &mut Drawing, view: &View) {
    scale_bar_of(page, view.area(), view.scale);
}

/// A bar of a round length under an area of so many px per µm.
pub(crate) fn scale_bar_of(page: &mut Drawing, [x, y, wide, tall]: [f64; 4], scale: f64) {
    let about = 0.2 * wide / scale;
    let power = 10_f64.powf(about.log10().floor());
    let length = [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|&m| m <= about).unwrap_or(power);
    let (right, base) = (x + wide, y + tall + 10.0);
    page.line([right - length * scale, base], [right, base], Stroke::solid(Ink::BLACK, 4.0));
    let label = if length < 0.1 { format!("{:.0} nm", length * 1e3) } else { format!("{length} µm") };
    page.text([right, base + 19.0], FONT, Anchor::End, label);
}

/// One swatch for each medium, no wider than `most`.
pub(super) fn legend(section: &Section, most: f64) -> Drawing {
    let mut entries: Vec<(String, [u8; 3], [u8; 3])> = Vec::new();
    let of_rods: Vec<Medium> = section
        .crystal
        .iter()
        .flat_map(|crystal| crystal.lattice.rods.iter().flat_map(|rod| &rod.circles))
        .map(|circle| Medium::Pure(circle.medium.clone()))
        .collect();
    for medium in section.all_media().chain(&of_rods) {
        let entry = match medium {
            Medium::Pure(substance) => (substance.label(), shade(substance), shade(substance)),
            Medium::Mixture { first, second, fraction, .. } => {
                let low = fraction.iter().copied().fold(1.0, f64::min);
                let high = fraction.iter().copied().fold(0.0, f64::max);
                let (a, b) = (shade(first), shade(second));
                let percent = format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high);
                let label = format!("{} with {percent} {}", first.label(), second.label());
                (label, blend(a, b, low), blend(a, b, high))
            }
        };
        if !entries.contains(&entry) && entries.len() < 12 {
            entries.push(entry);
        }
    }
    for entry in &mut entries {
        entry.0 = text::cut(&entry.0, FONT, most - 50.0);
    }
    let widest = entries.iter().map(|(label, ..)| text::width(label, FONT)).fold(0.0, f64::max);
    let mut drawing = Drawing::new(50.0 + widest, 30.0 * entries.len() as f64);
    for (i, (label, low, high)) in entries.into_iter().enumerate() {
        let y = 30.0 * i as f64;
        let steps = if low == high { 1 } else { 13 };
        let wide = 39.5 / f64::from(steps);
        for step in 0..steps {
            let ink = Ink::of(blend(low, high, f64::from(step) / f64::from(steps.max(2) - 1)));
            // Under the next one, so that no seam shows.
            let [from, to] = [wide * f64::from(step), (wide * f64::from(step) + 1.2 * wide).min(39.5)];
            drawing.rectangle([from, y, to - from, 20.0], Some(ink), None);
        }
        drawing.rectangle([0.0, y, 39.5, 20.0], None, Some(Stroke::solid(Ink::of([120, 120, 120]), 1.0)));
        drawing.text([50.0, y + 15.0], FONT, Anchor::Start, label);
    }
    drawing
}

/// The parameters of a hummingbird beside its first three layers without their randomness, as in the supplement's figure 8.
fn hummingbird_sketch(parameters: &Hummingbird, regular: &Section, page: f64) -> Drawing {
    let p = parameters;
    let nm = |um: f64| format!("{:.0} nm", um * 1e3);
    let second = p.air_second_share * p.air_first_um + (1.0 - p.air_second_share) * p.air_um;
    let airs = [p.air_first_um, second, p.air_um];
    let gaps = [p.gap_um * p.gap_first, p.gap_um * p.gap_second];
    let layers = p.layers.min(3);
    let mut depth = p.cortex_um;
    let mut marks: Vec<(f64, f64, String)> = vec![(0.0, p.cortex_um, format!("cortex {}", nm(p.cortex_um)))];
    for layer in 0..layers {
        let air = airs[layer];
        marks.push((depth, depth + p.wall_um, format!("melanin wall {}", nm(p.wall_um))));
        marks.push((depth + p.wall_um, depth + p.wall_um + air, format!("air {}", nm(air))));
        depth += air + 2.0 * p.wall_um;
        if layer + 1 < layers {
            marks.push((depth, depth + gaps[layer], format!("keratin gap {}", nm(gaps[layer]))));
            depth += gaps[layer];
        }
    }
    let tall = depth + p.cortex_um;
    let long = (p.melanosome_length_um * 1.25).min(4.0 * tall);
    let room = page - 2.0 * MARGIN;
    // The names of the parameters take the rest.
    let scale = ((room - 230.0).clamp(0.3 * room, 480.0) / long).min(360.0 / tall);
    let pad = 0.04 * tall;
    // The first melanosome starts near the left end.
    let left = first_x(regular) - 0.06 * long;
    let window = [left, left + long, -tall - pad, pad];
    let view = View { window, at: [0.0, 30.0], scale };
    let [_, y, wide, high] = view.area();
    let mut drawing = Drawing::new(room, 0.0);
    drawing.text([0.0, 18.0], 16.0, Anchor::Start, "Generator parameters, mean values");
    regions(&mut drawing, regular, &view);
    drawing.rectangle(view.area(), None, Some(Stroke::solid(Ink::of([120, 120, 120]), 1.0)));
    let step = (high / (marks.len() as f64 - 1.0).max(1.0)).max(20.0);
    for (i, (from, to, label)) in marks.iter().enumerate() {
        let middle = view.place(left, -0.5 * (from + to))[1];
        let [a, b] = [view.place(left, -from)[1], view.place(left, -to)[1]];
        let text_y = y + step * i as f64;
        let ink = Stroke::solid(Ink::of(FRAME), 1.2);
        drawing.line([wide + 6.0, a], [wide + 6.0, b], Stroke::solid(Ink::of(FRAME), 4.0));
        drawing.line([wide + 8.0, middle], [wide + 40.0, text_y], ink);
        drawing.text([wide + 46.0, text_y + 5.0], FONT, Anchor::Start, label.clone());
    }
    let notes = [
        format!(
            "{} layers; melanosomes {} µm long on average, covering {:.0} % (first layer {:.0} %) of the length",
            p.layers,
            p.melanosome_length_um,
            100.0 * p.coverage,
            100.0 * p.coverage_first
        ),
        format!(
            "bubbles on average {:.2} times as long as the air is thick, membranes {}",
            p.bubble_aspect,
            nm(p.membrane_um)
        ),
    ];
    let lines: Vec<String> = notes.iter().flat_map(|note| text::wrapped(note, FONT, room, 4)).collect();
    let named = y + step * marks.len().saturating_sub(1) as f64;
    let under = (y + high + 52.0).max(named + 28.0);
    drawing.height = under + 3.0 + 20.0 * lines.len() as f64;
    for (i, line) in lines.into_iter().enumerate() {
        drawing.text([0.0, under + 20.0 * i as f64], FONT, Anchor::Start, line);
    }
    scale_bar(&mut drawing, &view);
    drawing
}

/// Leftmost x of the second layer's first melanosome.
fn first_x(section: &Section) -> f64 {
    section.inclusions.iter().flat_map(|i| i.outline.corners().x_um).fold(f64::INFINITY, f64::min)
}
