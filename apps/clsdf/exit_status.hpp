#pragma once

#include <clsdf/error.hpp>

#include <span>
#include <string>

/// The exit statuses of the command.
enum class ExitStatus {
    done = 0,
    check_failed = 1,
    usage = 2,          ///< also what is unsupported
    invalid_input = 3,  ///< a mesh or field that is unreadable or invalid
    device = 4,         ///< no device, a failing one, or too little memory
    output = 5,
    cancelled = 6,
};

ExitStatus status_of(clsdf::ErrorCode code);

struct ExitStatusMeaning {
    ExitStatus status;
    const char* meaning;
};
std::span<const ExitStatusMeaning> exit_status_meanings();

/// One paragraph for the help page.
std::string exit_status_help();
