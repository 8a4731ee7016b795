#!/usr/bin/env bash
# The part of scripts/try-wheel on a system whose Python cannot install the wheel: try_old_system.bash FILES WORK. FILES has
# the unpacked wheel; WORK, a folder of it, gets a field, and programs of another project in C++ are built there and run.
set -euo pipefail
sources=$(cd "$(dirname "$0")/.." && pwd -P)
files=$(cd "$1" && pwd -P)
mkdir -p "$files/$2/project"
cd "$files/$2"
export OCL_ICD_VENDORS=$PWD CLSDF_CACHE_DIR= # the wheel's driver alone
"$files/clsdf/bin/clsdf" shape torus -o torus.off --quiet
LD_BIND_NOW=1 "$files/clsdf/bin/clsdf" compute torus.off -o torus.nrrd --resolution 64 --with gradient --quiet
cat >project/CMakeLists.txt <<END
cmake_minimum_required(VERSION 3.18)
project(consumer CXX)
find_package(clsdf REQUIRED COMPONENTS io)
foreach(program consumer meshes)
  add_executable(\${program} $sources/tests/consumer/\${program}.cpp)
  target_link_libraries(\${program} PRIVATE clsdf::io)
endforeach()
END
{ cmake -S project -B build -DCMAKE_PREFIX_PATH="$files/clsdf" && cmake --build build; } >log 2>&1 || {
    tail -n 40 log >&2
    echo "try_old_system: C++ programs on the wheel's libraries do not build; all of it: $PWD/log" >&2
    exit 1
}
build/consumer
build/meshes
ldd --version | sed -n 1p
