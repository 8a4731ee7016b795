#include "papers/gap_tests.hpp"

#include "papers/root_sum.hpp"

#include <CGAL/Interval_nt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace clsdf::papers {

namespace {

/// The bisector planes of a fan's edges in an arithmetic: a Number, its square_root(), and whether one
/// is_surely_positive() or is_surely_zero(). Vectors are positive multiples of what they stand for.
template <typename Arithmetic>
class BisectorPlanes {
public:
    using Number = typename Arithmetic::Number;
    using Vector = std::array<Number, 3>;

    explicit BisectorPlanes(const Fan& fan) {
        const std::size_t count = fan.size();
        const Number scale(power_of_two_to_one(fan));
        const auto difference = [&](const Vec3& to, std::size_t axis) {
            return (Number(to[axis]) - Number(fan.vertex[axis])) * scale;
        };
        std::vector<Vector> spokes;
        for (const Vec3& to : fan.neighbours)
            spokes.push_back({difference(to, 0), difference(to, 1), difference(to, 2)});
        for (std::size_t i = 0; i < count; ++i) {
            normals_.push_back(cross(spokes[i], spokes[fan.after(i)]));
            areas_.push_back(Arithmetic::square_root(dot(normals_[i], normals_[i])));
        }
        for (std::size_t i = 0; i < count; ++i) {
            // The plane holds the edge and the sum of the unit normals. At a flat edge that is either face's normal,
            // which takes no root; if the two are surely not opposite.
            const Vector& before = normals_[fan.before(i)];
            const Vector& after = normals_[i];
            const bool is_plain = fan.is_flat[i] != 0 && Arithmetic::is_surely_positive(dot(before, after));
            planes_.push_back(
                cross(spokes[i], is_plain ? after : sum(areas_[i], before, areas_[fan.before(i)], after)));
        }
    }

    /// det(A_i, A_j, A_k), A_i the normal of the bisector plane at the edge to neighbour i, pointing out of face i.
    Number determinant(std::size_t i, std::size_t j, std::size_t k) const {
        return dot(cross(planes_[i], planes_[j]), planes_[k]);
    }

    /// The same of the faces' normals.
    Number normal_determinant(std::size_t i, std::size_t j, std::size_t k) const {
        return dot(cross(normals_[i], normals_[j]), normals_[k]);
    }

    /// The component of face i's normal along the average of the faces' unit normals. Faces without area have none.
    Number facing(std::size_t i) const {
        if (!average_) {
            Vector& average = average_.emplace(zero());
            for (std::size_t k = 0; k < normals_.size(); ++k)
                for (std::size_t axis = 0; axis < 3 && !Arithmetic::is_surely_zero(areas_[k]); ++axis)
                    average[axis] = average[axis] + normals_[k][axis] / areas_[k];
        }
        return dot(normals_[i], *average_);
    }

    /// The bisector planes' normals, or those of the faces.
    const std::vector<Vector>& normals(PlaneKind kind) const {
        return kind == PlaneKind::bisector ? planes_ : normals_;
    }

    /// The sum of lines in which planes of a kind meet.
    Vector sum_of_lines(PlaneKind kind, std::span<const PlaneLine> lines) const {
        Vector result = zero();
        for (const PlaneLine& line : lines) {
            const Vector direction = cross(normals(kind)[line.i], normals(kind)[line.j]);
            for (std::size_t axis = 0; axis < 3; ++axis)
                result[axis] = result[axis] + Number(line.weight) * direction[axis];
        }
        return result;
    }

    /// The component of a direction along the normal of plane k, times that normal's length.
    Number component(PlaneKind kind, const Vector& direction, std::size_t k) const {
        return dot(direction, normals(kind)[k]);
    }

private:
    /// A power of two that brings the fan to the size of one, as far as one in range can: what follows has up to
    /// fifteen factors of its size.
    static double power_of_two_to_one(const Fan& fan) {
        double size = 0;
        for (const Vec3& neighbour : fan.neighbours)
            for (std::size_t axis = 0; axis < 3; ++axis)
                size = std::max(size, std::abs(neighbour[axis] / 2 - fan.vertex[axis] / 2));
        if (!(size > 0)) return 1;
        constexpr int limit = 1000;
        return std::ldexp(1.0, std::clamp(-std::ilogb(size), -limit, limit));
    }

    static Vector zero() { return {Number(0), Number(0), Number(0)}; }
    static Vector cross(const Vector& a, const Vector& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
    static Number dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
    static Vector sum(const Number& p, const Vector& a, const Number& q, const Vector& b) {
        return {p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]};
    }

    std::vector<Vector> normals_;
    std::vector<Number> areas_;
    std::vector<Vector> planes_;
    mutable std::optional<Vector> average_;  // of the faces' unit normals
};

using Rounding = CGAL::Protect_FPU_rounding<true>;  // what interval arithmetic needs around it

struct IntervalArithmetic {
    using Number = CGAL::Interval_nt_advanced;

    static Number square_root(const Number& square) { return CGAL::sqrt(square); }
    static bool is_surely_positive(const Number& value) { return value.inf() > 0; }
    static bool is_surely_zero(const Number& value) { return value.inf() == 0 && value.sup() == 0; }
};

struct ExactArithmetic {
    using Number = RootSum;

    static Number square_root(const Number& square) { return RootSum::square_root(square); }
    static bool is_surely_positive(const Number& value) { return value.sign() > 0; }
    static bool is_surely_zero(const Number& value) { return value.sign() == 0; }
};

/// nullopt if the interval leaves the sign open.
std::optional<int> sign_of(const IntervalArithmetic::Number& value) {
    if (value.inf() > 0) return 1;
    if (value.sup() < 0) return -1;
    if (IntervalArithmetic::is_surely_zero(value)) return 0;
    return std::nullopt;
}

BisectorPlanes<IntervalArithmetic> filtered_planes(const Fan& fan) {
    const Rounding rounding;
    return BisectorPlanes<IntervalArithmetic>(fan);
}

}  // namespace

struct FanSigns::Filter {
    explicit Filter(const Fan& fan) : planes(filtered_planes(fan)) {}
    BisectorPlanes<IntervalArithmetic> planes;
};

struct FanSigns::Exact {
    explicit Exact(const Fan& fan) : planes(fan) {}
    BisectorPlanes<ExactArithmetic> planes;
};

struct FanSigns::Direction {
    PlaneKind kind;
    std::vector<PlaneLine> lines;
    BisectorPlanes<IntervalArithmetic>::Vector filtered;
    std::optional<BisectorPlanes<ExactArithmetic>::Vector> exact;  // made when it is needed
};

FanSigns::FanSigns(const Fan& fan) : fan_(fan), filter_(std::make_unique<Filter>(fan)) {}

FanSigns::~FanSigns() = default;

template <typename Value>
int FanSigns::decide(const Value& value) {
    ++decisions_;
    const std::optional<int> sign = [&] {
        const Rounding rounding;
        return sign_of(value(filter_->planes));
    }();
    if (sign) return *sign;
    ++exact_decisions_;
    return value(exact().planes).sign();
}

const FanSigns::Exact& FanSigns::exact() {
    if (!exact_) exact_ = std::make_unique<Exact>(fan_);
    return *exact_;
}

int FanSigns::side(std::size_t i, std::size_t j, std::size_t k) {
    return decide([&](const auto& planes) { return planes.determinant(i, j, k); });
}

int FanSigns::side_of_face(std::size_t i, std::size_t j, std::size_t k) {
    return decide([&](const auto& planes) { return planes.normal_determinant(i, j, k); });
}

double FanSigns::line_weight(PlaneKind kind, std::size_t i, std::size_t j) const {
    const Rounding rounding;
    const PlaneLine line{i, j, 1};
    double longest = 0;
    for (const IntervalArithmetic::Number& component : filter_->planes.sum_of_lines(kind, std::span(&line, 1)))
        longest = std::max(longest, std::max(std::abs(component.inf()), std::abs(component.sup())));
    constexpr int limit = 1000;
    return longest > 0 ? std::ldexp(1.0, std::clamp(-std::ilogb(longest), -limit, limit)) : 1;
}

void FanSigns::set_direction(PlaneKind kind, std::span<const PlaneLine> lines) {
    const Rounding rounding;
    direction_ = std::make_unique<Direction>(
        Direction{kind, {lines.begin(), lines.end()}, filter_->planes.sum_of_lines(kind, lines), std::nullopt});
}

int FanSigns::side_of_direction(std::size_t k) {
    ++decisions_;
    const std::optional<int> sign = [&] {
        const Rounding rounding;
        return sign_of(filter_->planes.component(direction_->kind, direction_->filtered, k));
    }();
    if (sign) return *sign;
    ++exact_decisions_;
    if (!direction_->exact) direction_->exact = exact().planes.sum_of_lines(direction_->kind, direction_->lines);
    return exact().planes.component(direction_->kind, *direction_->exact, k).sign();
}

int FanSigns::facing(std::size_t i) {
    return decide([&](const auto& planes) { return planes.facing(i); });
}

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

/// About 0.618 of the count, and coprime with it: steps of that length visit everything, early ones all over it.
std::size_t spreading_step(std::size_t count) {
    std::size_t step = count * 618 / 1000 + 1;
    while (std::gcd(step, count) != 1) ++step;
    return step;
}

}  // namespace

Fan fan_at(const MeshSurface& surface, std::size_t vertex, engine::VertexFans& fans) {
    surface.build_fans(vertex, fans);
    Fan fan;
    fan.vertex = surface.position(vertex);
    for (const engine::VertexFans::Face& face : fans.faces()) {
        fan.neighbours.push_back(surface.position(face.neighbour));
        fan.is_flat.push_back(surface.kind(face.corner) == EdgeKind::flat);
    }
    return fan;
}

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

}  // namespace clsdf::papers
