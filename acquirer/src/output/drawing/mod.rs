//! Lines, marks and text over a picture, described once and drawn twice: into pixels for PNG files, and as SVG
//! for the report, where text stays crisp and marks say what they are when pointed at.
//!
//! # Conventions
//! Positions and sizes are in the units of the picture below (edge coordinates, y down), whatever size it is
//! shown at. Forms are drawn in the order in which they were added.

mod paint;

mod svg;

pub(super) use svg::escaped;

use shared::pattern::Rgb;

/// A colour with its opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    /// Colour as shown on a screen.
    pub colour: Rgb,
    /// 0 is invisible, 1 hides what is below.
    pub opacity: f64,
}

impl Ink {
    /// A colour that hides what is below.
    #[must_use]
    pub const fn solid(colour: [u8; 3]) -> Self {
        Self {
            colour: Rgb(colour),
            opacity: 1.0,
        }
    }

    /// The same colour with another opacity.
    #[must_use]
    pub const fn faded(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// Which part of a text stands at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text is centred there.
    Middle,
    /// The text ends there.
    End,
}

/// A text in one line.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Where it stands: the middle of its height, and along it as the anchor says.
    pub at: [f64; 2],
    /// What it says.
    pub text: String,
    /// Height of a line of text.
    pub size: f64,
    /// Which part of it stands at the position.
    pub anchor: Anchor,
    /// Its colour.
    pub ink: Ink,
    /// A rim around the letters that keeps them readable on any picture.
    pub halo: Option<Ink>,
}

/// What can be drawn.
#[derive(Debug, Clone, PartialEq)]
enum Form {
    Stroke {
        points: Vec<[f64; 2]>,
        width: f64,
        ink: Ink,
    },
    /// A convex polygon.
    Area {
        points: Vec<[f64; 2]>,
        ink: Ink,
    },
    Disc {
        centre: [f64; 2],
        radius: f64,
        ink: Ink,
    },
    Text(Text),
}

/// A form and what it says when it is pointed at.
#[derive(Debug, Clone, PartialEq)]
struct Mark {
    form: Form,
    title: Option<String>,
}

/// Forms over a picture of a given size.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    size: [f64; 2],
    marks: Vec<Mark>,
}

impl Drawing {
    /// An empty drawing over a picture of `width` x `height` units.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self {
            size: [width, height],
            marks: Vec::new(),
        }
    }

    /// Width and height in units.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        self.size
    }

    /// Adds a line through points.
    pub fn stroke(&mut self, points: impl Into<Vec<[f64; 2]>>, width: f64, ink: Ink) -> &mut Self {
        self.add(Form::Stroke {
            points: points.into(),
            width,
            ink,
        })
    }

    /// Adds a filled convex polygon.
    pub fn area(&mut self, points: impl Into<Vec<[f64; 2]>>, ink: Ink) -> &mut Self {
        self.add(Form::Area {
            points: points.into(),
            ink,
        })
    }

    /// Adds a filled rectangle from its upper left corner, width and height.
    pub fn rectangle(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], ink: Ink) -> &mut Self {
        self.area([[x, y], [x + w, y], [x + w, y + h], [x, y + h]], ink)
    }

    /// Adds a filled circle.
    pub fn disc(&mut self, centre: [f64; 2], radius: f64, ink: Ink) -> &mut Self {
        self.add(Form::Disc {
            centre,
            radius,
            ink,
        })
    }

    /// Adds a cross of two diagonal lines, each reaching `reach` from the centre in x and y.
    pub fn cross(&mut self, [x, y]: [f64; 2], reach: f64, width: f64, ink: Ink) -> &mut Self {
        let r = reach;
        self.stroke([[x - r, y - r], [x + r, y + r]], width, ink)
            .stroke([[x - r, y + r], [x + r, y - r]], width, ink)
    }

    /// Adds a text.
    pub fn text(&mut self, text: Text) -> &mut Self {
        self.add(Form::Text(text))
    }

    /// Says what the last form is when it is pointed at (in SVG only).
    pub fn titled(&mut self, title: String) -> &mut Self {
        if let Some(mark) = self.marks.last_mut() {
            mark.title = Some(title);
        }
        self
    }

    /// Adds all forms of another drawing, moved by an offset.
    pub fn place(&mut self, other: &Self, offset: [f64; 2]) -> &mut Self {
        let moved = |[x, y]: [f64; 2]| [x + offset[0], y + offset[1]];
        let all = |points: &[[f64; 2]]| points.iter().copied().map(moved).collect();
        for mark in &other.marks {
            let mut mark = mark.clone();
            match &mut mark.form {
                Form::Stroke { points, .. } | Form::Area { points, .. } => *points = all(points),
                Form::Disc { centre, .. } => *centre = moved(*centre),
                Form::Text(text) => text.at = moved(text.at),
            }
            self.marks.push(mark);
        }
        self
    }

    fn add(&mut self, form: Form) -> &mut Self {
        self.marks.push(Mark { form, title: None });
        self
    }
}

/// The same line with fewer points: none of those left out is further than `tolerance` from it.
///
/// Source: D. Douglas and T. Peucker, "Algorithms for the reduction of the number of points required to
/// represent a digitized line", 1973.
#[must_use]
pub fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let mut kept = vec![false; points.len()];
    let mut spans = Vec::new();
    if let Some(last) = points.len().checked_sub(1) {
        (kept[0], kept[last]) = (true, true);
        spans.push((0, last));
    }
    while let Some((first, last)) = spans.pop() {
        let between = (first + 1..last)
            .map(|k| {
                (
                    k,
                    distance_to_segment(points[k], points[first], points[last]),
                )
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, _)) = between.filter(|(_, distance)| *distance > tolerance) {
            kept[k] = true;
            spans.extend([(first, k), (k, last)]);
        }
    }
    let chosen = points.iter().zip(kept);
    chosen.filter_map(|(p, keep)| keep.then_some(*p)).collect()
}

/// Distance of a point from the segment between two others.
fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 {
        (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (x, y) = (p[0] - a[0] - along * dx, p[1] - a[1] - along * dy);
    (x * x + y * y).sqrt()
}
