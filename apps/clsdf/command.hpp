#pragma once

#include "report.hpp"

#include <CLI/CLI.hpp>

#include <functional>

/// A subcommand: how it is parsed, and what it does after that.
///
/// Each is made by a function `Command add_NAME(CLI::App& program)` in NAME.cpp, which CMakeLists.txt lists. --json and
/// --quiet, the exit statuses on the help page, the manual page and the completions follow from that by themselves.
/// They take from the parser: the footer up to "Examples:" explains, the lines after it are examples; an option's type
/// name is what it takes, see option_values.hpp.
struct Command {
    CLI::App* parser;

    /// Throws clsdf::Error. What --json prints is put into the report's result.
    std::function<ExitStatus(Report&)> run;
};
