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
/// Of a place in a grid, in samples, and of what kernels take for the half width: more than either.
constexpr double rounding = 0.125;

std::uint32_t* bodies_in(const targets::HostArrays& arrays) {
    return reinterpret_cast<std::uint32_t*>(arrays[Output::body].data);
}

/// Calls visit() for the first sample of each row of a part, as the lattice counts.
template <typename Visit>
void for_each_row(const Grid& part, const Visit& visit) {
    const auto height = static_cast<std::size_t>(part.size[1]);
    for_each_index(
        height * static_cast<std::size_t>(part.size[2]),
        [&](std::size_t row) {
            visit({part.first[0], part.first[1] + static_cast<std::int64_t>(row % height),
                   part.first[2] + static_cast<std::int64_t>(row / height)});
        },
        rows_at_once);
}

/// Of a sample as the lattice counts, in the arrays of a grid.
std::size_t place_in(const Grid& grid, const Index3& sample) {
    return grid.offset(sample[0] - grid.first[0], sample[1] - grid.first[1], sample[2] - grid.first[2]);
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
        const double lowest = std::max(begin, std::ceil(place(box.lower[axis] - margin) - rounding)),
                     highest = std::min(end, std::floor(place(box.upper[axis] + margin) + rounding) + 1);
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

void LeastField::begin_with(const Grid& part, std::uint32_t body) {
    std::uint32_t* const bodies = bodies_in(arrays_);
    if (bodies == nullptr || body == 0) return;
    for_each_row(part, [&](const Index3& first) {
        std::uint32_t* const row = bodies + place_in(grid_, first);
        std::replace_if(
            row, row + part.size[0], [](std::uint32_t found) { return found != no_body; }, body);
    });
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
    const auto width = static_cast<std::size_t>(part.size[0]);
    for_each_row(part, [&](const Index3& first) {
        if (arrays_[Output::distance].in_double)
            add_row<double>(place_in(grid_, first), place_in(block, first), width, values, body);
        else
            add_row<float>(place_in(grid_, first), place_in(block, first), width, values, body);
    });
}

}  // namespace clsdf::scenes
