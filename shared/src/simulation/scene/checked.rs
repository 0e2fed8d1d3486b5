//! Numbers of a scene file that are checked while it is read, so that an error names the line.

use serde::{Deserialize, Deserializer, de::Error};

fn checked<'de, D: Deserializer<'de>>(
    from: D,
    accept: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<f64, D::Error> {
    let value = f64::deserialize(from)?;
    if accept(value) {
        Ok(value)
    } else {
        Err(D::Error::custom(format!(
            "the value is {value}, it must be {expected}"
        )))
    }
}

fn checked_array<'de, D: Deserializer<'de>, const N: usize>(
    from: D,
    accept: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<[f64; N], D::Error>
where
    [f64; N]: Deserialize<'de>,
{
    let values = <[f64; N]>::deserialize(from)?;
    values
        .iter()
        .find(|v| !accept(**v))
        .map_or(Ok(values), |value| {
            Err(D::Error::custom(format!(
                "one of the values is {value}, it must be {expected}"
            )))
        })
}

/// Lengths beyond a kilometre are typing errors, and squares of them still far from overflow.
const LARGEST: f64 = 1e6;

/// What must not be 0 is at least this, so that its inverse stays in range too.
const SMALLEST: f64 = 1e-6;

/// From a millionth to a million.
pub(super) fn positive<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(
        from,
        |v| (SMALLEST..=LARGEST).contains(&v),
        "from 0.000001 to 1000000",
    )
}

/// From 0 to a million.
pub(super) fn non_negative<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |v| (0.0..=LARGEST).contains(&v), "from 0 to 1000000")
}

/// From 0.2 to 5.
pub(super) fn exponent<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |v| (0.2..=5.0).contains(&v), "from 0.2 to 5")
}

/// From 0 to 0.95: at 1 the curve would be flat at its ends.
pub(super) fn contrast<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |v| (0.0..=0.95).contains(&v), "from 0 to 0.95")
}

/// From 0 to 1.
pub(super) fn fraction<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |v| (0.0..=1.0).contains(&v), "from 0 to 1")
}

/// A blur in px: from 0 to 10.
pub(super) fn blur<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |v| (0.0..=10.0).contains(&v), "from 0 to 10 px")
}

/// Between minus and plus a million.
pub(super) fn finite<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |v| v.abs() <= LARGEST, "between -1000000 and 1000000")
}

/// Numbers between minus and plus a million.
pub(super) fn finite_array<'de, D: Deserializer<'de>, const N: usize>(
    from: D,
) -> Result<[f64; N], D::Error>
where
    [f64; N]: Deserialize<'de>,
{
    checked_array(from, |v| v.abs() <= LARGEST, "between -1000000 and 1000000")
}

/// Numbers from a millionth to a million.
pub(super) fn positive_array<'de, D: Deserializer<'de>, const N: usize>(
    from: D,
) -> Result<[f64; N], D::Error>
where
    [f64; N]: Deserialize<'de>,
{
    checked_array(
        from,
        |v| (SMALLEST..=LARGEST).contains(&v),
        "from 0.000001 to 1000000",
    )
}

/// Displacements of up to 10 px, x and y for each of red, green and blue.
pub(super) fn shifts<'de, D: Deserializer<'de>>(from: D) -> Result<[[f64; 2]; 3], D::Error> {
    let shifts = <[[f64; 2]; 3]>::deserialize(from)?;
    let fits = shifts.as_flattened().iter().all(|v| v.abs() <= 10.0);
    fits.then_some(shifts)
        .ok_or_else(|| D::Error::custom("each value must be between -10 and 10 px"))
}

/// A 3 x 3 matrix of entries from 0 to 2.
pub(super) fn mixing<'de, D: Deserializer<'de>>(from: D) -> Result<[[f64; 3]; 3], D::Error> {
    let matrix = <[[f64; 3]; 3]>::deserialize(from)?;
    let fits = matrix
        .as_flattened()
        .iter()
        .all(|v| (0.0..=2.0).contains(v));
    fits.then_some(matrix)
        .ok_or_else(|| D::Error::custom("each entry must be from 0 to 2"))
}

/// A side of a raster: 8 to 4096 px.
pub(super) fn side<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    let value = u32::deserialize(from)?;
    let fits = (8..=4096).contains(&value);
    fits.then_some(value)
        .ok_or_else(|| D::Error::custom(format!("the value is {value}, it must be 8 to 4096 px")))
}

/// A JPEG quality: 0 (no JPEG) or 1 to 100.
pub(super) fn quality<'de, D: Deserializer<'de>>(from: D) -> Result<u8, D::Error> {
    let value = u8::deserialize(from)?;
    (value <= 100)
        .then_some(value)
        .ok_or_else(|| D::Error::custom(format!("the value is {value}, it must be 0 to 100")))
}
