#!/bin/sh
# Puts the program, its entry in the desktop's menu and its icon below a folder, ~/.local unless another one is named.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
to=${1:-$HOME/.local}
mkdir -p "$to/bin" "$to/share/applications" "$to/share/icons/hicolor/scalable/apps"
cp "$here/burstscope" "$to/bin/burstscope"
cp "$here/burstscope.desktop" "$to/share/applications/burstscope.desktop"
cp "$here/icon.svg" "$to/share/icons/hicolor/scalable/apps/burstscope.svg"
echo "installed: $to/bin/burstscope"
