# Sourced by every script of this folder before it does anything. If the script's first argument is -h or --help, the
# script prints its head comment and ends.

head_comment=$(sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0")
case ${1-} in
    -h | --help)
        printf '%s\n' "$head_comment"
        exit 0
        ;;
esac

# Ends a script that was called with wrong arguments.
usage() {
    printf '%s\n' "$head_comment" >&2
    exit 2
}

# existing_file FILE prints its absolute path. Without such a file the script ends before any work.
existing_file() {
    if [ ! -f "$1" ]; then
        echo "${0##*/}: no such file: $1" >&2
        exit 3
    fi
    realpath -- "$1"
}

# existing_folder FOLDER does the same for a folder.
existing_folder() {
    if [ ! -d "$1" ]; then
        echo "${0##*/}: no such folder: $1" >&2
        exit 3
    fi
    realpath -- "$1"
}

# is_installed PACKAGE: dpkg also knows packages that were removed.
is_installed() {
    dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed
}

# install_missing PACKAGE ... installs those of Debian's packages that are not installed. If it may not, or they cannot be
# had, it fails, and `missing` names them.
install_missing() {
    local package
    missing=
    for package; do is_installed "$package" || missing+=" $package"; done
    missing=${missing# }
    [ -n "$missing" ] || return 0
    [ "$(id -u)" -eq 0 ] || return 1
    echo "Installing $missing"
    # shellcheck disable=SC2086
    { apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends $missing; } \
        </dev/null >/dev/null
}

# source_commit prints the commit of the sources in this folder, with -dirty if they differ from it; nothing without git.
# The records of runs are no sources.
source_commit() {
    local commit
    commit=$(git rev-parse --short HEAD 2>/dev/null) || return 0
    [ -z "$(git status --porcelain -- . ':!benchmarks/*.md')" ] || commit+=-dirty
    echo "$commit"
}

# debian_mirror prints the mirror of Debian that this machine's apt uses. Without one the script ends.
debian_mirror() {
    local codename mirror
    codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-none}")
    mirror=$(apt-get update --print-uris 2>/dev/null |
        sed -nE "s|^'(.*)/dists/($codename\|stable\|testing\|unstable\|sid)/(In)?Release'.*|\1|p" | head -n 1)
    if [ -z "$mirror" ]; then
        echo "${0##*/}: apt is configured for no mirror of Debian" >&2
        exit 2
    fi
    echo "$mirror"
}

# fetch_source POOL/FILE SHA256 FOLDER downloads a source of Debian's archive, as o/onetbb/onetbb_2021.8.0.orig.tar.xz, from the
# archives that apt is configured for. It fails if none of them has it, or another one.
fetch_source() {
    local archive
    for archive in $(apt-get update --print-uris 2>/dev/null | sed -nE "s|^'(.*)/dists/.*/(In)?Release'.*|\1|p" | uniq); do
        ! /usr/lib/apt/apt-helper download-file "$archive/pool/main/$1" "$3/${1##*/}" "SHA256:$2" >/dev/null 2>&1 || return 0
    done
    return 1
}

# clang_14 PROGRAM prints the name of version 14 of clang-format or clang-tidy: results of other versions differ.
clang_14() {
    local version
    if command -v "$1-14"; then return; fi
    version=$("$1" --version 2>/dev/null | sed -n 's/.*version \([0-9]*\)\..*/\1/p' | head -n 1)
    if [ "$version" != 14 ]; then
        echo "${0##*/}: needs $1 14${version:+, and this is $version}; on Debian 12: apt-get install $1-14" >&2
        exit 2
    fi
    echo "$1"
}

# source_version [FOLDER] prints the version of the sources there, or here: CMakeLists.txt reads it in the same file.
source_version() {
    sed -n 's/^#define CLSDF_VERSION_\(MAJOR\|MINOR\|PATCH\) \([0-9]*\)$/\2/p' "${1:-.}/lib/include/clsdf/version.hpp" |
        paste -s -d .
}

# step PROGRAM [ARGUMENT...] runs it between two lines: the command, and the seconds that it took. It returns the
# program's status, also under "||", where bash would not end the script.
step() {
    local began=$SECONDS status=0
    echo "== $*"
    "$@" || status=$?
    echo "== $((SECONDS - began)) s: $*"
    return $status
}
