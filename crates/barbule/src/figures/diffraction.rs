//! What a heightfield does with light: its heights, its pattern over the hemisphere, its colours against the angle, and its
//! tables beside the reference.

use glam::DVec2;
use rayon::prelude::*;

use crate::DVec3;
use crate::diffraction::{Reference, TableErrors, direction, in_plane, over, table_errors};
use crate::plot::{Axis, Band, Curve, Drawing, Figure, HeatMap, MeasuredBand, Page, spectra};
use crate::progress::Progress;
use crate::scattering::grating::Tables;
use crate::spectrum::Spectrum;
use crate::spectrum::colour::{display, into_gamut, rgb_from_xyz};
use crate::structure::Heightfield;

/// Of a patch at most so much is drawn, µm.
const SHOWN_UM: f64 = 20.0;
/// And of a grating without change along y.
const SHOWN_LINE_UM: f64 = 10.0;
/// Heights along either axis of the map.
const MOST_CELLS: usize = 480;
/// Places along the diameter of the hemisphere.
const PLACES: usize = 240;
/// Directions in the plane of incidence.
const ANGLES: usize = 360;
/// Polar angles of incidence of the strips of colours, degrees.
const INCIDENCES: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];
/// Places along the diameter of the hemisphere over which tables are judged.
const JUDGED: usize = 41;
/// How many directions the reference is asked for, of which a disc holds 0.785 of the square about it: what the picture takes its time for.
pub const DIRECTIONS: usize =
    (PLACES * PLACES + JUDGED * JUDGED) * 785 / 1000 + (INCIDENCES.len() + 2) * ANGLES;
/// This part of the hemisphere's places is drawn as white or brighter than a screen: the mirror's direction and what is about it.
const BRIGHTEST: f64 = 0.01;
/// Width and height of each plane, px.
const SIZE: [f64; 2] = [330.0, 330.0];

/// All that is drawn of a patch.
pub struct Pattern<'a> {
    /// The heights.
    pub field: &'a Heightfield,
    /// The reference.
    pub reference: &'a Reference,
    /// The tables.
    pub tables: &'a Tables,
    /// Where light comes from in the pattern and in the comparison of tables.
    pub w_i: DVec3,
}

/// Draws a patch: four parts under a heading. Also how far the tables are from the reference over the hemisphere.
#[must_use]
pub fn diffraction(
    title: &str,
    pattern: &Pattern<'_>,
    page: &Page,
    progress: &dyn Progress,
) -> (Drawing, TableErrors) {
    progress.begin("pattern", PLACES as u64);
    let errors = table_errors(pattern.reference, pattern.tables, pattern.w_i, JUDGED);
    let parts =
        [heights(pattern.field), hemisphere(pattern, progress), strips(pattern), curves(pattern, &errors)];
    let widths = [0, 1].map(|column| parts[column].width.max(parts[column + 2].width));
    let rows = [0, 2].map(|row| parts[row].height.max(parts[row + 1].height));
    let mut drawing = Drawing::new(widths[0] + widths[1], rows[0] + rows[1]);
    for (i, part) in parts.into_iter().enumerate() {
        drawing.place(part, [widths[0] * (i % 2) as f64, rows[0] * (i / 2) as f64]);
    }
    (page.place(drawing.under(title)), errors)
}

/// f against the wavelength, with what was measured.
#[must_use]
pub fn diffraction_spectrum(
    title: &str,
    found: &Spectrum,
    quantity: &str,
    measured: Option<&MeasuredBand>,
    page: &Page,
) -> Drawing {
    let band = Band { name: "simulated".into(), mean: found.clone(), std: None, peak: None };
    let mut figure = spectra(title, &[band], measured.map_or(&[], std::slice::from_ref));
    figure.y.label = quantity.into();
    if measured.is_none() {
        figure.legend = String::new();
    }
    // Of directional values, whose scale is arbitrary, swatches at their true luminance say nothing.
    figure.curves.iter_mut().for_each(|curve| curve.swatches.truncate(0));
    figure.footnote = None;
    figure.draw_on(page)
}

/// A map of the heights, or their curve where nothing changes along y.
fn heights(field: &Heightfield) -> Drawing {
    let ([columns, rows], [dx, dy]) = (field.cells(), field.pitch_um());
    if rows == 1 {
        let shown = ((SHOWN_LINE_UM / dx).round() as usize).clamp(2, columns.max(2)).min(columns);
        let points = field.height_um()[..shown].iter().enumerate();
        let points = points.map(|(i, height)| [(i as f64 + 0.5) * dx, 1e3 * height]).collect();
        let mut figure = Figure::new("heights", Axis::new("x (µm)"), Axis::new("height (nm)"));
        figure.curves.push(Curve::line("", points));
        figure.size = SIZE;
        return figure.draw();
    }
    let extent = field.size_um().map(|side| side.min(SHOWN_UM));
    let cells = [0, 1].map(|axis| {
        let pitch = [dx, dy][axis];
        ((extent[axis] / pitch).round() as usize).clamp(1, MOST_CELLS.min([columns, rows][axis]))
    });
    let values = (0..cells[0] * cells[1]).map(|place| {
        let at = |axis: usize, i: usize| {
            let um = (i as f64 + 0.5) / cells[axis] as f64 * extent[axis];
            ((um / [dx, dy][axis]) as usize).min([columns, rows][axis] - 1)
        };
        let (i, j) = (at(0, place % cells[0]), at(1, place / cells[0]));
        1e3 * field.height_um()[j * columns + i]
    });
    let x = Axis::with_range("x (µm)", 0.0, extent[0]);
    let y = Axis::with_range("y (µm)", 0.0, extent[1]);
    let mut map = HeatMap::new("heights", x, y, cells[0], values.collect());
    map.label = "height (nm)".into();
    map.size = [SIZE[0], SIZE[0] * extent[1] / extent[0]];
    map.keeps_shape = true;
    map.draw()
}

/// A colour at an exposure as a screen shows it: inside its gamut, and where it is too bright with its hue.
fn shown(xyz: [f64; 3], exposure: f64) -> [u8; 3] {
    let rgb = into_gamut(rgb_from_xyz(xyz).map(|v| v * exposure));
    let most = rgb.into_iter().fold(1.0, f64::max);
    display(rgb.map(|v| v / most))
}

/// The exposure at which all but the brightest have luminances below 1.
fn exposure(colours: impl Iterator<Item = [f64; 3]>) -> f64 {
    let mut luminances: Vec<f64> = colours.map(|xyz| xyz[1]).filter(|y| *y > 0.0).collect();
    luminances.sort_by(f64::total_cmp);
    let last = luminances.len().saturating_sub(1);
    luminances.get(((1.0 - BRIGHTEST) * last as f64) as usize).map_or(1.0, |y| 1.0 / y)
}

/// The hemisphere seen from above, in colour.
fn hemisphere(pattern: &Pattern<'_>, progress: &dyn Progress) -> Drawing {
    let at = |i: usize| (2.0 * i as f64 + 1.0) / PLACES as f64 - 1.0;
    let colour = |column: usize, row: usize| {
        let w_o = over(DVec2::new(at(column), at(row)))?;
        // As a wall shows it: the light that is sent into a solid angle.
        Some(pattern.reference.xyz(pattern.w_i, w_o).map(|v| v * w_o.z))
    };
    let rows: Vec<Vec<Option<[f64; 3]>>> = (0..PLACES)
        .into_par_iter()
        .map(|row| {
            let colours = (0..PLACES).map(|column| colour(column, row)).collect();
            progress.advance(1);
            colours
        })
        .collect();
    let colours = rows.concat();
    let exposure = exposure(colours.iter().flatten().copied());
    let bytes = colours.iter().map(|xyz| xyz.map_or([255; 3], |xyz| shown(xyz, exposure))).collect();
    let polar = libm::acos(pattern.w_i.z).to_degrees();
    let title = format!("light sent up, θ_i = {}°, in direction cosines", (10.0 * polar).round() / 10.0);
    let axis = |label: &str| Axis::with_range(label, -1.0, 1.0);
    let mut map = HeatMap::of_colours(title, axis("x of ω_o"), axis("y of ω_o"), PLACES, bytes);
    map.size = SIZE;
    map.keeps_shape = true;
    map.draw()
}

/// Colours in the plane of incidence for several angles of incidence, each strip at an exposure of its own.
fn strips(pattern: &Pattern<'_>) -> Drawing {
    let angles = in_plane(ANGLES);
    let rows: Vec<Vec<[u8; 3]>> = INCIDENCES
        .par_iter()
        .map(|polar| {
            let w_i = direction(*polar, 0.0);
            let colours: Vec<[f64; 3]> = angles
                .iter()
                .map(|angle| {
                    pattern.reference.xyz(w_i, DVec3::new(libm::sin(*angle), 0.0, libm::cos(*angle)))
                })
                .collect();
            let exposure = exposure(colours.iter().copied());
            colours.into_iter().map(|xyz| shown(xyz, exposure)).collect()
        })
        .collect();
    let half = 0.5 * (INCIDENCES[1] - INCIDENCES[0]);
    let y = Axis::with_range(
        "angle of incidence (°), azimuth 0",
        INCIDENCES[0] - half,
        INCIDENCES[INCIDENCES.len() - 1] + half,
    );
    let x = Axis::with_range("angle of ω_o (°): + azimuth 0, − 180°", -90.0, 90.0);
    let mut map = HeatMap::of_colours("colours in the plane of incidence", x, y, ANGLES, rows.concat());
    map.size = SIZE;
    map.draw()
}

/// Luminance in the plane of incidence: reference and tables.
fn curves(pattern: &Pattern<'_>, errors: &TableErrors) -> Drawing {
    let points: Vec<[[f64; 2]; 2]> = in_plane(2 * ANGLES)
        .into_par_iter()
        .map(|angle| {
            let w_o = DVec3::new(libm::sin(angle), 0.0, libm::cos(angle));
            let y = [pattern.reference.xyz(pattern.w_i, w_o)[1], pattern.tables.xyz(pattern.w_i, w_o)[1]];
            y.map(|y| [angle.to_degrees(), y])
        })
        .collect();
    let top = points.iter().map(|[reference, _]| reference[1]).fold(0.0, f64::max);
    let mut figure = Figure::new(
        "tables beside the reference",
        Axis::with_range("angle of ω_o (°)", -90.0, 90.0),
        Axis::logarithmic("luminance Y of f (1/sr)"),
    );
    let decades = |value: f64| libm::exp10(libm::ceil(libm::log10(value.max(1e-300))));
    figure.y.range = Some([decades(top) * 1e-7, decades(top)]);
    figure.curves = vec![
        Curve::line("reference", points.iter().map(|[reference, _]| *reference).collect()),
        Curve::line("tables", points.iter().map(|[_, tables]| *tables).collect()),
    ];
    figure.footnote = Some(format!(
        "over the hemisphere: |ΔY| ≤ {:.1e} of the peak; mean ΔE00 {:.2}",
        errors.largest_of_peak, errors.mean_delta_e
    ));
    figure.size = [SIZE[0], SIZE[1] - 20.0];
    figure.draw()
}
