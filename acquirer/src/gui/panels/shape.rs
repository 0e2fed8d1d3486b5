//! The surface, turned by the mouse: cells between the crossings and the points along the lines, far ones first,
//! coloured by depth or by the picture.
//!
//! # Conventions
//! As in `output::relief`: x to the right, y down, z away from the viewer; parallel projection.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, ColorImage, CornerRadius, FontId, Painter, Pos2, Rect, Sense, Stroke,
    Ui, epaint, pos2, vec2,
};

use crate::{
    gui::{model::Look, open_scan::OpenScan, pictures::Pictures},
    output::{
        colour_map::{tick_label, ticks},
        relief::mesh::Mesh,
    },
};

/// Width of the colour bar with its numbers, in points.
const BAR_WIDTH: f32 = 84.0;
/// A relief's depth range is drawn as long as this share of its larger side.
const RELIEF_SHARE: f32 = 0.4;
/// Radians per point that the mouse moves.
const TURN: f32 = 0.008;
/// Points along the lines that are drawn at most, and their side in points.
const MOST_DOTS: usize = 6000;
const DOT_SIDE: f32 = 1.6;
/// Dots lie this share of the depth range before the surface, or cells would cover them.
const DOT_LIFT: f32 = 0.02;
/// From the box to what is written beside it, in points.
const LABEL_OFFSET: f32 = 20.0;
/// Steepest look from above or below, in radians.
const STEEPEST: f32 = 1.5;
/// From where the light comes: right, down, away.
const LIGHT: [f32; 3] = [-0.35, -0.55, -0.76];

/// Shows the surface of a scan in the room that is left; dragging turns it, the wheel makes it larger.
pub(super) fn show(
    scan: &OpenScan,
    look: &mut Look,
    by_picture: bool,
    (pictures, name): (&mut Pictures, &str),
    ui: &mut Ui,
) {
    let room = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(room, Sense::click_and_drag());
    response.widget_info(|| {
        let text = format!("surface of {}", scan.name());
        egui::WidgetInfo::labeled(egui::Role::Image, true, text)
    });
    turn(look, &response, ui);
    let painter = ui.painter_at(room);
    let paper = Color32::from_gray(if ui.visuals().dark_mode { 52 } else { 244 });
    painter.rect_filled(room, CornerRadius::same(4), paper);
    if scan.mesh.nodes.is_empty() {
        let text = "No surface: too few crossings were read both without and with the object.";
        let ink = ui.visuals().text_color();
        painter.text(
            room.center(),
            Align2::CENTER_CENTER,
            text,
            FontId::proportional(14.0),
            ink,
        );
        return;
    }
    let picture = scan.picture.as_ref().filter(|_| by_picture);
    let texture = picture.map(|image| pictures.texture(ui.ctx(), name, image));
    let bar = if picture.is_none() { BAR_WIDTH } else { 0.0 };
    let frame = Rect::from_min_max(room.min, pos2(room.right() - bar, room.bottom()));
    let view = View::new(&scan.mesh, *look, scan.in_mm, frame.shrink(40.0));
    let ink = ui.visuals().weak_text_color();
    axes(&painter, &view, scan.in_mm, ink);
    let textured = picture.zip(texture.map(|texture| texture.id()));
    surface(&painter, scan, &view, textured);
    if picture.is_none() {
        let place = Rect::from_min_max(
            pos2(room.right() - bar, room.top() + 24.0),
            pos2(room.right(), room.bottom() - 24.0),
        );
        colour_bar(&painter, scan, place, ui.visuals().text_color());
    }
    let hint = "Drag to turn, wheel to zoom, double click to reset";
    let at = room.left_bottom() + vec2(10.0, -8.0);
    painter.text(
        at,
        Align2::LEFT_BOTTOM,
        hint,
        FontId::proportional(11.5),
        ink,
    );
}

fn turn(look: &mut Look, response: &egui::Response, ui: &Ui) {
    if response.dragged() {
        let moved = response.drag_delta();
        look.yaw_rad -= TURN * moved.x;
        look.pitch_rad = (look.pitch_rad + TURN * moved.y).clamp(-STEEPEST, STEEPEST);
    }
    if response.hovered() {
        let wheel = ui.input(|input| input.smooth_scroll_delta().y);
        look.zoom = (look.zoom * (0.004 * wheel).exp()).clamp(0.4, 6.0);
    }
    if response.double_clicked() {
        *look = Look::default();
    }
}

/// From data to the window.
struct View {
    low: [f32; 3],
    high: [f32; 3],
    factor: [f32; 3],
    rows: [[f32; 3]; 3],
    scale: f32,
    centre: Pos2,
}

impl View {
    fn new(mesh: &Mesh, look: Look, in_mm: bool, frame: Rect) -> Self {
        let sides: [[f32; 2]; 3] = std::array::from_fn(|k| {
            let values = mesh.nodes.iter().map(|node| node.position[k] as f32);
            values.fold([f32::MAX, f32::MIN], |[low, high], v| {
                [low.min(v), high.max(v)]
            })
        });
        let (low, high) = (sides.map(|side| side[0]), sides.map(|side| side[1]));
        let range = |k: usize| (high[k] - low[k]).max(1e-6);
        let relief = -RELIEF_SHARE * range(0).max(range(1)) / range(2);
        let factor = [1.0, 1.0, if in_mm { 1.0 } else { relief }];
        let ((sy, cy), (sp, cp)) = (look.yaw_rad.sin_cos(), look.pitch_rad.sin_cos());
        let mut view = Self {
            low,
            high,
            factor,
            rows: [
                [cy, 0.0, sy],
                [sy * sp, cp, -cy * sp],
                [-sy * cp, sp, cy * cp],
            ],
            scale: 1.0,
            centre: frame.center(),
        };
        let corners = view.corners();
        let reach = |k: usize| {
            let offsets = corners.map(|corner| view.turned(corner)[k].abs());
            offsets.into_iter().fold(1e-6, f32::max)
        };
        let fit = (0.5 * frame.width() / reach(0)).min(0.5 * frame.height() / reach(1));
        view.scale = fit * look.zoom;
        view
    }

    /// Right, down, away, as the viewer sees it.
    fn turned(&self, data: [f32; 3]) -> [f32; 3] {
        let room: [f32; 3] = std::array::from_fn(|k| {
            (data[k] - (self.low[k] + self.high[k]) / 2.0) * self.factor[k]
        });
        self.rows
            .map(|row| row.iter().zip(room).map(|(a, b)| a * b).sum())
    }

    fn at(&self, turned: [f32; 3]) -> Pos2 {
        self.centre + self.scale * vec2(turned[0], turned[1])
    }

    /// The corners of the box around the data; bit k of the number chooses low or high.
    fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|n| {
            std::array::from_fn(|k| {
                if n >> k & 1 == 0 {
                    self.low[k]
                } else {
                    self.high[k]
                }
            })
        })
    }
}

/// The box around the data, and what its sides are.
fn axes(painter: &Painter, view: &View, in_mm: bool, ink: Color32) {
    let corners = view.corners();
    let stroke = Stroke::new(1.0, ink.gamma_multiply(0.5));
    let names = if in_mm {
        ["x / mm", "y / mm", "z / mm"]
    } else {
        ["x / px", "y / px", "relative depth"]
    };
    for (axis, name) in names.into_iter().enumerate() {
        let edges = (0..8).filter(|n| n >> axis & 1 == 0).map(|n| {
            let (a, b) = (view.turned(corners[n]), view.turned(corners[n | 1 << axis]));
            (view.at(a), view.at(b))
        });
        let edges: Vec<(Pos2, Pos2)> = edges.collect();
        for &(a, b) in &edges {
            painter.line_segment([a, b], stroke);
        }
        // numbers stand outside: of what is upright at the left, of the others below
        let outer = edges.iter().max_by(|a, b| {
            let middle = |edge: &(Pos2, Pos2)| match axis {
                1 => -edge.0.x - edge.1.x,
                _ => edge.0.y + edge.1.y,
            };
            middle(a).total_cmp(&middle(b))
        });
        if let Some(&(a, b)) = outer {
            let font = FontId::proportional(11.0);
            let number = |value: f32| {
                tick_label(
                    f64::from(value),
                    f64::from(view.high[axis] - view.low[axis]),
                )
            };
            let along = b - a;
            let outwards = (a + 0.5 * along - view.centre).normalized() * LABEL_OFFSET;
            for (at, text) in [
                (a + 0.1 * along, number(view.low[axis])),
                (b - 0.1 * along, number(view.high[axis])),
                (a + 0.5 * along, name.to_owned()),
            ] {
                painter.text(
                    at + outwards,
                    Align2::CENTER_CENTER,
                    text,
                    font.clone(),
                    ink,
                );
            }
        }
    }
}

/// Something to be painted.
#[derive(Clone, Copy)]
enum Item {
    Cell(usize),
    Dot(usize),
}

/// All cells and the points along the lines, those far away first.
fn items(scan: &OpenScan, view: &View) -> Vec<(f32, Item)> {
    let away = |position: [f64; 3]| view.turned(position.map(|v| v as f32))[2];
    let mesh = &scan.mesh;
    let every = mesh.dots.len().div_ceil(MOST_DOTS).max(1);
    let range = (view.high[2] - view.low[2]) * view.factor[2].abs();
    let dots = mesh.dots.iter().enumerate().step_by(every);
    let dots = dots.map(|(k, dot)| (away(dot.position) - DOT_LIFT * range, Item::Dot(k)));
    let cells = mesh.cells.iter().enumerate().map(|(k, cell)| {
        let sum: f32 = cell.iter().map(|&n| away(mesh.nodes[n].position)).sum();
        (sum / 4.0, Item::Cell(k))
    });
    let mut items: Vec<(f32, Item)> = cells.chain(dots).collect();
    items.sort_by(|a, b| b.0.total_cmp(&a.0));
    items
}

/// Paints the surface; one mesh for each run of things with the same texture.
fn surface(
    painter: &Painter,
    scan: &OpenScan,
    view: &View,
    textured: Option<(&Arc<ColorImage>, egui::TextureId)>,
) {
    let new = |textured: Option<egui::TextureId>| {
        textured.map_or_else(epaint::Mesh::default, epaint::Mesh::with_texture)
    };
    let mut run = new(None);
    for (_, item) in items(scan, view) {
        let wanted = match item {
            Item::Cell(_) => textured.map_or(egui::TextureId::default(), |(_, id)| id),
            Item::Dot(_) => egui::TextureId::default(),
        };
        if run.texture_id != wanted {
            painter.add(std::mem::replace(&mut run, new(Some(wanted))));
        }
        match item {
            Item::Cell(k) => add_cell(&mut run, scan, view, (k, textured.map(|(image, _)| image))),
            Item::Dot(k) => add_dot(&mut run, scan, view, (k, textured.is_some())),
        }
    }
    painter.add(run);
}

fn add_cell(
    run: &mut epaint::Mesh,
    scan: &OpenScan,
    view: &View,
    (k, image): (usize, Option<&Arc<ColorImage>>),
) {
    let cell = scan.mesh.cells[k];
    let turned = cell.map(|n| view.turned(scan.mesh.nodes[n].position.map(|v| v as f32)));
    let light = light(turned);
    let corners = std::array::from_fn(|c| {
        let node = &scan.mesh.nodes[cell[c]];
        let (uv, colour) = match image {
            Some(image) => {
                let [x, y] = node.seen_at.unwrap_or([0.0; 2]);
                let [w, h] = image.size.map(|side| side as f32);
                (pos2(x as f32 / w, y as f32 / h), [255; 3])
            }
            None => (epaint::WHITE_UV, scan.scale.colour(node.position[2])),
        };
        let [r, g, b] = colour.map(|c| (f32::from(c) * light) as u8);
        epaint::Vertex {
            pos: view.at(turned[c]),
            uv,
            color: Color32::from_rgb(r, g, b),
        }
    });
    add_four(run, corners);
}

fn add_dot(run: &mut epaint::Mesh, scan: &OpenScan, view: &View, (k, by_picture): (usize, bool)) {
    let dot = &scan.mesh.dots[k];
    let at = view.at(view.turned(dot.position.map(|v| v as f32)));
    let own = dot.colour.filter(|_| by_picture);
    let [r, g, b] = own.unwrap_or_else(|| scan.scale.colour(dot.position[2]));
    let color = Color32::from_rgb(r, g, b);
    let corner = |dx: f32, dy: f32| epaint::Vertex {
        pos: at + vec2(dx, dy),
        uv: epaint::WHITE_UV,
        color,
    };
    let side = DOT_SIDE / 2.0;
    let (left, right) = (-side, side);
    add_four(
        run,
        [
            corner(left, -side),
            corner(right, -side),
            corner(right, side),
            corner(left, side),
        ],
    );
}

fn add_four(run: &mut epaint::Mesh, corners: [epaint::Vertex; 4]) {
    let first = run.vertices.len() as u32;
    run.vertices.extend(corners);
    run.add_triangle(first, first + 1, first + 2);
    run.add_triangle(first, first + 2, first + 3);
}

/// How much light a cell sends to the viewer, 0 to 1.
fn light(corners: [[f32; 3]; 4]) -> f32 {
    let sub = |a: [f32; 3], b: [f32; 3]| -> [f32; 3] { std::array::from_fn(|k| a[k] - b[k]) };
    let (u, v) = (sub(corners[2], corners[0]), sub(corners[3], corners[1]));
    let normal = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt().max(1e-12);
    let facing: f32 = normal.iter().zip(LIGHT).map(|(n, l)| n * l).sum::<f32>() / length;
    0.45 + 0.55 * facing.abs()
}

fn colour_bar(painter: &Painter, scan: &OpenScan, place: Rect, ink: Color32) {
    const STEPS: usize = 48;
    let scale = &scan.scale;
    let font = FontId::proportional(11.5);
    painter.text(
        place.center_top() - vec2(0.0, 4.0),
        Align2::CENTER_BOTTOM,
        &scale.name,
        font.clone(),
        ink,
    );
    let bar = Rect::from_min_max(
        pos2(place.left() + 10.0, place.top() + 6.0),
        pos2(place.left() + 26.0, place.bottom()),
    );
    for k in 0..STEPS {
        let share = (k as f32 + 0.5) / STEPS as f32;
        let top = bar.top() + bar.height() * k as f32 / STEPS as f32;
        let step = Rect::from_min_max(
            pos2(bar.left(), top),
            pos2(bar.right(), top + bar.height() / STEPS as f32 + 0.5),
        );
        let [r, g, b] = scale.colour(scale.high - f64::from(share) * (scale.high - scale.low));
        painter.rect_filled(step, CornerRadius::ZERO, Color32::from_rgb(r, g, b));
    }
    for tick in ticks(scale.low, scale.high, 6) {
        let share = ((scale.high - tick) / (scale.high - scale.low)) as f32;
        let y = bar.top() + bar.height() * share;
        painter.hline(bar.right()..=bar.right() + 4.0, y, Stroke::new(1.0, ink));
        let text = tick_label(tick, scale.high - scale.low);
        painter.text(
            pos2(bar.right() + 7.0, y),
            Align2::LEFT_CENTER,
            text,
            font.clone(),
            ink,
        );
    }
}
