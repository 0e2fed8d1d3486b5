//! A picture of each step, as the thesis's figures 5.5 to 5.8 show them.

use image::RgbImage;
use shared::pattern::Rgb;

use super::{
    background::Foreground, corners::Crossing, edges::EdgeMap, lines::Links, reconstruct::Label,
    threshold::ColourMap,
};
use crate::{StagePicture, grid::DropReason};

/// Drawn where something was recovered but has no colour.
const NO_COLOUR: [u8; 3] = [110, 110, 110];
/// A vertex that is part of the grid.
const IDENTIFIED: [u8; 3] = [255, 255, 255];
/// A vertex that was deleted.
const DELETED: [u8; 3] = [120, 120, 120];

/// The products of the steps.
pub(super) struct Steps<'a> {
    /// `None` without black frames.
    pub foreground: Option<&'a Foreground>,
    pub colours: &'a ColourMap,
    /// The projected colours, to draw with.
    pub palette: &'a [Rgb],
    pub edges: &'a EdgeMap,
    pub crossings: &'a [Crossing],
    pub links: &'a Links,
    pub labels: &'a [Result<Label, DropReason>],
}

impl Steps<'_> {
    /// The pictures in reading order.
    pub(super) fn pictures(&self, size: (u32, u32)) -> Vec<StagePicture> {
        let picture = |name, caption: &str, picture| StagePicture {
            name,
            caption: caption.to_owned(),
            picture,
        };
        let mut pictures = Vec::new();
        if let Some(foreground) = self.foreground {
            pictures.push(picture(
                "thesis_background",
                "Difference of hue from the background, bright where it is many standard deviations; \
                 foreground that only saturation or lightness shows is dark red.",
                hue_difference(foreground, size),
            ));
        }
        pictures.push(picture(
            "thesis_threshold",
            "Pixels left by the masked threshold, each in the projected colour it was given.",
            self.recovered(size),
        ));
        pictures.push(picture(
            "thesis_edges",
            "Edge map of the Sobel operator: left and right sides of columns in red and green, upper and \
             lower sides of rows in blue and yellow.",
            self.edge_map(size),
        ));
        pictures.push(picture(
            "thesis_grid",
            "The grid reconstructed from the edges that agree with the sequence; crossings that could not \
             be identified are grey dots.",
            self.reconstructed(size),
        ));
        pictures
    }

    fn colour_of(&self, class: Option<u8>) -> [u8; 3] {
        let colour = class.and_then(|class| self.palette.get(usize::from(class)));
        colour.map_or(NO_COLOUR, |colour| colour.0)
    }

    fn recovered(&self, size: (u32, u32)) -> RgbImage {
        from_pixels(size, |at| {
            if self.colours.covered[at] {
                self.colour_of(self.colours.classes[at])
            } else {
                [0; 3]
            }
        })
    }

    fn edge_map(&self, size: (u32, u32)) -> RgbImage {
        use super::edges::Side::{Left, Lower, Right, Upper};
        from_pixels(size, |at| match self.edges.sides[at] {
            Some(Left) => [255, 60, 60],
            Some(Right) => [60, 220, 60],
            Some(Upper) => [80, 120, 255],
            Some(Lower) => [240, 220, 60],
            None => [0; 3],
        })
    }

    fn reconstructed(&self, size: (u32, u32)) -> RgbImage {
        let mut picture = RgbImage::new(size.0, size.1);
        for (links, ends) in [
            (&self.links.right, [(1, 0), (2, 3)]),
            (&self.links.down, [(3, 0), (2, 1)]),
        ] {
            for (from, link) in links.iter().enumerate() {
                let Some(link) = link else { continue };
                for (leaves, arrives) in ends {
                    let a = self.crossings[from].corners[leaves];
                    let b = self.crossings[link.to].corners[arrives];
                    draw_line(&mut picture, a, b, self.colour_of(link.colour));
                }
            }
        }
        for (crossing, label) in self.crossings.iter().zip(self.labels) {
            let colour = if label.is_ok() { IDENTIFIED } else { DELETED };
            for corner in crossing.corners {
                draw_pixel(&mut picture, corner, colour);
            }
        }
        picture
    }
}

fn hue_difference(foreground: &Foreground, size: (u32, u32)) -> RgbImage {
    from_pixels(size, |at| {
        let level = (foreground.hue_sigmas[at] * 255.0 / 20.0) as u8;
        if foreground.mask[at] {
            [level.max(130), level, level]
        } else {
            [level / 3; 3]
        }
    })
}

fn from_pixels(size: (u32, u32), colour: impl Fn(usize) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(size.0, size.1, |x, y| {
        image::Rgb(colour(y as usize * size.0 as usize + x as usize))
    })
}

fn draw_line(picture: &mut RgbImage, a: [i32; 2], b: [i32; 2], colour: [u8; 3]) {
    let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).max(1);
    for step in 0..=steps {
        draw_pixel(
            picture,
            [0, 1].map(|c| a[c] + (b[c] - a[c]) * step / steps),
            colour,
        );
    }
}

fn draw_pixel(picture: &mut RgbImage, [x, y]: [i32; 2], colour: [u8; 3]) {
    let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
        return;
    };
    if let Some(pixel) = picture.get_pixel_mut_checked(x, y) {
        *pixel = image::Rgb(colour);
    }
}
