//! The pattern contract: places, colours, drawing order, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use proptest::prelude::*;
use shared::pattern::{
    Axis, Corner, Grid, GridIndex, GridSettings, Palette, Pattern, PatternError, RasterSize, Rgb,
};

const RED: Rgb = Rgb([255, 0, 0]);
const YELLOW: Rgb = Rgb([255, 255, 0]);
const MAGENTA: Rgb = Rgb([255, 0, 255]);
const GREEN: Rgb = Rgb([0, 255, 0]);
const FOUR: [Rgb; 4] = [RED, YELLOW, MAGENTA, GREEN];
const XGA: RasterSize = RasterSize {
    width: 1024,
    height: 768,
};

fn grid(rows: usize, columns: usize) -> Grid {
    Grid::coded(rows, columns, 6, 6, &FOUR).unwrap()
}

#[test]
fn fifteen_columns_carry_the_sequence_of_the_thesis() {
    // 0 1 1 w2 1 0 w w 1 w 0 w2 w2 w w2
    let expected = [0, 1, 1, 3, 1, 0, 2, 2, 1, 2, 0, 3, 3, 2, 3].map(|k| FOUR[k]);
    let grid = grid(15, 15);
    let colours: Vec<_> = (0..15)
        .filter_map(|k| grid.line_colour(Axis::Column, k))
        .collect();
    assert_eq!(colours, expected);
    assert_eq!(grid.line_colour(Axis::Column, 15), None);
}

#[test]
fn a_line_covers_whole_pixels_from_the_rounded_edge() {
    let grid = grid(15, 15);
    // centre (0.5) 1024/15 = 34.13, edge 31.13; row centre (0.5) 768/15 = 25.6, edge 22.6
    assert_eq!(grid.line(Axis::Column, 0, XGA).start_px, 31);
    assert_eq!(grid.line(Axis::Row, 0, XGA).start_px, 23);
    // a half rounds up: 64 px, 16 columns would give centre 2, width 5: edge -0.5 -> 0
    let symbols = vec![shared::sequence::Symbol(0); 16];
    let json = serde_json::json!({"row_width_px": 5, "column_width_px": 5, "colours": ["#ffffff"],
        "row_symbols": symbols, "column_symbols": symbols});
    let even: Grid = serde_json::from_value(json).unwrap();
    let size = RasterSize {
        width: 64,
        height: 64,
    };
    assert_eq!(even.line(Axis::Column, 0, size).start_px, 0);
    assert_eq!(even.line(Axis::Column, 1, size).start_px, 4);
}

#[test]
fn columns_are_drawn_over_rows_and_the_field_is_black() {
    let grid = grid(15, 15);
    let picture = Pattern::Grid(grid.clone()).raster(XGA);
    let (column, row) = (
        grid.line(Axis::Column, 3, XGA),
        grid.line(Axis::Row, 5, XGA),
    );
    let (x, y) = (column.start_px as u32, row.start_px as u32);
    assert_eq!(
        picture.pixel(x, y),
        GREEN,
        "column 3 carries w2, the fourth colour"
    );
    assert_eq!(
        picture.pixel(x - 1, y),
        RED,
        "row 5 carries 0, the first colour"
    );
    assert_eq!(picture.pixel(x - 1, y - 1), Rgb::BLACK);
    assert_eq!(picture.pixel(x + 5, y - 1), GREEN);
    assert_eq!(picture.pixel(x + 6, y - 1), Rgb::BLACK);
}

#[test]
fn vertices_lie_where_the_colours_change() {
    let grid = grid(31, 63);
    let picture = Pattern::Grid(grid.clone()).raster(XGA);
    let index = GridIndex {
        row: 10,
        column: 20,
    };
    let inside = |x: f64, y: f64| picture.pixel(x.floor() as u32, y.floor() as u32) != Rgb::BLACK;
    for corner in Corner::ALL {
        let p = grid.vertex(index, corner, XGA);
        let dx = if corner.is_right() { -0.5 } else { 0.5 };
        let dy = if corner.is_lower() { -0.5 } else { 0.5 };
        assert!(inside(p.x + dx, p.y + dy), "{corner} lies on the crossing");
        assert!(
            !inside(p.x - dx, p.y - dy),
            "beyond {corner} is a dark cell"
        );
    }
}

#[test]
fn every_size_and_both_codes_draw_as_many_lines_as_asked() {
    let size = RasterSize {
        width: 2048,
        height: 2048,
    };
    for lines in [15, 31, 63, 127, 255] {
        for colours in [&FOUR[..1], &FOUR[..2], &FOUR[..]] {
            let grid = Grid::coded(lines, lines, 3, 2, colours).unwrap();
            let profile = grid.profile(Axis::Column, size);
            let starts =
                (0..2048).filter(|&x| profile[x].is_some() && (x == 0 || profile[x - 1].is_none()));
            assert_eq!(starts.count(), lines);
        }
    }
}

#[test]
fn a_unary_twin_has_the_same_lines_in_one_colour() {
    let settings = GridSettings::default();
    let (coded, unary) = (settings.coded.clone(), settings.unary_grid());
    for axis in Axis::BOTH {
        let covered = |grid: &Grid| {
            grid.profile(axis, XGA)
                .iter()
                .map(Option::is_some)
                .collect::<Vec<_>>()
        };
        assert_eq!(covered(&coded), covered(&unary));
        assert!(
            unary
                .profile(axis, XGA)
                .iter()
                .flatten()
                .all(|&c| c == settings.unary)
        );
    }
}

#[test]
fn scan_json_pattern_reads_and_writes_unchanged() {
    let text = r##"{"rows":15,"columns":31,"row_width_px":6,"column_width_px":4,
        "colours":["#ff0000","#ffff00","#ff00ff","#00ff00"],"unary":"#ffffff","note":"extra keys are fine"}"##;
    let settings: GridSettings = serde_json::from_str(text).unwrap();
    assert_eq!((settings.coded.rows(), settings.coded.columns()), (15, 31));
    assert_eq!(settings.coded.width_px(Axis::Column), 4);
    let again: GridSettings =
        serde_json::from_str(&serde_json::to_string(&settings).unwrap()).unwrap();
    assert_eq!(again, settings);
}

#[test]
fn other_peoples_codes_come_as_explicit_symbols() {
    let json = serde_json::json!({"rows": 3, "row_width_px": 4, "column_width_px": 4,
        "colours": ["#ff0000", "#00ff00", "#0000ff"],
        "row_symbols": [0, 1, 2], "column_symbols": [2, 2, 0, 1]});
    let grid: Grid = serde_json::from_value(json.clone()).unwrap();
    assert_eq!(grid.columns(), 4);
    assert_eq!(grid.line_colour(Axis::Column, 0), Some(Rgb([0, 0, 255])));
    let back: Grid = serde_json::from_value(serde_json::to_value(&grid).unwrap()).unwrap();
    assert_eq!(back, grid);
}

#[test]
fn impossible_grids_are_refused_with_the_reason() {
    let refuse = |rows, columns, width, colours: &[Rgb]| {
        Grid::coded(rows, columns, width, 6, colours).unwrap_err()
    };
    assert_eq!(refuse(16, 15, 6, &FOUR), PatternError::LineCount(16));
    assert_eq!(refuse(15, 0, 6, &FOUR), PatternError::LineCount(0));
    assert_eq!(refuse(15, 15, 0, &FOUR), PatternError::Width(0));
    assert_eq!(refuse(15, 15, 60_000, &FOUR), PatternError::Width(60_000));
    assert_eq!(refuse(15, 15, 6, &FOUR[..3]), PatternError::ColourCount(3));
    assert_eq!(refuse(15, 15, 6, &[]), PatternError::ColourCount(0));
    let symbols = serde_json::json!({"row_width_px": 4, "column_width_px": 4, "colours": ["#ff0000"],
        "row_symbols": [0, 1], "column_symbols": [0]});
    let error = serde_json::from_value::<Grid>(symbols)
        .unwrap_err()
        .to_string();
    assert!(error.contains("symbol 1 but only 1 colours"), "{error}");
}

#[test]
fn touching_lines_are_drawn_with_a_warning() {
    let fine = Grid::coded(255, 255, 6, 6, &FOUR).unwrap();
    assert_eq!(fine.warnings(XGA).len(), 2);
    assert!(
        fine.warnings(XGA)[0].contains("touch"),
        "{:?}",
        fine.warnings(XGA)
    );
    assert!(grid(15, 15).warnings(XGA).is_empty());
}

#[test]
fn the_ramp_shows_every_byte_value_in_every_channel() {
    let picture = Pattern::Ramp.raster(RasterSize {
        width: 300,
        height: 280,
    });
    for channel in 0..3 {
        let mut seen = [false; 256];
        for pixel in picture.bytes().chunks_exact(3) {
            seen[usize::from(pixel[channel])] = true;
        }
        assert!(seen.iter().all(|&s| s));
    }
}

#[test]
fn the_identify_card_differs_by_label_and_frames_the_outermost_pixels() {
    let card = |label: &str| {
        Pattern::Identify {
            label: label.into(),
        }
        .raster(XGA)
    };
    assert_ne!(card("HDMI-1"), card("HDMI-2"));
    for (x, y) in [(0, 0), (1023, 0), (1023, 767), (0, 767), (512, 0), (0, 300)] {
        assert_eq!(card("HDMI-1").pixel(x, y), Rgb::WHITE);
    }
    // never panics on odd sizes and labels
    for (width, height) in [(1, 1), (7, 3), (3, 200), (1920, 17)] {
        let size = RasterSize { width, height };
        let picture = Pattern::Identify {
            label: "projecteur à gauche ✓".repeat(9),
        }
        .raster(size);
        assert_eq!(picture.size(), size);
    }
}

#[test]
fn the_test_card_has_its_frame_its_finest_line_pairs_and_every_size() {
    let card = Pattern::TestCard.raster(XGA);
    for (x, y) in [(0, 0), (1023, 0), (1023, 767), (0, 767), (300, 0), (0, 300)] {
        assert_eq!(card.pixel(x, y), Rgb::WHITE);
    }
    // mirrored about the middle, as far as the hatch and the circles go
    for x in 0..1024 {
        assert_eq!(card.pixel(x, 20), card.pixel(1023 - x, 20), "column {x}");
    }
    let alternating = |at: &dyn Fn(u32) -> Rgb, length: u32| {
        let run = |start: u32| (0..24).all(|k| (at(start + k) == Rgb::WHITE) == (k % 2 == 0));
        (0..length - 24).any(run)
    };
    let some_row = (0..768).any(|y| alternating(&|x| card.pixel(x, y), 1024));
    let some_column = (0..1024).any(|x| alternating(&|y| card.pixel(x, y), 768));
    assert!(some_row && some_column, "line pairs of one pixel");
    for (width, height) in [(1, 1), (7, 3), (3, 200), (1920, 17), (64, 48)] {
        let size = RasterSize { width, height };
        assert_eq!(Pattern::TestCard.raster(size).size(), size);
    }
}

#[test]
fn the_two_colour_twin_has_the_lines_of_the_grid_in_its_first_two_colours() {
    let mut settings = shared::pattern::GridSettings::default();
    settings = settings.with_lines(31, 63).unwrap();
    let twin = settings.two_colour_grid();
    assert_eq!((twin.rows(), twin.columns()), (31, 63));
    assert_eq!(twin.colours(), &settings.coded.colours()[..2]);
    let again = shared::pattern::GridSettings {
        coded: twin.clone(),
        unary: Rgb::WHITE,
    };
    assert_eq!(again.two_colour_grid(), twin);
}

#[test]
fn the_shipped_palette_has_sixteen_different_colours_with_the_thesis_ones() {
    let palette = Palette::default();
    assert_eq!(palette.colours().len(), 16);
    for (colour, name) in [
        (RED, "red"),
        (YELLOW, "yellow"),
        (MAGENTA, "magenta"),
        (GREEN, "green"),
    ] {
        assert_eq!(palette.name_of(colour), name);
    }
    assert_eq!(palette.name_of(Rgb([1, 2, 3])), "#010203");
}

#[test]
fn a_broken_palette_file_names_the_line() {
    let error = Palette::from_toml("[[colours]]\nname = \"red\"\ncolour = \"red\"\n").unwrap_err();
    assert!(error.to_string().contains("line 3"), "{error}");
    let error =
        Palette::from_toml("[[colours]]\nname = \"red\"\ncolour = \"#ff0000\"\n").unwrap_err();
    assert!(error.to_string().contains("1 colours"), "{error}");
    let twice = "[[colours]]\nname = \"red\"\ncolour = \"#ff0000\"\n".repeat(16);
    assert!(
        Palette::from_toml(&twice)
            .unwrap_err()
            .to_string()
            .contains("twice")
    );
}

proptest! {
    #[test]
    fn any_grid_draws_on_any_raster_without_a_panic(
        lines in prop::sample::select(vec![15_usize, 31, 63, 127, 255]),
        width_px in 1_u32..1025, width in 1_u32..400, height in 1_u32..300,
    ) {
        let grid = Grid::coded(lines, 15, width_px, 3, &FOUR).unwrap();
        let size = RasterSize { width, height };
        prop_assert_eq!(Pattern::Grid(grid).raster(size).bytes().len(), 3 * size.pixels());
    }

    #[test]
    fn text_that_is_no_colour_is_refused(text in "\\PC{0,12}") {
        let is_colour = text.len() == 7 && text.starts_with('#')
            && text[1..].bytes().all(|b| b.is_ascii_hexdigit());
        prop_assert_eq!(text.parse::<Rgb>().is_ok(), is_colour);
    }
}
