#include <clsdf/segments.hpp>

#include "core/refuse.hpp"

#include <array>
#include <cstddef>
#include <cstdlib>

namespace clsdf {

namespace {

/// The order of waLBerla and lbmpy: along axes, then diagonals of the planes, then of space.
constexpr std::array<LinkDirection, 27> by_name{
    {{0, 0, 0},   {0, 1, 0},  {0, -1, 0}, {-1, 0, 0}, {1, 0, 0},   {0, 0, 1},  {0, 0, -1},  {-1, 1, 0},  {1, 1, 0},
     {-1, -1, 0}, {1, -1, 0}, {0, 1, 1},  {0, -1, 1}, {-1, 0, 1},  {1, 0, 1},  {0, 1, -1},  {0, -1, -1}, {-1, 0, -1},
     {1, 0, -1},  {1, 1, 1},  {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}, {1, 1, -1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}}};

/// The first half of the order of OpenLB and Palabos; the second half has the opposites in the same order.
constexpr std::array<LinkDirection, 13> of_half{{{-1, 0, 0},
                                                 {0, -1, 0},
                                                 {0, 0, -1},
                                                 {-1, -1, 0},
                                                 {-1, 1, 0},
                                                 {-1, 0, -1},
                                                 {-1, 0, 1},
                                                 {0, -1, -1},
                                                 {0, -1, 1},
                                                 {-1, -1, -1},
                                                 {-1, -1, 1},
                                                 {-1, 1, -1},
                                                 {-1, 1, 1}}};

/// Whether a stencil has the direction: by the number of its components that are not 0.
bool has(std::size_t count, const LinkDirection& direction) {
    const int squared = direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2];
    return count == 27 || (count == 19 ? squared != 3 : squared != 2);
}

std::vector<LinkDirection> in_order_of_names(std::size_t count) {
    std::vector<LinkDirection> directions;
    for (const LinkDirection& direction : by_name)
        if (has(count, direction)) directions.push_back(direction);
    return directions;
}

std::vector<LinkDirection> in_halves(std::size_t count) {
    std::vector<LinkDirection> directions{{0, 0, 0}};
    for (const int sign : {1, -1})
        for (const auto& [x, y, z] : of_half)
            if (has(count, {x, y, z})) directions.push_back({sign * x, sign * y, sign * z});
    return directions;
}

/// x changes slowest; on each axis the values are these.
std::vector<LinkDirection> in_product(std::size_t count, const std::array<std::int32_t, 3>& values) {
    std::vector<LinkDirection> directions;
    for (const std::int32_t x : values)
        for (const std::int32_t y : values)
            for (const std::int32_t z : values)
                if (has(count, {x, y, z})) directions.push_back({x, y, z});
    return directions;
}

}  // namespace

std::vector<LinkDirection> stencil(std::string_view name, std::string_view code) {
    const std::size_t count = name == "D3Q15" ? 15 : name == "D3Q19" ? 19 : name == "D3Q27" ? 27 : 0;
    if (count != 0) {
        if (code == "waLBerla" || code == "lbmpy") return in_order_of_names(count);
        if (code == "OpenLB" || code == "Palabos") return in_halves(count);
        if (code == "XLB" && count != 15) return in_product(count, {0, -1, 1});
    }
    refuse(
        "there is no stencil {} in the order of {}; there are D3Q15, D3Q19 and D3Q27 of waLBerla, "
        "lbmpy, OpenLB and Palabos, and D3Q19 and D3Q27 of XLB",
        name, code);
}

}  // namespace clsdf
