//! The primitives that figures are made of. Coordinates are in px from the upper left corner, y down.

use super::text;

/// A colour and how much of it covers what lies below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    /// sRGB.
    pub rgb: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

impl Ink {
    /// Black.
    pub const BLACK: Self = Self::of([0, 0, 0]);
    /// White.
    pub const WHITE: Self = Self::of([255, 255, 255]);

    /// An opaque colour.
    #[must_use]
    pub const fn of(rgb: [u8; 3]) -> Self {
        Self { rgb, opacity: 1.0 }
    }

    /// The same colour, partly transparent.
    #[must_use]
    pub const fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// A line's look.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width in px.
    pub width: f64,
    /// Lengths of dashes and gaps in px, an even number of them; empty for a solid line.
    pub dash: Vec<f64>,
}

impl Stroke {
    /// A solid line.
    #[must_use]
    pub fn solid(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: Vec::new() }
    }
}

/// Which part of a text stands at its x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

impl Anchor {
    /// How much of a text, its font `size` px high, stands before this part of it, px.
    pub(super) fn before(self, text: &str, size: f64) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => text::width(text, size) / 2.0,
            Self::End => text::width(text, size),
        }
    }
}

/// Pixels for a drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// sRGB and opacity from the upper left corner; `width·height` of them.
    pub rgba: Vec<[u8; 4]>,
}

/// One primitive.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Lines through points: several runs in one item share their fill, whose holes follow the even-odd rule.
    Path {
        /// Runs of points (x, y).
        runs: Vec<Vec<[f64; 2]>>,
        /// Whether each run ends where it began.
        closed: bool,
        /// Fill.
        fill: Option<Ink>,
        /// Outline.
        stroke: Option<Stroke>,
    },
    /// A circle.
    Circle {
        /// Centre.
        center: [f64; 2],
        /// Radius.
        radius: f64,
        /// Fill.
        fill: Option<Ink>,
        /// Outline.
        stroke: Option<Stroke>,
    },
    /// One line of text whose baseline passes through `at`.
    Text {
        /// Where.
        at: [f64; 2],
        /// Height of the font in px.
        size: f64,
        /// The words.
        text: String,
        /// Which part stands at `at`.
        anchor: Anchor,
        /// Counterclockwise turn about `at` in degrees.
        turn: f64,
        /// Colour.
        ink: Ink,
    },
    /// Pixels stretched over a rectangle without smoothing.
    Picture {
        /// x, y, width, height.
        area: [f64; 4],
        /// The pixels.
        picture: Picture,
    },
    /// Items of which only what is inside a rectangle shows.
    Clip {
        /// x, y, width, height.
        area: [f64; 4],
        /// The items.
        items: Vec<Item>,
    },
}

/// A white page with items, the first at the bottom.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Width in px.
    pub width: f64,
    /// Height in px.
    pub height: f64,
    /// Pixels of a PNG for each px.
    pub resolution: f64,
    /// The items.
    pub items: Vec<Item>,
}

impl Drawing {
    /// An empty page.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, resolution: super::page::RESOLUTION, items: Vec::new() }
    }

    /// Adds a text.
    pub fn text(&mut self, at: [f64; 2], size: f64, anchor: Anchor, text: impl Into<String>) {
        self.items.push(Item::Text { at, size, text: text.into(), anchor, turn: 0.0, ink: Ink::BLACK });
    }

    /// Adds a line between two points.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        self.items.push(Item::Path {
            runs: vec![vec![from, to]],
            closed: false,
            fill: None,
            stroke: Some(stroke),
        });
    }

    /// Adds a rectangle x, y, width, height.
    pub fn rectangle(&mut self, area: [f64; 4], fill: Option<Ink>, stroke: Option<Stroke>) {
        let [x, y, w, h] = area;
        let runs = vec![vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]]];
        self.items.push(Item::Path { runs, closed: true, fill, stroke });
    }

    /// Puts another drawing's items at a place of this one.
    pub fn place(&mut self, other: Drawing, at: [f64; 2]) {
        self.items.extend(other.items.into_iter().map(|item| item.moved(at)));
    }
}

impl Drawing {
    /// The same, larger by a factor: lines and words too.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        if factor == 1.0 {
            return self;
        }
        self.items = self.items.into_iter().map(|item| item.mapped(factor, [0.0; 2])).collect();
        Self { width: self.width * factor, height: self.height * factor, ..self }
    }
}

impl Item {
    fn moved(self, by: [f64; 2]) -> Self {
        self.mapped(1.0, by)
    }

    /// Larger by a factor about the origin, then moved.
    fn mapped(self, factor: f64, by: [f64; 2]) -> Self {
        let at = |p: [f64; 2]| [p[0] * factor + by[0], p[1] * factor + by[1]];
        let over = |a: [f64; 4]| {
            let [x, y] = at([a[0], a[1]]);
            [x, y, a[2] * factor, a[3] * factor]
        };
        let drawn = |stroke: Option<Stroke>| {
            stroke.map(|s| Stroke {
                ink: s.ink,
                width: s.width * factor,
                dash: s.dash.into_iter().map(|d| d * factor).collect(),
            })
        };
        match self {
            Self::Path { runs, closed, fill, stroke } => {
                let runs = runs.into_iter().map(|run| run.into_iter().map(at).collect()).collect();
                Self::Path { runs, closed, fill, stroke: drawn(stroke) }
            }
            Self::Circle { center, radius, fill, stroke } => {
                Self::Circle { center: at(center), radius: radius * factor, fill, stroke: drawn(stroke) }
            }
            Self::Text { at: place, size, text, anchor, turn, ink } => {
                Self::Text { at: at(place), size: size * factor, text, anchor, turn, ink }
            }
            Self::Picture { area, picture } => Self::Picture { area: over(area), picture },
            Self::Clip { area, items } => {
                let items = items.into_iter().map(|item| item.mapped(factor, by)).collect();
                Self::Clip { area: over(area), items }
            }
        }
    }
}
