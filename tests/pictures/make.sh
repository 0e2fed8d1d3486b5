#!/usr/bin/env bash
# Makes the README's pictures anew from a run of the demo.   tests/pictures/make.sh [SCAN]
# SCAN: the folder of a demo that has been run already. Needs imagemagick and the built programs.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scan=${1:-}
if [ -z "$scan" ]; then
  scan=$(mktemp -d)/scan
  "$here/../../target/debug/acquirer" demo --scene cube --out "$scan"
fi
pictures=$scan/results/pictures
small() { convert "$1" -resize "480x" -quality 90 "$here/$2"; }

convert \( "$pictures/labels-object.png" -resize x420 \) \( "$pictures/view-depth.png" -resize x420 \) \
  +append -quality 92 "$here/overview.jpg"
small "$scan/object/prmvs-00.png" 0-capture.jpg
small "$pictures/object-01-mask.png" 1-reference.png
small "$pictures/object-02-gain.png" 2-gain.jpg
small "$pictures/object-03-lines.png" 3-lines.jpg
small "$pictures/object-04-crossings.png" 4-crossings.jpg
small "$pictures/labels-object.png" 5-grid.jpg
small "$pictures/shift-map.png" 6-shift.jpg
small "$pictures/view-picture.png" 7-surface.jpg
