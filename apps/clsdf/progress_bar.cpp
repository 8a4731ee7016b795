#include "progress_bar.hpp"

#include "report.hpp"

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>

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
