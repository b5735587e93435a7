use super::picture::check;
use super::*;

fn options() -> HeightsOptions {
    HeightsOptions { pitch_um: Some(0.5), clean: Clean::Never, ..HeightsOptions::default() }
}

fn decode(bytes: &[u8], options: &HeightsOptions) -> Result<(Heightfield, bool)> {
    super::decode(bytes).and_then(|raw| field(raw, options))
}

/// 3 columns, 2 rows: heights 0 … 5, of which the middle is taken off.
fn read(bytes: &[u8], options: &HeightsOptions) -> Vec<f64> {
    let (field, _) = decode(bytes, options).unwrap();
    assert_eq!(field.cells(), [3, 2]);
    assert!((field.pitch_um()[0] - 0.5).abs() < 1e-9 && (field.pitch_um()[1] - 0.5).abs() < 1e-9);
    field.height_um().to_vec()
}

const EXPECTED: [f64; 6] = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5];

fn refusal(bytes: &[u8], options: &HeightsOptions) -> String {
    let error = decode(bytes, options).unwrap_err();
    let text = error.to_string();
    assert!(error.is_input() && !text.contains('\n') && text.len() < 400, "{text}");
    text
}

fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = npy::MAGIC.to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((header.len() as u16).to_le_bytes()),
        _ => bytes.extend((header.len() as u32).to_le_bytes()),
    }
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn numpy_arrays_of_every_kind() {
    let header = |kind: &str, fortran: &str, shape: &str| {
        format!("{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}   \n")
    };
    let doubles: Vec<u8> = (0..6).flat_map(|i| f64::from(i).to_le_bytes()).collect();
    for version in 1..=3 {
        assert_eq!(read(&npy(version, &header("<f8", "False", "(2, 3)"), &doubles), &options()), EXPECTED);
    }
    let columns: Vec<u8> =
        [0, 3, 1, 4, 2, 5].iter().flat_map(|i| f32::from(*i as u8).to_be_bytes()).collect();
    assert_eq!(read(&npy(1, &header(">f4", "True", "(2, 3)"), &columns), &options()), EXPECTED);
    let shorts: Vec<u8> = (0..6).flat_map(|i: i16| i.to_be_bytes()).collect();
    assert_eq!(read(&npy(1, &header(">i2", "False", "(2, 3)"), &shorts), &options()), EXPECTED);
    let bytes: Vec<u8> = (0..6).collect();
    let nanometres = HeightsOptions { unit: Some(HeightUnit::Nanometre), ..options() };
    let found = read(&npy(1, &header("|u1", "False", "(2, 3)"), &bytes), &nanometres);
    assert!(found.iter().zip(EXPECTED).all(|(a, b)| (a - 1e-3 * b).abs() < 1e-15));

    let whole = npy(1, &header("<f8", "False", "(2, 3)"), &doubles);
    for length in 0..whole.len() {
        refusal(&whole[..length], &options());
    }
    for (kind, shape, expected) in [
        ("<f8", "(2, 4)", "48 bytes follow"),
        ("<f8", "(99999999999, 99999999999)", "are read"),
        ("<f8", "(18446744073709551615, 3)", "are read"),
        ("<f8", "(99999999999999999999999, 3)", "no tuple"),
        ("<f8", "(2, 3, 1)", "3 axes"),
        ("<f8", "(0, 3)", "are read"),
        ("<c16", "(2, 3)", "'c16'"),
        ("O", "(2, 3)", "none of numbers"),
        ("é", "(2, 3)", "none of numbers"),
        ("", "(2, 3)", "none of numbers"),
    ] {
        let text = refusal(&npy(1, &header(kind, "False", shape), &doubles), &options());
        assert!(text.contains(expected), "{text}");
    }
    // Whichever of two is meant: programs differ in which they take.
    for key in ["'shape': (3, 2)", "'descr': '<f8'", "'fortran_order': True"] {
        let twice = header("<f8", "False", "(2, 3)").replacen('{', &format!("{{{key}, "), 1);
        let text = refusal(&npy(1, &twice, &doubles), &options());
        assert!(text.contains("twice"), "{text}");
    }
    let nan: Vec<u8> =
        [0.0, 1.0, f64::NAN, 3.0, 4.0, 5.0].iter().flat_map(|v: &f64| v.to_le_bytes()).collect();
    assert!(
        refusal(&npy(1, &header("<f8", "False", "(2, 3)"), &nan), &options()).contains("column 2, row 0")
    );
    assert!(refusal(&whole, &HeightsOptions::default()).contains("`pitch_um`"));
    assert!(refusal(&whole, &HeightsOptions { range_um: Some(1.0), ..options() }).contains("`range_um`"));
}

#[test]
fn rows_of_numbers_with_any_separator() {
    for text in [
        "0 1 2\n3 4 5\n",
        "0 1 2\r3 4 5\r",
        "0,1,2,\n3, 4, 5,\n",
        "# heights\n\n0,1,2\r\n3,4,5",
        "0;1;2\n3;4,0;5",
        "\u{feff}0\t1\t2\n3\t4\t5e0\n",
    ] {
        assert_eq!(read(text.as_bytes(), &options()), EXPECTED, "{text}");
    }
    for (text, expected) in [
        ("0 1 2\n3 4\n", "line 2 has 2 heights"),
        ("0 1 2\n3 x 5\n", "line 2, column 2: 'x'"),
        ("# nothing\n", "no heights"),
        ("", "no heights"),
        ("0,1 0,2 0,3\n", "line 1, column 2: '1 0'"),
        ("0,,2\n3,4,5\n", "line 1, column 2: ''"),
        ("# Width: 3 µm\n0 1\n", "only one of Width"),
    ] {
        assert!(refusal(text.as_bytes(), &options()).contains(expected), "{text}");
    }
    assert!(refusal(b"\xff\x00\x01 no text", &options()).contains("no heightfield"));
}

#[test]
fn gwyddion_says_sizes_and_units() {
    let text = "# Channel: Height\n# Width: 1.5 µm\n# Height: 1000 nm\n# Value units: m\n3e-6\t4e-6\t5e-6\n0\t1e-6\t2e-6\n";
    let none = HeightsOptions { clean: Clean::Never, ..HeightsOptions::default() };
    let close = |found: Vec<f64>| found.iter().zip(EXPECTED).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(close(read(text.as_bytes(), &none)));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    assert!(close(read(&latin, &options())));
    let other = HeightsOptions { pitch_um: Some(0.4), ..options() };
    assert!(refusal(text.as_bytes(), &other).contains("`pitch_um` is 0.4"));
    let unit = |unit: HeightUnit| HeightsOptions { unit: Some(unit), ..none };
    assert!(close(read(text.as_bytes(), &unit(HeightUnit::Metre))));
    assert!(
        refusal(text.as_bytes(), &unit(HeightUnit::Nanometre))
            .contains("1000000 µm each, but `unit` says 0.001")
    );
    // As the file counts, whose first row is the top.
    assert!(refusal(text.replace("3e-6", "nan").as_bytes(), &none).contains("column 0, row 0"));
    let upright = text.replace("1000 nm", "2000 nm");
    assert!(refusal(upright.as_bytes(), &options()).contains("1 µm along y"));
    let millimetres = text.replace("units: m", "units: mm").replace("e-6", "e-3");
    assert!(close(read(millimetres.as_bytes(), &none)));
    assert!(refusal(text.replace("1.5 µm", "1.5 ft").as_bytes(), &none).contains("line 2: '1.5 ft'"));
}

fn png(color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    drop(writer);
    bytes
}

#[test]
fn grey_pictures_have_a_range_and_their_top_is_the_largest_y() {
    let with_range = HeightsOptions { range_um: Some(255.0), ..options() };
    // The upper row first.
    let eight = png(png::ColorType::Grayscale, png::BitDepth::Eight, &[3, 4, 5, 0, 1, 2]);
    let close = |found: Vec<f64>| found.iter().zip(EXPECTED).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(close(read(&eight, &with_range)));
    let sixteen: Vec<u8> = [3_u16, 4, 5, 0, 1, 2].iter().flat_map(|v| v.to_be_bytes()).collect();
    let sixteen = png(png::ColorType::Grayscale, png::BitDepth::Sixteen, &sixteen);
    assert!(close(read(&sixteen, &HeightsOptions { range_um: Some(65535.0), ..options() })));
    assert!(refusal(&eight, &options()).contains("`range_um`"));
    for (color, count) in [(png::ColorType::Rgb, 18), (png::ColorType::GrayscaleAlpha, 12)] {
        assert!(
            refusal(&png(color, png::BitDepth::Eight, &vec![7; count]), &with_range).contains("grey alone")
        );
    }
    let with_unit = HeightsOptions { unit: Some(HeightUnit::Nanometre), ..with_range };
    assert!(refusal(&eight, &with_unit).contains("`range_um` in place of `unit`"));
    // Two bits a pixel: rows of 3, 2, 1 and 0, 1, 2 in thirds.
    let two = png(png::ColorType::Grayscale, png::BitDepth::Two, &[0b1110_0100, 0b0001_1000]);
    let thirds = read(&two, &HeightsOptions { range_um: Some(3.0), ..options() });
    assert!(thirds.iter().zip([-1.5, -0.5, 0.5, 1.5, 0.5, -0.5]).all(|(a, b)| (a - b).abs() < 1e-9));
    let mut indexed = Vec::new();
    let mut encoder = png::Encoder::new(&mut indexed, 3, 2);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(vec![0; 18]);
    encoder.write_header().unwrap().write_image_data(&[0; 6]).unwrap();
    assert!(refusal(&indexed, &with_range).contains("grey alone"));
    // Pixels that cannot be in so few bytes, and more than are read.
    for (size, expected) in [([60_000, 1000], "cannot be in"), ([60_000, 60_000], "are read")] {
        assert!(check(size, eight.len()).unwrap_err().to_string().contains(expected));
    }
    for length in (4..eight.len() - 12).step_by(3) {
        refusal(&eight[..length], &with_range);
    }
}

fn tiff<C: tiff::encoder::colortype::ColorType>(data: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut file = std::io::Cursor::new(Vec::new());
    tiff::encoder::TiffEncoder::new(&mut file).unwrap().write_image::<C>(3, 2, data).unwrap();
    file.into_inner()
}

#[test]
fn tiffs_of_whole_numbers_and_of_floats() {
    use tiff::encoder::Compression;
    use tiff::encoder::colortype::{Gray8, Gray16, Gray32Float, Gray64Float, RGB8};
    let close = |found: Vec<f64>| found.iter().zip(EXPECTED).all(|(a, b)| (a - b).abs() < 1e-9);
    let whole = tiff::<Gray16>(&[3, 4, 5, 0, 1, 2]);
    let with_range = HeightsOptions { range_um: Some(65535.0), ..options() };
    assert!(close(read(&whole, &with_range)));
    assert!(refusal(&whole, &options()).contains("`range_um`"));
    assert!(close(read(&tiff::<Gray32Float>(&[3.0, 4.0, 5.0, 0.0, 1.0, 2.0]), &options())));
    assert!(close(read(&tiff::<Gray64Float>(&[3.0, 4.0, 5.0, 0.0, 1.0, 2.0]), &options())));
    let mut big = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new_big(&mut big).unwrap();
    encoder.write_image::<Gray32Float>(3, 2, &[3.0, 4.0, 5.0, 0.0, 1.0, 2.0]).unwrap();
    assert!(close(read(&big.into_inner(), &options())));
    let infinite = tiff::<Gray32Float>(&[3.0, 4.0, 5.0, 0.0, f32::INFINITY, 2.0]);
    assert!(refusal(&infinite, &options()).contains("column 1, row 1"));
    assert!(refusal(&tiff::<RGB8>(&[1; 18]), &with_range).contains("grey alone"));
    assert!(refusal(&whole[..whole.len() / 2], &with_range).contains("cannot be read as a TIFF"));
    for compression in [Compression::Lzw, Compression::Deflate(Default::default()), Compression::Packbits] {
        let mut file = std::io::Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut file).unwrap().with_compression(compression);
        encoder.write_image::<Gray8>(3, 2, &[3, 4, 5, 0, 1, 2]).unwrap();
        let eight = HeightsOptions { range_um: Some(255.0), ..options() };
        assert!(close(read(&file.into_inner(), &eight)));
    }
    // Which of the two is the picture nobody says.
    let mut both = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut both).unwrap();
    let mut image = encoder.new_image::<Gray8>(3, 2).unwrap();
    image.encoder().write_tag(tiff::tags::Tag::TileWidth, 0_u32).unwrap();
    image.write_data(&[3, 4, 5, 0, 1, 2]).unwrap();
    assert!(refusal(&both.into_inner(), &with_range).contains("tiles beside strips"));
    for length in 4..whole.len() {
        if let Err(error) = decode(&whole[..length], &with_range) {
            assert!(error.is_input(), "{error}");
        }
    }
    // Any byte another one: no panic, no great allocation.
    for place in 4..whole.len() {
        for value in [0, 0x7f, 0xff] {
            let mut bad = whole.clone();
            bad[place] = value;
            let _ = decode(&bad, &with_range);
        }
    }
}

#[test]
fn what_does_not_repeat_is_cleaned_unless_told_otherwise() {
    let tilted: String = (0..40)
        .map(|j| {
            (0..40)
                .map(|i| format!("{} ", 0.01 * f64::from(i) + 0.02 * f64::from((i + j) % 2)))
                .collect::<String>()
                + "\n"
        })
        .collect();
    let reach = |clean: Clean| {
        decode(tilted.as_bytes(), &HeightsOptions { clean, ..options() }).unwrap().0.reach_um()
    };
    assert!(reach(Clean::Auto) < 0.02 && reach(Clean::Always) < 0.02 && reach(Clean::Never) > 0.15);
}

/// Headers say how much reading takes, whatever the rest of the file is; a text is counted; a pipe is left alone.
#[test]
fn what_heights_take_is_foretold_from_their_beginnings() {
    let folder = tempfile::tempdir().unwrap();
    let foretold = |name: &str, bytes: &[u8], clean: Clean| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        foretell_heights(&path, &HeightsOptions { clean, ..options() })
    };
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (8192, 8192), }";
    let bytes = npy(1, header, &[]);
    let numbers = 8192 * 8192 * 8;
    assert_eq!(foretold("a.npy", &bytes, Clean::Never), Some(numbers + bytes.len() as u64));
    assert_eq!(foretold("a.npy", &bytes, Clean::Auto), Some(3 * numbers));
    for (text, count, longest) in [("1 2 3\n4 5\n", 5, 3), ("1,5;2\n3;4\n", 5, 2), ("1\t2\n", 3, 2)] {
        let expected = 3 * text.len() as u64 + PER_WORD * longest + 8 * count;
        assert_eq!(foretold("a.txt", text.as_bytes(), Clean::Never), Some(expected), "{text}");
    }
    assert_eq!(foretell_heights(&folder.path().join("none.txt"), &options()), None);
    assert_eq!(foretell_heights(folder.path(), &options()), None);
}
