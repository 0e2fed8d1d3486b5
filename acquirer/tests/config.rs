//! The shipped configuration file.

use std::{fs, path::Path};

use acquirer::config::Config;

fn shipped() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/acquirer.toml")
}

#[test]
fn the_shipped_file_holds_the_built_in_values() {
    assert_eq!(Config::load(Some(&shipped())).unwrap(), Config::default());
}

#[test]
fn the_shipped_file_names_every_key() {
    let shipped: toml::Table = fs::read_to_string(shipped()).unwrap().parse().unwrap();
    let built_in = toml::Table::try_from(Config::default()).unwrap();
    assert_eq!(shipped, built_in);
}

#[test]
fn an_unknown_key_is_refused_with_its_line() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("mine.toml");
    fs::write(
        &file,
        "[record]\nreferences = 2\n\n[pipeline.lines]\nwidest = 3\n",
    )
    .unwrap();
    let message = Config::load(Some(&file)).unwrap_err().to_string();
    assert!(
        message.contains("mine.toml") && message.contains("line 5"),
        "{message}"
    );
    assert!(message.contains("widest"), "{message}");
}

#[test]
fn a_missing_file_is_named() {
    let message = Config::load(Some(Path::new("/nowhere/my.toml")))
        .unwrap_err()
        .to_string();
    assert!(message.contains("/nowhere/my.toml"), "{message}");
}
