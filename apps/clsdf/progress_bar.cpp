#include "progress_bar.hpp"

#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cstdio>

namespace {

constexpr int width = 40;
constexpr std::chrono::milliseconds interval{100};

}  // namespace

// What is done before the first interval ends needs no bar.
ProgressBar::ProgressBar(bool wanted)
    : enabled_(wanted && ::isatty(STDERR_FILENO) != 0), next_(std::chrono::steady_clock::now() + interval) {}

void ProgressBar::show(double fraction) {
    if (!enabled_ || std::chrono::steady_clock::now() < next_) return;
    next_ = std::chrono::steady_clock::now() + interval;
    visible_ = true;
    const double clamped = std::clamp(fraction, 0.0, 1.0);
    fmt::print(stderr, "\r[{:<{}}] {:3.0f}%", std::string(static_cast<std::size_t>(clamped * width), '#'), width,
               clamped * 100);
    std::fflush(stderr);
}

void ProgressBar::clear() {
    if (!visible_) return;
    visible_ = false;
    fmt::print(stderr, "\r{:{}}\r", "", width + 8);
}
