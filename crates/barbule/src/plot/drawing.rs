//! The primitives that figures are made of. Coordinates are in px from the upper left corner, y down.

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
    /// The items.
    pub items: Vec<Item>,
}

impl Drawing {
    /// An empty page.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, items: Vec::new() }
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

impl Item {
    fn moved(self, by: [f64; 2]) -> Self {
        let shift = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
        let shift_area = |a: [f64; 4]| [a[0] + by[0], a[1] + by[1], a[2], a[3]];
        match self {
            Self::Path { runs, closed, fill, stroke } => {
                let runs = runs.into_iter().map(|run| run.into_iter().map(shift).collect()).collect();
                Self::Path { runs, closed, fill, stroke }
            }
            Self::Circle { center, radius, fill, stroke } => {
                Self::Circle { center: shift(center), radius, fill, stroke }
            }
            Self::Text { at, size, text, anchor, turn, ink } => {
                Self::Text { at: shift(at), size, text, anchor, turn, ink }
            }
            Self::Picture { area, picture } => Self::Picture { area: shift_area(area), picture },
            Self::Clip { area, items } => {
                let items = items.into_iter().map(|item| item.moved(by)).collect();
                Self::Clip { area: shift_area(area), items }
            }
        }
    }
}
