#!/usr/bin/env bash
# The part of scripts/try-wheel inside a tree, as root, in a mount namespace of its own: try_wheel.bash FILES
# bare|compilers|pocl. FILES has the wheel and all that it needs. Users' programs run as a user without rights.
set -euo pipefail
sources=$(cd "$(dirname "$0")/.." && pwd -P)
files=$(cd "$1" && pwd -P)
system=$2
env=/opt/clsdf-env
work=/opt/clsdf-try
homes=/opt/clsdf-homes
view=/opt/clsdf-sources
user=1234

fail() {
    echo "try-wheel: $*" >&2
    exit 1
}
say() { echo " $*"; }
# as_user HOME COMMAND ...: in a folder of its own, with these variables and no others.
as_user() {
    local home=$1
    shift
    (cd $work && setpriv --reuid $user --regid $user --clear-groups env -i HOME="$home" PATH=$env/bin:/usr/bin:/bin LANG=C.UTF-8 \
        PYTHONDONTWRITEBYTECODE=1 "$@")
}
try() { as_user "$1" ${level:+POCL_AOT_LEVEL=$level} ${kernels:+POCL_KERNELLIB_NAME=$kernels} $env/bin/python "$sources/packaging/try_wheel.py" "$2" "$sources" "${@:3}"; }
no_index() { $env/bin/pip --disable-pip-version-check -q --no-cache-dir "$@"; }

rm -rf $env $work $homes
mkdir -p $work $homes/usual $homes/read-only $homes/noexec
chown $user:$user $work $homes/usual
# /tmp, which is hidden below, may have the sources.
mkdir -p $view
mount --bind "$sources" $view
sources=$view
mount -t tmpfs -o ro none $homes/read-only
mount -t tmpfs -o noexec,uid=$user,gid=$user none $homes/noexec
if [ "$system" = bare ]; then
    if command -v cc gcc g++ c++ clang ld; then fail "the tree has a compiler"; fi
fi
if [ "$system" != pocl ]; then
    if ldconfig -p | grep OpenCL || [ -e /etc/OpenCL ] || [ -e /usr/include/CL ]; then fail "the tree has OpenCL"; fi
fi
start=$SECONDS
python3 -m venv $env
no_index install --no-index --find-links "$files" numpy nanobind-backend
find $env | sort >$work.before
no_index install --no-index --find-links "$files" "$files"/clsdf-*.whl
say "installed in $((SECONDS - start)) s"
as_user $homes/usual clsdf shape sphere4 -o bunny.off --quiet

if [ "$system" = bare ]; then
    for home in usual read-only noexec; do
        say "home: $home"
        try $homes/$home page $home.bytes
        cmp $work/usual.bytes $work/$home.bytes
    done
    say "home: there is none, /tmp is noexec"
    mount -t tmpfs -o noexec,mode=1777 none /tmp
    try /nonexistent page none.bytes
    cmp $work/usual.bytes $work/none.bytes
    umount /tmp
    left=$(find $homes/usual -type f ! -path '*/.cache/clsdf/*.tested' ! -path '*/.cache/clsdf/*.called' ! -path '*/.cache/clsdf/compiling.lock')
    [ -z "$left" ] || fail "it wrote to the home: $left"

    say "the command"
    as_user $homes/usual clsdf devices 2>$work/devices
    grep "bundled with clsdf" $work/devices
    as_user $homes/usual clsdf compute bunny.off -o bunny.nrrd --resolution 64 --quiet
    if as_user $homes/usual clsdf compute bunny.off -o by_slices.nrrd --resolution 64 --scan slices 2>$work/error; then
        fail "--scan slices computes without its program"
    fi
    grep -q 'slices.*pocl-opencl-icd' $work/error || fail "--scan slices says: $(cat $work/error)"
    as_user $homes/usual clsdf compile-ahead --device bundled --check

    say "pyopencl"
    no_index install --no-index --find-links "$files" pyopencl
    try $homes/usual pyopencl
    no_index uninstall -y pyopencl pytools siphash24 typing-extensions platformdirs 2>/dev/null

    say "without the driver"
    driver=$(echo $env/lib/python3*/site-packages/clsdf/driver)
    mv "$driver" "$driver.away"
    try $homes/usual nothing
    mv "$driver.away" "$driver"
elif [ "$system" = compilers ]; then
    say "other projects, on the driver in the wheel"
    as_user $homes/usual "$sources/packaging/try_consumers.bash" $env/bin/python $work/consumers
else
    say "other projects, beside Debian's PoCL, oneTBB and GMP"
    as_user $homes/usual "$sources/packaging/try_consumers.bash" $env/bin/python $work/consumers
    grep -q '^headers of oneTBB' $work/consumers.log || fail "no program linked the system's oneTBB"
fi
if [ "$system" = pocl ] && [ -e "$(echo $env/lib/python3*/site-packages/clsdf/driver)" ]; then
    say "beside Debian's PoCL"
    try $homes/usual beside
    # The levels below this processor's.
    if [ -e /usr/share/pocl/kernel-x86_64-pc-linux-gnu-avx2.bc ]; then
        level=x86-64-v3 kernels=avx2 try $homes/usual beside
        level=x86-64-v2 kernels=sse41 try $homes/usual beside
        say "likewise on the levels v3 and v2"
    fi
fi

no_index uninstall -y clsdf
find $env | sort | diff $work.before - || fail "uninstalling left these files, or took them"
umount $homes/read-only $homes/noexec $view
rmdir $view
rm -rf $env $work $work.before $homes
