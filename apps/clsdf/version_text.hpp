#pragma once

#include <string>

/// "clsdf 0.1.0", with the commit where the sources were under version control, and what the program was built with.
std::string version_text();
