//! What programs in the guest printed: lines of JSON, and what v4l2-ctl says of controls, in sections.
//!
//! A section is what stands between the line `== NAME` and the next one that begins with `==`.

use serde_json::Value;

/// The lines of a section.
fn lines<'a>(output: &'a str, name: &str) -> impl Iterator<Item = &'a str> {
    let head = format!("== {name}");
    let lines = output.lines().map(str::trim_end);
    lines
        .skip_while(move |line| *line != head)
        .skip(1)
        .take_while(|line| !line.starts_with("=="))
}

/// The JSON of a section; other lines are left out.
#[must_use]
pub fn section(output: &str, name: &str) -> Vec<Value> {
    lines(output, name)
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect()
}

/// The values that v4l2-ctl told of a control in a section.
#[must_use]
pub fn told<'a>(output: &'a str, name: &str, control: &str) -> Vec<&'a str> {
    lines(output, name)
        .filter_map(|line| line.strip_prefix(control)?.strip_prefix(": "))
        .collect()
}

/// What `camera_probe` told of one kind of event.
#[must_use]
pub fn events<'a>(section: &'a [Value], event: &str) -> Vec<&'a Value> {
    section
        .iter()
        .filter(|line| line["event"] == event)
        .collect()
}

/// The kinds of the errors that `camera_probe` told.
#[must_use]
pub fn error_kinds(section: &[Value]) -> Vec<&str> {
    let kinds = events(section, "error")
        .into_iter()
        .map(|error| error["kind"].as_str());
    kinds.flatten().collect()
}

/// Frames came after the trouble: the capture did not end for lack of time.
///
/// # Panics
/// When none did.
pub fn assert_frames_at_the_end(section: &[Value]) {
    let end = section.iter().position(|line| line["event"] == "end");
    let last = end
        .and_then(|end| end.checked_sub(1))
        .map(|last| &section[last]);
    assert!(
        last.is_some_and(|last| last["event"] == "frame"),
        "{section:?}"
    );
}
