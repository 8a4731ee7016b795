#pragma once

#include <cstddef>
#include <iterator>
#include <map>
#include <optional>

namespace clsdf::device {

/// The ranges of a piece of memory that are free, by their offsets.
class FreeRanges {
public:
    explicit FreeRanges(std::size_t bytes) : bytes_(bytes), free_{{0, bytes}} {}

    /// Where so many bytes begin, of the smallest range that has them.
    std::optional<std::size_t> take(std::size_t bytes) {
        auto best = free_.end();
        for (auto range = free_.begin(); range != free_.end(); ++range)
            if (range->second >= bytes && (best == free_.end() || range->second < best->second)) best = range;
        if (best == free_.end()) return std::nullopt;
        const auto [offset, length] = *best;
        if (length > bytes) free_.emplace(offset + bytes, length - bytes);
        free_.erase(offset);
        return offset;
    }

    void give_back(std::size_t offset, std::size_t bytes) {
        auto range = free_.emplace(offset, bytes).first;
        if (const auto next = std::next(range); next != free_.end() && range->first + range->second == next->first) {
            range->second += next->second;
            free_.erase(next);
        }
        if (range == free_.begin()) return;
        const auto previous = std::prev(range);
        if (previous->first + previous->second != range->first) return;
        previous->second += range->second;
        free_.erase(range);
    }

    bool are_all_free() const { return free_.size() == 1 && free_.begin()->second == bytes_; }
    std::size_t free_bytes() const {
        std::size_t sum = 0;
        for (const auto& [offset, length] : free_) sum += length;
        return sum;
    }

private:
    std::size_t bytes_;
    std::map<std::size_t, std::size_t> free_;  // bytes from an offset on; no two adjoin
};

}  // namespace clsdf::device
