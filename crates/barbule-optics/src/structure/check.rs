//! What a section must satisfy, each refusal with its field, index and remedy.

use super::section::{
    Inclusion, LARGEST_COORDINATE_UM, Loop, MOST_POINTS, Medium, Parts, Polyline, Section, material, refuse,
};
use super::sweep;
use crate::material::Library;
use crate::{Error, Result};

/// Boundaries may overlap by this much (rounding of interpolated heights), µm.
const ROUNDING_UM: f64 = 1e-11;

/// Which loop lies directly in which.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Nesting {
    pub(super) loops: Vec<Nested>,
}

/// One closed loop of a section.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nested {
    pub(super) inclusion: usize,
    pub(super) hole: Option<usize>,
    /// The innermost other loop that holds it.
    pub(super) parent: Option<usize>,
    /// How many loops hold it.
    pub(super) depth: u32,
    /// The inclusion whose medium shows directly inside; `None`: that of the layers.
    pub(super) shows: Option<usize>,
}

impl Nested {
    pub(super) fn shape<'a>(&self, inclusions: &'a [Inclusion]) -> &'a Loop {
        let inclusion = &inclusions[self.inclusion];
        self.hole.map_or(&inclusion.outline, |hole| &inclusion.holes[hole])
    }

    /// Its place in the section's file.
    fn name(&self) -> String {
        let inclusion = self.inclusion;
        self.hole.map_or_else(
            || format!("inclusions[{inclusion}]"),
            |hole| format!("inclusions[{inclusion}].holes[{hole}]"),
        )
    }
}

impl Nesting {
    /// The inclusion whose medium a point sees, if not the layers'.
    pub(super) fn innermost(&self, section: &Section, x: f64, z: f64) -> Option<usize> {
        let holds = |nested: &&Nested| contains(nested.shape(&section.inclusions), x, z);
        self.loops.iter().filter(holds).max_by_key(|nested| nested.depth).and_then(|nested| nested.shows)
    }
}

/// Whether a loop holds a point (even-odd rule).
fn contains(shape: &Loop, x: f64, z: f64) -> bool {
    let corners = match shape {
        Loop::Circle { x_um, z_um, radius_um } => return libm::hypot(x - x_um, z - z_um) < *radius_um,
        Loop::Polygon(corners) => corners,
    };
    let (xs, zs) = (&corners.x_um, &corners.z_um);
    let mut inside = false;
    let mut before = xs.len() - 1;
    for i in 0..xs.len() {
        let (x0, z0, x1, z1) = (xs[before], zs[before], xs[i], zs[i]);
        if (x0 > x) != (x1 > x) && z < z0 + (z1 - z0) * ((x - x0) / (x1 - x0)) {
            inside = !inside;
        }
        before = i;
    }
    inside
}

/// Checks everything.
pub(super) fn check(parts: &Parts, library: &Library) -> Result<Nesting> {
    check_size(parts)?;
    check_media(parts, library)?;
    for (index, boundary) in parts.boundaries.iter().enumerate() {
        check_boundary(&format!("boundaries[{index}]"), boundary)?;
    }
    check_width(parts)?;
    for (index, pair) in parts.boundaries.windows(2).enumerate() {
        check_order(index, &pair[0], &pair[1], &parts.boundaries[0])?;
    }
    for (index, inclusion) in parts.inclusions.iter().enumerate() {
        check_loop(&format!("inclusions[{index}]"), &inclusion.outline, parts)?;
        for (hole, shape) in inclusion.holes.iter().enumerate() {
            check_loop(&format!("inclusions[{index}].holes[{hole}]"), shape, parts)?;
        }
    }
    nest(parts)
}

/// The width of the inclusions' bounding box; 0 without inclusions.
pub(super) fn bounding_width(inclusions: &[Inclusion]) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for inclusion in inclusions {
        let (from, to) = extent(&inclusion.outline);
        (low, high) = (low.min(from), high.max(to));
    }
    (high - low).max(0.0)
}

fn extent(shape: &Loop) -> (f64, f64) {
    match shape {
        Loop::Circle { x_um, radius_um, .. } => (x_um - radius_um, x_um + radius_um),
        Loop::Polygon(corners) => corners
            .x_um
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x))),
    }
}

fn check_size(parts: &Parts) -> Result<()> {
    if parts.boundaries.is_empty() && parts.inclusions.is_empty() {
        return refuse(
            "boundaries and inclusions are both missing or empty; give at least a top boundary".into(),
        );
    }
    let of_media = |medium: &Medium| if let Medium::Mixture { x_um, .. } = medium { x_um.len() } else { 0 };
    let of_inclusion = |inclusion: &Inclusion| {
        inclusion.outline.points()
            + inclusion.holes.iter().map(Loop::points).sum::<usize>()
            + of_media(&inclusion.medium)
    };
    let points = parts.boundaries.iter().map(|b| b.x_um.len()).sum::<usize>()
        + parts.media.iter().map(of_media).sum::<usize>()
        + parts.inclusions.iter().map(of_inclusion).sum::<usize>();
    if points > MOST_POINTS {
        return refuse(format!(
            "the section has {points} points, over the limit of 1000000 (a circle counts 64); sample its curves more coarsely"
        ));
    }
    Ok(())
}

fn check_media(parts: &Parts, library: &Library) -> Result<()> {
    let (boundaries, media) = (parts.boundaries.len(), parts.media.len());
    if media != boundaries + 1 {
        return refuse(format!(
            "media has {media} entries for {boundaries} boundaries, but there must be one more medium than boundaries; \
             list what is above the top, between the boundaries and below the last, {} in all",
            boundaries + 1
        ));
    }
    for (index, medium) in parts.media.iter().enumerate() {
        check_medium(&format!("media[{index}]"), medium, library)?;
    }
    for (index, inclusion) in parts.inclusions.iter().enumerate() {
        check_medium(&format!("inclusions[{index}].medium"), &inclusion.medium, library)?;
    }
    Ok(())
}

fn check_medium(place: &str, medium: &Medium, library: &Library) -> Result<()> {
    for substance in medium.substances() {
        material(substance, library).map_err(|error| error.at(place))?;
    }
    let Medium::Mixture { x_um, fraction, .. } = medium else { return Ok(()) };
    if x_um.len() != fraction.len() {
        return refuse(format!(
            "{place}: x has {} values and fraction {}; give one fraction for each x",
            x_um.len(),
            fraction.len()
        ));
    }
    if x_um.is_empty() {
        return refuse(format!("{place}: x and fraction are empty; give at least one of each"));
    }
    check_increasing(&format!("{place}.x"), x_um)?;
    match fraction.iter().position(|f| !(0.0..=1.0).contains(f)) {
        Some(at) => refuse(format!(
            "{place}.fraction[{at}] is {}, outside 0 to 1; it is the part of the volume that is the second medium",
            fraction[at]
        )),
        None => Ok(()),
    }
}

/// Finite, within the largest coordinate, increasing strictly.
fn check_increasing(place: &str, xs: &[f64]) -> Result<()> {
    check_coordinates(place, xs)?;
    match xs.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(at) => refuse(format!(
            "{place}[{}] is {} after {}, but x must increase; sort the points by x and leave out repeated ones",
            at + 1,
            xs[at + 1],
            xs[at]
        )),
        None => Ok(()),
    }
}

fn check_coordinates(place: &str, values: &[f64]) -> Result<()> {
    for (index, value) in values.iter().enumerate() {
        if !value.is_finite() {
            return refuse(format!("{place}[{index}] is not a finite number; give a length in µm"));
        }
        if value.abs() > LARGEST_COORDINATE_UM {
            return refuse(format!(
                "{place}[{index}] is {value} µm, outside -1000 to 1000 µm; coordinates are in µm, not nm"
            ));
        }
    }
    Ok(())
}

fn check_boundary(place: &str, boundary: &Polyline) -> Result<()> {
    check_points(place, boundary)?;
    check_increasing(&format!("{place}.x"), &boundary.x_um)?;
    check_coordinates(&format!("{place}.z"), &boundary.z_um)
}

fn check_points(place: &str, curve: &Polyline) -> Result<()> {
    let (xs, zs) = (curve.x_um.len(), curve.z_um.len());
    if xs != zs {
        return refuse(format!("{place}: x has {xs} values and z {zs}; give one z for each x"));
    }
    if xs < 3 {
        return refuse(format!(
            "{place} has {xs} points, fewer than 3; add points (a straight line may hold any number)"
        ));
    }
    Ok(())
}

fn check_width(parts: &Parts) -> Result<()> {
    let Some(width) = parts.width_um else {
        return if parts.boundaries.is_empty() {
            Ok(())
        } else {
            refuse("width is missing; give the barbule's width in µm".into())
        };
    };
    if !(width.is_finite() && width > 0.0 && width <= 2.0 * LARGEST_COORDINATE_UM) {
        return refuse(format!("width is {width} µm, but must be above 0 and at most 2000 µm"));
    }
    let Some(top) = parts.boundaries.first() else { return Ok(()) };
    let span = top.x_um[top.x_um.len() - 1] - top.x_um[0];
    if (span - width).abs() > 0.01 * width {
        return refuse(format!(
            "width is {width} µm but boundaries[0] spans {span} µm in x; make the two equal within 1 %"
        ));
    }
    Ok(())
}

/// The lower of two boundaries is nowhere above the upper one over the extent of the top.
fn check_order(index: usize, upper: &Polyline, lower: &Polyline, top: &Polyline) -> Result<()> {
    let (from, to) = (top.x_um[0], top.x_um[top.x_um.len() - 1]);
    let (mut upper_walk, mut lower_walk) = (Walk::new(upper), Walk::new(lower));
    // The points of both curves in order, without a list of them.
    let mut x0 = from;
    let mut before = upper_walk.height(from) - lower_walk.height(from);
    let mut x = from;
    let gap = loop {
        let gap = upper_walk.height(x) - lower_walk.height(x);
        if gap < -ROUNDING_UM {
            break gap;
        }
        if x >= to {
            return Ok(());
        }
        (x0, before) = (x, gap);
        x = upper_walk.next_point().min(lower_walk.next_point()).min(to);
    };
    let (above, below) = (format!("boundaries[{index}]"), format!("boundaries[{}]", index + 1));
    let hint = |usual: &str| heights_in_nm(index, [upper, lower], to - from).unwrap_or(format!("; {usual}"));
    if x == from {
        return refuse(format!(
            "{below} lies above {above} at x = {x:.4} µm{}",
            hint("list the boundaries from the top down")
        ));
    }
    let x = x0 + (x - x0) * (before / (before - gap));
    refuse(format!(
        "{below} crosses {above} at x = {x:.4}, z = {:.4} µm{}",
        upper.height(x),
        hint("keep every boundary below the one before it")
    ))
}

/// `; boundaries[1].z is -200 µm …; did you mean -0.2 (-200 nm)?` where one of two boundaries that follow each other is
/// farther from the top than any barbule of this width (µm) is thick.
fn heights_in_nm(index: usize, pair: [&Polyline; 2], width: f64) -> Option<String> {
    /// Barbules are not thicker than wide, and films of under so many nm are not seen.
    const LEAST_NM: f64 = 20.0;
    let (at, z) = pair
        .iter()
        .enumerate()
        .flat_map(|(i, curve)| curve.z_um.iter().map(move |&z| (index + i, z)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (z.abs() > width.max(LEAST_NM)).then(|| {
        format!(
            "; boundaries[{at}] has z = {z} µm on a barbule of {width} µm; did you mean {} ({z} nm)?",
            z / 1000.0
        )
    })
}

/// Heights of a curve at increasing x.
struct Walk<'a> {
    curve: &'a Polyline,
    segment: usize,
}

impl<'a> Walk<'a> {
    fn new(curve: &'a Polyline) -> Self {
        Self { curve, segment: 0 }
    }

    fn height(&mut self, x: f64) -> f64 {
        let (xs, zs) = (&self.curve.x_um, &self.curve.z_um);
        while self.segment + 2 < xs.len() && xs[self.segment + 1] <= x {
            self.segment += 1;
        }
        let i = self.segment;
        zs[i] + (zs[i + 1] - zs[i]) * ((x - xs[i]) / (xs[i + 1] - xs[i]))
    }

    /// The next point after the last height asked for, or ∞.
    fn next_point(&self) -> f64 {
        let xs = &self.curve.x_um;
        // Before the first point, which the end segment's line reaches, it comes next.
        xs[self.segment + 1..]
            .first()
            .copied()
            .filter(|_| self.segment + 2 < xs.len())
            .unwrap_or(f64::INFINITY)
    }
}

fn check_loop(place: &str, shape: &Loop, parts: &Parts) -> Result<()> {
    match shape {
        Loop::Circle { x_um, z_um, radius_um } => {
            check_coordinates(&format!("{place}.circle (x, z)"), &[*x_um, *z_um])?;
            if !(radius_um.is_finite() && *radius_um >= 1e-6 && *radius_um <= LARGEST_COORDINATE_UM) {
                return refuse(format!(
                    "{place}.circle.radius is {radius_um} µm, but must be from 0.000001 to 1000 µm"
                ));
            }
        }
        Loop::Polygon(corners) => {
            check_points(place, corners)?;
            check_coordinates(&format!("{place}.x"), &corners.x_um)?;
            check_coordinates(&format!("{place}.z"), &corners.z_um)?;
        }
    }
    let Some(top) = parts.boundaries.first() else { return Ok(()) };
    let (from, to) = extent(shape);
    let (left, right) = (top.x_um[0], top.x_um[top.x_um.len() - 1]);
    if from < left || to > right {
        let beyond = if from < left { from } else { to };
        return refuse(format!(
            "{place} reaches x = {beyond:.4} µm, past the end of the top boundary ({left} to {right} µm); cut or move it"
        ));
    }
    Ok(())
}

/// Finds crossings, touches and containment with exact predicates.
fn nest(parts: &Parts) -> Result<Nesting> {
    let mut loops = Vec::new();
    let mut outlines = Vec::new();
    for (inclusion, region) in parts.inclusions.iter().enumerate() {
        outlines.push(loops.len());
        loops.push(Nested { inclusion, hole: None, parent: None, depth: 0, shows: Some(inclusion) });
        loops.extend((0..region.holes.len()).map(|hole| Nested {
            inclusion,
            hole: Some(hole),
            parent: None,
            depth: 0,
            shows: None,
        }));
    }
    if loops.is_empty() {
        return Ok(Nesting::default());
    }
    let shapes: Vec<Polyline> =
        loops.iter().map(|nested| nested.shape(&parts.inclusions).corners()).collect();
    let parents = sweep::nesting(&parts.boundaries, &shapes)
        .map_err(|conflict| Error::input(conflict_in_words(&loops, &conflict)))?;
    for (index, nested) in loops.iter().enumerate() {
        if nested.hole.is_some() && parents[index] != Some(outlines[nested.inclusion]) {
            return refuse(format!(
                "{} does not lie directly inside its inclusion; move it there, or make it an inclusion of its own",
                nested.name()
            ));
        }
    }
    // A chain of parents has no circle, so the medium about each hole follows by walking outwards.
    let around = |outline: usize| -> Option<usize> {
        let mut at = parents[outline];
        while let Some(index) = at {
            match loops[index].hole {
                None => return Some(loops[index].inclusion),
                Some(_) => at = parents[outlines[loops[index].inclusion]],
            }
        }
        None
    };
    let shows: Vec<Option<usize>> = loops
        .iter()
        .map(|nested| if nested.hole.is_some() { around(outlines[nested.inclusion]) } else { nested.shows })
        .collect();
    let depth = depths(&parents);
    for (index, nested) in loops.iter_mut().enumerate() {
        nested.parent = parents[index];
        nested.depth = depth[index];
        nested.shows = shows[index];
    }
    Ok(Nesting { loops })
}

/// How many loops each lies in, from the one around each.
fn depths(parents: &[Option<usize>]) -> Vec<u32> {
    let mut depth = vec![u32::MAX; parents.len()];
    for start in 0..parents.len() {
        let mut chain = Vec::new();
        let mut at = Some(start);
        while let Some(index) = at.filter(|&i| depth[i] == u32::MAX) {
            chain.push(index);
            at = parents[index];
        }
        let outer = at.map_or(0, |i| depth[i] + 1);
        for (deeper, index) in (outer..).zip(chain.into_iter().rev()) {
            depth[index] = deeper;
        }
    }
    depth
}

/// What is wrong where two outlines meet.
fn conflict_in_words(loops: &[Nested], conflict: &sweep::Conflict) -> String {
    let (x, z) = (conflict.x_um, conflict.z_um);
    match (conflict.a, conflict.b) {
        (sweep::Owner::Loop(a), sweep::Owner::Loop(b)) if a == b => format!(
            "{} crosses or touches itself at x = {x:.4}, z = {z:.4} µm; give a simple outline",
            loops[a].name()
        ),
        (sweep::Owner::Loop(a), sweep::Owner::Loop(b)) => format!(
            "{} and {} cross or touch at x = {x:.4}, z = {z:.4} µm; move them apart or nest one in the other",
            loops[a.min(b)].name(),
            loops[a.max(b)].name()
        ),
        (sweep::Owner::Loop(a), sweep::Owner::Boundary(b))
        | (sweep::Owner::Boundary(b), sweep::Owner::Loop(a)) => format!(
            "{} crosses or touches boundaries[{b}] at x = {x:.4}, z = {z:.4} µm; an inclusion must lie between two boundaries",
            loops[a].name()
        ),
        (sweep::Owner::Boundary(a), sweep::Owner::Boundary(b)) => {
            format!("boundaries[{a}] and boundaries[{b}] cross at x = {x:.4}, z = {z:.4} µm")
        }
    }
}
