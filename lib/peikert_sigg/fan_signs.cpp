#include "peikert_sigg/fan_signs.hpp"

#include "peikert_sigg/root_sum.hpp"

#include <CGAL/Interval_nt.h>

#include <optional>

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
    if (!exact_) exact_ = std::make_unique<Exact>(fan_);
    return value(exact_->planes).sign();
}

int FanSigns::side(std::size_t i, std::size_t j, std::size_t k) {
    return decide([&](const auto& planes) { return planes.determinant(i, j, k); });
}

int FanSigns::side_of_face(std::size_t i, std::size_t j, std::size_t k) {
    return decide([&](const auto& planes) { return planes.normal_determinant(i, j, k); });
}

int FanSigns::facing(std::size_t i) {
    return decide([&](const auto& planes) { return planes.facing(i); });
}

}  // namespace clsdf::peikert_sigg
