#pragma once

#include <string>

/// "clsdf 0.1.0", with the commit if the sources were under version control, and the libraries of the build.
std::string version_text();
