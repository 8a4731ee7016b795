#!/usr/bin/env bash
# The part of scripts/install-times inside an empty tree, as root: install_times.bash wheel|packages|cmake.
# build/install-times has what pip and dpkg install, apart from the system's packages, which are downloaded before the clock
# starts. The seconds appear in build/install-times/WAY.seconds.
set -euo pipefail
sources=$PWD
files=$PWD/build/install-times
way=$1
work=/root/first
export DEBIAN_FRONTEND=noninteractive

quiet() { "$@" </dev/null >/root/log 2>&1 || { tail -n 20 /root/log >&2; echo "install_times: '$*' failed" >&2; exit 1; }; }
case $way in
    wheel) packages=(python3 python3-venv) ;;
    cmake) packages=(python3 python3-venv cmake make g++) ;;
    packages) packages=("$files"/packages/*.deb) ;;
esac
mkdir -p $work
cd $work
awk '/^```cpp$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$sources/README.md" >simulation.cpp
cat >CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.16)
project(simulation LANGUAGES CXX)
find_package(clsdf REQUIRED COMPONENTS io)
add_executable(simulation simulation.cpp)
target_link_libraries(simulation PRIVATE clsdf::io)
END
cat >field.py <<'END'
import clsdf
body = clsdf.Transform(clsdf.make_shape("torus"))
clsdf.write_field(body.field(resolution=64, band="10%"), "first.nrrd")
END
quiet apt-get -qq update
# Recommended packages are installed with the packages, as PoCL is; the others are what a program needs.
few=()
[ "$way" = packages ] || few=(--no-install-recommends)
quiet apt-get -y "${few[@]}" --download-only install "${packages[@]}"

start=$(date +%s%N)
quiet apt-get -y "${few[@]}" install "${packages[@]}"
if [ "$way" = packages ]; then
    quiet clsdf shape torus -o torus.off
    quiet clsdf compute torus.off -o first.nrrd --resolution 64 --band 10%
else
    quiet python3 -m venv env
    quiet env/bin/pip --disable-pip-version-check install --no-index --find-links "$files/wheels" clsdf
    if [ "$way" = cmake ]; then
        quiet env/bin/clsdf shape torus -o bunny.off
        quiet cmake -S . -B build -DCMAKE_PREFIX_PATH="$(env/bin/python -m clsdf.cmake)"
        quiet cmake --build build
        quiet build/simulation
    else
        quiet env/bin/python field.py
    fi
fi
end=$(date +%s%N)

# The wheel has no "clsdf check"; the packages' command, the last way, checks the fields of all.
case $way in
    cmake) cp outside.nrrd "$files/cmake.nrrd" ;;
    *) cp first.nrrd "$files/$way.nrrd" ;;
esac
if [ "$way" = packages ]; then
    for field in "$files"/*.nrrd; do quiet clsdf check torus.off "$field"; done
fi
echo $(((end - start + 500000000) / 1000000000)) >"$files/$way.seconds"
