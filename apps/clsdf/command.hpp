#pragma once

#include "report.hpp"

#include <CLI/CLI.hpp>

#include <functional>

/// A subcommand: its parser and its function.
///
/// Each is made by a function `Command add_NAME(CLI::App& program)` in NAME.cpp, which CMakeLists.txt lists. It then
/// has --json and --quiet, the exit statuses on the help page, a manual page and completions. These are made from the
/// parser: the footer up to "Examples:" is the explanation, the lines after it are examples, and an option's type name
/// states its values, see option_values.hpp.
struct Command {
    CLI::App* parser;

    /// Throws clsdf::Error. Puts the output of --json into the report's result.
    std::function<ExitStatus(Report&)> run;
};
