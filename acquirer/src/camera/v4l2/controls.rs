//! Controls of a V4L2 device by their numbers, on a second handle to it.
//!
//! The v4l crate's list of controls panics on control types newer than itself, which newer kernels give to USB
//! cameras. So each control is asked for by itself, through v4l2r. Left out are controls that are no single number:
//! buttons, texts, bit masks, 64-bit numbers, rectangles.

use std::fs::File;
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use v4l::control::{MenuItem as NamedItem, Type};
use v4l2r::bindings::{v4l2_query_ext_ctrl, v4l2_querymenu};
use v4l2r::ioctl::{CtrlId, QueryCtrlFlags, g_ctrl, query_ext_ctrl, querymenu, s_ctrl};
use v4l2r::nix::errno::Errno;

use super::kept::ControlPort;
use super::list::{guarded, open_error};
use crate::camera::CameraError;
use crate::camera::controls::{ControlInfo, ControlKind, MenuItem, key_of, standard};

/// Do not wait in `open`.
const O_NONBLOCK: i32 = 0o4000;
/// Flags of linux/videodev2.h: never there, read only, in another control's hand, not readable.
const DISABLED: u32 = 0x0001;
const READ_ONLY: u32 = 0x0004;
const INACTIVE: u32 = 0x0010;
const WRITE_ONLY: u32 = 0x0040;
/// No camera has more controls: an end for a driver that counts in circles.
const MOST_CONTROLS: usize = 512;
/// No menu is longer.
const MOST_ITEMS: i64 = 64;

/// The controls of a camera that nobody needs to have opened.
///
/// # Errors
/// When the device cannot be opened or asked.
pub fn list_controls(path: &Path) -> Result<Vec<ControlInfo>, CameraError> {
    let handle = ControlHandle::open(path)?;
    handle.list().map_err(|error| asking(path, &error))
}

/// The error of asking a device for its controls.
pub(super) fn asking(path: &Path, error: &io::Error) -> CameraError {
    CameraError::Setup {
        path: path.into(),
        step: "asking for its controls",
        reason: error.to_string(),
    }
}

/// A device that is open for its controls alone.
pub(super) struct ControlHandle {
    file: File,
    path: PathBuf,
}

impl ControlHandle {
    pub(super) fn open(path: &Path) -> Result<Self, CameraError> {
        let file = File::options()
            .read(true)
            .write(true)
            .custom_flags(O_NONBLOCK)
            .open(path)
            .map_err(|error| open_error(path, &error))?;
        Ok(Self {
            file,
            path: path.into(),
        })
    }

    fn info(
        &self,
        control: &v4l2_query_ext_ctrl,
        names: &mut Option<Names>,
    ) -> Option<ControlInfo> {
        let known = standard(control.id);
        let kind = match control.type_ {
            kind if kind == Type::Integer as u32 => ControlKind::Number {
                least: control.minimum,
                most: control.maximum,
                step: control.step.max(1),
            },
            kind if kind == Type::Boolean as u32 => ControlKind::Switch,
            kind if kind == Type::Menu as u32 || kind == Type::IntegerMenu as u32 => {
                let usual = known.as_ref().map_or(&[][..], |known| known.menu);
                ControlKind::Menu {
                    items: self.items(control, usual, names),
                }
            }
            _ => return None,
        };
        let name = text(&control.name);
        let readable = control.flags & WRITE_ONLY == 0;
        Some(ControlInfo {
            id: control.id,
            key: known
                .as_ref()
                .map_or_else(|| key_of(&name), |known| known.key.into()),
            name,
            kind,
            unit: known.and_then(|known| known.unit),
            default: control.default_value,
            value: readable.then(|| self.get(control.id).ok()).flatten(),
            inactive: control.flags & INACTIVE != 0,
            read_only: control.flags & READ_ONLY != 0,
        })
    }

    /// The items that the driver has of a menu. It leaves out some between the least and the most.
    fn items(
        &self,
        control: &v4l2_query_ext_ctrl,
        usual: &[&str],
        names: &mut Option<Names>,
    ) -> Vec<MenuItem> {
        let last = control
            .maximum
            .min(control.minimum.saturating_add(MOST_ITEMS));
        let there = (control.minimum..=last).filter_map(|value| {
            let index = u32::try_from(value).ok()?;
            querymenu::<v4l2_querymenu>(&self.file, control.id, index).ok()?;
            Some((value, index))
        });
        there
            .map(|(value, index)| {
                let usual = usual.get(index as usize).map(|name| (*name).to_owned());
                let name = usual.or_else(|| {
                    let names = names.get_or_insert_with(|| self.names());
                    let item = names
                        .iter()
                        .find(|(id, k, _)| (*id, *k) == (control.id, index));
                    item.map(|(_, _, name)| name.clone())
                });
                MenuItem {
                    value,
                    name: name.unwrap_or_else(|| value.to_string()),
                }
            })
            .collect()
    }

    /// The names of all menu items as v4l reads them; none where it cannot read the list.
    fn names(&self) -> Names {
        let read = || v4l::Device::with_path(&self.path)?.query_controls();
        let controls = guarded(read).unwrap_or_default();
        let items = controls.into_iter().flat_map(|control| {
            let items = control.items.unwrap_or_default();
            items.into_iter().map(move |(index, item)| {
                let name = match item {
                    NamedItem::Name(name) => name,
                    NamedItem::Value(value) => value.to_string(),
                };
                // a name shorter than its field may be followed by anything
                let name = name.split('\0').next().unwrap_or_default().to_owned();
                (control.id, index, name)
            })
        });
        items.collect()
    }
}

/// Names of menu items, by control and index.
type Names = Vec<(u32, u32, String)>;

impl ControlPort for ControlHandle {
    fn list(&self) -> io::Result<Vec<ControlInfo>> {
        let (mut controls, mut names, mut last) = (Vec::new(), None, 0);
        for _ in 0..MOST_CONTROLS {
            let id = CtrlId::new(last).map_err(io::Error::other)?;
            let next = query_ext_ctrl::<v4l2_query_ext_ctrl>(&self.file, id, QueryCtrlFlags::NEXT);
            let control = match next {
                Ok(control) if control.id > last => control,
                // the end of the list; a device without controls has no such call
                Ok(_) => break,
                Err(error) => match Errno::from(error) {
                    Errno::EINVAL | Errno::ENOTTY => break,
                    errno => return Err(errno.into()),
                },
            };
            last = control.id;
            if control.flags & DISABLED == 0 {
                controls.extend(self.info(&control, &mut names));
            }
        }
        Ok(controls)
    }

    fn get(&self, id: u32) -> io::Result<i64> {
        let value = g_ctrl(&self.file, id).map_err(Errno::from)?;
        Ok(value.into())
    }

    fn set(&self, id: u32, value: i64) -> io::Result<i64> {
        let number = i32::try_from(value).map_err(io::Error::other)?;
        let taken = s_ctrl(&self.file, id, number).map_err(Errno::from)?;
        // what it is now tells more than the answer, unless it cannot be read
        Ok(self.get(id).unwrap_or_else(|_| taken.into()))
    }
}

/// The text of a C string in a field.
fn text(field: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = field
        .iter()
        .map(|byte| byte.cast_unsigned())
        .take_while(|byte| *byte != 0)
        .collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
