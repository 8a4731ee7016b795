#include "targets/target_overlap.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <utility>

namespace clsdf::targets {

namespace {

/// Runs of consecutive bytes: one at each point of a lattice of up to four axes, whose strides ascend.
struct ByteRuns {
    const WrittenArray* array = nullptr;
    std::uint64_t begin = 0;  ///< of the first run
    std::uint64_t bytes = 0;  ///< of a run
    std::array<std::uint64_t, 4> strides{};
    std::array<std::uint64_t, 4> counts{};
    std::size_t axes = 0;

    std::uint64_t end() const {
        std::uint64_t end = begin + bytes;
        for (std::size_t axis = 0; axis < axes; ++axis) end += strides[axis] * (counts[axis] - 1);
        return end;
    }
};

/// Axes with negative strides run from the other end. Values that lie side by side are one run.
ByteRuns runs_of(const WrittenArray& array) {
    ByteRuns runs{&array, array.first, array.width, {}, {}, 0};
    const auto add = [&](std::ptrdiff_t signed_stride, std::uint64_t count) {
        if (count < 2) return;
        const auto stride = static_cast<std::uint64_t>(std::abs(signed_stride));
        if (signed_stride < 0) runs.begin -= stride * (count - 1);
        std::size_t axis = runs.axes++;
        for (; axis > 0 && runs.strides[axis - 1] > stride; --axis) {
            runs.strides[axis] = runs.strides[axis - 1];
            runs.counts[axis] = runs.counts[axis - 1];
        }
        runs.strides[axis] = stride;
        runs.counts[axis] = count;
    };
    add(array.component_stride, array.components);
    for (std::size_t axis = 0; axis < 3; ++axis) add(array.strides[axis], static_cast<std::uint64_t>(array.size[axis]));
    std::size_t joined = 0;
    while (joined < runs.axes && runs.strides[joined] == runs.bytes) runs.bytes *= runs.counts[joined++];
    for (std::size_t axis = joined; axis < runs.axes; ++axis) {
        runs.strides[axis - joined] = runs.strides[axis];
        runs.counts[axis - joined] = runs.counts[axis];
    }
    runs.axes -= joined;
    std::fill(runs.strides.begin() + static_cast<std::ptrdiff_t>(runs.axes), runs.strides.end(), 0);
    return runs;
}

/// An axis-parallel box of bytes, runs, rows and so on: [lower, upper) on each axis.
struct ByteBox {
    const WrittenArray* array = nullptr;
    std::array<std::uint64_t, 5> lower{};
    std::array<std::uint64_t, 5> upper{};
};

/// The runs as boxes in the coordinates of an array with these strides, each a multiple of the one before. A run, row
/// or slice that continues in the next one is cut in two.
void add_boxes(const ByteRuns& runs, std::uint64_t origin, std::vector<ByteBox>& boxes) {
    const std::size_t first = boxes.size();
    ByteBox& box = boxes.emplace_back(ByteBox{runs.array, {}, {}});
    std::uint64_t rest = runs.begin - origin;
    for (std::size_t axis = runs.axes; axis > 0; --axis) {
        box.lower[axis] = rest / runs.strides[axis - 1];
        box.upper[axis] = box.lower[axis] + runs.counts[axis - 1];
        rest %= runs.strides[axis - 1];
    }
    box.lower[0] = rest;
    box.upper[0] = rest + runs.bytes;
    for (std::size_t axis = 0; axis < runs.axes; ++axis) {
        const std::uint64_t length = axis == 0 ? runs.strides[0] : runs.strides[axis] / runs.strides[axis - 1];
        for (std::size_t n = first; n < boxes.size(); ++n) {
            if (boxes[n].upper[axis] <= length) continue;
            ByteBox next = boxes[n];
            next.lower[axis] = 0;
            next.upper[axis] -= length;
            ++next.lower[axis + 1];
            ++next.upper[axis + 1];
            boxes[n].upper[axis] = length;
            boxes.push_back(next);
        }
    }
}

/// Two of the boxes of `axes` + 1 axes, of different arrays, that overlap. Planes across `axis`, then across the next
/// ones, divide the boxes. Those that none divides, `undivided` being the axes tried, are compared in the order along
/// the last one.
std::optional<Overlap> find_overlap(std::span<ByteBox> boxes, std::size_t axes, std::size_t axis,
                                    std::size_t undivided = 0) {
    if (boxes.size() < 2) return std::nullopt;
    const auto is_before = [&](const ByteBox& a, const ByteBox& b) { return a.lower[axis] < b.lower[axis]; };
    if (!std::ranges::is_sorted(boxes, is_before)) std::ranges::sort(boxes, is_before);  // most callers' boxes are
    if (undivided > axes) {
        std::vector<const ByteBox*> active;
        for (const ByteBox& box : boxes) {
            std::erase_if(active, [&](const ByteBox* other) { return other->upper[axis] <= box.lower[axis]; });
            for (const ByteBox* other : active) {
                bool are_apart = other->array == box.array;
                for (std::size_t across = 0; across <= axes; ++across)
                    are_apart |= other->upper[across] <= box.lower[across] || box.upper[across] <= other->lower[across];
                if (!are_apart) return Overlap{other->array, box.array};
            }
            active.push_back(&box);
        }
        return std::nullopt;
    }
    std::size_t begin = 0;
    std::uint64_t reached = boxes.front().upper[axis];
    for (std::size_t n = 1; n <= boxes.size(); ++n) {
        if (n < boxes.size() && boxes[n].lower[axis] < reached) {
            reached = std::max(reached, boxes[n].upper[axis]);
            continue;
        }
        const std::span<ByteBox> part = boxes.subspan(begin, n - begin);
        if (const auto found =
                find_overlap(part, axes, axis > 0 ? axis - 1 : axes, part.size() < boxes.size() ? 1 : undivided + 1))
            return found;
        if (n == boxes.size()) break;
        begin = n;
        reached = boxes[n].upper[axis];
    }
    return std::nullopt;
}

/// Whether two sets of runs have a byte in common, by trying the steps of one axis after the other, those of the
/// longest stride first. `budget`: of steps; false when it is used up.
class Search {
public:
    Search(const ByteRuns& a, const ByteRuns& b, std::size_t& budget) : a_(a), b_(b), budget_(budget) {
        for (std::size_t axis = 0; axis < a.axes; ++axis) add(a.strides[axis], a.counts[axis], 1);
        for (std::size_t axis = 0; axis < b.axes; ++axis) add(b.strides[axis], b.counts[axis], -1);
        std::sort(axes_.begin(), axes_.end(), [](const Axis& x, const Axis& y) { return x.stride > y.stride; });
        for (const Axis& axis : axes_) {
            lowest_.push_back(axis.stride * axis.least);
            highest_.push_back(axis.stride * axis.most);
        }
        for (std::size_t i = axes_.size(); i-- > 1;) {
            lowest_[i - 1] += lowest_[i];
            highest_[i - 1] += highest_[i];
        }
    }

    /// Runs of a and b overlap if a's begins less than b's length before it, or b's less than a's.
    bool finds() { return find(0, static_cast<double>(a_.begin) - static_cast<double>(b_.begin)); }

private:
    struct Axis {
        double stride, least, most;  ///< steps of a minus steps of b
    };

    void add(std::uint64_t stride, std::uint64_t count, int sign) {
        const auto steps = static_cast<double>(count - 1);
        for (Axis& axis : axes_)
            if (axis.stride == static_cast<double>(stride)) {
                (sign > 0 ? axis.most : axis.least) += sign * steps;
                return;
            }
        axes_.push_back({static_cast<double>(stride), sign > 0 ? 0 : -steps, sign > 0 ? steps : 0});
    }

    bool find(std::size_t i, double difference) {
        const auto below = -static_cast<double>(a_.bytes), above = static_cast<double>(b_.bytes);
        if (i == axes_.size()) return below < difference && difference < above;
        const double lowest = i + 1 < axes_.size() ? lowest_[i + 1] : 0;
        const double highest = i + 1 < axes_.size() ? highest_[i + 1] : 0;
        const Axis& axis = axes_[i];
        const double first = std::max(axis.least, std::ceil((below - highest - difference) / axis.stride));
        const double last = std::min(axis.most, std::floor((above - lowest - difference) / axis.stride));
        for (double step = first; step <= last; ++step) {
            if (budget_ == 0) return false;
            --budget_;
            if (find(i + 1, difference + step * axis.stride)) return true;
        }
        return false;
    }

    const ByteRuns& a_;
    const ByteRuns& b_;
    std::size_t& budget_;
    std::vector<Axis> axes_;
    std::vector<double> lowest_, highest_;  ///< that axes from this one on can add
};

/// Whether each begins behind the end of another one, as most callers' arrays do.
bool lie_apart(const std::vector<ByteRuns>& all) {
    std::vector<std::tuple<const void*, std::uint64_t, std::uint64_t>> ranges;
    for (const ByteRuns& runs : all) ranges.emplace_back(runs.array->memory, runs.begin, runs.end());
    std::ranges::sort(ranges);
    return std::ranges::adjacent_find(ranges, [](const auto& before, const auto& range) {
               return std::get<0>(before) == std::get<0>(range) && std::get<2>(before) > std::get<1>(range);
           }) == ranges.end();
}

/// Each stride is a multiple of the one before.
bool are_nested(const ByteRuns& runs) {
    for (std::size_t axis = 1; axis < runs.axes; ++axis)
        if (runs.strides[axis] % runs.strides[axis - 1] != 0) return false;
    return true;
}

}  // namespace

std::optional<Overlap> find_overlap(const std::vector<WrittenArray>& arrays) {
    if (arrays.size() < 2) return std::nullopt;
    std::vector<ByteRuns> all_runs;
    for (const WrittenArray& array : arrays)
        if (array.width > 0 && std::ranges::all_of(array.size, [](std::int64_t n) { return n > 0; }))
            all_runs.push_back(runs_of(array));
    if (lie_apart(all_runs)) return std::nullopt;
    // Runs of one buffer with the same strides are a group: boxes of one large array.
    std::map<std::tuple<const void*, std::size_t, std::array<std::uint64_t, 4>>, std::vector<ByteRuns>> groups;
    std::vector<std::pair<ByteRuns, std::size_t>> all;  // with the number of the group
    for (const ByteRuns& runs : all_runs) groups[{runs.array->memory, runs.axes, runs.strides}].push_back(runs);
    std::map<const void*, std::size_t> groups_of_memory;
    for (const auto& [key, group] : groups) ++groups_of_memory[std::get<0>(key)];
    std::size_t number = 0;
    for (const auto& [key, group] : groups) {
        const bool is_exact = are_nested(group.front());
        if (is_exact) {
            const auto first = std::ranges::min_element(group, {}, &ByteRuns::begin);
            std::vector<ByteBox> boxes;
            for (const ByteRuns& runs : group) add_boxes(runs, first->begin, boxes);
            if (const auto found = find_overlap(boxes, group.front().axes, group.front().axes)) return found;
        }
        if (is_exact && groups_of_memory.at(std::get<0>(key)) == 1) continue;
        for (const ByteRuns& runs : group) {
            all.emplace_back(runs, number);
            if (!is_exact) ++number;  // compared with each other below
        }
        ++number;
    }
    // Different groups of one buffer.
    std::size_t budget = 1000000;
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
        return std::tuple(a.first.array->memory, a.first.begin) < std::tuple(b.first.array->memory, b.first.begin);
    });
    std::vector<const std::pair<ByteRuns, std::size_t>*> active;
    for (const auto& entry : all) {
        std::erase_if(active, [&](const auto* other) {
            return other->first.array->memory != entry.first.array->memory || other->first.end() <= entry.first.begin;
        });
        for (const auto* other : active) {
            const Overlap pair{entry.first.array, other->first.array};
            if (other->second != entry.second && Search(entry.first, other->first, budget).finds()) return pair;
            if (budget == 0) return Overlap{pair.one, pair.other, false};
            --budget;
        }
        active.push_back(&entry);
    }
    return std::nullopt;
}

void throw_overlap(const Overlap& overlap) {
    const WrittenArray *first = overlap.one, *second = overlap.other;
    const auto order = [](const WrittenArray& array) {
        return std::tuple(array.name != nullptr, array.request, array.output, &array);
    };
    if (order(*second) < order(*first)) std::swap(first, second);
    const bool are_outputs = second->name == nullptr;
    const auto text_of = [&](const WrittenArray& array) {
        if (array.name != nullptr) return std::string(array.name);
        const char* const output = info_of(array.output).name;
        if (!are_outputs) return fmt::format("the array of the output {}", output);
        return first->request == second->request ? std::string(output)
                                                 : fmt::format("{} of request {}", output, array.request);
    };
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{}{} and {} {} on the same bytes; give each memory of its own",
                            are_outputs ? "the arrays of the outputs " : "", text_of(*first), text_of(*second),
                            overlap.is_certain ? "lie" : "may lie"));
}

void refuse_overlap(const std::vector<WrittenArray>& arrays) {
    if (const auto found = find_overlap(arrays); found && found->is_certain) throw_overlap(*found);
}

}  // namespace clsdf::targets
