#pragma once

#include <cstdlib>
#include <string>

namespace clsdf::test {

/// A file of the sources by its path within them. A bundle of the programs on another machine has the files that tests
/// read, and names their folder in CLSDF_SOURCE.
inline std::string source_file(const std::string& path) {
    const char* const folder = std::getenv("CLSDF_SOURCE");
    return (folder == nullptr ? std::string(CLSDF_SOURCE) : std::string(folder)) + '/' + path;
}

}  // namespace clsdf::test
