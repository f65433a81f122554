#!/bin/sh
# Puts the program, its entry in the desktop's menu, its icon, manual pages and licences below a folder, ~/.local unless another one is named.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
to=${1:-$HOME/.local}
mkdir -p "$to/bin" "$to/share/applications" "$to/share/icons/hicolor/scalable/apps" "$to/share/man/man1" "$to/share/doc/burstscope"
cp "$here/burstscope" "$to/bin/burstscope"
cp "$here/burstscope.desktop" "$to/share/applications/burstscope.desktop"
cp "$here/icon.svg" "$to/share/icons/hicolor/scalable/apps/burstscope.svg"
cp "$here"/share/man/man1/burstscope*.1.gz "$to/share/man/man1/"
cp "$here/LICENSE-APACHE" "$here/LICENSE-MIT" "$here/THIRD-PARTY.txt" "$to/share/doc/burstscope/"
echo "installed: $to/bin/burstscope"
