use super::*;
use crate::render::integrator::FirstHit;
use crate::spectrum::hero::Hero;

fn hero() -> Hero {
    Sensor::human().density().draw(0.3)
}

/// CIE XYZ of radiance 1 over the densities.
fn white() -> [f64; 4] {
    let Rows::Eye(rows) = Response::new(&Sensor::human()).rows else { panic!("the eye's rows") };
    seen(&rows, &[1.0; WAVES], &hero())
}

/// A ramp of light, in tiles with counts of their own: every pixel is the ramp through its tent, also at the edges.
#[test]
fn pixels_are_seen_through_their_tents() {
    let size = [70, 33];
    let mut film = Film::new(size).unwrap();
    let side = 64;
    for tile in 0..film.tiles() {
        if tile == 2 {
            continue;
        }
        let [x0, y0, x1, y1] = film.bounds(tile);
        let repeats = 1 + tile as u32 % 3;
        for (x, y) in (x0..x1).flat_map(|x| (y0..y1).map(move |y| (x, y))) {
            for at in 0..repeats * side * side {
                let offset = [at % side, at / side % side].map(|k| (f64::from(k) + 0.5) / f64::from(side));
                let value = 1.0 + 0.1 * (f64::from(x) + offset[0]);
                let hero = hero();
                let first = FirstHit { id: 3, ..NO_HIT };
                let rays = [0; 2];
                let sample = Sample { radiance: [value; WAVES], hero, first, offset, alpha: 0.5, rays };
                let Film { planes, response, tiles, .. } = &mut film;
                tiles[tile].add([x - x0, y - y0], x1 - x0, (planes, response), &sample, at);
            }
        }
        film.tiles[tile].count = repeats * side * side;
    }
    let white = white()[1];
    let value = |x: u32, y: u32| film.xyz(x, y)[1] / white;
    for (x, y, centre) in [
        (5, 7, 5.5),
        (31, 31, 31.5),
        (32, 32, 32.5),
        // What lies outside does not count: ∫ x (1 − |x|) from −½ to 1 is 1/12, of the tent's part 7/8.
        (0, 5, 0.5 + 2.0 / 21.0),
    ] {
        let found = (value(x, y) - 1.0) / 0.1;
        assert!((found - centre).abs() < 1e-3, "{x} {y}: {found}");
        assert!((film.alpha(x, y) - 0.5).abs() < 1e-12);
    }
    // In the tile without samples, away from its neighbours, there is nothing.
    assert_eq!((film.xyz(67, 10), film.count(67, 10)), ([0.0; 3], 0));
    assert!(film.variance(5, 7) < 1e-3 && film.pixel(5, 7).id == 3);
}

/// A few samples at random places of each pixel, in tiles with counts of their own.
#[test]
fn light_that_is_the_same_everywhere_has_no_noise() {
    let mut film = Film::new([70, 33]).unwrap();
    let mut stream = crate::math::rng::Stream::new(5, &[]);
    let (hero, radiance, first) = (hero(), [1.0; WAVES], NO_HIT);
    let mut sample = Sample { radiance, hero, first, offset: [0.5; 2], alpha: 1.0, rays: [0; 2] };
    for tile in 0..film.tiles() {
        let [x0, y0, x1, y1] = film.bounds(tile);
        film.tiles[tile].count = 1 + tile as u32;
        for (x, y) in (x0..x1).flat_map(|x| (y0..y1).map(move |y| (x - x0, y - y0))) {
            for number in 0..=tile as u32 {
                sample.offset = [stream.unit(), stream.unit()];
                let Film { planes, response, tiles, .. } = &mut film;
                tiles[tile].add([x, y], x1 - x0, (planes, response), &sample, number);
            }
        }
    }
    let expected = white()[1];
    for (x, y) in (0..70).flat_map(|x| (0..33).map(move |y| (x, y))) {
        assert!((film.xyz(x, y)[1] / expected - 1.0).abs() < 1e-12);
    }
}

#[test]
fn tiles_cover_every_pixel_once() {
    let film = Film::new([70, 33]).unwrap();
    let mut seen = vec![0; 70 * 33];
    for tile in 0..film.tiles() {
        let [x0, y0, x1, y1] = film.bounds(tile);
        for y in y0..y1 {
            for x in x0..x1 {
                seen[(y * 70 + x) as usize] += 1;
            }
        }
    }
    assert!(seen.iter().all(|s| *s == 1));
    assert!(Film::new([0, 5]).is_err() && Film::new([20_000, 5]).is_err());
}

#[test]
fn the_variance_is_that_of_the_mean() {
    // Samples 1 and 3: variance 2, of their mean 1.
    let pixel = Pixel { luminance: 4.0, squares: 10.0, ..Pixel::default() };
    assert!((pixel.variance(2) - 1.0).abs() < 1e-12 && pixel.variance(1) == 0.0);
    let mut film = Film::new([3, 3]).unwrap();
    film.tiles[0].count = 2;
    film.tiles[0].pixels.fill(pixel);
    // The tent's square over its area is 2/3 along each side.
    assert!((film.variance(1, 1) - 4.0 / 9.0).abs() < 1e-12, "{}", film.variance(1, 1));
}
