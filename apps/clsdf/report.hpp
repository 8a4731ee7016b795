#pragma once

#include "exit_status.hpp"
#include "standard_streams.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

/// What a subcommand says, and how it was asked to say it. Human text goes to standard error, the result with --json to
/// standard output.
struct Report {
    bool json = false;
    bool quiet = false;  ///< warnings and errors only

    /// One object. It is printed when the subcommand has ended, well or with an error, which becomes its member
    /// "error".
    nlohmann::ordered_json result = nlohmann::ordered_json::object();

    /// Human text; nothing with --quiet.
    template <class... Values>
    void print(fmt::format_string<const Values&...> format, const Values&... values) const {
        if (!quiet) print_text(format, values...);
    }

    /// Says it to people, also with --quiet, and in the result's member "warnings", which is always there.
    void warn(const std::string& warning);

    /// Says what went wrong, and prints the result with it where --json asks for that.
    ExitStatus fail(clsdf::ErrorCode code, const std::string& message);

    /// Prints the result where --json asks for it. Throws clsdf::Error(output_failure).
    void finish() const;

private:
    std::vector<std::string> warnings_;
};

/// "invalid_mesh" and so on: what the member "code" of an error is in JSON.
const char* name_of(clsdf::ErrorCode code);
