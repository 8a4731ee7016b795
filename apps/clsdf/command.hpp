#pragma once

#include "options.hpp"
#include "report.hpp"

#include <functional>

/// A subcommand: its parser and its function.
///
/// Each is made by a function `Command add_NAME(Parser& program)` in NAME.cpp, which CMakeLists.txt lists. It then
/// has --json and --quiet, the exit statuses on the help page, a manual page and completions. These are made from the
/// parser, see options.hpp.
struct Command {
    Parser parser;

    /// Throws clsdf::Error. Puts the output of --json into the report's result.
    std::function<ExitStatus(Report&)> run;
};
