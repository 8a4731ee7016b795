#!/usr/bin/env bash
# Builds and runs other projects in C++, C and Fortran (tests/consumer) on the libraries of an installed wheel:
# try_consumers.bash PYTHON FOLDER. PYTHON has the wheel. The work is in FOLDER, and its log. If gfortran is not installed,
# Fortran is left out; likewise a program that links oneTBB and GMP itself.
set -euo pipefail
sources=$(cd "$(dirname "$0")/.." && pwd -P)
python=$1
folder=$2
prefix=$("$python" -m clsdf.cmake)
descriptions=$("$python" -m clsdf.pkgconfig)
fortran=$(command -v gfortran || true)
beside=$([ -e /usr/include/gmp.h ] || [ -e "/usr/include/$(gcc -print-multiarch)/gmp.h" ] && [ -e /usr/include/tbb/version.h ] && echo ON || true)
generator=$(command -v ninja >/dev/null && echo Ninja || echo "Unix Makefiles")
cmake -DWAY=wheel -DPREFIX="$prefix" -DPKG_CONFIG_PATH="$descriptions" -DCLSDF="$sources" -DSCRATCH="$folder" \
    -DGENERATOR="$generator" -DCOMPILER=c++ -DLAUNCHER= -DFORTRAN="$fortran" -DBESIDE="$beside" \
    -P "$sources/tests/consumer/run.cmake" >"$folder.log" 2>&1 || {
    tail -n 40 "$folder.log" >&2
    echo "try_consumers: programs on the wheel's libraries do not build or run; all of it: $folder.log" >&2
    exit 1
}
grep -E '^(The first field by CMake|headers of oneTBB)' "$folder.log" | sort -u || true
echo "C++, C${fortran:+, Fortran}${beside:+, oneTBB and GMP of the system}: $SECONDS s for all programs"
