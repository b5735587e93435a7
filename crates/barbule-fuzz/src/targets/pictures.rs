//! Skies, textures and micrographs.

use barbule::io::decode_micrograph;
use barbule::io::image::{Meaning, decode_picture, encode_exr, encode_png, foretell_picture};

use super::{Target, Weight};
use crate::laws::{holds, judged};
use crate::{Verdict, seal};

const PNG_WORDS: &[&str] =
    &["IHDR", "IDAT", "IEND", "PLTE", "tRNS", "gAMA", "acTL", "fcTL", "fdAT", "iTXt", "\0\0\0\x0d"];
const TIFF_WORDS: &[&str] = &[
    "II*\0",
    "MM\0*",
    "\x01\x01\x03\0",
    "\x11\x01\x04\0",
    "\x17\x01\x04\0",
    "\x03\x01\x03\0\x01\0\0\0\x05\0",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "picture-png",
        about: "textures in PNG",
        tokens: PNG_WORDS,
        seeds: || vec![png()],
        check: |bytes| picture("picture.png", &seal::png(bytes)),
        weight: Weight::Picture,
    },
    Target {
        name: "picture-exr",
        about: "skies and textures in EXR",
        tokens: &[
            "channels\0chlist\0",
            "compression\0compression\0",
            "dataWindow\0box2i\0",
            "displayWindow\0",
            "lineOrder\0",
            "tiles\0tiledesc\0",
            "R\0",
            "G\0",
            "B\0",
            "scanlineimage\0",
            "chunkCount\0int\0",
        ],
        seeds: exr,
        check: |bytes| picture("picture.exr", bytes),
        weight: Weight::Picture,
    },
    Target {
        name: "picture-hdr",
        about: "skies and textures in Radiance's HDR",
        tokens: &[
            "#?RADIANCE\n",
            "#?RGBE\n",
            "FORMAT=32-bit_rle_rgbe\n",
            "EXPOSURE=",
            "-Y 2 +X 10\n",
            "+X 2 -Y 2\n",
            "\x02\x02\0\x0a",
            "\x01\x01\x01\x05",
            "\n\n",
        ],
        seeds: hdr,
        check: |bytes| picture("picture.hdr", bytes),
        weight: Weight::Picture,
    },
    Target {
        name: "micrograph-png",
        about: "micrographs in PNG",
        tokens: PNG_WORDS,
        seeds: Vec::new,
        check: |bytes| micrograph(&seal::png(bytes)),
        weight: Weight::Picture,
    },
    Target {
        name: "micrograph-tiff",
        about: "micrographs in TIFF",
        tokens: TIFF_WORDS,
        seeds: Vec::new,
        check: micrograph,
        weight: Weight::Picture,
    },
    Target {
        name: "micrograph-jpeg",
        about: "micrographs in JPEG",
        tokens: &["\u{ff}\u{d8}", "JFIF\0", "Exif\0\0"],
        seeds: Vec::new,
        check: micrograph,
        weight: Weight::Picture,
    },
];

fn picture(name: &str, bytes: &[u8]) -> Verdict {
    let check = |meaning| {
        judged(decode_picture(name, bytes, meaning), |(image, _)| {
            let pixels = image.size[0] * image.size[1];
            holds(pixels == image.pixels.len(), || format!("{pixels} pixels are {}", image.pixels.len()))?;
            let foretold = foretell_picture(name, bytes);
            holds(foretold.is_some_and(|foretold| foretold >= pixels), || {
                format!("{pixels} pixels, foretold {foretold:?}")
            })
        })
    };
    check(Meaning::Colour)
}

fn micrograph(bytes: &[u8]) -> Verdict {
    judged(decode_micrograph(bytes), |grey| {
        let [width, height] = grey.size();
        holds(grey.values().len() == width * height, || "a picture of other sides than its values".into())?;
        holds(grey.values().iter().all(|value| (-1e-6..=1.0 + 1e-6).contains(value)), || {
            "a grey that is not within 0 to 1".into()
        })
    })
}

fn png() -> Vec<u8> {
    let pixels: Vec<u8> = (0..4 * 3 * 4).map(|i| i * 5).collect();
    encode_png([4, 3], &pixels, true, &[("Software", "barbule")]).unwrap_or_default()
}

fn exr() -> Vec<Vec<u8>> {
    let plane = |at: usize| (0..12).map(|i| (i + at) as f32 * 0.1).collect();
    let planes = vec![("R", plane(0)), ("G", plane(1)), ("B", plane(2)), ("A", plane(3))];
    let more = vec![("id", (0..12).collect())];
    encode_exr([4, 3], planes, more, &[("scene", "test")], &[]).into_iter().collect()
}

fn hdr() -> Vec<Vec<u8>> {
    let head = b"#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n";
    // Ten pixels, packed: red of 1, then a ramp of green, in runs and bytes, component by component.
    let mut line = vec![2, 2, 0, 10, 128 + 10, 128, 10];
    line.extend((0..10).map(|i| i * 16));
    line.extend([128 + 4, 0, 6, 0, 0, 0, 0, 0, 0, 128 + 10, 129]);
    let packed = [head.as_slice(), b"-Y 2 +X 10\n", &line, &line].concat();
    let plain =
        [head.as_slice(), b"+X 2 -Y 2\n", &[128, 64, 0, 130, 1, 1, 1, 2, 1, 1, 1, 0, 0, 0, 0, 0]].concat();
    vec![packed, plain]
}
