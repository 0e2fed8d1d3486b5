#!/usr/bin/env bash
# Makes the README's pictures of both windows anew, out of the session by mouse of tests/window_session.rs.
#   tests/pictures/windows.sh [WIDTHxHEIGHT [FOLDER]]      size of the acquirer's window, where the pictures go
# Needs what the tests need (`rig test` installs it), and imagemagick.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
size=${1:-1280x720}
folder=${2:-tests/pictures}
seen=$(mktemp -d)
trap 'rm -r "$seen"' EXIT

cargo build --workspace
WINDOW_SIZE=$size WINDOW_PICTURES=$seen cargo test --workspace --test window_session
for picture in "$seen"/*.png; do
  convert "$picture" -strip -quality 88 "$folder/window-$(basename "$picture" .png).jpg"
done
