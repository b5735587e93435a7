//! Segments: what goes on along y and what does not.

use super::*;
use crate::structure::{Structure, species_names};

fn layers(segment: &Segment, column: usize) -> (Line, Layers) {
    let grid = SegmentGrid::new(segment, [0.1, 0.1]);
    let sampled = segment.sampled(grid, 1).unwrap();
    let (mut line, mut layers) = (Line::default(), Layers::default());
    sampled.line(column, &mut line);
    sampled.layers(&line, 0, 8, &mut layers);
    (line, layers)
}

#[test]
fn without_roughness_nothing_changes_along_y() {
    for name in species_names() {
        let segment = Structure::builtin(name).unwrap().segment(1, 0, 5.0, Roughness::NONE).unwrap();
        let (line, layers) = layers(&segment, 77);
        assert!(line.rise_um.iter().chain(line.slopes.iter().flatten()).all(|v| *v == 0.0));
        assert!(layers.varying.is_none());
        for row in layers.thickness_um.chunks_exact(layers.stride) {
            assert!(row[..50].iter().all(|value| value == &row[0]), "{name}");
        }
    }
}

#[test]
fn every_layer_is_roughened_by_itself_and_none_turns_inside_out() {
    let rough = Roughness { amplitude_um: 0.02, correlation_um: [0.5, 0.5] };
    let segment = Structure::builtin("starling").unwrap().segment(1, 0, 60.0, rough).unwrap();
    let (line, layers) = layers(&segment, 120);
    let rows = line.rise_um.len();
    let spread = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let first = &layers.thickness_um[..rows];
    // Both of a layer's boundaries move: √2 of the amplitude. 120 correlation lengths.
    assert!((spread(first) / (0.02 * 2f64.sqrt()) - 1.0).abs() < 0.25, "{}", spread(first));
    let rise: Vec<f64> = line.rise_um.iter().map(|v| f64::from(*v)).collect();
    assert!((spread(&rise) / 0.02 - 1.0).abs() < 0.25);
    assert!(layers.thickness_um.iter().all(|t| *t >= 0.0));
    assert_eq!(layers.media.len() * layers.stride, layers.thickness_um.len() + layers.stride);
}

#[test]
fn a_rock_doves_granules_are_laid_out_in_the_plane() {
    let segment = Structure::builtin("rock-dove").unwrap().segment(1, 0, 60.0, Roughness::default()).unwrap();
    let (line, layers) = layers(&segment, 100);
    let (slot, fractions) = layers.varying.as_ref().unwrap();
    assert_eq!(*slot, 2);
    assert!(fractions.iter().all(|f| (0.8..=1.0).contains(f)));
    let rows = line.rise_um.len();
    let gap = &layers.thickness_um[layers.stride..layers.stride + rows];
    assert!(gap.iter().all(|g| (0.25..=0.75).contains(g)));
    let (low, high) = gap.iter().fold((1.0, 0.0), |(low, high): (f64, f64), g| (low.min(*g), high.max(*g)));
    assert!(low < 0.35 && high > 0.65, "{low} {high}");
}

#[test]
fn a_hummingbirds_discs_cover_as_much_of_the_plane_as_of_the_section() {
    let segment =
        Structure::builtin("hummingbird").unwrap().segment(1, 0, 20.0, Roughness::default()).unwrap();
    let Under::Pancakes(pancakes) = &segment.under else { panic!("no pancakes") };
    assert_eq!(pancakes.layers.len(), 12);
    for (index, layer) in pancakes.layers.iter().enumerate() {
        let (mut covered, mut count, mut air) = (0.0, 0.0, 0.0);
        for i in 0..200 {
            for j in 0..100 {
                let halves = pancakes.at(layer, 0.19 * f64::from(i) - 19.0, 0.19 * f64::from(j) - 9.5);
                assert!(halves.air_um >= 0.0 && halves.air_um <= halves.outer_um);
                count += 1.0;
                covered += f64::from(u8::from(halves.outer_um > 0.0));
                air += halves.air_um;
            }
        }
        let wanted = if index == 0 { 0.85 } else { 0.9 };
        assert!((covered / count - wanted).abs() < 0.02, "layer {index}: {}", covered / count);
        assert!(air > 0.0);
    }
    let (_, layers) = layers(&segment, 200);
    assert_eq!(layers.media.len(), 4 * 12 + 2);
}

#[test]
fn the_same_seed_gives_the_same_segment_and_another_another() {
    let structure = Structure::builtin("starling").unwrap();
    let of = |seed, index| {
        layers(&structure.segment(seed, index, 5.0, Roughness::default()).unwrap(), 50).0.rise_um
    };
    assert_eq!(of(1, 0), of(1, 0));
    assert_ne!(of(1, 0), of(2, 0));
    assert_ne!(of(1, 0), of(1, 1));
}

#[test]
fn impossible_segments_are_refused() {
    let structure = Structure::builtin("starling").unwrap();
    let usual = Roughness::default();
    for (length, roughness, words) in [
        (0.1, usual, "give a length from 1 to 1000"),
        (f64::NAN, usual, "give a length from 1 to 1000"),
        (10.0, Roughness { correlation_um: [0.0, 1.0], ..usual }, "correlation lengths"),
        (10.0, Roughness { amplitude_um: -0.1, ..usual }, "amplitude"),
        (10.0, Roughness { amplitude_um: 0.4, ..usual }, "amplitude"),
    ] {
        let error = structure.segment(1, 0, length, roughness).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
