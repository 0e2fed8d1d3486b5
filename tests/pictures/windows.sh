#!/usr/bin/env bash
# Makes the README's pictures of the acquirer's window anew: the real window in the demo's room, on a display nobody sees.
#   tests/pictures/windows.sh [SCENE]
# Needs xvfb, xdotool, imagemagick, python3, mesa-vulkan-drivers and the built programs (`rig test` installs and builds).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scene=${1:-cube}
work=$(mktemp -d)
programs=()
end() {
  for program in "${programs[@]}"; do kill "$program" 2>/dev/null || true; done
  wait || true
  rm -rf "$work"
}
trap end EXIT

Xvfb -displayfd 3 -screen 0 1280x690x24 -nolisten tcp -noreset 3>"$work/display" 2>/dev/null &
programs+=($!)
until [ -s "$work/display" ]; do sleep 0.2; done
DISPLAY=:$(tr -d '[:space:]' <"$work/display")
export DISPLAY WGPU_BACKEND=vulkan HOME=$work XDG_RUNTIME_DIR=$work ACQUIRER_WIDGETS=$work/widgets.json
unset WAYLAND_DISPLAY XDG_CONFIG_HOME
VK_ICD_FILENAMES=$(ls /usr/share/vulkan/icd.d/lvp_icd*.json | head -1)
export VK_ICD_FILENAMES

# A projector without a window, so that the acquirer's has the display for itself.
target=$here/../../target/debug
"$target/projector" --headless 1024x768 --listen 127.0.0.1:0 >"$work/projector" &
programs+=($!)
until [ -s "$work/projector" ]; do sleep 0.2; done
address=$(sed 's/listening on //' "$work/projector")
mkdir "$work/scans"
cd "$work/scans"
"$target/acquirer" demo --gui --scene "$scene" --projector "$address" --out "$scene" &
programs+=($!)

# The middle of a widget that can be used; the numbers of the list are pixels of the window, which fills the display.
place() {
  python3 - "$1" <<'PYTHON'
import json, os, sys
try:
    widgets = json.load(open(os.environ["ACQUIRER_WIDGETS"]))
except (OSError, ValueError):
    sys.exit(1)
found = [w for w in widgets if w["label"] == sys.argv[1] and w["enabled"]]
if not found:
    sys.exit(1)
print(int(found[0]["x"]), int(found[0]["y"]))
PYTHON
}
wait_for() {
  for _ in $(seq 600); do
    if place "$1" >/dev/null; then return; fi
    sleep 0.5
  done
  echo "windows.sh: waited for \"$1\" in vain" >&2
  exit 1
}
click() {
  local at
  wait_for "$1"
  at=$(place "$1")
  # shellcheck disable=SC2086  # two numbers
  xdotool mousemove $at sleep 0.5 click 1 sleep "${2:-3}"
}
shoot() {
  xdotool mousemove 640 689 sleep 2 # off every button
  import -window root -quality 90 "$here/$1"
}

wait_for "Open report"
shoot window-result.jpg
click "Colours"
click "Live"
click "Read" 1
sleep 12
shoot window-live.jpg
click "Scan"
click "Steps"
xdotool mousemove 700 520 sleep 0.5 click 1 sleep 3
shoot window-steps.jpg
