//! Where the projector's light falls, and how much of it comes back.

use super::{BOX, frame, grid, mean, plain_room};
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Pattern, Raster, RasterSize, Rgb},
    simulation::{Room, Space},
    stage::Stage,
};

#[test]
fn edges_of_rendered_lines_lie_where_the_geometry_puts_them() {
    let lens = "distortion = [-0.06, 0.02, 0.0, 0.0, 0.0]\nblur_px = 0.6";
    let scene = plain_room(lens, "blur_px = 0.7", "");
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let grid = grid(6);
    let lines = room.render(&scene.project(&Pattern::Grid(grid.clone()).raster(size)), 0);
    let white = room.render(&scene.project(&Pattern::WHITE.raster(size)), 0);
    let level = |x: u32, y: u32| {
        f64::from(lines.get_pixel(x, y).0[1]) / f64::from(white.get_pixel(x, y).0[1])
    };
    let between_rows = |y: f64| {
        let nearest = |k| (y - grid.line(Axis::Row, k, size).nominal_centre_px).abs();
        (0..15).all(|k| nearest(k) > 7.0)
    };
    let mut errors = Vec::new();
    for y in 20..220 {
        for x in 20..300 {
            let (here, next) = (level(x, y), level(x + 1, y));
            if (here < 0.5) == (next < 0.5) {
                continue;
            }
            let edge = f64::from(x) + 0.5 + (0.5 - here) / (next - here);
            let at = CameraPixel::new(edge, f64::from(y) + 0.5);
            let projector = room.projector_at(at).unwrap();
            if !between_rows(projector.y) {
                continue;
            }
            let spans = (0..15).map(|k| grid.line(Axis::Column, k, size));
            let edges = spans.flat_map(|span| [(span.low_px(), -1.0), (span.high_px(), 1.0)]);
            let (true_edge, outward) = edges
                .min_by(|a, b| {
                    (a.0 - projector.x)
                        .abs()
                        .total_cmp(&(b.0 - projector.x).abs())
                })
                .unwrap();
            // 640 px against 345 px of focal length, 1120 mm against 1000: a camera px is about 1.65 projector px
            errors.push(((projector.x - true_edge) / 1.65, outward));
        }
    }
    let count = errors.len() as f64;
    let bias = errors.iter().map(|(e, _)| e).sum::<f64>() / count;
    let widening = errors.iter().map(|(e, outward)| e * outward).sum::<f64>() / count;
    let rms = (errors.iter().map(|(e, _)| e * e).sum::<f64>() / count).sqrt();
    assert!(count > 2000.0, "{count} edges");
    assert!(bias.abs() < 0.02, "shift {bias} px");
    assert!(widening.abs() < 0.02, "widening {widening} px");
    assert!(rms < 0.06, "rms {rms} px");
}

#[test]
fn black_is_the_black_level_of_white() {
    let scene = plain_room("", "black_level = 0.1", "");
    let white = mean(
        &frame(&scene, Stage::Background, &Pattern::WHITE),
        0,
        140..180,
        100..140,
    );
    let black = mean(
        &frame(&scene, Stage::Background, &Pattern::BLACK),
        0,
        140..180,
        100..140,
    );
    assert!(
        (180.0..215.0).contains(&white),
        "white is {white}, 0.8 of 255 expected"
    );
    assert!(
        (black / white - 0.1).abs() < 0.005,
        "ratio {}",
        black / white
    );
}

#[test]
fn light_falls_off_with_the_square_of_the_distance() {
    let near = plain_room("", "", BOX);
    let on_wall = mean(
        &frame(&near, Stage::Background, &Pattern::WHITE),
        0,
        155..165,
        115..125,
    );
    let on_box = mean(
        &frame(&near, Stage::Object, &Pattern::WHITE),
        0,
        155..165,
        115..125,
    );
    // the projector is 1100 mm before the wall and 900 mm before the front of the box, 228 mm off the axis
    let arriving = |depth: f64| depth / (depth * depth + 228.0 * 228.0_f64).powf(1.5);
    // the box gives back 0.503 of the light, byte 0xbc of the sRGB curve
    let expected = 0.503 * arriving(900.0) / arriving(1100.0);
    assert!(
        (on_box / on_wall / expected - 1.0).abs() < 0.02,
        "{on_box} / {on_wall}"
    );
}

#[test]
fn ambient_light_is_its_share_of_white_in_its_colour() {
    let ambient = "[ambient]\nlevel = 0.25\ncolour = \"#ff8000\"";
    let scene = plain_room("", "", ambient);
    let dark = frame(&scene, Stage::Background, &Pattern::BLACK);
    let [red, green, blue] = [0, 1, 2].map(|c| mean(&dark, c, 100..200, 80..160));
    assert!((red - 0.25 * 0.8 * 255.0).abs() < 1.0, "red {red}");
    // byte 0x80 of the sRGB curve is 21.6 % of the light
    assert!((green / red - 0.216).abs() < 0.02, "green {green}");
    assert_eq!(blue, 0.0);
}

#[test]
fn the_object_throws_a_shadow_on_the_side_away_from_the_projector() {
    let scene = plain_room("", "", BOX);
    let before = frame(&scene, Stage::Background, &Pattern::WHITE);
    let after = frame(&scene, Stage::Object, &Pattern::WHITE);
    let room = Space::new(&scene, Stage::Object);
    // the box ends 43 px left of the axis at its front; the light comes from the upper right
    let (x, y) = (110, 130);
    assert!(before.get_pixel(x, y).0[0] > 100);
    assert_eq!(after.get_pixel(x, y).0[0], 0);
    let at = CameraPixel::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    assert!(
        room.point_at(at).unwrap().z > 990.0,
        "the camera sees the wall there"
    );
    assert_eq!(room.projector_at(at), None);
    let right = after.get_pixel(220, 110).0[0];
    assert_eq!(
        right,
        before.get_pixel(220, 110).0[0],
        "no shadow on the other side"
    );
}

#[test]
fn a_glossy_surface_has_a_highlight_where_it_mirrors_the_projector() {
    let ball = |gloss: f64| {
        format!(
            "[[solids]]\nname = \"ball\"\nposition_mm = [0.0, 0.0, 800.0]\nsphere = {{ radius_mm = 100.0 }}\n\
             surface = {{ colour = \"#404040\", gloss = {gloss} }}\n"
        )
    };
    let brightest = |gloss: f64| {
        let picture = frame(
            &plain_room("", "", &ball(gloss)),
            Stage::Background,
            &Pattern::WHITE,
        );
        let on_ball = |x: &u32, y: &u32| (*x as f64 - 161.0).hypot(*y as f64 - 118.0) < 35.0;
        let pixels = picture.enumerate_pixels().filter(|(x, y, _)| on_ball(x, y));
        pixels
            .max_by_key(|(_, _, p)| p.0[0])
            .map(|(x, y, p)| (x, y, p.0[0]))
            .unwrap()
    };
    let (x, y, level) = brightest(0.1);
    assert!(level > 2 * brightest(0.0).2, "highlight {level}");
    assert!(
        x > 161 && y < 118,
        "the projector is to the upper right, the highlight at ({x}, {y})"
    );
}

#[test]
fn colours_that_do_not_converge_are_displaced_by_the_given_amount() {
    let apart = "convergence_px = [[0.75, 0.0], [0.0, 0.0], [-0.75, 0.0]]";
    let scene = plain_room("", apart, "");
    let size = scene.projector_size();
    let half = Raster::from_fn(size, |x, _| if x < 256 { Rgb::WHITE } else { Rgb::BLACK });
    let room = Room::new(&scene, Stage::Background);
    let picture = room.render(&scene.project(&half), 0);
    // total light along one row, in projector px: the position of the edge up to a constant
    let lit = |channel: usize| {
        let row = (60..260).map(|x| f64::from(picture.get_pixel(x, 118).0[channel]));
        row.sum::<f64>() / mean(&picture, channel, 80..120, 118..119) * 1.65
    };
    let (red, green, blue) = (lit(0), lit(1), lit(2));
    assert!(
        (red - green - 0.75).abs() < 0.15,
        "red is {} px further",
        red - green
    );
    assert!(
        (blue - green + 0.75).abs() < 0.15,
        "blue is {} px further",
        blue - green
    );
}

#[test]
fn a_picture_of_another_size_fills_the_same_raster() {
    let scene = plain_room("", "", "");
    let size = scene.projector_size();
    let half = |width: u32, height: u32| {
        let size = RasterSize { width, height };
        Raster::from_fn(size, |x, _| {
            if x < width / 2 {
                Rgb::WHITE
            } else {
                Rgb::BLACK
            }
        })
    };
    let room = Room::new(&scene, Stage::Background);
    let native = room.render(&scene.project(&half(size.width, size.height)), 0);
    for (width, height) in [(256, 192), (1024, 600), (640, 480)] {
        let stretched = room.render(&scene.project(&half(width, height)), 0);
        let pairs = native.as_raw().iter().zip(stretched.as_raw());
        let worst = pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(worst <= 1, "{width} x {height} differs by {worst}");
    }
}

#[test]
fn a_power_curve_gives_the_root_of_the_light_and_a_contrast_curve_darkens_shadows() {
    let middle = |curve: &str| {
        let camera = format!("tone_curve = {curve}");
        let scene = plain_room(&camera, "", "");
        mean(
            &frame(&scene, Stage::Background, &Pattern::WHITE),
            0,
            140..180,
            100..140,
        ) / 255.0
    };
    let light = middle("\"linear\"");
    let root = middle("{ power = 2.0 }");
    assert!((root - light.sqrt()).abs() < 0.005, "{root}, {light}");
    let (plain, steep) = (middle("\"srgb\""), middle("{ contrast = 0.8 }"));
    let expected = plain - 0.8 * (std::f64::consts::TAU * plain).sin() / std::f64::consts::TAU;
    assert!((steep - expected).abs() < 0.005, "{steep}, {expected}");
}
