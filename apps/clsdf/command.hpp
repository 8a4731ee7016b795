#pragma once

#include "exit_status.hpp"

#include <CLI/CLI.hpp>

#include <functional>

/// A subcommand: how it is parsed, and what it does after that. run() throws clsdf::Error.
struct Command {
    CLI::App* parser;
    std::function<ExitStatus()> run;
};

Command add_bench(CLI::App& program);
Command add_compute(CLI::App& program);
Command add_check(CLI::App& program);
Command add_devices(CLI::App& program);
Command add_info(CLI::App& program);
Command add_polyhedra(CLI::App& program);
Command add_render(CLI::App& program);
Command add_shape(CLI::App& program);
Command add_slice(CLI::App& program);
