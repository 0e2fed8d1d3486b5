//! Linear light and the bytes that stand for it.

/// The share of white light (0 to 1) that a byte of the sRGB curve (IEC 61966-2-1) stands for.
pub(super) fn linear_from_srgb(byte: u8) -> f32 {
    let coded = f32::from(byte) / 255.0;
    if coded <= 0.04045 {
        coded / 12.92
    } else {
        ((coded + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB value (0 to 1) of a share of white light (0 to 1).
pub(super) fn srgb_from_linear(light: f32) -> f32 {
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_round_trip() {
        for byte in 0..=255_u8 {
            let back = srgb_from_linear(linear_from_srgb(byte)) * 255.0;
            assert!(
                (back - f32::from(byte)).abs() < 0.01,
                "{byte} came back as {back}"
            );
        }
    }
}
