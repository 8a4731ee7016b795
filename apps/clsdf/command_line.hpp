#pragma once

#include "command.hpp"

#include <CLI/CLI.hpp>

#include <vector>

/// All subcommands, and what is common to them.
class CommandLine {
public:
    explicit CommandLine(Report& report);
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// Throws clsdf::Error, of invalid_argument where the words make no sense; the message has the nearest one.
    ExitStatus run(int argument_count, char** arguments);

private:
    void add(const Command& command);
    void add_common_options(const Command& command);

    Report& report_;
    CLI::App program_;
    std::vector<Command> commands_;
};
