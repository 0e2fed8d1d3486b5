//! From light to the bytes of a frame.

use image::RgbImage;

use super::{BOX, frame, grid, mean, plain_room};
use shared::{
    pattern::{Grid, Pattern, Raster, Rgb},
    simulation::Room,
    stage::Stage,
};

#[test]
fn a_frame_depends_on_its_number_and_nothing_else() {
    let noisy = "bayer = true\nfull_well_electrons = 5000.0\njpeg_quality = 85";
    let scene = plain_room(noisy, "", BOX);
    let light = scene.project(&Pattern::Grid(grid(5)).raster(scene.projector_size()));
    let room = Room::new(&scene, Stage::Object);
    let again = Room::new(&scene, Stage::Object);
    assert_eq!(room.render(&light, 7), again.render(&light, 7));
    assert_ne!(room.render(&light, 7), room.render(&light, 8));
}

#[test]
fn noise_follows_the_full_well_and_the_read_noise() {
    let scene = plain_room(
        "full_well_electrons = 1000.0\nread_noise_electrons = 10.0",
        "",
        "",
    );
    let room = Room::new(&scene, Stage::Background);
    let light = scene.project(&Pattern::WHITE.raster(scene.projector_size()));
    let frames: Vec<RgbImage> = (0..24).map(|k| room.render(&light, k)).collect();
    let (mut variance, mut signal, mut count) = (0.0, 0.0, 0.0);
    for y in 100..140 {
        for x in 140..180 {
            let values = frames
                .iter()
                .map(|f| f64::from(f.get_pixel(x, y).0[1]) / 255.0);
            let mean = values.clone().sum::<f64>() / 24.0;
            variance += values.map(|v| (v - mean).powi(2)).sum::<f64>() / 23.0;
            signal += mean;
            count += 1.0;
        }
    }
    let (variance, signal) = (variance / count, signal / count);
    let expected = signal / 1000.0 + 1e-4 + 1.0 / 12.0 / 255.0_f64.powi(2);
    assert!(
        (variance / expected - 1.0).abs() < 0.05,
        "variance {variance}, expected {expected}"
    );
}

#[test]
fn jpeg_changes_the_picture_a_little_and_colours_more_than_brightness() {
    let picture = Pattern::Grid(Grid::coded(15, 15, 5, 5, &[Rgb([255, 0, 0])]).unwrap());
    let clean = frame(&plain_room("", "", ""), Stage::Background, &picture);
    let jpeg = frame(
        &plain_room("jpeg_quality = 80", "", ""),
        Stage::Background,
        &picture,
    );
    let rms = |weights: [f64; 3]| {
        let difference = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
            let d: f64 = (0..3)
                .map(|c| weights[c] * (f64::from(a.0[c]) - f64::from(b.0[c])))
                .sum();
            d * d
        };
        let sum: f64 = clean.pixels().zip(jpeg.pixels()).map(difference).sum();
        (sum / f64::from(320 * 240)).sqrt()
    };
    let brightness = rms([0.299, 0.587, 0.114]);
    let colour = rms([0.5, -0.419, -0.081]);
    assert!(
        (0.2..10.0).contains(&brightness),
        "brightness differs by {brightness}"
    );
    assert!(
        colour > 2.0 * brightness,
        "colour differs by {colour}, brightness by {brightness}"
    );
}

#[test]
fn crosstalk_lets_other_colours_see_red_light() {
    let mixing = "crosstalk = [[1.0, 0.0, 0.0], [0.2, 1.0, 0.0], [0.05, 0.0, 1.0]]";
    let red = Pattern::Solid {
        colour: Rgb([255, 0, 0]),
    };
    let picture = frame(&plain_room(mixing, "", ""), Stage::Background, &red);
    let [r, g, b] = [0, 1, 2].map(|c| mean(&picture, c, 140..180, 100..140));
    assert!(
        (g / r - 0.2).abs() < 0.01 && (b / r - 0.05).abs() < 0.01,
        "{r} {g} {b}"
    );
}

#[test]
fn jpeg_and_bayer_mosaic_displace_no_colour() {
    let processing = "jpeg_quality = 90\nbayer = true";
    let scene = plain_room(processing, "blur_px = 1.0", "");
    let clean = plain_room("", "blur_px = 1.0", "");
    let bars = [(200..240, 0..384), (0..512, 150..190)];
    for (bar, along_x) in bars.into_iter().zip([true, false]) {
        let (x_span, y_span) = bar;
        let picture = Raster::from_fn(scene.projector_size(), |x, y| {
            let lit = x_span.contains(&x) && y_span.contains(&y);
            if lit { Rgb([255, 0, 255]) } else { Rgb::BLACK }
        });
        let [processed, ideal] = [&scene, &clean]
            .map(|scene| Room::new(scene, Stage::Background).render(&scene.project(&picture), 0));
        for channel in [0, 2] {
            let middle = |picture: &RgbImage| {
                let pixels = (60..240).flat_map(|x| (40..200).map(move |y| (x, y)));
                let (mut weight, mut sum) = (0.0, 0.0);
                for (x, y) in pixels {
                    let level = f64::from(picture.get_pixel(x, y).0[channel]);
                    weight += level;
                    sum += level * f64::from(if along_x { x } else { y });
                }
                sum / weight
            };
            let shift = middle(&processed) - middle(&ideal);
            assert!(
                shift.abs() < 0.05,
                "channel {channel}, along x {along_x}: {shift} px"
            );
        }
    }
}
