#pragma once

#include "json.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <chrono>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// Opens each closed standard stream on /dev/null: input for writing, output and error for reading. Otherwise the next
/// file would get the stream's number and receive the printed text. Writing a result to a closed output still fails.
/// Call it before anything opens a file.
void open_closed_streams();

/// From now on a write into a pipe without a reader, or beyond the limit on a file's size, fails with EPIPE or EFBIG;
/// SIGPIPE and SIGXFSZ would end the process in the middle of a file.
void let_writes_fail();

/// Human text, on standard error. Text that cannot be written is dropped: a full disk changes no exit
/// status.
void write_to_standard_error(std::string_view text) noexcept;

/// The same, formatted. All output but results is printed by it.
template <class... Values>
void print_text(fmt::format_string<const Values&...> format, const Values&... values) noexcept {
    try {
        write_to_standard_error(fmt::format(format, values...));
    } catch (const std::exception&) {
        // Out of memory: the text is dropped.
    }
}

/// Prints a result on standard output. Throws clsdf::Error(output_failure).
void print_result(const Json& result);
void print_result(const std::string& text);

Json describe(const clsdf::Grid& grid);
/// A half width is null if it is infinite.
Json describe(const clsdf::Band& band);

/// "51.5 MB".
std::string human_bytes(double bytes);
/// "12.9 million".
std::string human_count(double count);
/// One line: samples, spacing and origin.
std::string human(const clsdf::Grid& grid);
/// One line: half widths in the mesh's units and in voxels.
std::string human(const clsdf::Band& band, double voxel);
/// One line: the first names, each after its number.
std::string human(const clsdf::FaceGroups& groups);

/// The output of a subcommand. Human text goes to standard error, the result with --json to standard output.
struct Report {
    bool json = false;
    bool quiet = false;    ///< warnings and errors only
    bool verbose = false;  ///< warnings in full

    /// One object, printed at the end of the subcommand, also after an error, which becomes its member "error".
    Json result = Json::object();

    /// Human text; nothing with --quiet.
    template <class... Values>
    void print(fmt::format_string<const Values&...> format, const Values&... values) const {
        if (!quiet) print_text(format, values...);
    }

    /// Prints a warning, if it is not empty, also with --quiet, shortened unless with --verbose, and adds it in full to
    /// the result's member "warnings", which always exists.
    void warn(const std::string& warning);

    /// Prints the error, and with --json the result, which contains it.
    ExitStatus fail(clsdf::ErrorCode code, const std::string& message);

    /// Prints the result if --json is set. Throws clsdf::Error(output_failure).
    void finish() const;

private:
    std::vector<std::string> warnings_;
};

/// "4 s", "2 min 10 s", "3 h 5 min".
std::string human_duration(double seconds);

/// A bar with an estimate of the time that is left, on standard error if that is a terminal; else nothing.
class ProgressBar {
public:
    explicit ProgressBar(bool wanted);
    ~ProgressBar() { clear(); }
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(double fraction);
    /// A line of text in its place.
    void show(const std::string& text);
    /// Begins new work: the estimate of the time left begins anew.
    void restart();

    /// Takes the bar away, so that a line can be printed in its place.
    void clear();

private:
    void print(const std::string& text);

    bool enabled_;
    int columns_ = 0;
    std::chrono::steady_clock::time_point begin_;
    std::chrono::steady_clock::time_point next_;
};
