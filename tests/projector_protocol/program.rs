//! The command line, the end, and pictures without a projector.

use shared::pattern::{Grid, Pattern, RasterSize, Rgb};

use crate::{headless, run};

#[test]
fn signals_end_it_cleanly_after_one_line_on_standard_output() {
    for signal in ["TERM", "INT"] {
        let projector = headless();
        let mut client = projector.controller();
        projector.signal(signal);
        while client.next().is_some() {}
        let (status, rest) = projector.ended();
        assert_eq!((status.code(), rest.as_str()), (Some(0), ""), "{signal}");
    }
}

#[test]
fn failures_exit_with_1_and_wrong_use_with_2() {
    let projector = headless();
    let taken = run(&format!(
        "--headless 64x48 --listen {}",
        projector.address()
    ));
    let without_display = run("--listen 127.0.0.1:0");
    for (output, code, hint) in [
        (taken, 1, "--listen"),
        (without_display, 1, "--headless"),
        (run("screens"), 1, "--headless"),
        (
            run("--headless 64x48 --config /nonexistent.toml"),
            1,
            "/nonexistent.toml",
        ),
        (run("--headless 64"), 2, "WIDTHxHEIGHT"),
        (run("--headless 64x48 --windowed 64x48"), 2, "--windowed"),
    ] {
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{text}");
        assert!(text.contains(hint), "{text}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn render_writes_what_would_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    let four = ["#ff0000", "#ffff00", "#ff00ff", "#00ff00"].map(|text| text.parse().unwrap());
    let grid = Grid::coded(15, 31, 2, 3, &four).unwrap();
    let object = serde_json::to_string(&grid).unwrap();
    let unary: Rgb = "#0080ff".parse().unwrap();
    let settings = object.replacen('{', "{\"unary\":\"#0080ff\",", 1);
    let as_toml = "kind = \"solid\"\ncolour = \"#8000ff\"\n";
    let cases = [
        ("grid.json", object.clone(), "", Pattern::from(grid.clone())),
        (
            "pattern.json",
            object.replacen('{', "{\"kind\":\"grid\",", 1),
            "",
            grid.clone().into(),
        ),
        (
            "scan.json",
            format!("{{\"format\":1,\"pattern\":{settings}}}"),
            "",
            grid.clone().into(),
        ),
        (
            "twin.json",
            settings.clone(),
            "--unary",
            grid.unary(unary).into(),
        ),
        (
            "ramp.json",
            "{\"kind\":\"ramp\"}".to_owned(),
            "",
            Pattern::Ramp,
        ),
        (
            "solid.toml",
            as_toml.to_owned(),
            "",
            Pattern::try_from("#8000ff").unwrap(),
        ),
    ];
    for (name, text, option, pattern) in cases {
        let (file, out) = (
            folder.path().join(name),
            folder.path().join(format!("{name}.png")),
        );
        std::fs::write(&file, text).unwrap();
        let (file, out_name) = (file.display(), out.display());
        let output = run(&format!(
            "render --pattern {file} --size 200x150 {option} {out_name}"
        ));
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let picture = image::open(&out).unwrap().to_rgb8();
        let expected = pattern.raster(RasterSize {
            width: 200,
            height: 150,
        });
        assert_eq!(picture.dimensions(), (200, 150));
        assert!(picture.as_raw() == expected.bytes(), "{name}");
    }
    let nothing = folder.path().join("nothing.json");
    std::fs::write(&nothing, "{\"format\":1}").unwrap();
    let output = run(&format!(
        "render --pattern {} --size 8x8 /dev/null",
        nothing.display()
    ));
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("colours"));
}
