//! Trees of plugins, as Mitsuba has them: as XML, and as JSON that Python turns into a dictionary.

use std::fmt::Write as _;

use serde_json::{Map, Value as Json, json};

/// What a plugin is to Mitsuba.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Class {
    Scene,
    Integrator,
    Sensor,
    Film,
    Filter,
    Sampler,
    Shape,
    Emitter,
    Bsdf,
    Spectrum,
    Texture,
    /// One that stands elsewhere.
    Reference,
}

impl Class {
    fn tag(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Integrator => "integrator",
            Self::Sensor => "sensor",
            Self::Film => "film",
            Self::Filter => "rfilter",
            Self::Sampler => "sampler",
            Self::Shape => "shape",
            Self::Emitter => "emitter",
            Self::Bsdf => "bsdf",
            Self::Spectrum => "spectrum",
            Self::Texture => "texture",
            Self::Reference => "ref",
        }
    }
}

/// A parameter's value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Flag(bool),
    Whole(u64),
    Number(f64),
    Text(String),
    /// A file of the scene's folder.
    File(String),
    Point([f64; 3]),
    /// A transformation, row by row.
    Matrix([[f64; 4]; 4]),
}

/// A plugin with its parameters and those within it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plugin {
    class: Class,
    kind: &'static str,
    values: Vec<(&'static str, Value)>,
    parts: Vec<(String, Self)>,
}

impl Plugin {
    pub(super) fn new(class: Class, kind: &'static str) -> Self {
        Self { class, kind, values: Vec::new(), parts: Vec::new() }
    }

    /// The plugin of this name at the scene's top.
    pub(super) fn reference(name: &str) -> Self {
        Self::new(Class::Reference, "ref").with("id", Value::Text(name.to_owned()))
    }

    pub(super) fn with(mut self, name: &'static str, value: Value) -> Self {
        self.values.push((name, value));
        self
    }

    pub(super) fn number(self, name: &'static str, value: f64) -> Self {
        self.with(name, Value::Number(value))
    }

    pub(super) fn holding(mut self, name: impl Into<String>, part: Self) -> Self {
        self.parts.push((name.into(), part));
        self
    }

    /// As Mitsuba's dictionaries, where `{"file": …}` is a file and `{"matrix": …}` a transformation.
    pub(super) fn json(&self) -> Json {
        let mut all = Map::new();
        all.insert("type".to_owned(), self.kind.into());
        for (name, value) in &self.values {
            let value = match value {
                Value::Flag(flag) => json!(flag),
                Value::Whole(number) => json!(number),
                Value::Number(number) => json!(number),
                Value::Text(text) => json!(text),
                Value::File(name) => json!({ "file": name }),
                Value::Point(at) => json!(at),
                Value::Matrix(rows) => json!({ "matrix": rows }),
            };
            all.insert((*name).to_owned(), value);
        }
        all.extend(self.parts.iter().map(|(name, part)| (name.clone(), part.json())));
        Json::Object(all)
    }

    /// As a Mitsuba scene file, whose files lie in `folder`.
    pub(super) fn xml(&self, folder: &str) -> String {
        let mut text = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<scene version=\"3.9.1\">\n".to_owned();
        self.write_inside(&mut text, folder, 1);
        text.push_str("</scene>\n");
        text
    }

    fn write(&self, name: &str, text: &mut String, folder: &str, depth: usize) {
        // Writing to a String cannot fail.
        let (indent, tag) = ("    ".repeat(depth), self.class.tag());
        if self.class == Class::Reference {
            let id = self.values.iter().find_map(|(_, value)| match value {
                Value::Text(id) => Some(id.as_str()),
                _ => None,
            });
            let _ = writeln!(text, "{indent}<ref id=\"{}\"/>", escaped(id.unwrap_or_default()));
            return;
        }
        let label = if depth == 1 { "id" } else { "name" };
        let _ = writeln!(text, "{indent}<{tag} type=\"{}\" {label}=\"{}\">", self.kind, escaped(name));
        self.write_inside(text, folder, depth + 1);
        let _ = writeln!(text, "{indent}</{tag}>");
    }

    fn write_inside(&self, text: &mut String, folder: &str, depth: usize) {
        let indent = "    ".repeat(depth);
        for (name, value) in &self.values {
            let plain =
                |tag: &str, value: &str| format!("<{tag} name=\"{name}\" value=\"{}\"/>", escaped(value));
            let line = match value {
                Value::Flag(flag) => plain("boolean", if *flag { "true" } else { "false" }),
                Value::Whole(number) => plain("integer", &number.to_string()),
                Value::Number(number) => plain("float", &number.to_string()),
                Value::Text(text) => plain("string", text),
                Value::File(file) => plain("string", &format!("{folder}/{file}")),
                Value::Point([x, y, z]) => format!("<point name=\"{name}\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>"),
                Value::Matrix(rows) => {
                    let numbers: Vec<_> = rows.iter().flatten().map(ToString::to_string).collect();
                    format!(
                        "<transform name=\"{name}\"><matrix value=\"{}\"/></transform>",
                        numbers.join(" ")
                    )
                }
            };
            let _ = writeln!(text, "{indent}{line}");
        }
        for (name, part) in &self.parts {
            part.write(name, text, folder, depth);
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
