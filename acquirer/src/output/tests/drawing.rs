//! Marks over pictures, in pixels and as SVG; numbers as colours.

use image::{Rgb as Pixel, RgbImage};

use crate::output::{
    colour_map::{Scale, tick_label, ticks, viridis},
    drawing::{Anchor, Drawing, Ink, Text, simplified},
    figure::Figure,
};

const RED: Ink = Ink::solid([255, 0, 0]);

fn text(text: &str) -> Text {
    Text {
        at: [10.0, 10.0],
        text: text.to_owned(),
        size: 10.0,
        anchor: Anchor::Start,
        ink: RED,
        halo: None,
    }
}

#[test]
fn a_rectangle_covers_its_pixels_and_no_others() {
    let mut picture = RgbImage::new(20, 20);
    let mut drawing = Drawing::new(20.0, 20.0);
    drawing.rectangle([4.0, 5.0], [6.0, 3.0], RED);
    drawing.paint(&mut picture, 1.0);
    let covered = |x, y| (4..10).contains(&x) && (5..8).contains(&y);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let expected = if covered(x, y) { [255, 0, 0] } else { [0; 3] };
        assert_eq!(pixel, &Pixel(expected), "at {x}, {y}");
    }
}

#[test]
fn a_line_between_pixels_is_spread_over_both() {
    let mut picture = RgbImage::new(9, 9);
    let mut drawing = Drawing::new(9.0, 9.0);
    drawing.stroke([[0.0, 4.0], [9.0, 4.0]], 1.0, RED);
    drawing.paint(&mut picture, 1.0);
    assert_eq!(picture.get_pixel(4, 3)[0], picture.get_pixel(4, 4)[0]);
    assert!((120..=135).contains(&picture.get_pixel(4, 3)[0]));
    assert_eq!(picture.get_pixel(4, 6)[0], 0);
}

#[test]
fn wild_positions_neither_panic_nor_reach_the_svg() {
    let mut picture = RgbImage::new(30, 30);
    let mut drawing = Drawing::new(30.0, 30.0);
    for wild in [f64::NAN, f64::INFINITY, -1e300, 1e300] {
        drawing
            .stroke([[wild, 3.0], [5.0, 5.0]], 1.0, RED)
            .area([[wild, 0.0], [1.0, 1.0], [0.0, wild]], RED)
            .disc([wild, wild], 3.0, RED)
            .text(Text {
                at: [wild, 4.0],
                ..text("ä€�x")
            });
    }
    drawing.area([], RED).stroke([], 1.0, RED);
    drawing.paint(&mut picture, 2.0);
    let svg = drawing.svg("x", "");
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn letters_are_painted_where_they_stand() {
    let mut picture = RgbImage::new(60, 20);
    let mut drawing = Drawing::new(60.0, 20.0);
    drawing.text(text("12"));
    drawing.paint(&mut picture, 1.0);
    let columns: Vec<u32> = picture
        .enumerate_pixels()
        .filter(|(_, _, pixel)| pixel[0] > 0)
        .map(|(x, _, _)| x)
        .collect();
    assert!(columns.iter().all(|x| (10..26).contains(x)));
    assert!(columns.iter().any(|x| *x < 18) && columns.iter().any(|x| *x >= 18));
}

#[test]
fn text_in_svg_is_escaped_and_titled() {
    let mut drawing = Drawing::new(9.0, 9.0);
    drawing.text(text("a<b")).titled("\"&\"".into());
    let svg = drawing.svg("c", "");
    assert!(svg.contains(">a&lt;b<title>&quot;&amp;&quot;</title></text>"));
}

#[test]
fn a_simplified_line_keeps_its_corners() {
    let line: Vec<[f64; 2]> = (0..=20)
        .map(f64::from)
        .map(|k| [k, (k - 10.0).abs() + 0.01 * (k * 9.0).sin()])
        .collect();
    let short = simplified(&line, 0.1);
    assert_eq!(short.len(), 3);
    assert_eq!(short[1], line[10]);
    assert!(simplified(&[], 0.1).is_empty());
}

#[test]
fn colours_go_from_dark_blue_to_yellow_and_stay_within_the_scale() {
    let scale = Scale::covering([10.0, 20.0, f64::NAN].into_iter(), 0.0, "z / mm");
    assert_eq!(scale.colour(10.0), [0x44, 0x01, 0x54]);
    assert_eq!(scale.colour(15.0), viridis(0.5));
    assert_eq!(scale.colour(99.0), [0xfd, 0xe7, 0x25]);
    assert_eq!(scale.clone().turned().colour(20.0), scale.colour(10.0));
    let constant = Scale::covering([7.0, 7.0].into_iter(), 0.0, "");
    assert!(constant.low < 7.0 && constant.high > 7.0);
}

#[test]
fn ticks_are_round_numbers() {
    assert_eq!(ticks(0.0, 12.5, 6), [0.0, 5.0, 10.0]);
    assert_eq!(ticks(728.0, 924.0, 4), [750.0, 800.0, 850.0, 900.0]);
    assert!(ticks(1.0, 1.0, 5).is_empty() && ticks(f64::NAN, 1.0, 5).is_empty());
    assert_eq!(tick_label(0.5, 2.0), "0.5");
    assert_eq!(tick_label(-0.0, 100.0), "0");
}

#[test]
fn a_small_picture_is_enlarged_without_steps_and_keeps_its_ends() {
    let figure = Figure {
        picture: RgbImage::from_fn(2, 3, |x, _| Pixel([200 * x as u8; 3])),
        px_per_unit: 1.0,
        drawing: Drawing::new(2.0, 3.0),
    };
    let painted = figure.painted();
    assert_eq!(painted.dimensions(), (8, 12));
    for row in painted.rows() {
        let levels: Vec<u8> = row.map(|pixel| pixel[0]).collect();
        assert_eq!(levels, [0, 0, 25, 75, 125, 175, 200, 200]);
    }
}
