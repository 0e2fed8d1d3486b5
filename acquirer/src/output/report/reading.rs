//! The pipeline's own pictures, both stages side by side.

use super::{
    Content,
    body::{Body, Photo, Section},
    html::PAIR,
};

pub(super) fn section<'a>(content: &Content<'a>) -> Option<Section<'a>> {
    let steps = content.stage_pictures.iter().map(Vec::len).max();
    let mut body = Body::default();
    for k in 0..steps.unwrap_or(0) {
        let mut row = Body::default();
        for (when, pictures) in ["before", "after"].into_iter().zip(content.stage_pictures) {
            if let Some(picture) = pictures.get(k) {
                let caption = format!("{}. {} ({when})", k + 1, picture.caption);
                row.photograph(Photo::Encoded(picture), caption);
            }
        }
        body.within(PAIR, row);
    }
    (!body.is_empty()).then_some(Section {
        id: "reading",
        title: "How the grid was read, step by step",
        body,
    })
}
