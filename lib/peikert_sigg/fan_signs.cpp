#include "peikert_sigg/fan_signs.hpp"

#include "peikert_sigg/root_sum.hpp"

#include <CGAL/Interval_nt.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace clsdf::peikert_sigg {

namespace {

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

/// nullopt where the interval leaves the sign open.
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

}  // namespace clsdf::peikert_sigg
