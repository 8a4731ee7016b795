#pragma once

#include "description.hpp"

#include <string>
#include <vector>

/// A manual page, in the macros of man(7).
struct ManualPage {
    std::string file;  ///< "clsdf-compute.1"
    std::string text;
};

/// One page for the program and one for each subcommand.
std::vector<ManualPage> manual_pages(const ProgramDescription& description);
