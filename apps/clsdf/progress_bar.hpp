#pragma once

#include <chrono>
#include <string>

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
