#pragma once

#include "description.hpp"

#include <string>

/// The document with the table of options of each subcommand between "<!-- options of NAME -->" and "<!-- end of
/// options -->", as Markdown. Throws clsdf::Error if a subcommand has no marks, or marks have no subcommand.
std::string with_option_tables(const std::string& document, const ProgramDescription& description);
