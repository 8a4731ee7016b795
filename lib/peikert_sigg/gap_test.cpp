#include "peikert_sigg/gap_test.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

namespace clsdf::peikert_sigg {

namespace {

/// The lines in which two of some planes through one point meet, and which do not lie on both sides of the others: the
/// points that lie on one side of all planes form a cone, and these lines bound it. `side(i, j, k)` is the side of
/// plane k on which the line of the planes i and j lies. Calls found(i, j, common side, planes beside the line) until
/// that returns true; returns whether it did.
template <typename Side, typename Found>
bool find_bounding_lines(std::size_t count, const Side& side, const Found& found) {
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
                const int found_side = k == i || k == j ? 0 : side(i, j, k);
                if (found_side == 0) continue;
                bounds = found_side != -common;
                common = found_side;
                beside.push_back(k);
            }
            if (!bounds) {
                const auto last = order.begin() + static_cast<std::ptrdiff_t>(tested);
                std::rotate(order.begin(), last - 1, last);
                continue;
            }
            if (found(i, j, common, beside)) return true;
        }
    return false;
}

/// Whether there are points strictly on one side of all planes. The sum of the lines that bound their cone is one.
template <typename Side>
bool is_cone(std::size_t count, const Side& side) {
    std::vector<bool> strictly(count, false);  // on that side of the plane lies some line strictly
    return find_bounding_lines(count, side, [&](std::size_t, std::size_t, int, std::span<const std::size_t> beside) {
        for (const std::size_t k : beside) strictly[k] = true;
        return std::find(strictly.begin(), strictly.end(), false) == strictly.end();
    });
}

/// Whether a few planes have points on one side of all of them; unknown if the planes share a line.
enum class Cone { found, absent, unknown };

/// Sets the direction of `signs` to one in the cone of the planes `few`, if they have one.
template <typename Side>
Cone enter_cone(FanSigns& signs, PlaneKind kind, std::span<const std::size_t> few, const Side& side) {
    std::vector<bool> strictly(few.size(), false);
    std::vector<PlaneLine> lines;
    bool has_side = false;
    find_bounding_lines(
        few.size(),
        [&](std::size_t i, std::size_t j, std::size_t k) {
            const int found = side(few[i], few[j], few[k]);
            has_side = has_side || found != 0;
            return found;
        },
        [&](std::size_t i, std::size_t j, int common, std::span<const std::size_t> beside) {
            for (const std::size_t k : beside) strictly[k] = true;
            if (common != 0) lines.push_back({few[i], few[j], common * signs.line_weight(kind, few[i], few[j])});
            return false;
        });
    if (!has_side) return Cone::unknown;
    if (std::find(strictly.begin(), strictly.end(), false) != strictly.end()) return Cone::absent;
    signs.set_direction(kind, lines);
    return Cone::found;
}

/// The same as is_cone() for very many planes, in a time that grows with their number. If a few planes have no cone,
/// all have none. Else a direction in the cone of the few is compared with all planes; the first one that excludes it
/// joins the few, and removes about half of their cone.
template <typename Side>
bool is_cone_of_many(FanSigns& signs, PlaneKind kind, const Side& side) {
    constexpr std::size_t first_few = 6;
    constexpr std::size_t most_few = 96;
    const std::size_t count = signs.fan().size();
    std::vector<std::size_t> few;
    for (std::size_t i = 0; i < first_few; ++i) few.push_back(i * count / first_few);
    std::size_t start = 0;
    while (few.size() < most_few) {
        const Cone cone = enter_cone(signs, kind, few, side);
        if (cone == Cone::absent) return false;
        // In steps that visit the planes all over the fan.
        start = (start + count * 5 / 13 + 1) % count;
        std::size_t tested = 0;
        if (cone == Cone::found)
            while (tested < count && signs.side_of_direction((start + tested) % count) > 0) ++tested;
        if (tested == count) return true;
        few.push_back((start + tested) % count);
    }
    return is_cone(count, side);
}

/// Fewer planes are compared with each other.
constexpr std::size_t many_planes = 64;

template <typename Side>
bool has_cone(FanSigns& signs, PlaneKind kind, const Side& side) {
    return signs.fan().size() < many_planes ? is_cone(signs.fan().size(), side) : is_cone_of_many(signs, kind, side);
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

namespace {

/// About 0.618 of the count, and coprime with it: steps of that length visit everything, early ones all over it.
std::size_t spreading_step(std::size_t count) {
    std::size_t step = count * 618 / 1000 + 1;
    while (std::gcd(step, count) != 1) ++step;
    return step;
}

}  // namespace

std::vector<FailingLine> failing_lines(FanSigns& signs) {
    const std::size_t count = signs.fan().size();
    std::vector<FailingLine> result;
    if (count < 4) return result;  // three planes have no others to be on one side of
    // Planes on the same side of a line are often neighbours: the others are tried all over the fan, and first the one
    // that lay across the line before.
    const std::size_t step = spreading_step(count);
    std::size_t last = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t j = signs.fan().after(i);
        const int direction = signs.side(i, j, signs.fan().after(j));
        bool fails = direction != 0;
        for (std::size_t tried = 0, k = last; tried < count && fails; ++tried, k = (k + step) % count)
            if (k != i && k != j && signs.side(i, j, k) != direction) {
                fails = false;
                last = k;
            }
        if (fails) result.push_back({i, direction});
    }
    return result;
}

bool has_gap(FanSigns& signs) {
    return has_cone(signs, PlaneKind::bisector,
                    [&](std::size_t i, std::size_t j, std::size_t k) { return signs.side(i, j, k); });
}

bool has_view(FanSigns& signs) {
    return has_cone(signs, PlaneKind::face,
                    [&](std::size_t i, std::size_t j, std::size_t k) { return signs.side_of_face(i, j, k); });
}

std::vector<std::size_t> flipped_faces(FanSigns& signs) {
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < signs.fan().size(); ++i)
        if (signs.facing(i) <= 0) result.push_back(i);
    return result;
}

}  // namespace clsdf::peikert_sigg
