//! Shifts, depth, height over the background, and the surface.

use super::{
    Content,
    body::Section,
    html::{PAIR, figures},
};

pub(super) fn section<'a>(content: &Content<'a>) -> Option<Section<'a>> {
    let [open, close] = PAIR;
    let groups = [&content.figures.views, &content.figures.maps].map(|group| figures(group));
    let groups = groups.iter().filter(|figures| !figures.is_empty());
    let body: String = groups
        .map(|figures| format!("{open}{figures}{close}"))
        .collect();
    (!body.is_empty()).then(|| Section {
        id: "shape",
        title: "Shape of the object",
        body: body.into(),
    })
}
