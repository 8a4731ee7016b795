# CMake's toolchain file of a cross build for aarch64 on Debian: -DCMAKE_TOOLCHAIN_FILE=cmake/aarch64-linux-gnu.cmake. It needs
# the packages of `scripts/setup --arm64`. qemu runs the programs that the build and CTest start.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
# Libraries that pkg-config describes are those of aarch64.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)
# CGAL's headers pass pairs by value: g++ notes each time that their passing changed with version 10.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
