//! The usual controls of cameras: numbers and menus of the kernel's `linux/v4l2-controls.h`.

/// V4L2's numbers of the controls that this program uses.
pub mod ids {
    /// Automatic white balance, a switch.
    pub const WHITE_BALANCE_AUTOMATIC: u32 = 0x0098_090c;
    /// Exposure of cameras that are not USB video class, in the driver's units.
    pub const EXPOSURE_OLD: u32 = 0x0098_0911;
    /// Automatic gain, a switch.
    pub const GAIN_AUTOMATIC: u32 = 0x0098_0912;
    /// Gain, in the camera's units.
    pub const GAIN: u32 = 0x0098_0913;
    /// The mains frequency that automatic exposure avoids: 0 none, 1 50 Hz, 2 60 Hz, 3 found by itself.
    pub const POWER_LINE_FREQUENCY: u32 = 0x0098_0918;
    /// Automatic hue, a switch.
    pub const HUE_AUTOMATIC: u32 = 0x0098_0919;
    /// Colour temperature of the light, in kelvin.
    pub const WHITE_BALANCE_TEMPERATURE: u32 = 0x0098_091a;
    /// Backlight compensation, 0 is none.
    pub const BACKLIGHT_COMPENSATION: u32 = 0x0098_091c;
    /// Who sets the exposure: 0 the camera, 1 we, 2 we the time alone, 3 we the aperture alone.
    pub const AUTO_EXPOSURE: u32 = 0x009a_0901;
    /// Exposure time in units of 100 microseconds.
    pub const EXPOSURE_TIME: u32 = 0x009a_0902;
    /// Whether the frame rate may fall in poor light, a switch.
    pub const EXPOSURE_DYNAMIC_FRAMERATE: u32 = 0x009a_0903;
    /// Focus distance in the camera's units.
    pub const FOCUS_ABSOLUTE: u32 = 0x009a_090a;
    /// Automatic focus, a switch.
    pub const FOCUS_AUTOMATIC: u32 = 0x009a_090c;
}

/// What is known of a usual control.
pub(in crate::camera) struct Standard {
    pub(in crate::camera) key: &'static str,
    pub(in crate::camera) unit: Option<&'static str>,
    /// Names of a menu's values, as the kernel has them.
    pub(in crate::camera) menu: &'static [&'static str],
}

/// What is known of a control, by its number.
pub(in crate::camera) fn standard(id: u32) -> Option<Standard> {
    let (key, unit): (_, Option<&'static str>) = match id {
        0x0098_0900 => ("brightness", None),
        0x0098_0901 => ("contrast", None),
        0x0098_0902 => ("saturation", None),
        0x0098_0903 => ("hue", None),
        ids::WHITE_BALANCE_AUTOMATIC => ("white_balance_automatic", None),
        0x0098_090e => ("red_balance", None),
        0x0098_090f => ("blue_balance", None),
        0x0098_0910 => ("gamma", None),
        ids::EXPOSURE_OLD => ("exposure", None),
        ids::GAIN_AUTOMATIC => ("gain_automatic", None),
        ids::GAIN => ("gain", None),
        ids::POWER_LINE_FREQUENCY => ("power_line_frequency", None),
        ids::HUE_AUTOMATIC => ("hue_automatic", None),
        ids::WHITE_BALANCE_TEMPERATURE => ("white_balance_temperature", Some("K")),
        0x0098_091b => ("sharpness", None),
        ids::BACKLIGHT_COMPENSATION => ("backlight_compensation", None),
        ids::AUTO_EXPOSURE => ("auto_exposure", None),
        ids::EXPOSURE_TIME => ("exposure_time_absolute", Some("x 100 us")),
        ids::EXPOSURE_DYNAMIC_FRAMERATE => ("exposure_dynamic_framerate", None),
        ids::FOCUS_ABSOLUTE => ("focus_absolute", None),
        ids::FOCUS_AUTOMATIC => ("focus_automatic_continuous", None),
        0x009a_090d => ("zoom_absolute", None),
        0x009a_0911 => ("iris_absolute", None),
        _ => return None,
    };
    let menu: &[&str] = match id {
        ids::POWER_LINE_FREQUENCY => &["Disabled", "50 Hz", "60 Hz", "Auto"],
        ids::AUTO_EXPOSURE => &[
            "Auto Mode",
            "Manual Mode",
            "Shutter Priority Mode",
            "Aperture Priority Mode",
        ],
        _ => &[],
    };
    Some(Standard { key, unit, menu })
}

/// Controls that decide whether a scan can be read, in the order in which one sets them.
const FIRST_SET: [u32; 12] = [
    ids::AUTO_EXPOSURE,
    ids::EXPOSURE_TIME,
    ids::EXPOSURE_OLD,
    ids::EXPOSURE_DYNAMIC_FRAMERATE,
    ids::GAIN_AUTOMATIC,
    ids::GAIN,
    ids::WHITE_BALANCE_AUTOMATIC,
    ids::WHITE_BALANCE_TEMPERATURE,
    ids::FOCUS_AUTOMATIC,
    ids::FOCUS_ABSOLUTE,
    ids::POWER_LINE_FREQUENCY,
    ids::BACKLIGHT_COMPENSATION,
];

/// Where a control stands in a list for people; those of no great weight all stand behind.
pub(super) fn place_in_list(id: u32) -> usize {
    let first = FIRST_SET.iter().position(|&known| known == id);
    first.unwrap_or(FIRST_SET.len())
}

/// The number of a control by another usual word: a short one, or that of older kernels.
pub(super) fn alias(word: &str) -> Option<u32> {
    Some(match word {
        "exposure" | "exposure_time" | "exposure_absolute" => ids::EXPOSURE_TIME,
        "exposure_auto" => ids::AUTO_EXPOSURE,
        "exposure_auto_priority" => ids::EXPOSURE_DYNAMIC_FRAMERATE,
        "white_balance" | "temperature" => ids::WHITE_BALANCE_TEMPERATURE,
        "auto_white_balance" | "white_balance_temperature_auto" => ids::WHITE_BALANCE_AUTOMATIC,
        "auto_gain" | "autogain" => ids::GAIN_AUTOMATIC,
        "focus" => ids::FOCUS_ABSOLUTE,
        "auto_focus" | "autofocus" | "focus_auto" => ids::FOCUS_AUTOMATIC,
        "mains" => ids::POWER_LINE_FREQUENCY,
        _ => return None,
    })
}
