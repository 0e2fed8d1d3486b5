//! Dense lines from tracks made by hand.

use super::*;
use crate::grid::DecodedCrossing;

/// A flat line at y = 100.5 over some pixels of x, moved down from `step_at` on.
fn track(line: Option<u16>, x: impl Iterator<Item = u32>, step_at: u32, step_px: f64) -> LineTrack {
    let point = |x: u32| LinePoint {
        position: CameraPixel::new(
            f64::from(x) + 0.5,
            100.3 + if x >= step_at { step_px } else { 0.0 },
        ),
        half_width_px: 2.0,
        confidence: 0.9,
    };
    LineTrack {
        axis: Axis::Row,
        line,
        points: x.map(point).collect(),
    }
}

fn crossing(row: u16, column: u16, x: f64) -> DecodedCrossing {
    let corner = |dx, dy| CameraPixel::new(x + dx, 100.3 + dy);
    DecodedCrossing {
        index: GridIndex { row, column },
        centre: corner(0.0, 0.0),
        vertices: [
            corner(-2.0, -2.0),
            corner(2.0, -2.0),
            corner(2.0, 2.0),
            corner(-2.0, 2.0),
        ],
        confidence: 1.0,
    }
}

fn grid(tracks: Vec<LineTrack>, crossings: Vec<DecodedCrossing>) -> DecodedGrid {
    DecodedGrid {
        crossings,
        tracks,
        ..DecodedGrid::default()
    }
}

#[test]
fn a_crossing_zone_is_filled_and_a_gap_beside_it_is_not() {
    let gap_at = |from: u32, to: u32| {
        let x = (10..90).filter(move |x| !(from..to).contains(x));
        let tracks = vec![track(Some(3), x, 1000, 0.0)];
        find_dense_lines(&grid(tracks, vec![crossing(3, 1, 40.0)]))
    };
    let filled = gap_at(36, 44);
    assert_eq!(filled.len(), 1);
    assert_eq!(filled[0].points.len(), 80);
    let cut = gap_at(60, 70);
    assert_eq!(cut.len(), 2);
}

#[test]
fn a_step_cuts_the_line_even_inside_a_crossing() {
    let whole = vec![track(Some(3), 10..90, 50, 4.0)];
    assert_eq!(find_dense_lines(&grid(whole, Vec::new())).len(), 2);
    let x = (10..90).filter(|x| !(36..44).contains(x));
    let gap = vec![track(Some(3), x, 40, 4.0)];
    let lines = find_dense_lines(&grid(gap, vec![crossing(3, 1, 40.0)]));
    assert_eq!(lines.len(), 2, "arms that miss each other are not joined");
}

#[test]
fn an_end_goes_on_for_one_pitch_and_not_where_numbers_differ() {
    let tracks = || {
        vec![
            track(Some(3), 10..40, 1000, 0.0),
            track(None, 40..90, 1000, 0.0),
        ]
    };
    let known = vec![crossing(3, 0, 10.0), crossing(3, 1, 40.0)];
    let lines = find_dense_lines(&grid(tracks(), known.clone()));
    assert_eq!(lines.len(), 1);
    let last = lines[0].points.last().unwrap();
    assert!((last.position.x - 69.5).abs() < 1.0, "{}", last.position.x);
    assert!(last.confidence < 1.0);
    let other = [known, vec![crossing(4, 2, 85.0)]].concat();
    let lines = find_dense_lines(&grid(tracks(), other));
    assert_eq!(lines[0].points.len(), 30);
}
