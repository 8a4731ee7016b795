#!/usr/bin/env bash
# Makes what a wheel for older systems is linked with: a toolchain file of CMake with which this machine's g++ links programs
# and libraries that start with glibc 2.28 and the C++ library of GCC 8 (Debian 10, RHEL 8, Ubuntu 20.04, and later), and the
# libraries that Debian has for its own glibc only, linked so: on x86-64 and aarch64, by the compilers CC and CXX.
#
#   packaging/old_glibc.bash FOLDER [VENV]     (VENV: an environment of Python with ziglang; default: one is made)
#
#   FOLDER/toolchain.cmake       for -DCMAKE_TOOLCHAIN_FILE
#   FOLDER/toolchain             the same for configure scripts: to be sourced, it sets LDFLAGS
#   FOLDER/installed             oneTBB, fmt, HDF5 and the loader of OpenCL, for CMAKE_PREFIX_PATH
#   FOLDER/sources               what they are made of: a line with the library's and the archive's name
#
# The C library's side is zig's: it has lists of the symbols of all versions of glibc, and writes libraries of names and the
# start of programs for 2.28. The compiler, the headers and the C++ library are this machine's. What a program needs of a
# C++ library after GCC 8 is linked into it, by the members of libstdc++.a that have it; all else remains that of the
# system, so that exceptions and streams pass between the wheel's libraries and a user's program. Red Hat's newer
# compilers for RHEL 8 do the same. The script needs root for packages that are missing, PyPI, and three minutes.
# The exit status is 125 if packages, PyPI or sources cannot be had.
set -euo pipefail
. "$(dirname "$0")/../scripts/common.bash"
sources=$(cd "$(dirname "$0")" && pwd)
[ $# -ge 1 ] && [ $# -le 2 ] && [[ $1 != -* ]] || usage
folder=$(realpath -m -- "$1")
venv=${2-}
cc=${CC:-gcc}
cxx=${CXX:-g++}
version=2.28
# Functions of the C++ library after GCC 8 that clsdf uses: paths and files, numbers from text, string streams, memory
# resources, and what the headers of containers call. packaging/old_glibc.c has the rest.
members=(fs_dir.o fs_ops.o fs_path.o floating_from_chars.o sstream-inst.o lt5-sstream-inst.o memory_resource.o functexcept.o
    snprintf_lite.o)
cannot() {
    echo "old_glibc: $*" >&2
    exit 2
}
# Without packages, PyPI or sources nothing is wrong with this machine.
unavailable() {
    echo "old_glibc: needs $*" >&2
    exit 125
}
machine=$(uname -m)
case $machine in
    x86_64) loader=/lib64/ld-linux-x86-64.so.2 ;;
    aarch64) loader=/lib/ld-linux-aarch64.so.1 ;;
    *) cannot "links for x86-64 and aarch64 only, and this is $machine" ;;
esac

state() {
    { cat "$sources/old_glibc.bash" "$sources/old_glibc.c" && "$cxx" --version && dpkg-query -W libc6-dev; } | sha256sum
}
if [ "$(cat "$folder/complete" 2>/dev/null)" = "$(state)" ]; then exit 0; fi
rm -rf "$folder"
mkdir -p "$folder/lib"

# C: names of glibc, the start of programs, and what glibc 2.28 links into each program (stat, atexit).
make_c_library() {
    if [ -z "$venv" ]; then
        venv=$folder/venv
        /usr/bin/python3 -m venv "$venv" && "$venv/bin/pip" --disable-pip-version-check -q install ziglang ||
            unavailable "python3-venv, or ziglang from PyPI"
    fi
    echo 'int main(void) { return 0; }' >"$folder/main.c"
    # Programs are position-independent, as g++ makes them here.
    ZIG_GLOBAL_CACHE_DIR=$folder/zig ZIG_LOCAL_CACHE_DIR=$folder/zig "$venv/bin/python" -m ziglang cc -fPIE -pie \
        -target $machine-linux-gnu.$version "$folder/main.c" -o "$folder/main"
    find "$folder/zig" \( -name 'lib*.so.*' -o -name '*crt1.o' -o -name libc_nonshared.a \) -exec mv -t "$folder/lib" {} +
    rm -r "$folder/zig"
    rm "$folder"/main*
    echo "GROUP(libc.so.6 libc_nonshared.a AS_NEEDED(libpthread.so.0 libdl.so.2 librt.so.1 $loader))" >"$folder/lib/libc.so"
    echo "INPUT(libm.so.6)" >"$folder/lib/libm.so"
    echo "INPUT(libpthread.so.0)" >"$folder/lib/libpthread.so"
    echo "INPUT(libdl.so.2)" >"$folder/lib/libdl.so"
    echo "INPUT(librt.so.1)" >"$folder/lib/librt.so"
}

make_cxx_library() {
    local own
    own=$(realpath "$("$cxx" -print-file-name=libstdc++.so)")
    "$cc" -c -O2 -fPIC -Wall -Wextra "$sources/old_glibc.c" -o "$folder/lib/old_glibc.o"
    (cd "$folder/lib" && ar x "$("$cxx" -print-file-name=libstdc++.a)" "${members[@]}" &&
        ar rcs libstdc++_new.a old_glibc.o "${members[@]}")
    echo "INPUT(libstdc++_new.a $own)" >"$folder/lib/libstdc++.so"
}

write_toolchain() {
    # -B: the start of programs is there. This machine's C++ library needs names of a later glibc than that of FOLDER.
    local shared="-B$folder/lib -L$folder/lib -Wl,--exclude-libs,libstdc++_new.a"
    cat >"$folder/toolchain.cmake" <<END
set(CMAKE_SHARED_LINKER_FLAGS_INIT "$shared")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "$shared")
set(CMAKE_EXE_LINKER_FLAGS_INIT "$shared -Wl,--allow-shlib-undefined")
list(PREPEND CMAKE_PREFIX_PATH "$folder/installed")
END
    echo "export LDFLAGS='$shared -Wl,--allow-shlib-undefined'" >"$folder/toolchain"
}

# unpack NAME POOL/FILE SHA256: the folder NAME has the sources of a library.
unpack() {
    mkdir -p "$folder/$1"
    fetch_source "$2" "$3" "$folder" || unavailable "${2##*/} with the SHA256 $3, which no archive of apt has"
    tar -xf "$folder/${2##*/}" -C "$folder/$1" --strip-components=1
    rm "$folder/${2##*/}"
    echo "$1 ${2##*/}" >>"$folder/sources"
}
build() {
    local name=$1
    shift
    # HDF5's tests of compilers leave files in the working folder, and read them in that of the build.
    mkdir "$folder/$name/build" &&
        env -C "$folder/$name/build" cmake .. -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON \
        -DCMAKE_INSTALL_PREFIX="$folder/installed" -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_TOOLCHAIN_FILE="$folder/toolchain.cmake" \
        -DCMAKE_C_COMPILER_LAUNCHER="$launcher" -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" "$@" &&
        cmake --build "$folder/$name/build" -j 2 && cmake --install "$folder/$name/build"
}

make_libraries() {
    local launcher
    launcher=$(command -v ccache || true)
    unpack onetbb o/onetbb/onetbb_2021.8.0.orig.tar.xz 7e9111b8bb59c8800bf6d0b06afe7b0891937443d2dae1ee1101c8e2ede6a7ef
    unpack fmtlib f/fmtlib/fmtlib_9.1.0+ds1.orig.tar.gz 84ce1c2d0be3a9863935137969dcec6970125caac032f82474640bfc81463583
    unpack hdf5 h/hdf5/hdf5_1.10.8+repack1.orig.tar.gz 7b38e58ff83b13fd8959a90b13bf896bc318ba096c940ab0847abf3ad41a0b31
    # The archives have Debian 12's own version, 2.3.1, no more.
    unpack ocl-icd o/ocl-icd/ocl-icd_2.3.4.orig.tar.gz 1a302b71b7304cca5a36f69d017b1af2b762cc4c2dd1c0c0e2fc1933db25c9cc
    {
        build onetbb -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF -DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON &&
            build fmtlib -DFMT_DOC=OFF -DFMT_TEST=OFF &&
            build hdf5 -DBUILD_STATIC_LIBS=OFF -DBUILD_TESTING=OFF -DHDF5_BUILD_TOOLS=OFF -DHDF5_BUILD_EXAMPLES=OFF \
                -DHDF5_BUILD_HL_LIB=OFF -DHDF5_BUILD_CPP_LIB=OFF -DHDF5_ENABLE_Z_LIB_SUPPORT=ON \
                -DHDF5_ENABLE_SZIP_SUPPORT=ON -DHDF5_ENABLE_SZIP_ENCODING=ON &&
            (
                . "$folder/toolchain"
                cd "$folder/ocl-icd" && ./bootstrap && CC="$launcher $cc" ./configure --prefix="$folder/installed" && make -j 2 &&
                    make install
            )
    } >"$folder/log" 2>&1 || cannot "the libraries could not be built; what was said: $folder/log"
}

install_missing cmake ninja-build make ruby autoconf automake libtool zlib1g-dev libaec-dev xz-utils ||
    unavailable "the packages $missing"
make_c_library
make_cxx_library
write_toolchain
make_libraries
state >"$folder/complete"
