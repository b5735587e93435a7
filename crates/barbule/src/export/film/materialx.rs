//! A film as a MaterialX document with OpenPBR's surface.

use super::OneFilm;

/// The document. What made it stands in an attribute, since comments of XML may not hold the dashes of a command.
pub(super) fn encoded(film: &OneFilm, name: &str, notes: &[(&str, &str)]) -> Vec<u8> {
    let doc: Vec<String> = std::iter::once(("stack", name))
        .chain(notes.iter().copied())
        .map(|(name, text)| format!("{name}: {}", text.replace(['\n', '\r'], " ")))
        .collect();
    // An opaque base is black inside; through a clear one light goes on.
    let transmitted = if film.is_clear { 1.0 } else { 0.0 };
    let inputs: String = [
        ("base_weight", 0.0),
        ("specular_weight", 1.0),
        ("specular_roughness", 0.0),
        ("specular_ior", film.base_index),
        ("transmission_weight", transmitted),
        ("thin_film_weight", 1.0),
        ("thin_film_thickness", film.thickness_nm / 1000.0),
        ("thin_film_ior", film.index),
    ]
    .iter()
    .map(|(name, value)| format!("    <input name=\"{name}\" type=\"float\" value=\"{value}\" />\n"))
    .collect();
    format!(
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" doc=\"{}\">\n  <open_pbr_surface name=\"film\" type=\"surfaceshader\">\n{inputs}  </open_pbr_surface>\n  <surfacematerial name=\"film_material\" type=\"material\">\n    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"film\" />\n  </surfacematerial>\n</materialx>\n",
        escaped(&doc.join("; "))
    )
    .into_bytes()
}

/// Text as an attribute may hold it.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            control if control.is_control() => out.push(' '),
            other => out.push(other),
        }
    }
    out
}
