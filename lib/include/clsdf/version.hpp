#pragma once

#include <string>

namespace clsdf {

/// "major.minor.patch" of the library in use.
std::string version();

}  // namespace clsdf
