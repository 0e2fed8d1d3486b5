//! The report: one well-formed file that needs nothing outside of itself.

use std::fs;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use shared::pattern::Rgb;

use super::fixture::{recorded, result, selection, stage_pictures};
use crate::{
    output::write_results,
    pipeline::{colour_choice::ColourSelection, result::ScanResult},
};

fn report(result: &ScanResult, selection: Option<&ColourSelection>) -> String {
    let dir = tempfile::tempdir().unwrap();
    let folder = recorded(dir.path(), true);
    let paths = write_results(&folder, &stage_pictures(), result, selection).unwrap();
    fs::read_to_string(paths.report).unwrap()
}

/// Every tag closes the one that was opened last.
fn assert_well_formed(page: &str) {
    const ALONE: [&str; 3] = ["meta", "img", "!DOCTYPE"];
    let mut open: Vec<&str> = Vec::new();
    // the style sheet has no tags but may have angle brackets
    let (head, rest) = page.split_once("<style>").unwrap();
    let (_, body) = rest.split_once("</style>").unwrap();
    for part in [head, body].iter().flat_map(|text| text.split('<').skip(1)) {
        let (tag, text) = part.split_once('>').expect("a tag that ends");
        assert!(!text.contains('>'), "a loose > after {tag:.60}");
        let name = tag.split([' ', '/']).find(|word| !word.is_empty()).unwrap();
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "after {:?}", open);
        } else if !tag.ends_with('/') && !ALONE.contains(&name) {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

/// What stands behind each `name="`.
fn attributes<'a>(page: &'a str, name: &'a str) -> impl Iterator<Item = &'a str> {
    let start = format!("{name}=\"");
    let values: Vec<&str> = page.split(start.as_str()).skip(1).collect();
    values
        .into_iter()
        .map(|rest| rest.split('"').next().unwrap())
}

#[test]
fn the_report_needs_nothing_outside_of_itself() {
    let page = report(&result(true), Some(&selection()));
    assert_well_formed(&page);
    for forbidden in ["http://", "https://", "<script", "<link", "@import", "url("] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    let inner = |value: &str| value.starts_with("data:image/") || value.starts_with('#');
    assert!(
        attributes(&page, "src")
            .chain(attributes(&page, "href"))
            .all(inner)
    );
    for target in attributes(&page, "href").filter_map(|value| value.strip_prefix('#')) {
        assert!(page.contains(&format!("id=\"{target}\"")), "{target}");
    }
}

#[test]
fn every_embedded_picture_can_be_decoded() {
    let page = report(&result(true), None);
    let uris = attributes(&page, "src").chain(attributes(&page, "href"));
    let data: Vec<_> = uris.filter_map(|uri| uri.split_once(";base64,")).collect();
    // 8 captures, 2 stage pictures, 2 label maps, 2 maps, 2 views
    assert_eq!(data.len(), 16);
    for (kind, data) in data {
        let picture = image::load_from_memory(&STANDARD.decode(data).unwrap()).unwrap();
        assert!(picture.width() >= 640, "{kind}");
    }
}

#[test]
fn labels_say_what_they_are_when_pointed_at() {
    let page = report(&result(true), None);
    assert!(page.contains(
        "<title>row 0, column 0, UPPER_LEFT: (116.67, 36.67) px, confidence 0.980</title>"
    ));
    assert!(page.contains("<title>dropped: too dark</title>"));
}

#[test]
fn texts_are_escaped() {
    let mut selection = selection();
    selection.colours[0].name = "<b>red & \"hot\"".into();
    selection.reasons = vec!["a < b".into()];
    let page = report(&result(true), Some(&selection));
    assert_well_formed(&page);
    assert!(page.contains("&lt;b&gt;red &amp; &quot;hot&quot;"));
    assert!(page.contains("<li>a &lt; b</li>"));
    assert!(page.contains("the room&#39;s &amp; the surface&#39;s &lt;share&gt;."));
}

#[test]
fn the_choice_of_colours_is_shown_only_when_there_was_one() {
    let heading = "Why these colours";
    assert!(!report(&result(true), None).contains(heading));
    let page = report(&result(true), Some(&selection()));
    assert!(page.contains(heading) && page.contains("red is expected to be read well."));
    assert!(page.contains("red and green: error 1.50 %, distance 4.3"));
}

#[test]
fn a_scan_of_which_nothing_was_read_still_has_a_report() {
    let dir = tempfile::tempdir().unwrap();
    let folder = recorded(dir.path(), false);
    let nothing = ScanResult::default();
    let paths = write_results(&folder, &[Vec::new(), Vec::new()], &nothing, None).unwrap();
    let page = fs::read_to_string(paths.report).unwrap();
    assert_well_formed(&page);
    assert!(page.contains("What was projected") && !page.contains("Shape of the object"));
}

#[test]
fn numbers_that_are_none_and_broken_tables_do_no_harm() {
    let mut broken = result(true);
    for stage in [&mut broken.background, &mut broken.object] {
        let grid = &mut stage.as_mut().unwrap().grid;
        grid.crossings[0].vertices[0].x = f64::NAN;
        grid.crossings[1].centre.y = f64::INFINITY;
        grid.crossings[2].confidence = f64::NAN;
        grid.tracks[0].points[0].position.x = f64::NEG_INFINITY;
        grid.tracks[1].line = Some(u16::MAX);
        grid.dropped[0].centre.x = 1e300;
    }
    broken.shifts[0].shift_px = f64::NAN;
    broken.surface[0].position_mm = [f64::NAN; 3];
    let mut choice = selection();
    choice.separability = Default::default();
    choice.colours[1].hue_histogram.clear();
    choice.tiles[0].seen.clear();
    choice.unary = Rgb([1, 2, 3]);
    choice.expected_error = f64::NAN;
    assert_well_formed(&report(&broken, Some(&choice)));
}
