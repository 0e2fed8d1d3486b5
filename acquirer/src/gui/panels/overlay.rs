//! The decoded grid over a picture: lines, labels, holes, and what their colours mean.

use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Shape, Stroke, Vec2, pos2, vec2,
};

use crate::{
    gui::{
        live_picture::{LiveReading, Overlay, hole_colour},
        preferences::Overlays,
    },
    output::maps::reason_words,
    pipeline::grid::DropReason,
};

/// Labels are drawn when crossings are at least this far apart, in points.
const ROOM_FOR_LABEL: f32 = 26.0;
/// Size of letters on the picture, in points.
const LETTERS: f32 = 10.5;
const RIM: Color32 = Color32::from_black_alpha(190);

/// Where a picture stands on the window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    target: Rect,
    scale: f32,
}

impl Place {
    /// A picture of this size in pixels, drawn over this rectangle.
    pub(super) fn new(target: Rect, size: Vec2) -> Self {
        Self {
            target,
            scale: target.width() / size.x.max(1.0),
        }
    }

    /// A camera pixel on the window.
    pub(super) fn at(self, [x, y]: [f32; 2]) -> Pos2 {
        self.target.min + self.scale * vec2(x, y)
    }

    /// A place on the window in camera pixels.
    pub(super) fn pixel(self, at: Pos2) -> [f32; 2] {
        let from = (at - self.target.min) / self.scale;
        [from.x, from.y]
    }
}

/// Draws what is switched on.
pub(super) fn draw(painter: &Painter, overlay: &Overlay, place: Place, on: Overlays) {
    if on.grid {
        for (points, colour) in &overlay.lines {
            let points: Vec<Pos2> = points.iter().map(|&p| place.at(p)).collect();
            painter.add(Shape::line(points.clone(), Stroke::new(3.2, RIM)));
            painter.add(Shape::line(points, Stroke::new(1.6, *colour)));
        }
        for (at, _) in &overlay.labels {
            painter.circle_filled(place.at(*at), 2.0, Color32::WHITE);
        }
    }
    if on.holes {
        for (at, reason) in &overlay.holes {
            cross(painter, place.at(*at), hole_colour(*reason));
        }
    }
    if on.labels {
        labels(painter, overlay, place);
    }
}

fn labels(painter: &Painter, overlay: &Overlay, place: Place) {
    let near = overlay
        .labels
        .windows(2)
        .filter(|pair| pair[0].1[0] == pair[1].1[0]);
    let mut steps: Vec<f32> = near
        .map(|pair| place.at(pair[0].0).distance(place.at(pair[1].0)))
        .collect();
    steps.sort_by(f32::total_cmp);
    if steps
        .get(steps.len() / 2)
        .is_none_or(|&step| step < ROOM_FOR_LABEL)
    {
        return;
    }
    let font = FontId::proportional(LETTERS);
    for (at, [row, column]) in &overlay.labels {
        let at = place.at(*at) + vec2(4.0, 2.0);
        let text = format!("{row},{column}");
        painter.text(
            at + vec2(0.8, 0.8),
            Align2::LEFT_TOP,
            &text,
            font.clone(),
            Color32::BLACK,
        );
        painter.text(at, Align2::LEFT_TOP, &text, font.clone(), Color32::WHITE);
    }
}

/// The mark of a hole.
pub(super) fn cross(painter: &Painter, at: Pos2, colour: Color32) {
    for (width, colour) in [(4.0, RIM), (2.2, colour)] {
        let stroke = Stroke::new(width, colour);
        painter.line_segment([at - vec2(4.0, 4.0), at + vec2(4.0, 4.0)], stroke);
        painter.line_segment([at - vec2(4.0, -4.0), at + vec2(4.0, -4.0)], stroke);
    }
}

/// What the colours of the holes mean, in the lower left corner; what the frame shows, in the upper left one.
pub(super) fn legend(painter: &Painter, room: Rect, reading: &LiveReading, on: Overlays) {
    let mut rows: Vec<(Option<Color32>, String)> = Vec::new();
    rows.push((
        None,
        format!(
            "{} of {} crossings read",
            reading.crossings, reading.possible
        ),
    ));
    if on.holes {
        let named = DropReason::ALL.into_iter().filter_map(|reason| {
            let count = reading.reasons.get(reason.name())?;
            Some((
                Some(hole_colour(reason)),
                format!("{count} {}", reason_words(reason)),
            ))
        });
        rows.extend(named);
    }
    if reading.pattern != "coded" {
        rows.push((None, format!("this frame shows: {}", reading.pattern)));
    }
    let font = FontId::proportional(12.5);
    let line = 18.0;
    let size = vec2(190.0, line * rows.len() as f32 + 10.0);
    let corner = pos2(room.left() + 8.0, room.bottom() - 8.0 - size.y);
    painter.rect_filled(
        Rect::from_min_size(corner, size),
        CornerRadius::same(4),
        Color32::from_black_alpha(170),
    );
    for (k, (colour, text)) in rows.iter().enumerate() {
        let at = corner + vec2(10.0, 5.0 + line * (k as f32 + 0.5));
        let indent = colour.map_or(0.0, |colour| {
            cross(painter, at + vec2(4.0, 0.0), colour);
            16.0
        });
        painter.text(
            at + vec2(indent, 0.0),
            Align2::LEFT_CENTER,
            text,
            font.clone(),
            Color32::from_gray(235),
        );
    }
}
