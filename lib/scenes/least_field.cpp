#include "scenes/least_field.hpp"

#include "core/outputs.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace clsdf::scenes {

namespace {

/// Rows of samples that are worth a task.
constexpr std::size_t rows_at_once = 64;

std::uint32_t* bodies_in(const targets::HostArrays& arrays) {
    return reinterpret_cast<std::uint32_t*>(arrays[Output::body].data);
}

/// Where two bodies have the same distance: see LeastField::add().
bool comes_before(std::uint32_t body, std::uint32_t other, bool is_inside) {
    if ((body == no_body) == (other == no_body)) return body < other;
    return (body == no_body) == is_inside;
}

}  // namespace

std::optional<Grid> part_near(const Grid& grid, const Box& box, double margin) {
    Index3 first = grid.first, size = grid.size;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto begin = static_cast<double>(grid.first[axis]), end = begin + static_cast<double>(grid.size[axis]);
        const auto place = [&](double x) { return (x - grid.origin[axis]) / grid.spacing[axis]; };
        const double lowest = std::max(begin, std::floor(place(box.lower[axis] - margin)) - 1),
                     highest = std::min(end, std::ceil(place(box.upper[axis] + margin)) + 2);
        if (!(lowest < highest)) return std::nullopt;
        first[axis] = static_cast<std::int64_t>(lowest);
        size[axis] = static_cast<std::int64_t>(highest - lowest);
    }
    return grid.block(first, size);
}

void LeastField::clear(double outside) {
    const auto as_float = static_cast<float>(outside);
    for_each_output(
        [&](const OutputInfo& info, const targets::HostArray& array) {
            if (array.data == nullptr) return;
            const std::size_t bytes = sample_bytes(info, array.in_double);
            for_each_range(
                grid_.sample_count(),
                [&](std::size_t begin, std::size_t end) {
                    std::byte* const first = array.data + begin * bytes;
                    if (info.output != Output::distance)
                        std::memset(first, 0xFF, (end - begin) * bytes);
                    else if (array.in_double)
                        std::fill_n(reinterpret_cast<double*>(first), end - begin, outside);
                    else
                        std::fill_n(reinterpret_cast<float*>(first), end - begin, as_float);
                },
                std::size_t{1} << 16);
        },
        arrays_);
}

void LeastField::begin_with(std::uint32_t body) {
    std::uint32_t* const bodies = bodies_in(arrays_);
    if (bodies == nullptr || body == 0) return;
    for_each_index(
        grid_.sample_count(),
        [&](std::size_t i) {
            if (bodies[i] != no_body) bodies[i] = body;
        },
        std::size_t{1} << 16);
}

template <typename Distance>
void LeastField::add_row(std::size_t to, std::size_t from, std::size_t count, const targets::HostArrays& values,
                         std::uint32_t body) {
    auto* const least = reinterpret_cast<Distance*>(arrays_[Output::distance].data) + to;
    const auto* const found = reinterpret_cast<const Distance*>(values[Output::distance].data) + from;
    std::uint32_t* const bodies = bodies_in(arrays_);
    if (bodies == nullptr) {
        // A zero with a sign is that beyond a band without depth. Without branches: compilers make vectors of it.
        for (std::size_t i = 0; i < count; ++i) {
            const bool is_less = found[i] < least[i],
                       is_zero_with_sign = (found[i] == least[i]) & (std::signbit(found[i]) != 0);
            least[i] = is_less | is_zero_with_sign ? found[i] : least[i];
        }
        return;
    }
    const std::uint32_t* const found_body = bodies_in(values) + from;
    for (std::size_t i = 0; i < count; ++i) {
        if (found[i] > least[i]) continue;
        const std::uint32_t of_found = found_body[i] == no_body ? no_body : body;
        if (found[i] == least[i]) {
            const bool is_inside = std::signbit(found[i]);
            if (is_inside != std::signbit(least[i]) ? !is_inside : !comes_before(of_found, bodies[to + i], is_inside))
                continue;
        }
        for_each_output(
            [&](const OutputInfo& info, const targets::HostArray& array, const targets::HostArray& value) {
                if (array.data == nullptr) return;
                const std::size_t bytes = sample_bytes(info, array.in_double);
                std::memcpy(array.data + (to + i) * bytes, value.data + (from + i) * bytes, bytes);
            },
            arrays_, values);
        bodies[to + i] = of_found;
    }
}

void LeastField::add(const Grid& part, const Grid& block, const targets::HostArrays& values, std::uint32_t body) {
    const auto width = static_cast<std::size_t>(part.size[0]), height = static_cast<std::size_t>(part.size[1]);
    for_each_index(
        height * static_cast<std::size_t>(part.size[2]),
        [&](std::size_t row) {
            const std::int64_t y = part.first[1] + static_cast<std::int64_t>(row % height),
                               z = part.first[2] + static_cast<std::int64_t>(row / height);
            const auto place_in = [&](const Grid& grid) {
                return grid.offset(part.first[0] - grid.first[0], y - grid.first[1], z - grid.first[2]);
            };
            if (arrays_[Output::distance].in_double)
                add_row<double>(place_in(grid_), place_in(block), width, values, body);
            else
                add_row<float>(place_in(grid_), place_in(block), width, values, body);
        },
        rows_at_once);
}

}  // namespace clsdf::scenes
