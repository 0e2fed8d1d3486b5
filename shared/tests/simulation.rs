//! The simulated room through its public interface: where light falls, how much of it, when, and what is refused.

use std::{path::Path, time::Duration};

use image::RgbImage;
use proptest::prelude::*;
use shared::{
    geometry::CameraPixel,
    pattern::{Axis, Corner, Grid, Pattern, Raster, Rgb},
    simulation::{Room, Scene, Timeline, write_truth_csv},
    stage::Stage,
};

/// A white wall a metre away, seen by an ideal camera and lit by an ideal projector, and room for changes.
fn plain_room(camera: &str, projector: &str, rest: &str) -> Scene {
    let text = format!(
        r##"
        title = "test"
        [camera]
        width = 320
        height = 240
        focal_px = [345.0, 345.0]
        centre_px = [161.3, 118.4]
        position_mm = [0.0, 0.0, 0.0]
        looks_at_mm = [0.0, 0.0, 1000.0]
        tone_curve = "linear"
        exposure = 0.8
        {camera}
        [projector]
        width = 512
        height = 384
        focal_px = [640.0, 640.0]
        centre_px = [256.0, 192.0]
        position_mm = [180.0, -140.0, -100.0]
        looks_at_mm = [0.0, 0.0, 1000.0]
        {projector}
        [[solids]]
        name = "wall"
        position_mm = [0.0, 0.0, 1000.0]
        plane = {{ size_mm = [4000.0, 4000.0] }}
        surface = {{ colour = "#ffffff" }}
        {rest}
        "##
    );
    Scene::parse(&text, Path::new(".")).unwrap()
}

const BOX: &str = r##"
    [[solids]]
    name = "box"
    when = "object"
    position_mm = [0.0, 0.0, 900.0]
    box = { size_mm = [200.0, 200.0, 200.0] }
    surface = { colour = "#bcbcbc" }
"##;

fn grid(width_px: u32) -> Grid {
    Grid::coded(15, 15, width_px, width_px, &[Rgb::WHITE]).unwrap()
}

fn frame(scene: &Scene, stage: Stage, picture: &Pattern) -> RgbImage {
    let light = scene.project(&picture.raster(scene.projector_size()));
    Room::new(scene, stage).render(&light, 0)
}

fn mean(
    picture: &RgbImage,
    channel: usize,
    x: std::ops::Range<u32>,
    y: std::ops::Range<u32>,
) -> f64 {
    let values = y.flat_map(|y| x.clone().map(move |x| (x, y)));
    let values: Vec<f64> = values
        .map(|(x, y)| f64::from(picture.get_pixel(x, y).0[channel]))
        .collect();
    values.iter().sum::<f64>() / values.len() as f64
}

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
    let room = Room::new(&scene, Stage::Object);
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
        let size = shared::pattern::RasterSize { width, height };
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
fn a_rolling_shutter_shows_both_pictures_in_one_frame() {
    let scene = plain_room("exposure_ms = 10.0\nreadout_ms = 20.0", "", "");
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let mut timeline = Timeline::new(&scene);
    timeline.show(Duration::from_millis(100), &Pattern::BLACK.raster(size));
    timeline.show(Duration::from_millis(115), &Pattern::WHITE.raster(size));
    let torn = room.render_at(&timeline, Duration::from_millis(100), 0);
    let white = room.render(&scene.project(&Pattern::WHITE.raster(size)), 0);
    let share = |y: u32| mean(&torn, 0, 150..170, y..y + 1) / mean(&white, 0, 150..170, y..y + 1);
    // row y gathers light from 100 + y / 12 ms on, for 10 ms
    assert!(share(40) < 0.01, "exposed before the change: {}", share(40));
    assert!(
        (share(120) - 0.5).abs() < 0.02,
        "half and half: {}",
        share(120)
    );
    assert!(
        share(200) > 0.99,
        "exposed after the change: {}",
        share(200)
    );
    assert_eq!(
        room.render_at(&timeline, Duration::from_millis(115), 0),
        white
    );
    assert_eq!(
        mean(
            &room.render_at(&timeline, Duration::ZERO, 0),
            0,
            0..320,
            0..240
        ),
        0.0
    );
}

#[test]
fn light_follows_the_command_after_the_latency_and_old_pictures_can_be_forgotten() {
    let scene = plain_room(
        "exposure_ms = 0.1",
        "display_latency_ms = 60.0\ndisplay_jitter_ms = 5.0",
        "",
    );
    let room = Room::new(&scene, Stage::Background);
    let size = scene.projector_size();
    let mut timeline = Timeline::new(&scene);
    timeline.show(Duration::from_secs(1), &Pattern::WHITE.raster(size));
    timeline.show(Duration::from_secs(2), &Pattern::BLACK.raster(size));
    let level = |timeline: &Timeline, ms: u64| {
        mean(
            &room.render_at(timeline, Duration::from_millis(ms), 0),
            0,
            150..170,
            110..130,
        )
    };
    assert_eq!(level(&timeline, 1059), 0.0);
    assert!(level(&timeline, 1066) > 150.0);
    assert!(level(&timeline, 2059) > 150.0);
    assert_eq!(level(&timeline, 2066), 0.0);
    timeline.forget_before(Duration::from_millis(1500));
    assert!(
        level(&timeline, 2000) > 150.0,
        "what is still shown is kept"
    );
    timeline.forget_before(Duration::from_secs(3));
    assert_eq!(level(&timeline, 3000), 0.0);
}

#[test]
fn truth_agrees_with_the_calibration_and_with_what_the_camera_sees() {
    let scene = plain_room(
        "distortion = [-0.1, 0.03, 0.001, 0.0, 0.0]",
        "distortion = [0.05, 0.0, 0.0, 0.0, 0.0]",
        BOX,
    );
    let (size, rig) = (scene.projector_size(), scene.calibration());
    let grid = grid(6);
    for stage in Stage::BOTH {
        let room = Room::new(&scene, stage);
        let truth = room.truth(&grid, size);
        assert!(truth.len() > 600, "{stage}: {} vertices", truth.len());
        for vertex in &truth {
            let expected = grid.vertex(vertex.index, vertex.corner, size);
            let found = rig.projector_pixel(&vertex.point_mm).unwrap();
            assert!((found.x - expected.x).hypot(found.y - expected.y) < 1e-6);
            let seen = rig.camera_pixel(&vertex.point_mm).unwrap();
            assert!((seen.x - vertex.camera.x).hypot(seen.y - vertex.camera.y) < 1e-9);
            if vertex.clear {
                let lit_by = room.projector_at(vertex.camera).unwrap();
                assert!((lit_by.x - expected.x).hypot(lit_by.y - expected.y) < 1e-6);
                assert!(
                    (12.0..25.0).contains(&vertex.pitch_px),
                    "pitch {}",
                    vertex.pitch_px
                );
            }
        }
    }
}

#[test]
fn crossings_on_an_edge_or_in_shadow_are_not_clear() {
    let scene = plain_room("", "", BOX);
    let size = scene.projector_size();
    let grid = grid(6);
    let clear = |stage| {
        let truth = Room::new(&scene, stage).truth(&grid, size);
        let clear: Vec<_> = truth.iter().filter(|v| v.clear).copied().collect();
        assert_eq!(clear.len() % 4, 0, "a clear crossing has all four vertices");
        clear
    };
    let (before, after) = (clear(Stage::Background), clear(Stage::Object));
    assert!(
        after.len() < before.len(),
        "{} / {}",
        after.len(),
        before.len()
    );
    for vertex in &after {
        let p = vertex.point_mm;
        let on_front = (p.z - 800.0).abs() < 1e-6 && p.x.abs() < 96.0 && p.y.abs() < 96.0;
        let on_wall = (p.z - 1000.0).abs() < 1e-6;
        let on_side = (p.x.abs() - 100.0).abs() < 1e-6 || (p.y.abs() - 100.0).abs() < 1e-6;
        assert!(on_front || on_wall || on_side, "clear at {p}");
    }
    assert!(after.iter().filter(|v| v.point_mm.z < 801.0).count() >= 4 * 4);
}

#[test]
fn truth_is_written_as_the_table_that_scoring_reads() {
    let scene = plain_room("", "", "");
    let truth = Room::new(&scene, Stage::Background).truth(&grid(6), scene.projector_size());
    let mut table = Vec::new();
    write_truth_csv(&truth, &mut table).unwrap();
    let table = String::from_utf8(table).unwrap();
    let mut lines = table.lines();
    let header = "stage,row,column,vertex,x_px,y_px,x_mm,y_mm,z_mm,clear,pitch_px";
    assert_eq!(lines.next(), Some(header));
    let first: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(first.len(), 11);
    assert_eq!(first[0], "background");
    assert!(Corner::ALL.iter().any(|corner| corner.name() == first[3]));
    assert_eq!(table.lines().count(), truth.len() + 1);
}

#[test]
fn nonsense_is_refused_with_the_line_and_what_to_do() {
    let cube = std::fs::read_to_string(scenes().join("cube.toml")).unwrap();
    let refused = |text: &str| Scene::parse(text, &scenes()).unwrap_err().to_string();
    let with = |from: &str, to: &str| {
        assert!(cube.contains(from), "{from}");
        refused(&cube.replacen(from, to, 1))
    };
    let line_of = |key: &str| {
        let line = cube.lines().position(|line| line.starts_with(key)).unwrap() + 1;
        format!("line {line}")
    };
    let unknown = with("\nexposure =", "\nexposrue =");
    assert!(
        unknown.contains(&line_of("exposure =")) && unknown.contains("exposrue"),
        "{unknown}"
    );
    let negative = with("jpeg_quality = 90", "jpeg_quality = 101");
    assert!(
        negative.contains(&line_of("jpeg_quality")) && negative.contains("0 to 100"),
        "{negative}"
    );
    let endless = with("frame_rate_hz = 30.0", "frame_rate_hz = nan");
    assert!(endless.contains(&line_of("frame_rate_hz")), "{endless}");
    let colour = with("colour = \"#fff1dc\"", "colour = \"warm\"");
    assert!(
        colour.contains("warm") && colour.contains("#rrggbb"),
        "{colour}"
    );
    let two = with("\nbox = {", "\nsphere = { radius_mm = 3.0 }\nbox = {");
    assert!(two.contains("exactly one shape"), "{two}");
    let blind = with(
        "looks_at_mm = [0.0, 0.0, 1000.0]",
        "looks_at_mm = [0.0, 0.0, 0.0]",
    );
    assert!(
        blind.contains(&line_of("[camera]")) && blind.contains("looks_at_mm"),
        "{blind}"
    );
    let same = with(
        "position_mm = [180.0, -140.0, -100.0]",
        "position_mm = [0.0, 0.0, 0.0]",
    );
    assert!(same.contains("baseline"), "{same}");
    let solids = cube.find("[[solids]]\nname").unwrap();
    assert!(refused(&cube[..solids]).contains("the room is empty"));
    let missing = with(
        "box = { size_mm = [240.0, 240.0, 150.0] }",
        "mesh = { file = \"no.obj\" }",
    );
    assert!(missing.contains("no.obj"), "{missing}");
    let corner = "mesh = { vertices_mm = [[0, 0, 0]], faces = [[0, 1, 2]] }";
    let broken = with("box = { size_mm = [240.0, 240.0, 150.0] }", corner);
    assert!(broken.contains("none of the 1 vertices"), "{broken}");
    assert!(
        Scene::load(Path::new("no/such/scene.toml"))
            .unwrap_err()
            .to_string()
            .contains("no/such")
    );
}

fn scenes() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/scenes")
}

#[test]
fn every_shipped_scene_shows_grid_and_object() {
    let mut count = 0;
    for entry in std::fs::read_dir(scenes()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let scene = Scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let grid = Grid::coded(15, 15, 6, 6, &[Rgb::WHITE]).unwrap();
        let clear = Stage::BOTH.map(|stage| {
            let truth = Room::new(&scene, stage).truth(&grid, scene.projector_size());
            truth.iter().filter(|v| v.clear).count() / 4
        });
        assert!(
            clear[0] >= 150,
            "{}: {} crossings clear before",
            path.display(),
            clear[0]
        );
        assert!(
            clear[1] >= 100,
            "{}: {} crossings clear after",
            path.display(),
            clear[1]
        );
        assert_ne!(
            clear[0],
            clear[1],
            "{}: the object changes nothing",
            path.display()
        );
        count += 1;
    }
    assert!(count >= 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_damaged_scene_file_never_panics(at in 0_usize..9000, to in 0_u8..128, cut in 0_usize..20) {
        let cube = std::fs::read_to_string(scenes().join("cube.toml")).unwrap();
        let mut bytes = cube.into_bytes();
        let at = at % bytes.len();
        bytes[at] = to;
        let until = (at + 1 + cut).min(bytes.len());
        bytes.drain(at + 1..until);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        drop(Scene::parse(&text, &scenes()));
    }
}
