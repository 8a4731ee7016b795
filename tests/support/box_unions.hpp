#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <vector>

namespace clsdf::test {

/// The union of boxes by the cells between all their coordinates.
class Cells {
public:
    explicit Cells(const std::vector<Box>& boxes) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::set<double> all;
            for (const Box& box : boxes) all.insert({box.lower[axis], box.upper[axis]});
            at_[axis].assign(all.begin(), all.end());
        }
        for_each_cell([&](const std::array<std::size_t, 3>& cell) {
            const auto is_in = [&](const Box& box) {
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (at_[axis][cell[axis]] < box.lower[axis] || at_[axis][cell[axis] + 1] > box.upper[axis])
                        return false;
                return true;
            };
            if (std::ranges::any_of(boxes, is_in)) full_.insert(cell);
        });
        for (const std::array<std::size_t, 3>& cell : full_) {
            double volume = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) volume *= at_[axis][cell[axis] + 1] - at_[axis][cell[axis]];
            volume_ += volume;
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) add_side(cell, axis, side);
        }
    }

    double volume() const { return volume_; }
    double area() const { return area_; }
    /// Of the boundary, without a sign.
    double distance(const Vec3& point) const {
        double least = infinite;
        for (const Box& side : sides_) {
            double squared = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double off = point[axis] - std::clamp(point[axis], side.lower[axis], side.upper[axis]);
                squared += off * off;
            }
            least = std::min(least, std::sqrt(squared));
        }
        return least;
    }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();

    template <typename Function>
    void for_each_cell(const Function& f) const {
        for (std::size_t i = 0; i + 1 < at_[0].size(); ++i)
            for (std::size_t j = 0; j + 1 < at_[1].size(); ++j)
                for (std::size_t k = 0; k + 1 < at_[2].size(); ++k) f({i, j, k});
    }
    void add_side(const std::array<std::size_t, 3>& cell, std::size_t axis, std::size_t side) {
        std::array<std::size_t, 3> beyond = cell;
        beyond[axis] += side == 0 ? std::size_t(-1) : 1;
        if (full_.contains(beyond)) return;
        Box box;
        double area = 1;
        for (std::size_t k = 0; k < 3; ++k) {
            box.lower[k] = at_[k][cell[k] + (k == axis ? side : 0)];
            box.upper[k] = at_[k][cell[k] + (k == axis ? side : 1)];
            if (k != axis) area *= box.upper[k] - box.lower[k];
        }
        area_ += area;
        sides_.push_back(box);
    }

    std::array<std::vector<double>, 3> at_;
    std::set<std::array<std::size_t, 3>> full_;
    std::vector<Box> sides_;
    double volume_ = 0, area_ = 0;
};

}  // namespace clsdf::test
