#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf::device {

/// The names of the latest kernels that were launched. A driver tells that a command has failed, but not which one: it
/// is one of those that the host has not waited for. For any number of threads.
class LaunchedKernels {
public:
    /// name: a literal.
    void add(const char* name) noexcept { names_[count_++ % room] = name; }
    /// How many were launched.
    std::size_t count() const noexcept { return count_; }
    /// The first `count` have ended well.
    void forget(std::size_t count) noexcept {
        std::size_t before = forgotten_;
        while (before < count && !forgotten_.compare_exchange_weak(before, count)) {
        }
    }
    /// Those that are not forgotten, each name once, in their order: "a, b or c". Empty if there are none.
    std::string names() const;

private:
    static constexpr std::size_t room = 128;

    std::array<std::atomic<const char*>, room> names_{};
    std::atomic<std::size_t> count_ = 0, forgotten_ = 0;
};

inline std::string LaunchedKernels::names() const {
    const std::size_t end = count_, begin = end > room && forgotten_ < end - room ? end - room : forgotten_.load();
    std::vector<std::string_view> different;
    for (std::size_t n = begin; n < end; ++n)
        if (const char* const name = names_[n % room];
            name != nullptr && std::find(different.begin(), different.end(), name) == different.end())
            different.emplace_back(name);
    std::string text;
    for (std::size_t n = 0; n < different.size(); ++n) {
        if (n > 0) text += n + 1 < different.size() ? ", " : " or ";
        text += different[n];
    }
    return text;
}

}  // namespace clsdf::device
