#!/usr/bin/env bash
# Installs each package of the folder that is named in a bare system of its own and starts it there; `make try-dist` calls it.
# Needs root; debootstrap is installed if it is missing. The system is Debian's smallest, with Python for the wheel.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath "${1:?name the folder with the packages}")

if [ "$(id -u)" != 0 ]; then
    echo "try: a system can be made by root only; run it as root" >&2
    exit 1
fi
if ! command -v debootstrap >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends debootstrap >/dev/null
fi
base=$(mktemp -d)
trap 'rm -rf "$base"' EXIT
suite=$(. /etc/os-release && echo "${VERSION_CODENAME:-stable}")
echo "== a bare $suite"
debootstrap --variant=minbase --include=python3,python3-venv "$suite" "$base/bare" >"$base/log" 2>&1 || {
    tail -20 "$base/log" >&2
    exit 1
}
echo "   $(du -sh "$base/bare" | cut -f1)"

fresh() {
    rm -rf "$base/root"
    cp -a "$base/bare" "$base/root"
    mkdir -p "$base/root/packages"
    cp "$out"/burstscope* "$base/root/packages/"
}

# Without a display, a driver or a network: the version, and the features of the demo burst.
start() {
    chroot "$base/root" /usr/bin/env -i HOME=/root PATH=/usr/bin:/bin:"$2" sh -euc "
        cd /tmp
        burstscope --version
        burstscope detect demo --slopes-u -3:3:7 --out found --quiet
        test -s found/demo.csv
        rm -r found"
    echo "   $1: started, features found"
}

# The notices of others' software: the text of rawler's licence, the way to build with another rawler, those of the fonts.
noticed() {
    for words in "GNU LESSER GENERAL PUBLIC LICENSE" "patch.crates-io" "UBUNTU FONT LICENCE" "SIL OPEN FONT LICENSE"; do
        chroot "$base/root" sh -c "grep -q '$words' $1" || {
            echo "try: no '$words' in $1" >&2
            exit 1
        }
    done
    echo "   notices: $1"
}

# The manual pages: the program's, and one of a command of two words.
documented() {
    for page in burstscope burstscope-evaluate-chart; do
        chroot "$base/root" sh -c "gzip -dc $1/$page.1.gz | grep -q '^.TH $page 1 '" || {
            echo "try: no page of $page in $1" >&2
            exit 1
        }
    done
    echo "   manual pages: $1"
}

for package in "$out"/burstscope-*.tar.gz; do
    echo "== $(basename "$package"), $(stat -c %s "$package") bytes"
    fresh
    chroot "$base/root" sh -euc "tar -xzf /packages/$(basename "$package") -C /opt && /opt/burstscope-*/install.sh /usr/local >/dev/null"
    start "portable package" /usr/local/bin
    noticed /usr/local/share/doc/burstscope/THIRD-PARTY.txt
    documented /usr/local/share/man/man1
done

for package in "$out"/burstscope_*.deb; do
    echo "== $(basename "$package"), $(stat -c %s "$package") bytes"
    fresh
    chroot "$base/root" dpkg --install "/packages/$(basename "$package")" >/dev/null
    start "Debian package" /usr/bin
    noticed /usr/share/doc/burstscope/THIRD-PARTY.txt
    documented /usr/share/man/man1
    chroot "$base/root" dpkg --remove burstscope >/dev/null
done

for package in "$out"/burstscope-*.whl; do
    echo "== $(basename "$package"), $(stat -c %s "$package") bytes"
    fresh
    # numpy comes as a wheel beside it, for the Python of the bare system, which has no network.
    python=$(chroot "$base/root" python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    "${PIP:-target/python/bin/pip}" download --quiet --disable-pip-version-check --only-binary :all: --python-version "$python" \
        --dest "$base/root/packages" numpy
    chroot "$base/root" /usr/bin/env -i HOME=/root PATH=/usr/bin:/bin sh -euc "
        python3 -m venv /opt/venv
        /opt/venv/bin/pip install --quiet --no-index --find-links /packages /packages/$(basename "$package")"
    start "wheel" /opt/venv/bin
    noticed "/opt/venv/lib/python*/site-packages/burstscope-*.dist-info/licenses/THIRD-PARTY.txt"
    chroot "$base/root" /opt/venv/bin/python -c "
import burstscope as bs
found = bs.detect(bs.open('demo'), slopes_u=(-3, 3, 7))
assert len(found) > 100 and found.descriptors.shape == (len(found), 128)
print('   module: %d features' % len(found))"
done
echo "all packages start in a bare system"
