#pragma once

#include "core/parallel.hpp"

#include <clsdf/arrays.hpp>
#include <clsdf/error.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>

/// The items of a mesh's arrays: three numbers each, at any distance from each other.
namespace clsdf {

/// Strides in bytes; 0 is replaced by the packed stride.
struct Steps {
    std::ptrdiff_t triple = 0;
    std::ptrdiff_t number = 0;
};

inline Steps steps_of(const InputArray& triples) {
    const auto width = static_cast<std::ptrdiff_t>(bytes_of(triples.type));
    const std::ptrdiff_t number = triples.component_stride != 0 ? triples.component_stride : width;
    // Components that lie elsewhere leave no room between the items.
    return {triples.strides[0] != 0 ? triples.strides[0] : number == width ? 3 * width : width, number};
}

/// Throws Error(unsupported) for memory of the device.
inline const std::byte* first_of(const InputArray& triples) {
    if (triples.device != nullptr)
        throw Error(ErrorCode::unsupported,
                    "these arrays of a mesh are memory of the device, which this call cannot read; make a transform of "
                    "them, or give arrays of the host");
    return static_cast<const std::byte*>(triples.host) + triples.offset;
}

/// The three numbers of the item at an address.
template <typename Number>
std::array<Number, 3> read_triple(const std::byte* at, const Steps& steps) {
    std::array<Number, 3> numbers;
    for (std::size_t k = 0; k < 3; ++k)
        std::memcpy(&numbers[k], at + static_cast<std::ptrdiff_t>(k) * steps.number, sizeof(Number));
    return numbers;
}

template <typename Number>
std::array<Number, 3> triple_of(const InputArray& triples, std::size_t i) {
    const Steps steps = steps_of(triples);
    return read_triple<Number>(first_of(triples) + static_cast<std::ptrdiff_t>(i) * steps.triple, steps);
}

/// Calls f(index, numbers) for each triple, on all cores.
template <typename Number, typename Function>
void for_each_triple(const InputArray& triples, const Function& f) {
    if (triples.count == 0) return;
    const std::byte* const first = first_of(triples);
    const Steps steps = steps_of(triples);
    for_each_index(triples.count, [&](std::size_t i) {
        f(i, read_triple<Number>(first + static_cast<std::ptrdiff_t>(i) * steps.triple, steps));
    });
}

/// The least of the indices that threads take.
class LeastIndex {
public:
    explicit LeastIndex(std::size_t none) : least_(none) {}

    void take(std::size_t index) {
        std::size_t least = least_;
        while (index < least && !least_.compare_exchange_weak(least, index)) {
        }
    }
    std::size_t get() const { return least_; }

private:
    std::atomic<std::size_t> least_;
};

}  // namespace clsdf
