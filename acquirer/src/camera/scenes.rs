//! Where the scene files of simulated rooms are.
//!
//! A scene is named by its file's name without `.toml`, looked for in `config/scenes` under the
//! current folder, under every folder above the program, and in the source tree that the program
//! was built from; or by a path.

use std::path::{Path, PathBuf};

use shared::simulation::Scene;

use super::CameraError;

/// The folder of scenes in the source tree.
const SOURCE_TREE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/scenes");

/// The scene files that can be named, as (name, path), by name; the first folder that has a name
/// wins.
#[must_use]
pub fn scenes() -> Vec<(String, PathBuf)> {
    let mut found: Vec<(String, PathBuf)> = Vec::new();
    for folder in folders() {
        let files = std::fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path());
        for path in files.filter(|path| path.extension().is_some_and(|ending| ending == "toml")) {
            if let Some(name) = path.file_stem().and_then(|name| name.to_str())
                && !found.iter().any(|(known, _)| known == name)
            {
                found.push((name.to_owned(), path.clone()));
            }
        }
    }
    found.sort();
    found
}

/// The file of a scene that is given by its name or as a path.
///
/// # Errors
/// When there is none; the message lists the names there are.
pub fn scene_file(scene: &str) -> Result<PathBuf, CameraError> {
    if scene.contains('/') || scene.ends_with(".toml") {
        return Ok(scene.into());
    }
    let known = scenes();
    if let Some((_, path)) = known.iter().find(|(name, _)| name == scene) {
        return Ok(path.clone());
    }
    let names: Vec<_> = known.into_iter().map(|(name, _)| name).collect();
    let reason = if names.is_empty() {
        "no folder config/scenes was found; give the path of a scene file".into()
    } else {
        format!("no scene has this name; there are {}", names.join(", "))
    };
    Err(CameraError::Simulation {
        scene: scene.to_owned(),
        reason,
    })
}

/// Reads a scene that is given by its name or as a path.
///
/// # Errors
/// When there is none, or it cannot be read.
pub fn load_scene(scene: &str) -> Result<Scene, CameraError> {
    let path = scene_file(scene)?;
    Scene::load(&path).map_err(|error| CameraError::Simulation {
        scene: scene.to_owned(),
        reason: error.to_string(),
    })
}

/// Folders that may hold scenes, nearest first.
fn folders() -> impl Iterator<Item = PathBuf> {
    let program = std::env::current_exe().unwrap_or_default();
    let above: Vec<_> = program.ancestors().skip(1).map(Path::to_path_buf).collect();
    let inside = |folder: PathBuf| folder.join("config/scenes");
    std::iter::once(PathBuf::from("."))
        .chain(above)
        .map(inside)
        .chain([PathBuf::from(SOURCE_TREE)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_found_by_its_name() {
        assert!(
            scene_file("cube")
                .unwrap()
                .ends_with("config/scenes/cube.toml")
        );
        assert_eq!(load_scene("cube").unwrap().camera_size(), (640, 480));
    }

    #[test]
    fn a_wrong_name_is_told_with_the_names_there_are() {
        let message = load_scene("cuube").unwrap_err().to_string();
        assert!(
            message.contains("cuube") && message.contains("cube,") || message.ends_with("cube"),
            "{message}"
        );
        assert!(
            load_scene("./no-such-scene.toml")
                .unwrap_err()
                .to_string()
                .contains("no-such-scene")
        );
    }
}
