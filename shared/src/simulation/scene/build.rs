//! From the tables of a scene file to a checked scene, with the files that it names.

use std::{ops::Range, path::Path};

use nalgebra::Vector3;
use toml::Spanned;

use super::{
    Scene, SceneError, device_pose,
    file::{MeshTable, SceneFile, SolidTable, SurfaceTable},
};
use crate::{
    geometry::Pose,
    simulation::{
        solid::{Mesh, MeshData, Shape, Solid, read_mesh},
        surface::{Paint, Surface, albedo_of},
    },
};

/// What is being read, for error messages, and where files lie.
struct Source<'a> {
    name: &'a str,
    text: &'a str,
    folder: &'a Path,
}

impl Source<'_> {
    fn sense(&self, span: Range<usize>, fault: impl Into<String>) -> SceneError {
        let before = &self.text.as_bytes()[..span.start.min(self.text.len())];
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        SceneError::Sense {
            scene: self.name.to_owned(),
            line,
            fault: fault.into(),
        }
    }
}

/// Reads the text of a scene file called `name`, whose files lie in `folder`.
pub(super) fn scene(text: &str, name: &str, folder: &Path) -> Result<Scene, SceneError> {
    let file: SceneFile = toml::from_str(text).map_err(|source| SceneError::Toml {
        scene: name.to_owned(),
        source: Box::new(source),
    })?;
    let source = Source { name, text, folder };
    let no_view =
        "looks_at_mm must be another place than position_mm, and not straight above or below it";
    let (camera_span, projector_span) = (file.camera.span(), file.projector.span());
    let (camera, projector) = (file.camera.into_inner(), file.projector.into_inner());
    let room_from_camera = device_pose(camera.position_mm, camera.looks_at_mm, camera.roll_deg)
        .ok_or_else(|| source.sense(camera_span, format!("[camera]: {no_view}")))?;
    let aim = device_pose(
        projector.position_mm,
        projector.looks_at_mm,
        projector.roll_deg,
    );
    let room_from_projector =
        aim.ok_or_else(|| source.sense(projector_span.clone(), format!("[projector]: {no_view}")))?;
    if projector.position_mm == camera.position_mm {
        let fault = "[projector] stands where the camera stands: move one, depth needs a baseline";
        return Err(source.sense(projector_span, fault));
    }
    if file.solids.is_empty() {
        let fault = "the room is empty: add at least one [[solids]] for the light to fall on";
        return Err(source.sense(0..0, fault));
    }
    let solids = file
        .solids
        .into_iter()
        .map(|table| Ok((table.get_ref().when, solid(table, &source)?)));
    let target = Vector3::from(projector.looks_at_mm);
    Ok(Scene {
        title: file.title,
        seed: file.seed,
        ambient: file.ambient,
        faults: file.faults,
        reference_mm: (target - Vector3::from(projector.position_mm)).norm(),
        room_from_camera,
        room_from_projector,
        solids: solids.collect::<Result<_, SceneError>>()?,
        camera,
        projector,
    })
}

fn solid(table: Spanned<SolidTable>, source: &Source) -> Result<Solid, SceneError> {
    let span = table.span();
    let table = table.into_inner();
    let name = table.name;
    let position = Vector3::from(table.position_mm);
    let pose = Pose::turned(position, table.rotation_deg.map(f64::to_radians));
    let mesh = table
        .mesh
        .map(|mesh| read(mesh, &name, source))
        .transpose()?;
    let half = |v: f64| v / 2.0;
    let shapes = [
        table.plane.map(|p| Shape::Plane {
            half: p.size_mm.map(half),
        }),
        table.cuboid.map(|b| Shape::Box {
            half: Vector3::from(b.size_mm) / 2.0,
        }),
        table.cylinder.map(|c| Shape::Cylinder {
            radius: c.radius_mm,
            half_height: half(c.height_mm),
        }),
        table.sphere.map(|s| Shape::Ellipsoid {
            radii: Vector3::repeat(s.radius_mm),
        }),
        table.ellipsoid.map(|e| Shape::Ellipsoid {
            radii: Vector3::from(e.radii_mm),
        }),
        mesh.map(Shape::Mesh),
    ];
    let mut shapes = shapes.into_iter().flatten();
    let (Some(shape), None) = (shapes.next(), shapes.next()) else {
        let fault = format!(
            "solid {name:?} needs exactly one shape: plane, box, cylinder, sphere, ellipsoid or mesh"
        );
        return Err(source.sense(span, fault));
    };
    let surface = surface(table.surface, source)
        .map_err(|fault| fault.unwrap_or_else(|| source.sense(span, two_paints(&name))))?;
    Ok(Solid::new(shape, pose, surface))
}

fn two_paints(name: &str) -> String {
    format!(
        "the surface of solid {name:?} takes at most one of checker, stripes (across something), patches (of \
         at least one colour), noise, picture"
    )
}

fn read(table: MeshTable, name: &str, source: &Source) -> Result<Mesh, SceneError> {
    let data = match &table.file {
        Some(file) => read_mesh(&source.folder.join(file))?,
        None => MeshData {
            vertices: table.vertices_mm.into_iter().map(Vector3::from).collect(),
            faces: table
                .faces
                .into_iter()
                .map(|face| face.map(|k| k as usize))
                .collect(),
        },
    };
    let mesh = table.file.unwrap_or_else(|| format!("of solid {name:?}"));
    Mesh::new(data, table.scale, table.smooth).map_err(|fault| SceneError::Mesh { mesh, fault })
}

/// The surface; `Err(None)` when its paint is not one that can be.
fn surface(table: SurfaceTable, source: &Source) -> Result<Surface, Option<SceneError>> {
    let picture = match table.picture {
        Some(picture) => {
            let path = source.folder.join(&picture.file);
            let image = image::open(&path)
                .map_err(|source| SceneError::Picture { path, source })?
                .into_rgb8();
            Some(Paint::Picture {
                image,
                width_mm: picture.width_mm,
            })
        }
        None => None,
    };
    let stripes = table.stripes.map(|s| -> Result<Paint, Option<SceneError>> {
        let across = Vector3::from(s.across).try_normalize(1e-9).ok_or(None)?;
        Ok(Paint::Stripes {
            other: albedo_of(s.colour),
            width_mm: s.width_mm,
            across,
        })
    });
    let patches = table.patches.map(|p| {
        let colours: Vec<_> = p.colours.into_iter().map(albedo_of).collect();
        let some = !colours.is_empty();
        let paint = Paint::Patches {
            colours,
            size_mm: p.size_mm,
            seam_mm: p.seam_mm,
        };
        some.then_some(paint).ok_or(None)
    });
    let paints = [
        table.checker.map(|c| Paint::Checker {
            other: albedo_of(c.colour),
            size_mm: c.size_mm,
        }),
        stripes.transpose()?,
        patches.transpose()?,
        table.noise.map(|n| Paint::Noise {
            other: albedo_of(n.colour),
            size_mm: n.size_mm,
        }),
        picture,
    ];
    let mut paints = paints.into_iter().flatten();
    let paint = paints.next().unwrap_or(Paint::Plain);
    if paints.next().is_some() {
        return Err(None);
    }
    Ok(Surface {
        base: albedo_of(table.colour),
        paint,
        gloss: table.gloss,
        gloss_exponent: table.gloss_exponent,
    })
}
