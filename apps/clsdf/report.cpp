#include "report.hpp"

#include "tools/text.hpp"
#include "two_lines.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <system_error>

ExitStatus status_of(clsdf::ErrorCode code) {
    using clsdf::ErrorCode;
    switch (code) {
        case ErrorCode::invalid_argument:
        case ErrorCode::unsupported:
            return ExitStatus::usage;
        case ErrorCode::invalid_mesh:
        case ErrorCode::unreadable_input:
            return ExitStatus::invalid_input;
        case ErrorCode::no_device:
        case ErrorCode::device_failure:
        case ErrorCode::wrong_results:
        case ErrorCode::out_of_memory:
            return ExitStatus::device;
        case ErrorCode::output_failure:
            return ExitStatus::output;
        case ErrorCode::cancelled:
            return ExitStatus::cancelled;
    }
    return ExitStatus::device;
}

std::span<const ExitStatusMeaning> exit_status_meanings() {
    static constexpr ExitStatusMeaning meanings[] = {{ExitStatus::done, "done"},
                                                     {ExitStatus::check_failed, "a check failed"},
                                                     {ExitStatus::usage, "usage or unsupported"},
                                                     {ExitStatus::invalid_input, "unreadable or invalid input"},
                                                     {ExitStatus::device, "device or memory"},
                                                     {ExitStatus::output, "output"},
                                                     {ExitStatus::cancelled, "cancelled"}};
    return meanings;
}

std::string exit_status_help() {
    std::string text = "Exit status:";
    for (const auto& [status, meaning] : exit_status_meanings())
        text += fmt::format("{} {} {}", status == ExitStatus::done ? "" : ",", static_cast<int>(status), meaning);
    text[text.rfind(", ", 100) + 1] = '\n';
    return text + '.';
}

void open_closed_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
        // open() returns the lowest free number, which is that of the stream.
        ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    }
}

void let_writes_fail() {
    for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_IGN);
}

void write_to_standard_error(std::string_view text) noexcept {
    std::fwrite(text.data(), 1, text.size(), stderr);
}

using clsdf::Band;
using clsdf::Grid;

namespace {

std::string human_half_width(double width, double voxel) {
    return std::isinf(width) ? "everything" : fmt::format("{:.6g} ({:.4g} voxels)", width, width / voxel);
}

}  // namespace

void print_result(const std::string& text) {
    errno = 0;
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!written)
        throw clsdf::Error(
            clsdf::ErrorCode::output_failure,
            fmt::format("standard output: the result cannot be written: {}", std::generic_category().message(errno)));
}

void print_result(const Json& result) {
    print_result(result.dump() + '\n');
}

Json describe(const Grid& grid) {
    return {{"origin", grid.position(0, 0, 0)}, {"spacing", grid.spacing}, {"size", grid.size}};
}

Json describe(const Band& band) {
    // JSON has no infinity: it becomes null.
    Json result = {{"inside", band.inside}, {"outside", band.outside}};
    if (band.has_exact_signs) result["exact_signs"] = true;
    return result;
}

std::string human_bytes(double bytes) {
    for (const char* unit : {"bytes", "kB", "MB", "GB"}) {
        if (bytes < 1000) return fmt::format("{:.3g} {}", bytes, unit);
        bytes /= 1000;
    }
    return fmt::format("{:.4g} TB", bytes);
}

std::string human_count(double count) {
    if (count < 1e6) return fmt::format("{:.0f}", count);
    return count < 1e9 ? fmt::format("{:.1f} million", count / 1e6) : fmt::format("{:.2f} billion", count / 1e9);
}

std::string human(const Grid& grid) {
    const auto& [hx, hy, hz] = grid.spacing;
    const std::string spacing =
        hx == hy && hy == hz ? fmt::format("{:.6g}", hx) : fmt::format("({:.6g}, {:.6g}, {:.6g})", hx, hy, hz);
    const clsdf::Vec3 origin = grid.position(0, 0, 0);
    return fmt::format("{} x {} x {} samples, {} apart, from ({:.6g}, {:.6g}, {:.6g})", grid.size[0], grid.size[1],
                       grid.size[2], spacing, origin[0], origin[1], origin[2]);
}

std::string human(const Band& band, double voxel) {
    if (band.inside == band.outside)
        return std::isinf(band.outside) ? "none: every sample has its distance"
                                        : human_half_width(band.outside, voxel) + " on both sides";
    return fmt::format("{} inside, {} outside", human_half_width(band.inside, voxel),
                       human_half_width(band.outside, voxel));
}

std::string human(const clsdf::FaceGroups& groups) {
    constexpr std::size_t most = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(groups.names.size(), most); ++i)
        text += fmt::format("{}{} {}", i == 0 ? "" : ", ", i, clsdf::quoted(groups.names[i]));
    return groups.names.size() > most ? fmt::format("{}, ... ({})", text, groups.names.size()) : text;
}

using clsdf::ErrorCode;

void Report::warn(const std::string& warning) {
    if (warning.empty()) return;
    warnings_.push_back(warning);
    print_text("{}\n", verbose ? "warning: " + warning : two_lines_of("warning: " + warning));
}

ExitStatus Report::fail(ErrorCode code, const std::string& message) {
    const ExitStatus status = status_of(code);
    print_text("clsdf: {}\n", message);
    result["error"] = {{"code", name_of(code)}, {"message", message}, {"exit_status", static_cast<int>(status)}};
    try {
        finish();
    } catch (const clsdf::Error&) {
        // If standard output failed, standard error has the message.
    }
    return status;
}

void Report::finish() const {
    if (!json) return;
    Json object = result;
    object["warnings"] = warnings_;
    print_result(object);
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr int width = 40;
constexpr std::chrono::milliseconds interval{100};
// Time and work before which no estimate is shown.
constexpr double least_seconds = 1;
constexpr double least_fraction = 0.02;

std::string time_left(double seconds, double fraction) {
    if (seconds < least_seconds || fraction < least_fraction) return {};
    return fmt::format("  about {} left", human_duration(seconds * (1 - fraction) / fraction));
}

}  // namespace

std::string human_duration(double seconds) {
    const auto whole = static_cast<long long>(std::ceil(std::clamp(seconds, 0.0, 1e15)));
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
    return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

// Work that ends within the first interval shows no bar.
ProgressBar::ProgressBar(bool wanted)
    : enabled_(wanted && ::isatty(STDERR_FILENO) != 0), begin_(Clock::now()), next_(begin_ + interval) {}

void ProgressBar::show(double fraction) {
    const Clock::time_point now = Clock::now();
    if (!enabled_ || now < next_) return;
    next_ = now + interval;
    const double clamped = std::clamp(fraction, 0.0, 1.0);
    const std::chrono::duration<double> elapsed = now - begin_;
    print(fmt::format("[{:<{}}] {:3.0f}%{}", std::string(static_cast<std::size_t>(clamped * width), '#'), width,
                      clamped * 100, time_left(elapsed.count(), clamped)));
}

void ProgressBar::show(const std::string& text) {
    if (enabled_ && Clock::now() >= next_) print(text);
}

void ProgressBar::restart() {
    clear();
    begin_ = Clock::now();
    next_ = begin_ + interval;
}

void ProgressBar::print(const std::string& text) {
    print_text("\r{:<{}}", text, columns_);
    std::fflush(stderr);
    columns_ = static_cast<int>(text.size());
}

void ProgressBar::clear() {
    if (columns_ == 0) return;
    print_text("\r{:{}}\r", "", columns_);
    columns_ = 0;
}
