//! Reads triangle meshes: Wavefront OBJ and ASCII PLY, positions and faces only.
//!
//! Faces with more than three corners are cut into a fan. Normals, colours and texture coordinates are passed over.

use std::path::Path;

use nalgebra::Vector3;

use super::mesh::MeshData;
use crate::simulation::scene::SceneError;

/// Reads a mesh file; its extension says which kind it is.
///
/// # Errors
/// When the file can't be read or is not such a file.
pub(in crate::simulation) fn read_mesh(path: &Path) -> Result<MeshData, SceneError> {
    let bytes = std::fs::read(path).map_err(|source| SceneError::Read {
        path: path.to_owned(),
        source,
    })?;
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let data = match extension.as_deref().and_then(|e| e.to_str()) {
        Some("obj") => parse_obj(&String::from_utf8_lossy(&bytes)),
        Some("ply") => parse_ply(&String::from_utf8_lossy(&bytes)),
        _ => Err("only .obj and .ply files are read".to_owned()),
    };
    data.map_err(|fault| SceneError::Mesh {
        mesh: path.display().to_string(),
        fault,
    })
}

fn parse_obj(text: &str) -> Result<MeshData, String> {
    let mut data = MeshData::default();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let wrong = |what: &str| format!("line {}: {what}", number + 1);
        match words.next() {
            Some("v") => data
                .vertices
                .push(position(words).ok_or_else(|| wrong("v needs x y z"))?),
            Some("f") => {
                let corners: Option<Vec<usize>> = words
                    .map(|word| obj_index(word, data.vertices.len()))
                    .collect();
                let corners = corners.ok_or_else(|| wrong("f needs the numbers of vertices"))?;
                fan(&corners, &mut data.faces).ok_or_else(|| wrong("f needs three corners"))?;
            }
            _ => {}
        }
    }
    Ok(data)
}

/// A corner of an OBJ face, `7`, `7/1/2` or `-1` (the last vertex so far), counted from 0.
fn obj_index(word: &str, count: usize) -> Option<usize> {
    let index: i64 = word.split('/').next()?.parse().ok()?;
    match index {
        1.. => usize::try_from(index - 1).ok(),
        0 => None,
        _ => count.checked_sub(usize::try_from(index.checked_neg()?).ok()?),
    }
}

fn parse_ply(text: &str) -> Result<MeshData, String> {
    let mut lines = text.lines().enumerate();
    let (mut vertices, mut faces) = (None, None);
    if lines.next().is_none_or(|(_, line)| line.trim() != "ply") {
        return Err("line 1: a PLY file begins with \"ply\"".to_owned());
    }
    for (number, line) in lines.by_ref() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["format", kind, ..] if kind != "ascii" => {
                return Err(format!(
                    "line {}: save it as ASCII PLY, not {kind}",
                    number + 1
                ));
            }
            ["element", "vertex", count] => vertices = count.parse::<usize>().ok(),
            ["element", "face", count] => faces = count.parse::<usize>().ok(),
            ["end_header"] => break,
            _ => {}
        }
    }
    let (Some(vertices), Some(faces)) = (vertices, faces) else {
        return Err("its header does not count vertices and faces".to_owned());
    };
    let mut data = MeshData::default();
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let wrong = |what: &str| format!("line {}: {what}", number + 1);
        let mut words = line.split_whitespace();
        if data.vertices.len() < vertices {
            data.vertices
                .push(position(words).ok_or_else(|| wrong("a vertex needs x y z"))?);
            continue;
        }
        let count = words.next().and_then(|word| word.parse::<usize>().ok());
        let corners: Option<Vec<usize>> =
            count.and_then(|count| words.take(count).map(|word| word.parse().ok()).collect());
        let corners = corners.ok_or_else(|| wrong("a face needs a count and its corners"))?;
        fan(&corners, &mut data.faces).ok_or_else(|| wrong("a face needs three corners"))?;
    }
    let complete = data.vertices.len() == vertices && data.faces.len() >= faces;
    complete
        .then_some(data)
        .ok_or_else(|| "it ends before its last face".to_owned())
}

fn position<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Vector3<f64>> {
    let mut next = || words.next()?.parse().ok();
    Some(Vector3::new(next()?, next()?, next()?))
}

fn fan(corners: &[usize], faces: &mut Vec<[usize; 3]>) -> Option<()> {
    let (first, rest) = corners.split_first().filter(|(_, rest)| rest.len() >= 2)?;
    faces.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE_OBJ: &str =
        "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1/1/1 2 3 -1\n";
    const SQUARE_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

    #[test]
    fn both_kinds_of_file_give_the_same_square() {
        let from_obj = parse_obj(SQUARE_OBJ).unwrap();
        assert_eq!(from_obj.faces, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(from_obj, parse_ply(SQUARE_PLY).unwrap());
    }

    #[test]
    fn broken_files_are_refused_with_the_line() {
        assert!(parse_obj("v 0 0\n").unwrap_err().contains("line 1"));
        assert!(
            parse_obj("v 0 0 0\nf 1 -9 1\n")
                .unwrap_err()
                .contains("line 2")
        );
        assert!(
            parse_obj("v 0 0 0\nf 1 1\n")
                .unwrap_err()
                .contains("three corners")
        );
        assert!(
            parse_obj("f 0 -9223372036854775808 1\n")
                .unwrap_err()
                .contains("line 1")
        );
        assert!(parse_ply("solid\n").unwrap_err().contains("begins with"));
        assert!(
            parse_ply("ply\nend_header\n")
                .unwrap_err()
                .contains("does not count")
        );
        let binary = SQUARE_PLY.replace("ascii", "binary_little_endian");
        assert!(parse_ply(&binary).unwrap_err().contains("ASCII"));
        let cut = &SQUARE_PLY[..SQUARE_PLY.len() - 12];
        assert!(parse_ply(cut).is_err());
        let huge = SQUARE_PLY.replace("4 0 1 2 3", "18446744073709551615 0 1");
        assert!(parse_ply(&huge).unwrap_err().contains("three corners"));
    }
}
