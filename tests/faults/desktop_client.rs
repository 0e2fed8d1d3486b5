//! What a person or a cable does to a desktop: a connection to the X server.

use x11rb::{
    connection::Connection,
    protocol::{
        randr::{ConnectionExt as _, GetCrtcInfoReply},
        xproto::{AtomEnum, ClientMessageEvent, ConnectionExt as _, EventMask, Window},
    },
    rust_connection::RustConnection,
};

use super::{display::Display, until};

/// A client of the X server.
pub(super) struct Desktop {
    connection: RustConnection,
    root: Window,
}

impl Desktop {
    pub(super) fn of(display: &Display) -> Self {
        let (_, name) = display.environment()[0];
        let (connection, screen) = RustConnection::connect(Some(name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Self { connection, root }
    }

    /// Waits until a window of this title is there.
    pub(super) fn window(&self, title: &str) -> Window {
        until(&format!("a window {title:?}"), || {
            let tree = self
                .connection
                .query_tree(self.root)
                .unwrap()
                .reply()
                .unwrap();
            tree.children
                .into_iter()
                .find(|&window| self.title(window) == title.as_bytes())
        })
    }

    fn title(&self, window: Window) -> Vec<u8> {
        let asked =
            self.connection
                .get_property(false, window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 64);
        // a window may end while it is asked
        asked
            .unwrap()
            .reply()
            .map_or_else(|_| Vec::new(), |reply| reply.value)
    }

    /// What a window manager's close button does.
    pub(super) fn close(&self, window: Window) {
        let atom = |name: &[u8]| {
            let asked = self.connection.intern_atom(false, name).unwrap();
            asked.reply().unwrap().atom
        };
        let delete = [atom(b"WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, atom(b"WM_PROTOCOLS"), delete);
        let sent = self
            .connection
            .send_event(false, window, EventMask::NO_EVENT, event);
        sent.unwrap().check().unwrap();
    }

    /// Unplugs the only monitor; gives what plugs it in again.
    pub(super) fn unplug(&self) -> impl FnOnce() + use<'_> {
        let resources = self.connection.randr_get_screen_resources(self.root);
        let resources = resources.unwrap().reply().unwrap();
        let crtc = resources.crtcs[0];
        let time = resources.config_timestamp;
        let before = self.connection.randr_get_crtc_info(crtc, time);
        let before: GetCrtcInfoReply = before.unwrap().reply().unwrap();
        let set = move |mode, outputs: &[u32]| {
            let asked = self.connection.randr_set_crtc_config(
                crtc,
                x11rb::CURRENT_TIME,
                time,
                before.x,
                before.y,
                mode,
                before.rotation,
                outputs,
            );
            asked.unwrap().reply().unwrap();
        };
        set(0, &[]);
        move || set(before.mode, &before.outputs)
    }
}
