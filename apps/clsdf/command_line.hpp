#pragma once

#include "command.hpp"

#include <CLI/CLI.hpp>

#include <vector>

/// All subcommands, and the parts that they share.
class CommandLine {
public:
    explicit CommandLine(Report& report);
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// Throws clsdf::Error; invalid_argument if a word is not valid, with the nearest valid one in the message.
    ExitStatus run(int argument_count, char** arguments);

private:
    void add(const Command& command);
    void add_common_options(const Command& command);

    Report& report_;
    CLI::App program_;
    std::vector<Command> commands_;
};
