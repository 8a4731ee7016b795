#!/usr/bin/env bash
# The part of scripts/debian-packages inside a tree, as root, in a mount namespace of its own: debian_packages.bash
# [--record]. build/packages/clsdf has the sources, with debian/. The packages appear in build/packages.
set -euo pipefail
sources=$PWD
# Always the same folder, so that what one checkout has compiled serves all.
mkdir -p /build
mount --bind build/packages /build
cd /build/clsdf

quiet() {
    "$@" </dev/null >/build/log 2>&1 || {
        tail -n 40 /build/log >&2
        echo "debian-packages: '$*' failed; its whole output is in build/packages/log of the tree" >&2
        exit 1
    }
}
if ! dpkg-checkbuilddeps 2>/dev/null || ! command -v lintian abidiff >/dev/null; then
    echo "== Installing what the build needs"
    quiet apt-get -qq update
    quiet apt-get -qq install -y --no-install-recommends dpkg-dev lintian abigail-tools xz-utils
    quiet apt-get -qq build-dep -y --no-install-recommends ./
fi

echo "== Building"
began=$SECONDS
# Without packages of debug information.
quiet env DEB_BUILD_OPTIONS="noautodbgsym terse" dpkg-buildpackage -b -us -uc
mv /build/log /build/build.log
echo "== $((SECONDS - began)) s"

# Snapshots close no bug of Debian, and have no bug that asks for the package.
echo "== lintian"
lintian --allow-root --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs ../clsdf_*.changes

# The interfaces, as abidw reads them in the debug information: what the public headers declare. A record depends on the
# compiler and on abidw, so only Debian 12 has them. Each is named after a library's SONAME: another SONAME may have another
# interface.
[ "$(. /etc/os-release && echo "$VERSION_ID")" = 12 ] || exit 0
echo "== The interfaces"
abi_of() {
    abidw --exported-interfaces-only --drop-private-types --no-corpus-path --no-comp-dir-path --no-show-locs \
        --headers-dir lib/include --headers-dir bindings/c/include "$1"
}
unfit=
for library in obj-*/{lib,bindings/c}/libclsdf*.so; do
    soname=$(objdump -p "$library" | sed -n 's/^ *SONAME *//p')
    record=packaging/abi/$soname.abi.xz
    abi_of "$library" >"../$soname.abi"
    if [ -e "$record" ]; then
        xz -d <"$record" >"../recorded.abi"
        # Structs of C may grow.
        growth=()
        [[ $soname != libclsdf_c* ]] || growth=(--suppressions packaging/abi/growth.abignore)
        abidiff --no-added-syms "${growth[@]}" ../recorded.abi "../$soname.abi" &&
            echo "$soname: as recorded" || unfit+=" $soname"
    elif [ "${1-}" != --record ]; then
        echo "$soname: there is no record; scripts/release makes it"
    fi
    [ "${1-}" != --record ] || xz -9 "../$soname.abi"
done
[ -z "$unfit" ] || {
    echo "debian-packages: the interface differs from its record:$unfit. See above. Programs that were compiled with the" \
        "recorded one break. If it was never released, delete the record in packaging/abi; otherwise see \"What stays\" in" \
        "docs/install.md" >&2
    exit 1
}
