#!/usr/bin/env bash
# The part of scripts/try-wheel on a system whose Python cannot install the wheel: try_old_system.bash FILES WORK. FILES has
# the unpacked wheel; WORK, a folder of it, gets a field, and programs of another project in C and C++ are built there and run.
set -euo pipefail
sources=$(cd "$(dirname "$0")/.." && pwd -P)
files=$(cd "$1" && pwd -P)
mkdir -p "$files/$2/project"
cd "$files/$2"
export OCL_ICD_VENDORS=$PWD CLSDF_CACHE_DIR= # the wheel's driver alone
"$files/clsdf/bin/clsdf" shape torus -o torus.off --quiet
LD_BIND_NOW=1 "$files/clsdf/bin/clsdf" compute torus.off -o torus.nrrd --resolution 64 --with gradient --quiet
awk '/^```c$/ { found = 1; next } /^```$/ { if (found) exit } found' "$sources/docs/c.md" >project/first.c
cat >project/CMakeLists.txt <<END
cmake_minimum_required(VERSION 3.18)
project(consumer C CXX)
find_package(clsdf REQUIRED COMPONENTS c io)
add_executable(first first.c)
target_link_libraries(first PRIVATE clsdf::c)
add_executable(consumer EXCLUDE_FROM_ALL $sources/tests/consumer/consumer.cpp)
target_link_libraries(consumer PRIVATE clsdf::io)
END
{ cmake -S project -B build -DCMAKE_PREFIX_PATH="$files/clsdf" && cmake --build build; } >log 2>&1 || {
    tail -n 40 log >&2
    echo "try_old_system: a program in C on the wheel's libraries does not build; all of it: $PWD/log" >&2
    exit 1
}
build/first
if [ "$(c++ -dumpversion)" -ge 11 ]; then
    cmake --build build --target consumer >>log
    build/consumer
elif cmake --build build --target consumer >>log 2>&1 || ! grep -q 'clsdf needs C++20.*g++ 11 or later' log; then
    echo "try_old_system: the headers do not refuse g++ $(c++ -dumpversion), whose std::span has another layout" >&2
    exit 1
fi
ldd --version | sed -n 1p
