// From linear light to what a screen shows: gamut, tone curve and transfer of `render::tone` of barbule-appearance, which is
// its reference and says where the formulas come from.

// Largest component kept as it is by the plain curve.
const TONE_SHOULDER: f32 = 0.6;
// The film's curve: the grey that stays, the largest component that is white, the contrast, and the largest component at
// which colours have lost half of their chroma.
const TONE_GREY: f32 = 0.18;
const TONE_BRIGHTEST: f32 = 16.3;
const TONE_CONTRAST: f32 = 1.3;
const TONE_HALF_WHITE: f32 = 5.0;

fn tone_largest(rgb: vec3f) -> f32 {
    return max(rgb.x, max(rgb.y, rgb.z));
}

// A colour outside sRGB moves towards the grey of its luminance until it is inside.
fn tone_into_gamut(rgb: vec3f) -> vec3f {
    let least = min(rgb.x, min(rgb.y, rgb.z));
    if least >= 0.0 {
        return rgb;
    }
    let luminance = dot(rgb, vec3f(0.2126, 0.7152, 0.0722));
    if luminance <= 0.0 {
        return vec3f(0.0);
    }
    return max(luminance + (rgb - luminance) * (luminance / (luminance - least)), vec3f(0.0));
}

fn tone_plain(rgb: vec3f) -> vec3f {
    let largest = tone_largest(rgb);
    if largest <= TONE_SHOULDER {
        return rgb;
    }
    let room = 1.0 - TONE_SHOULDER;
    let shown = 1.0 - room * exp(-(largest - TONE_SHOULDER) / room);
    let over = max((largest - 1.0) / 3.0, 0.0);
    let white = 1.0 - 1.0 / (1.0 + over * over);
    let kept = rgb * (shown / largest);
    return kept + (shown - kept) * white;
}

fn tone_film_curve(value: f32) -> f32 {
    let power = pow(value, TONE_CONTRAST);
    let grey = pow(TONE_GREY, TONE_CONTRAST);
    let white = pow(TONE_BRIGHTEST, TONE_CONTRAST);
    let half_way = (1.0 - TONE_GREY) * grey * white / (TONE_GREY * white - grey);
    return (1.0 + half_way / white) * power / (power + half_way);
}

fn tone_cube_root(v: vec3f) -> vec3f {
    return sign(v) * pow(abs(v), vec3f(1.0 / 3.0));
}

// Oklab (Ottosson 2020): lightness, a, b.
fn tone_oklab(rgb: vec3f) -> vec3f {
    let lms = tone_cube_root(vec3f(
        dot(rgb, vec3f(0.4122214708, 0.5363325363, 0.0514459929)),
        dot(rgb, vec3f(0.2119034982, 0.6806995451, 0.1073969566)),
        dot(rgb, vec3f(0.0883024619, 0.2817188376, 0.6299787005)),
    ));
    return vec3f(
        dot(lms, vec3f(0.2104542553, 0.7936177850, -0.0040720468)),
        dot(lms, vec3f(1.9779984951, -2.4285922050, 0.4505937099)),
        dot(lms, vec3f(0.0259040371, 0.7827717662, -0.8086757660)),
    );
}

fn tone_from_oklab(lab: vec3f) -> vec3f {
    let root = vec3f(
        lab.x + 0.3963377774 * lab.y + 0.2158037573 * lab.z,
        lab.x - 0.1055613458 * lab.y - 0.0638541728 * lab.z,
        lab.x - 0.0894841775 * lab.y - 1.2914855480 * lab.z,
    );
    let lms = root * root * root;
    return vec3f(
        dot(lms, vec3f(4.0767416621, -3.3077115913, 0.2309699292)),
        dot(lms, vec3f(-1.2684380046, 2.6097574011, -0.3413193965)),
        dot(lms, vec3f(-0.0041960863, -0.7034186147, 1.7076147010)),
    );
}

// A colour with a share of its chroma, its lightness on the way to that of the grey.
fn tone_faded(lab: vec3f, grey: f32, chroma: f32) -> vec3f {
    return tone_from_oklab(vec3f(grey + (lab.x - grey) * chroma, lab.yz * chroma));
}

fn tone_fits(rgb: vec3f) -> bool {
    return all(rgb >= vec3f(0.0)) && all(rgb <= vec3f(1.0));
}

fn tone_film(rgb: vec3f) -> vec3f {
    let largest = tone_largest(rgb);
    if largest <= 0.0 {
        return vec3f(0.0);
    }
    let bright = tone_film_curve(min(largest, TONE_BRIGHTEST));
    if all(rgb == vec3f(largest)) {
        return vec3f(bright);
    }
    let lab = tone_oklab(rgb * (bright / largest));
    let white = largest * largest / (largest * largest + TONE_HALF_WHITE * TONE_HALF_WHITE);
    let grey = pow(bright, 1.0 / 3.0);
    let wished = tone_faded(lab, grey, 1.0 - white);
    if tone_fits(wished) {
        return wished;
    }
    var low = 0.0;
    var high = 1.0 - white;
    for (var k = 0; k < 12; k++) {
        let middle = 0.5 * (low + high);
        if tone_fits(tone_faded(lab, grey, middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return clamp(tone_faded(lab, grey, low), vec3f(0.0), vec3f(1.0));
}

// Linear sRGB after exposure as a screen shows it, still linear.
fn tone_shown(rgb: vec3f, is_film: bool) -> vec3f {
    let inside = tone_into_gamut(rgb);
    if is_film {
        return tone_film(inside);
    }
    return tone_plain(inside);
}

// The sRGB transfer curve (IEC 61966-2-1).
fn tone_encoded(shown: vec3f) -> vec3f {
    let v = clamp(shown, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(v, vec3f(1.0 / 2.4)) - 0.055, 12.92 * v, v <= vec3f(0.0031308));
}
