#pragma once

#include "core/large_memory.hpp"
#include "core/parallel.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace clsdf {

/// Numbers from 0 on in sets that are joined (union-find).
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) { reset(count); }

    /// Each number in a set of its own.
    void reset(std::size_t count) {
        parent_.resize(count);
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }

    /// The same number for all of a set: the lowest.
    std::uint32_t root(std::uint32_t number) {
        while (parent_[number] != number) number = parent_[number] = parent_[parent_[number]];
        return number;
    }

    void join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parent_[a < b ? b : a] = a < b ? a : b;
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// The same for all cores at once: any number of threads may call join().
class SharedDisjointSets {
public:
    explicit SharedDisjointSets(std::size_t count) : parent_(count) {
        for_each_index(count, [this](std::size_t i) { parent_[i] = static_cast<std::uint32_t>(i); });
    }

    /// Whether they were in different sets. How many calls of all return true does not depend on their order.
    bool join(std::uint32_t a, std::uint32_t b) {
        for (;;) {
            a = root(a);
            b = root(b);
            if (a == b) return false;
            std::uint32_t higher = a < b ? b : a;
            const std::uint32_t lower = a < b ? a : b;
            if (parent(higher).compare_exchange_strong(higher, lower, std::memory_order_relaxed)) return true;
        }
    }

    /// The same number for all of a set, once no thread joins: the lowest.
    std::uint32_t root(std::uint32_t number) {
        for (;;) {
            const std::uint32_t above = parent(number).load(std::memory_order_relaxed);
            if (above == number) return number;
            const std::uint32_t next = parent(above).load(std::memory_order_relaxed);
            if (next != above) parent(number).store(next, std::memory_order_relaxed);  // still above it
            number = next;
        }
    }

private:
    std::atomic_ref<std::uint32_t> parent(std::uint32_t number) { return std::atomic_ref(parent_[number]); }

    UninitializedVector<std::uint32_t> parent_;
};

}  // namespace clsdf
