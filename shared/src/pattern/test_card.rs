//! The card to focus the projector by and to set its keystone: everything on it is drawn in whole pixels.
//!
//! | on the card | what it tells |
//! |---|---|
//! | frame on the outermost pixels | all of the raster is shown, nothing is cut off |
//! | hatch of straight lines, circles in the middle and the corners | keystone: lines parallel, circles round and of one size |
//! | line pairs of 1, 2, 3 and 4 pixels, in the middle and the corners | focus, everywhere at once; grey stripes mean that something scales the picture |
//! | chequers of 1 and 2 pixels | the same in both directions |
//! | text of 8 to 32 pixels | what can be read from where |
//! | grey steps, colour bars | brightness, contrast, colour mode: all sixteen greys can be told apart |

use super::{
    Raster, RasterSize, Rgb,
    text::{GLYPH_PX, Text, text_width},
};

const FIELD: Rgb = Rgb::BLACK;
const HATCH: Rgb = Rgb([72; 3]);
const LINE: Rgb = Rgb::WHITE;
const COLOURS: [[u8; 3]; 8] = [
    [255, 0, 0],
    [255, 255, 0],
    [0, 255, 0],
    [0, 255, 255],
    [0, 0, 255],
    [255, 0, 255],
    [255, 255, 255],
    [0, 0, 0],
];
/// Number of grey steps, black and white among them.
const GREYS: i32 = 16;

/// Draws the card.
pub(super) fn raster(size: RasterSize) -> Raster {
    let mut card = Card::new(size);
    card.hatch();
    card.circles();
    card.corner_pairs();
    card.middle();
    card.texts();
    card.frame();
    card.finish()
}

/// A rectangle in pixels: upper left corner, width, height.
#[derive(Clone, Copy)]
struct Area {
    x: i32,
    y: i32,
    width: i32,
    height: i32,
}

/// The picture while it is drawn. Whatever lies outside it is left out.
struct Card {
    size: RasterSize,
    width: i32,
    height: i32,
    /// The shorter side: what all lengths on the card are fractions of.
    side: i32,
    pixels: Vec<Rgb>,
}

impl Card {
    fn new(size: RasterSize) -> Self {
        let (width, height) = (size.width as i32, size.height as i32);
        Self {
            size,
            width,
            height,
            side: width.min(height),
            pixels: vec![FIELD; size.pixels()],
        }
    }

    fn finish(self) -> Raster {
        let stride = self.size.width as usize;
        Raster::from_fn(self.size, |x, y| {
            self.pixels[y as usize * stride + x as usize]
        })
    }

    fn set(&mut self, x: i32, y: i32, colour: Rgb) {
        if (0..self.width).contains(&x) && (0..self.height).contains(&y) {
            self.pixels[y as usize * self.size.width as usize + x as usize] = colour;
        }
    }

    fn fill(&mut self, area: Area, colour: impl Fn(i32, i32) -> Rgb) {
        for y in 0..area.height {
            for x in 0..area.width {
                self.set(area.x + x, area.y + y, colour(x, y));
            }
        }
    }

    fn upright(&mut self, x: i32, colour: Rgb) {
        let (width, height) = (1, self.height);
        self.fill(
            Area {
                x,
                y: 0,
                width,
                height,
            },
            |_, _| colour,
        );
    }

    fn level(&mut self, y: i32, colour: Rgb) {
        let (width, height) = (self.width, 1);
        self.fill(
            Area {
                x: 0,
                y,
                width,
                height,
            },
            |_, _| colour,
        );
    }

    /// Square meshes around the middle; the middle lines are white, and two pixels wide where the middle lies
    /// between two pixels.
    fn hatch(&mut self) {
        let mesh = (self.side / 12).max(4);
        let (right, low) = (self.width / 2, self.height / 2);
        let (left, high) = ((self.width - 1) / 2, (self.height - 1) / 2);
        for k in 1..=self.width / mesh {
            self.upright(left - k * mesh, HATCH);
            self.upright(right + k * mesh, HATCH);
        }
        for k in 1..=self.height / mesh {
            self.level(high - k * mesh, HATCH);
            self.level(low + k * mesh, HATCH);
        }
        for x in [left, right] {
            self.upright(x, LINE);
        }
        for y in [high, low] {
            self.level(y, LINE);
        }
    }

    fn circles(&mut self) {
        let (middle_x, middle_y) = (f64::from(self.width) / 2.0, f64::from(self.height) / 2.0);
        self.circle(middle_x, middle_y, f64::from(self.side) * 0.46);
        let radius = self.corner_radius();
        for (x, y) in self.corners() {
            self.circle(x, y, radius);
        }
    }

    fn corner_radius(&self) -> f64 {
        f64::from(self.side) / 8.0
    }

    /// The middles of the corner circles, which nearly touch the frame.
    fn corners(&self) -> [(f64, f64); 4] {
        let inset = self.corner_radius() + 3.0;
        let (right, low) = (
            f64::from(self.width) - inset,
            f64::from(self.height) - inset,
        );
        [(inset, inset), (right, inset), (right, low), (inset, low)]
    }

    /// A ring about one and a half pixels wide around a point in edge coordinates.
    fn circle(&mut self, x: f64, y: f64, radius: f64) {
        let reach = radius.ceil() as i32 + 1;
        for py in y as i32 - reach..=y as i32 + reach {
            for px in x as i32 - reach..=x as i32 + reach {
                let distance = (f64::from(px) + 0.5 - x).hypot(f64::from(py) + 0.5 - y);
                if (distance - radius).abs() < 0.75 {
                    self.set(px, py, LINE);
                }
            }
        }
    }

    fn corner_pairs(&mut self) {
        let square = (self.side / 20).max(4);
        for (x, y) in self.corners() {
            let (x, y) = (x.round() as i32 - 2 * square, y.round() as i32);
            self.pairs(x, y - square, square, Direction::Upright);
            self.pairs(x, y, square, Direction::Level);
        }
    }

    /// Four squares side by side with line pairs of 1, 2, 3 and 4 pixels.
    fn pairs(&mut self, x: i32, y: i32, square: i32, direction: Direction) {
        for width_px in 1..=4 {
            let (x, width, height) = (x + (width_px - 1) * square, square - 2, square - 2);
            let stripe = |along: i32| {
                if along / width_px % 2 == 0 {
                    LINE
                } else {
                    FIELD
                }
            };
            self.fill(
                Area {
                    x,
                    y,
                    width,
                    height,
                },
                |dx, dy| match direction {
                    Direction::Upright => stripe(dx),
                    Direction::Level => stripe(dy),
                },
            );
        }
    }

    /// Line pairs and chequers around the centre cross, bars below.
    fn middle(&mut self) {
        let (x, y) = (self.width / 2, self.height / 2);
        let square = (self.side / 12).max(4);
        let gap = (square / 8).max(2);
        self.pairs(x - 2 * square, y - gap - square, square, Direction::Upright);
        self.pairs(x - 2 * square, y + gap, square, Direction::Level);
        for (side, chequer_px) in [(-1, 1), (1, 2)] {
            let area = Area {
                x: x + side * square * 7 / 2 - square / 2,
                y: y - square / 2,
                width: square,
                height: square,
            };
            self.fill(area, |dx, dy| {
                if (dx / chequer_px + dy / chequer_px) % 2 == 0 {
                    LINE
                } else {
                    FIELD
                }
            });
        }
        self.bars(y + gap + square * 3 / 2, square);
    }

    /// Sixteen greys, and under them the pure colours.
    fn bars(&mut self, y: i32, square: i32) {
        let step = (square * 6 / GREYS).max(1);
        let (x, width, height) = (self.width / 2 - step * GREYS / 2, step * GREYS, square / 2);
        self.fill(
            Area {
                x,
                y,
                width,
                height,
            },
            |dx, _| Rgb([(dx / step * 255 / (GREYS - 1)) as u8; 3]),
        );
        let wide = (width / COLOURS.len() as i32).max(1);
        self.fill(
            Area {
                x,
                y: y + height,
                width,
                height,
            },
            |dx, _| Rgb(COLOURS[(dx / wide) as usize % COLOURS.len()]),
        );
        let outline = Area {
            x: x - 1,
            y: y - 1,
            width: width + 2,
            height: 2 * height + 2,
        };
        self.outline(outline, HATCH);
    }

    /// Lines of text from small to large above the middle, the size of the raster below the bars.
    fn texts(&mut self) {
        let square = (self.side / 12).max(4);
        let room = (self.side * 3 / 5) as u32;
        let mut y = self.height / 2 - square * 5 / 4;
        for scale in 1..=4 {
            let text = format!("{} px: sharp?", GLYPH_PX * scale);
            let height = (GLYPH_PX * scale) as i32;
            y -= height + height / 2;
            if text_width(&text, scale) <= room && y > self.height / 2 - self.side * 2 / 5 {
                self.text(&text, y, scale);
            }
        }
        let scale = (self.side as u32 / 300).max(1);
        self.text(&self.size.to_string(), self.height / 2 + square * 3, scale);
    }

    /// A line of text on a black ground, in the middle of the width.
    fn text(&mut self, text: &str, y: i32, scale: u32) {
        let (width, height) = (text_width(text, scale), GLYPH_PX * scale);
        let x = (self.width - width as i32) / 2;
        let line = Text {
            text,
            x: 0,
            y: 0,
            scale,
            colour: LINE,
        };
        let pad = 2 * scale as i32;
        let ground = Area {
            x: x - pad,
            y: y - pad,
            width: width as i32 + 2 * pad,
            height: height as i32 + 2 * pad,
        };
        self.fill(ground, |_, _| FIELD);
        self.fill(
            Area {
                x,
                y,
                width: width as i32,
                height: height as i32,
            },
            |dx, dy| {
                if line.covers(dx as u32, dy as u32) {
                    line.colour
                } else {
                    FIELD
                }
            },
        );
    }

    fn frame(&mut self) {
        let (width, height) = (self.width, self.height);
        self.outline(
            Area {
                x: 0,
                y: 0,
                width,
                height,
            },
            LINE,
        );
    }

    fn outline(&mut self, area: Area, colour: Rgb) {
        let Area {
            x,
            y,
            width,
            height,
        } = area;
        for (x, y, width, height) in [
            (x, y, width, 1),
            (x, y + height - 1, width, 1),
            (x, y, 1, height),
            (x + width - 1, y, 1, height),
        ] {
            self.fill(
                Area {
                    x,
                    y,
                    width,
                    height,
                },
                |_, _| colour,
            );
        }
    }
}

/// Which way the lines of a pair run.
#[derive(Clone, Copy)]
enum Direction {
    Upright,
    Level,
}
