#pragma once

// g++ 10 has another number for C++20, and another layout of std::span.
#if __cplusplus < 202002L && !(defined(_MSVC_LANG) && _MSVC_LANG >= 202002L)
#error "clsdf needs C++20: compile with -std=c++20 (with CMake, link clsdf::clsdf), by g++ 11 or later"
#include <clsdf/needs_cxx20>  // no such file: the compiler stops here, with one message
#endif

#include <clsdf/export.hpp>

#include <string>

/// The version that these headers are of. CMakeLists.txt reads it here.
#define CLSDF_VERSION_MAJOR 0
#define CLSDF_VERSION_MINOR 1
#define CLSDF_VERSION_PATCH 0

/// A version as a number that grows with it: #if CLSDF_VERSION >= CLSDF_MAKE_VERSION(0, 2, 0).
#define CLSDF_MAKE_VERSION(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))
#define CLSDF_VERSION CLSDF_MAKE_VERSION(CLSDF_VERSION_MAJOR, CLSDF_VERSION_MINOR, CLSDF_VERSION_PATCH)

namespace clsdf {

/// "major.minor.patch" of the library in use. It differs from the macros' if the program was compiled with the
/// headers of another version.
CLSDF_EXPORT std::string version();

}  // namespace clsdf
