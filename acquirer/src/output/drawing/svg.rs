//! Drawings as SVG elements, to lie over a picture in an HTML page.

use super::{Anchor, Drawing, Form, Ink, Mark, Text};

impl Drawing {
    /// An `svg` element of the drawing's size with `class`, in front of what `below` holds (SVG elements).
    #[must_use]
    pub fn svg(&self, class: &str, below: &str) -> String {
        let [width, height] = self.size;
        let marks: String = self.marks.iter().map(element).collect();
        format!(
            "<svg class=\"{class}\" viewBox=\"0 0 {} {}\" role=\"img\">{below}{marks}</svg>\n",
            number(width),
            number(height)
        )
    }
}

/// A text made safe for HTML and XML, inside of elements and quoted attributes.
#[must_use]
pub(in crate::output) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // XML knows no other control characters, and no non-characters
            c if (c.is_control() && c != '\n' && c != '\t')
                || matches!(c, '\u{fffe}' | '\u{ffff}') =>
            {
                safe.push(' ');
            }
            c => safe.push(c),
        }
    }
    safe
}

fn element(mark: &Mark) -> String {
    if !is_finite(&mark.form) {
        return String::new();
    }
    let title = mark.title.as_ref().map_or(String::new(), |title| {
        format!("<title>{}</title>", escaped(title))
    });
    match &mark.form {
        Form::Stroke { points, width, ink } => format!(
            "<polyline points=\"{}\" fill=\"none\" {} stroke-width=\"{}\">{title}</polyline>",
            list(points),
            painted("stroke", *ink),
            number(*width)
        ),
        Form::Area { points, ink } => format!(
            "<polygon points=\"{}\" {}>{title}</polygon>",
            list(points),
            painted("fill", *ink)
        ),
        Form::Disc {
            centre: [x, y],
            radius,
            ink,
        } => format!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}>{title}</circle>",
            number(*x),
            number(*y),
            number(*radius),
            painted("fill", *ink)
        ),
        Form::Text(text) => text_element(text, &title),
    }
}

fn text_element(text: &Text, title: &str) -> String {
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let halo = text.halo.map_or(String::new(), |ink| {
        format!(
            " {} stroke-width=\"{}\" paint-order=\"stroke\" stroke-linejoin=\"round\"",
            painted("stroke", ink),
            number(0.25 * text.size)
        )
    });
    format!(
        "<text x=\"{}\" y=\"{}\" dy=\"0.35em\" font-size=\"{}\" text-anchor=\"{anchor}\" {}{halo}>{}{title}</text>",
        number(text.at[0]),
        number(text.at[1]),
        number(text.size),
        painted("fill", text.ink),
        escaped(&text.text),
    )
}

fn painted(what: &str, ink: Ink) -> String {
    if ink.opacity < 1.0 {
        let opacity = number(ink.opacity);
        format!("{what}=\"{}\" {what}-opacity=\"{opacity}\"", ink.colour)
    } else {
        format!("{what}=\"{}\"", ink.colour)
    }
}

fn list(points: &[[f64; 2]]) -> String {
    let pairs: Vec<_> = points
        .iter()
        .map(|[x, y]| format!("{},{}", number(*x), number(*y)))
        .collect();
    pairs.join(" ")
}

/// Two digits after the point at most: a hundredth of a camera pixel can't be seen.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0" } else { short }.to_owned()
}

fn is_finite(form: &Form) -> bool {
    let finite = |p: &[f64; 2]| p.iter().all(|v| v.is_finite());
    match form {
        Form::Stroke { points, width, .. } => points.iter().all(finite) && width.is_finite(),
        Form::Area { points, .. } => points.iter().all(finite),
        Form::Disc { centre, radius, .. } => finite(centre) && radius.is_finite(),
        Form::Text(text) => finite(&text.at) && text.size.is_finite(),
    }
}
