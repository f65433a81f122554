#!/usr/bin/env bash
# Makes the portable .tar.gz and the .deb, in the folder that is named, of the program in target/release or in the place that PROGRAM names;
# `make dist` calls it.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$(realpath -m "${1:?name the folder for the packages}")
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)
triple=$(rustc -vV | sed -n 's/^host: //p')
program=${PROGRAM:-target/release/burstscope}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"
rm -f "$out"/burstscope-*.tar.gz "$out"/burstscope_*.deb

# Manual pages: the program's, and those of the commands that a page names.
pages=$work/man1
mkdir "$pages"
write_pages() {
    local name=burstscope word
    for word; do name=$name-$word; done
    "$program" man "$@" >"$pages/$name.1"
    for word in $(sed -n "s/\\\\-/-/g; s/^$name-\(.*\)(1)$/\1/p" "$pages/$name.1"); do
        write_pages "$@" "$word"
    done
}
write_pages
gzip -9n "$pages"/*

# The portable package: one folder that runs from anywhere.
name=burstscope-$version-$triple
mkdir "$work/$name"
install -m 755 "$program" "$work/$name/"
strip "$work/$name/burstscope"
install -m 644 assets/burstscope.desktop assets/icon.svg README.md CITATION.cff LICENSE-APACHE LICENSE-MIT assets/THIRD-PARTY.txt "$work/$name/"
install -m 755 packaging/install.sh "$work/$name/"
install -Dm 644 "$pages"/* -t "$work/$name/share/man/man1"
tar -C "$work" --owner=0 --group=0 --sort=name -czf "$out/$name.tar.gz" "$name"

if ! command -v dpkg-deb >/dev/null; then
    echo "dist: no dpkg-deb here, so no .deb is made" >&2
else
    # What the program was linked with decides the oldest system on which it starts.
    glibc=$(objdump -T "$work/$name/burstscope" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -1 | sed s/GLIBC_//)
    architecture=$(dpkg --print-architecture)
    root=$work/deb
    install -Dm 755 "$work/$name/burstscope" "$root/usr/bin/burstscope"
    install -Dm 644 assets/burstscope.desktop "$root/usr/share/applications/burstscope.desktop"
    install -Dm 644 assets/icon.svg "$root/usr/share/icons/hicolor/scalable/apps/burstscope.svg"
    install -Dm 644 "$pages"/* -t "$root/usr/share/man/man1"
    install -Dm 644 README.md "$root/usr/share/doc/burstscope/README"
    install -Dm 644 assets/THIRD-PARTY.txt CITATION.cff -t "$root/usr/share/doc/burstscope"
    {
        cat LICENSE-MIT LICENSE-APACHE
        printf '\nLicences of software of others in the program: /usr/share/doc/burstscope/THIRD-PARTY.txt\n'
    } >"$work/copyright"
    install -Dm 644 "$work/copyright" "$root/usr/share/doc/burstscope/copyright"
    mkdir "$root/DEBIAN"
    cat >"$root/DEBIAN/control" <<CONTROL
Package: burstscope
Version: $version
Architecture: $architecture
Maintainer: Burstscope contributors
Section: science
Priority: optional
Installed-Size: $(du -sk "$root/usr" | cut -f1)
Depends: libc6 (>= $glibc), libgcc-s1
Recommends: libxkbcommon-x11-0, libxcursor1, libxi6, libwayland-client0, mesa-vulkan-drivers
Description: desktop inspector for burst features
 Burst features are found in a whole burst of dark, noisy frames at once: shift
 and sum the frames for every plausible apparent motion, filter each sum over
 scales, and keep what stands out in place, scale and slope. The window shows
 every step and says why there is a feature or none; the commands write features
 and matches for COLMAP.
CONTROL
    dpkg-deb --root-owner-group --build "$root" "$out/burstscope_${version}_$architecture.deb" >/dev/null
    echo "the program needs glibc $glibc or newer"
fi

(cd "$out" && du -h --apparent-size burstscope*)
