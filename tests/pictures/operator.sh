#!/usr/bin/env bash
# Makes the README's picture of the operator's window anew: the real window on a display nobody sees, while a client
# shows the coded grid.   tests/pictures/operator.sh
# Needs xvfb, xdotool, x11-apps, imagemagick and the built programs.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
unset WAYLAND_DISPLAY
cleanup() {
  kill ${projector:-} ${server:-} 2>/dev/null || true
  rm -r "$work"
}
trap cleanup EXIT

Xvfb -displayfd 3 -nolisten tcp -noreset -screen 0 2200x800x24 3>"$work/display" 2>/dev/null &
server=$!
until [ -s "$work/display" ]; do sleep 0.1; done
DISPLAY=:$(cat "$work/display")
export DISPLAY
"$here/../../target/debug/projector" --windowed 1024x768 --operator --listen 127.0.0.1:0 >"$work/said" 2>"$work/log" &
projector=$!
until grep -q '^listening on' "$work/said"; do sleep 0.1; done
port=$(sed -n 's/^listening on .*://p' "$work/said")
xdotool search --sync --name '^projector - operator$' windowmove --sync 1040 10

exec 4<>"/dev/tcp/127.0.0.1/$port"
printf '%s\n' '{"type":"hello","version":1,"role":"controller","name":"acquirer on bench-2"}' \
  '{"id":1,"type":"show","view":{"kind":"coded"}}' >&4
until grep -m1 -q '"done"' <&4; do sleep 0.1; done
sleep 3   # the window follows a moment later
xwd -silent -name 'projector - operator' >"$work/window.xwd"
convert "xwd:$work/window.xwd" -strip "$here/operator.png"
