#include "peikert_sigg/gap_test.hpp"

#include <algorithm>
#include <numeric>

namespace clsdf::peikert_sigg {

namespace {

/// Whether there are points strictly on one side of all planes through one point. `side(i, j, k)` is the side of plane
/// k on which the line lies in which the planes i and j meet. Such points form a cone, the sum of the lines that bound
/// it is one of them, and those are the lines that do not lie on both sides of the planes.
template <typename Side>
bool is_cone(std::size_t count, const Side& side) {
    std::vector<bool> strictly(count, false);  // on that side of the plane lies some line strictly
    std::vector<std::size_t> beside;
    // In any order, but first those that showed lately that a line lies on both sides: most often they show it of the
    // next line too, and the test of all lines takes the square of the planes instead of the cube.
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = i + 1; j < count; ++j) {
            beside.clear();
            int common = 0;
            bool bounds = true;
            std::size_t tested = 0;
            for (; tested < count && bounds; ++tested) {
                const std::size_t k = order[tested];
                const int found = k == i || k == j ? 0 : side(i, j, k);
                if (found == 0) continue;
                bounds = found != -common;
                common = found;
                beside.push_back(k);
            }
            if (!bounds) {
                const auto last = order.begin() + static_cast<std::ptrdiff_t>(tested);
                std::rotate(order.begin(), last - 1, last);
                continue;
            }
            for (const std::size_t k : beside) strictly[k] = true;
            if (std::find(strictly.begin(), strictly.end(), false) == strictly.end()) return true;
        }
    return false;
}

}  // namespace

Fan fan_at(const Surface& surface, std::size_t vertex, polyhedra::VertexFans& fans) {
    surface.build_fans(vertex, fans);
    Fan fan;
    fan.vertex = surface.position(vertex);
    for (const polyhedra::VertexFans::Face& face : fans.faces()) {
        fan.neighbours.push_back(surface.position(face.neighbour));
        fan.is_flat.push_back(surface.kind(face.corner) == EdgeKind::flat);
    }
    return fan;
}

std::vector<FailingLine> failing_lines(FanSigns& signs) {
    const std::size_t count = signs.fan().size();
    std::vector<FailingLine> result;
    if (count < 4) return result;  // three planes have no others to be on one side of
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t j = signs.fan().after(i);
        const int direction = signs.side(i, j, signs.fan().after(j));
        bool fails = direction != 0;
        for (std::size_t k = 0; k < count && fails; ++k) fails = k == i || k == j || signs.side(i, j, k) == direction;
        if (fails) result.push_back({i, direction});
    }
    return result;
}

bool has_gap(FanSigns& signs) {
    return is_cone(signs.fan().size(),
                   [&](std::size_t i, std::size_t j, std::size_t k) { return signs.side(i, j, k); });
}

bool has_view(FanSigns& signs) {
    return is_cone(signs.fan().size(),
                   [&](std::size_t i, std::size_t j, std::size_t k) { return signs.side_of_face(i, j, k); });
}

std::vector<std::size_t> flipped_faces(FanSigns& signs) {
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < signs.fan().size(); ++i)
        if (signs.facing(i) <= 0) result.push_back(i);
    return result;
}

}  // namespace clsdf::peikert_sigg
