#pragma once

#include "exit_status.hpp"
#include "standard_streams.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

/// The output of a subcommand. Human text goes to standard error, the result with --json to standard output.
struct Report {
    bool json = false;
    bool quiet = false;  ///< warnings and errors only

    /// One object, printed at the end of the subcommand, also after an error, which becomes its member "error".
    nlohmann::ordered_json result = nlohmann::ordered_json::object();

    /// Human text; nothing with --quiet.
    template <class... Values>
    void print(fmt::format_string<const Values&...> format, const Values&... values) const {
        if (!quiet) print_text(format, values...);
    }

    /// Prints a warning, also with --quiet, and adds it to the result's member "warnings", which always exists.
    void warn(const std::string& warning);

    /// Prints the error, and with --json the result, which contains it.
    ExitStatus fail(clsdf::ErrorCode code, const std::string& message);

    /// Prints the result if --json is set. Throws clsdf::Error(output_failure).
    void finish() const;

private:
    std::vector<std::string> warnings_;
};

/// "invalid_mesh" and so on: the member "code" of an error in JSON.
const char* name_of(clsdf::ErrorCode code);
