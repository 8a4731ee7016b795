#pragma once

#include <chrono>

/// A bar on standard error, where that is a terminal; nothing elsewhere.
class ProgressBar {
public:
    explicit ProgressBar(bool wanted);
    ~ProgressBar() { clear(); }
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    void show(double fraction);

    /// Takes the bar away, so that a line can be printed in its place.
    void clear();

private:
    bool enabled_;
    bool visible_ = false;
    std::chrono::steady_clock::time_point next_;
};
