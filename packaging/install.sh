#!/bin/sh
# Puts the program, its entry in the desktop's menu, its icon and its licences below a folder, ~/.local unless another one is named.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
to=${1:-$HOME/.local}
mkdir -p "$to/bin" "$to/share/applications" "$to/share/icons/hicolor/scalable/apps" "$to/share/doc/burstscope"
cp "$here/burstscope" "$to/bin/burstscope"
cp "$here/burstscope.desktop" "$to/share/applications/burstscope.desktop"
cp "$here/icon.svg" "$to/share/icons/hicolor/scalable/apps/burstscope.svg"
cp "$here/LICENSE-APACHE" "$here/LICENSE-MIT" "$here/THIRD-PARTY.txt" "$to/share/doc/burstscope/"
echo "installed: $to/bin/burstscope"
