//! Drawings as PDF: vectors, words that can be selected and searched, pixels as they are.
//!
//! The built-in font is embedded whole, so that a page looks the same everywhere. Nothing in the file depends on the day or
//! on chance: the same drawing and notes are the same bytes.

use std::collections::{BTreeMap, BTreeSet};

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

use super::drawing::{Anchor, Drawing, Ink, Item, Picture, Stroke};
use super::text;

/// Points (1/72 inch) in a px (1/96 inch).
const POINTS: f64 = 0.75;
/// Effort of the compression, of 10.
const EFFORT: u8 = 6;
/// Control points of a quarter circle of radius 1 lie this far from its ends.
const QUARTER: f32 = 0.552_284_8;

const FONT: Name<'static> = Name(b"F");
/// PostScript's name of the font; the letters in front say that it is a part of one.
const FONT_NAME: Name<'static> = Name(b"BARBUL+DejaVuSans");
const UNICODE: SystemInfo<'static> =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// The objects that every file has; those of pictures follow.
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);
const TYPE0: Ref = Ref::new(6);
const CID_FONT: Ref = Ref::new(7);
const DESCRIPTOR: Ref = Ref::new(8);
const FONT_FILE: Ref = Ref::new(9);
const TO_UNICODE: Ref = Ref::new(10);
const FIRST_FREE: i32 = 11;

pub(super) fn write(drawing: &Drawing, notes: &[(&str, &str)]) -> Vec<u8> {
    let mut sheet = Sheet {
        content: Content::new(),
        letters: BTreeMap::new(),
        opacities: BTreeSet::new(),
        pictures: Vec::new(),
    };
    let [width, height] = [drawing.width * POINTS, drawing.height * POINTS].map(|v| v as f32);
    // From here on px, y down, as everywhere else.
    sheet.content.transform([POINTS as f32, 0.0, 0.0, -POINTS as f32, 0.0, height]);
    sheet.content.set_fill_rgb(1.0, 1.0, 1.0);
    sheet.content.rect(0.0, 0.0, drawing.width as f32, drawing.height as f32).fill_nonzero();
    sheet.content.set_line_join(LineJoinStyle::RoundJoin);
    sheet.items(&drawing.items);
    let Sheet { content, letters, opacities, pictures } = sheet;

    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut page = pdf.page(PAGE);
    page.media_box(Rect::new(0.0, 0.0, width, height)).parent(PAGES).contents(CONTENT);
    let mut resources = page.resources();
    resources.fonts().pair(FONT, TYPE0);
    let mut states = resources.ext_g_states();
    for &[fill, stroke] in &opacities {
        let name = opacity_name([fill, stroke]);
        let mut state = states.insert(Name(name.as_bytes())).start::<ExtGraphicsState<'_>>();
        state.non_stroking_alpha(f32::from(fill) / 100.0).stroking_alpha(f32::from(stroke) / 100.0);
    }
    states.finish();
    let mut objects = resources.x_objects();
    for number in 0..pictures.len() {
        objects.pair(Name(picture_name(number).as_bytes()), picture_ref(number));
    }
    objects.finish();
    resources.finish();
    page.finish();
    pdf.stream(CONTENT, &packed(&content.finish())).filter(Filter::FlateDecode);
    for (number, picture) in pictures.into_iter().enumerate() {
        embed_picture(&mut pdf, picture_ref(number), picture);
    }
    embed_font(&mut pdf, &letters);
    let mut info = pdf.document_info(INFO);
    info.producer(TextStr("Barbule"));
    for (name, text) in notes {
        info.pair(Name(name.as_bytes()), TextStr(text));
    }
    info.finish();
    pdf.finish()
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    compress_to_vec_zlib(bytes, EFFORT)
}

fn opacity_name([fill, stroke]: [u8; 2]) -> String {
    format!("O{fill}-{stroke}")
}

fn picture_name(number: usize) -> String {
    format!("P{number}")
}

/// A picture takes two objects: its colours, and their opacity.
fn picture_ref(number: usize) -> Ref {
    Ref::new(FIRST_FREE + 2 * i32::try_from(number).unwrap_or(i32::MAX / 4))
}

fn embed_picture(pdf: &mut Pdf, at: Ref, picture: &Picture) {
    let size = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
    let (width, height) = (size(picture.width), size(picture.height));
    let clear = picture.rgba.iter().any(|p| p[3] < 255);
    let rgb: Vec<u8> = picture.rgba.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let rgb = packed(&rgb);
    let mut image = pdf.image_xobject(at, &rgb);
    image.filter(Filter::FlateDecode);
    image.width(width).height(height).bits_per_component(8).interpolate(false).color_space().device_rgb();
    let mask = Ref::new(at.get() + 1);
    if clear {
        image.s_mask(mask);
    }
    image.finish();
    if clear {
        let opacity = packed(&picture.rgba.iter().map(|p| p[3]).collect::<Vec<_>>());
        let mut image = pdf.image_xobject(mask, &opacity);
        image.filter(Filter::FlateDecode);
        image.width(width).height(height).bits_per_component(8).color_space().device_gray();
    }
}

/// Embeds the font, and says which letter each of the used signs is.
fn embed_font(pdf: &mut Pdf, letters: &BTreeMap<u16, char>) {
    pdf.type0_font(TYPE0)
        .base_font(FONT_NAME)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(CID_FONT)
        .to_unicode(TO_UNICODE);
    let metrics = text::metrics();
    let mut font = pdf.cid_font(CID_FONT);
    font.subtype(CidFontType::Type2).base_font(FONT_NAME).system_info(UNICODE).font_descriptor(DESCRIPTOR);
    font.cid_to_gid_map_predefined(Name(b"Identity"));
    font.widths().consecutive(0, metrics.advances.iter().copied());
    font.finish();
    let [left, bottom, right, top] = metrics.bounds;
    pdf.font_descriptor(DESCRIPTOR)
        .name(FONT_NAME)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(left, bottom, right, top))
        .italic_angle(0.0)
        .ascent(metrics.ascent)
        .descent(metrics.descent)
        .cap_height(metrics.capitals)
        .stem_v(80.0)
        .font_file2(FONT_FILE);
    let file = packed(text::FONT);
    let mut stream = pdf.stream(FONT_FILE, &file);
    stream.filter(Filter::FlateDecode);
    stream.pair(Name(b"Length1"), i32::try_from(text::FONT.len()).unwrap_or(i32::MAX));
    stream.finish();
    let mut map = UnicodeCmap::<u16>::new(Name(b"Barbule"), UNICODE);
    for (glyph, letter) in letters {
        map.pair(*glyph, *letter);
    }
    pdf.cmap(TO_UNICODE, &map.finish());
}

/// A page being written, and what it asks for from the file around it.
struct Sheet<'a> {
    content: Content,
    /// The letters used, by their signs in the font.
    letters: BTreeMap<u16, char>,
    /// Opacities of fills and strokes that are used, in percent.
    opacities: BTreeSet<[u8; 2]>,
    pictures: Vec<&'a Picture>,
}

impl<'a> Sheet<'a> {
    fn items(&mut self, list: &'a [Item]) {
        for item in list {
            match item {
                Item::Path { runs, closed, fill, stroke } => {
                    self.painted(*fill, stroke.as_ref(), |content| path(content, runs, *closed));
                }
                Item::Circle { center, radius, fill, stroke } => {
                    self.painted(*fill, stroke.as_ref(), |content| circle(content, *center, *radius));
                }
                Item::Text { at, size, text, anchor, turn, ink } => {
                    self.text(*at, *size, text, *anchor, *turn, *ink);
                }
                Item::Picture { area, picture } if !picture.rgba.is_empty() => {
                    let [x, y, w, h] = area.map(|v| v as f32);
                    let name = picture_name(self.pictures.len());
                    self.pictures.push(picture);
                    // A picture fills the unit square, its first row at the top.
                    self.content.save_state().transform([w, 0.0, 0.0, -h, x, y + h]);
                    self.content.x_object(Name(name.as_bytes())).restore_state();
                }
                Item::Picture { .. } => {}
                Item::Clip { area, items } => {
                    let [x, y, w, h] = area.map(|v| v as f32);
                    self.content.save_state().rect(x, y, w, h).clip_nonzero().end_path();
                    self.items(items);
                    self.content.restore_state();
                }
            }
        }
    }

    /// Fills and strokes what `trace` traces, unless it traces nothing.
    fn painted(
        &mut self,
        fill: Option<Ink>,
        stroke: Option<&Stroke>,
        trace: impl FnOnce(&mut Content) -> bool,
    ) {
        self.content.save_state();
        self.opacity([fill, stroke.map(|s| s.ink)].map(|ink| ink.map_or(1.0, |i| i.opacity)));
        if let Some(ink) = fill {
            let [r, g, b] = parts(ink);
            self.content.set_fill_rgb(r, g, b);
        }
        if let Some(Stroke { ink, width, dash }) = stroke {
            let [r, g, b] = parts(*ink);
            self.content.set_stroke_rgb(r, g, b).set_line_width(*width as f32);
            if !dash.is_empty() {
                self.content.set_dash_pattern(dash.iter().map(|d| *d as f32), 0.0);
            }
        }
        if trace(&mut self.content) {
            match (fill, stroke) {
                (Some(_), Some(_)) => self.content.fill_even_odd_and_stroke(),
                (Some(_), None) => self.content.fill_even_odd(),
                (None, Some(_)) => self.content.stroke(),
                (None, None) => self.content.end_path(),
            };
        }
        self.content.restore_state();
    }

    fn opacity(&mut self, opacities: [f64; 2]) {
        let percent = opacities.map(|o| (100.0 * o.clamp(0.0, 1.0)).round() as u8);
        if percent != [100, 100] {
            self.opacities.insert(percent);
            self.content.set_parameters(Name(opacity_name(percent).as_bytes()));
        }
    }

    fn text(&mut self, at: [f64; 2], size: f64, text: &str, anchor: Anchor, turn: f64, ink: Ink) {
        let before = anchor.before(text, size);
        let (sin, cos) = turn.to_radians().sin_cos();
        let [x, y] = [at[0] - before * cos, at[1] + before * sin].map(|v| v as f32);
        let (sin, cos) = (sin as f32, cos as f32);
        let mut signs = Vec::with_capacity(2 * text.len());
        for (letter, glyph) in text::glyphs(text) {
            signs.extend(glyph.to_be_bytes());
            self.letters.entry(glyph).or_insert(letter);
        }
        let [r, g, b] = parts(ink);
        self.content.save_state();
        self.opacity([ink.opacity, 1.0]);
        self.content.set_fill_rgb(r, g, b);
        self.content.begin_text().set_font(FONT, size as f32);
        // Letters stand upright where y points down.
        self.content.set_text_matrix([cos, -sin, -sin, -cos, x, y]).show(Str(&signs)).end_text();
        self.content.restore_state();
    }
}

fn parts(ink: Ink) -> [f32; 3] {
    ink.rgb.map(|c| f32::from(c) / 255.0)
}

/// Traces runs of points; whether there are any.
fn path(content: &mut Content, runs: &[Vec<[f64; 2]>], closed: bool) -> bool {
    let mut any = false;
    for run in runs.iter().filter(|run| !run.is_empty()) {
        any = true;
        for (i, at) in run.iter().enumerate() {
            let [x, y] = at.map(|v| v as f32);
            if i == 0 {
                content.move_to(x, y)
            } else {
                content.line_to(x, y)
            };
        }
        if closed {
            content.close_path();
        }
    }
    any
}

fn circle(content: &mut Content, center: [f64; 2], radius: f64) -> bool {
    let ([x, y], r) = (center.map(|v| v as f32), radius as f32);
    let q = QUARTER * r;
    content
        .move_to(x + r, y)
        .cubic_to(x + r, y + q, x + q, y + r, x, y + r)
        .cubic_to(x - q, y + r, x - r, y + q, x - r, y)
        .cubic_to(x - r, y - q, x - q, y - r, x, y - r)
        .cubic_to(x + q, y - r, x + r, y - q, x + r, y)
        .close_path();
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a reader makes of a file: each object's text, found through the table of cross references, and each stream.
    struct Read {
        objects: BTreeMap<usize, String>,
        streams: BTreeMap<usize, Vec<u8>>,
        trailer: String,
    }

    fn find(bytes: &[u8], what: &str, from: usize) -> usize {
        let found = bytes[from..].windows(what.len()).position(|w| w == what.as_bytes());
        from + found.unwrap_or_else(|| panic!("no {what}"))
    }

    /// A letter for every byte, so that places in both are the same.
    fn text(bytes: &[u8]) -> String {
        bytes.iter().map(|b| if b.is_ascii() { *b as char } else { '?' }).collect()
    }

    fn read(bytes: &[u8]) -> Read {
        assert!(bytes.starts_with(b"%PDF-1.7") && text(bytes).trim_end().ends_with("%%EOF"));
        let all = text(bytes);
        let xref: usize =
            all[all.rfind("startxref").unwrap() + 9..].split_whitespace().next().unwrap().parse().unwrap();
        let mut lines = all[xref..].lines();
        assert_eq!(lines.next().unwrap().trim(), "xref");
        let count: usize = lines.next().unwrap().split_whitespace().nth(1).unwrap().parse().unwrap();
        let (mut objects, mut streams) = (BTreeMap::new(), BTreeMap::new());
        for (id, line) in lines.take(count).enumerate() {
            let words: Vec<_> = line.split_whitespace().collect();
            if words[2] != "n" {
                continue;
            }
            let start: usize = words[0].parse().unwrap();
            assert!(all[start..].starts_with(&format!("{id} 0 obj")), "object {id}");
            let end = find(bytes, "endobj", start);
            let object = &all[start..end];
            if let Some(at) = object.find("stream\n") {
                let length: usize = number_after(object, "/Length ");
                let body = &bytes[start + at + 7..][..length];
                assert!(text(&bytes[start + at + 7 + length..]).trim_start().starts_with("endstream"));
                let plain = if object[..at].contains("/FlateDecode") {
                    miniz_oxide::inflate::decompress_to_vec_zlib(body).unwrap()
                } else {
                    body.to_vec()
                };
                streams.insert(id, plain);
            }
            objects.insert(id, object.to_owned());
        }
        let trailer = all[find(bytes, "trailer", xref)..].to_owned();
        Read { objects, streams, trailer }
    }

    fn number_after(text: &str, key: &str) -> usize {
        let rest = &text[text.find(key).unwrap_or_else(|| panic!("no {key}")) + key.len()..];
        rest.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap()
    }

    /// The words of a page as a reader's search finds them: signs of the font through its map to letters.
    fn words(file: &Read) -> Vec<String> {
        let map = text(&file.streams[&10]);
        let letters: BTreeMap<u16, char> = map
            .lines()
            .filter_map(|line| {
                let (glyph, letter) = line.strip_prefix('<')?.strip_suffix('>')?.split_once("> <")?;
                let code = |t: &str| u16::from_str_radix(t, 16).ok();
                Some((code(glyph)?, char::from_u32(code(letter)?.into())?))
            })
            .collect();
        let content = &file.streams[&4];
        let mut found = Vec::new();
        for (at, _) in text(content).match_indices(" Tm\n") {
            let from = at + 4;
            let to = find(content, " Tj", from);
            found.push(
                string(&content[from..to])
                    .chunks(2)
                    .map(|c| letters[&u16::from_be_bytes([c[0], c[1]])])
                    .collect(),
            );
        }
        found
    }

    /// A string object: `<hex>` or `(bytes with escapes)`.
    fn string(object: &[u8]) -> Vec<u8> {
        if object[0] == b'<' {
            let digits = text(&object[1..object.len() - 1]);
            return (0..digits.len() / 2)
                .map(|i| u8::from_str_radix(&digits[2 * i..][..2], 16).unwrap())
                .collect();
        }
        let (mut out, mut inner) = (Vec::new(), object[1..object.len() - 1].iter());
        while let Some(byte) = inner.next() {
            out.push(match byte {
                b'\\' => match inner.next().unwrap() {
                    b'n' => b'\n',
                    b'r' => b'\r',
                    b't' => b'\t',
                    b'b' => 8,
                    b'f' => 12,
                    // Three octal digits.
                    digit if digit.is_ascii_digit() => {
                        let more = [*inner.next().unwrap(), *inner.next().unwrap()];
                        [*digit, more[0], more[1]].iter().fold(0, |n, d| 8 * n + (d - b'0'))
                    }
                    other => *other,
                },
                other => *other,
            });
        }
        out
    }

    fn example() -> Drawing {
        let mut drawing = Drawing::new(400.0, 200.0);
        let ink = Ink::of([255, 0, 0]).with_opacity(0.18);
        drawing.rectangle(
            [0.0, 0.0, 50.0, 40.0],
            Some(ink),
            Some(Stroke { ink: Ink::BLACK, width: 2.0, dash: vec![7.0, 3.0] }),
        );
        drawing.text([200.0, 100.0], 12.0, Anchor::Middle, "φ_o (°) − λ = 520 nm \\ (x)");
        drawing.items.push(Item::Text {
            at: [20.0, 100.0],
            size: 10.0,
            text: "upwards".into(),
            anchor: Anchor::Middle,
            turn: 90.0,
            ink: Ink::BLACK,
        });
        let rgba = vec![[255, 0, 0, 255], [0, 255, 0, 128]];
        let picture =
            Item::Picture { area: [10.0, 10.0, 20.0, 10.0], picture: Picture { width: 2, height: 1, rgba } };
        let circle = Item::Circle { center: [5.0, 6.0], radius: 3.0, fill: Some(Ink::BLACK), stroke: None };
        drawing.items.push(Item::Clip { area: [1.0, 2.0, 30.0, 40.0], items: vec![picture, circle] });
        drawing
    }

    #[test]
    fn every_object_is_where_the_table_says_and_the_page_has_its_size_in_points() {
        let file = read(&write(&example(), &[]));
        assert_eq!(file.objects.len(), 12);
        assert!(file.objects[&3].contains("/MediaBox [0 0 300 150]"), "{}", file.objects[&3]);
        assert!(file.trailer.contains("/Root 1 0 R") && file.trailer.contains("/Info 5 0 R"));
        assert_eq!(file.streams[&9], text::FONT);
        assert_eq!(number_after(&file.objects[&9], "/Length1 "), text::FONT.len());
    }

    #[test]
    fn words_can_be_searched_and_stand_where_they_were_put() {
        let file = read(&write(&example(), &[]));
        assert_eq!(words(&file), ["φ_o (°) − λ = 520 nm \\ (x)", "upwards"]);
        let content = text(&file.streams[&4]);
        let matrices: Vec<Vec<f64>> = content
            .lines()
            .filter_map(|line| line.strip_suffix(" Tm"))
            .map(|line| line.split(' ').map(|n| n.parse().unwrap()).collect())
            .collect();
        let half = |words: &str, size: f64| text::width(words, size) / 2.0;
        let close = |a: &[f64], b: [f64; 6]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
        let first = [1.0, 0.0, 0.0, -1.0, 200.0 - half("φ_o (°) − λ = 520 nm \\ (x)", 12.0), 100.0];
        assert!(close(&matrices[0], first), "{matrices:?}");
        // Turned words begin below their place and run upwards.
        assert!(
            close(&matrices[1], [0.0, -1.0, -1.0, 0.0, 20.0, 100.0 + half("upwards", 10.0)]),
            "{matrices:?}"
        );
    }

    #[test]
    fn pictures_keep_their_pixels_and_opacity_and_clips_their_area() {
        let file = read(&write(&example(), &[]));
        assert_eq!(file.streams[&11], [255, 0, 0, 0, 255, 0]);
        assert_eq!(file.streams[&12], [255, 128]);
        assert!(file.objects[&11].contains("/SMask 12 0 R") && file.objects[&11].contains("/Width 2"));
        let content = text(&file.streams[&4]);
        assert!(content.contains("1 2 30 40 re\nW\nn") && content.contains("20 0 0 -10 10 20 cm\n/P0 Do"));
        assert!(content.contains("[7 3] 0 d") && content.contains("/O18-100 gs") && content.contains("B*"));
        assert!(file.objects[&3].contains("/ca 0.18"));
        assert_eq!(content.matches("\nq\n").count() + 1, content.matches("\nQ").count() + 1);
    }

    #[test]
    fn notes_travel_inside_and_the_bytes_follow_from_the_drawing_alone() {
        let notes = [("version", "1.2.3"), ("command", "barbule film 'µ' (x)")];
        let bytes = write(&example(), &notes);
        assert_eq!(bytes, write(&example(), &notes));
        let info = &read(&bytes).objects[&5];
        assert!(
            info.contains("/version (1.2.3)") && info.contains("/command") && !info.contains("Date"),
            "{info}"
        );
    }
}
