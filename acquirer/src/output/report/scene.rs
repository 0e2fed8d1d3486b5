//! The scene before and after, as the camera saw it.

use shared::stage::Stage;

use super::{
    Content,
    body::{Body, Photo, Section},
};
use crate::scan::Shows;

/// What is shown, and what the caption says of it.
const KINDS: [(Shows, &str); 4] = [
    (Shows::Black, "projector black"),
    (Shows::White, "projector white"),
    (Shows::Prmvs, "coded grid"),
    (Shows::Unary, "single-colour grid"),
];

/// One photograph of each kind, a row for each stage.
pub(super) fn section<'a>(content: &Content<'a>) -> Option<Section<'a>> {
    let manifest = content.folder.manifest();
    let mut body = Body::default();
    for (stage, when) in Stage::BOTH.into_iter().zip(["Before", "After"]) {
        let mut row = Body::default();
        for (shows, light) in KINDS {
            if let Some(entry) = manifest.captures_of(stage, shows).next() {
                row.photograph(Photo::Capture(entry), format!("{when}: {light}."));
            }
        }
        body.within(["<div class=\"row\">\n", "</div>\n"], row);
    }
    (!body.is_empty()).then_some(Section {
        id: "scene",
        title: "The scene",
        body,
    })
}
