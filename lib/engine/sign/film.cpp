#include "sign/film.hpp"

#include "core/parallel.hpp"
#include "sign/turns_of_lanes.hpp"
#include "solid_angle.h"
#include "surface/film_bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <utility>

namespace clsdf::engine {

namespace {

// Blocks of samples: the largest ones lie in columns, and the smallest ones are searched sample by sample.
constexpr int largest_block = 32;
constexpr int smallest_block = lanes;
// Above the rounding of the winding number, and of its bounds, in a block that no open edge meets.
constexpr double slack = 1e-6;
// Around a block with more open edges than that, loops far away are taken as a linear function,
constexpr std::size_t fewest_approximated = 48;
// which may be off by that in a block, and as much more in the blocks around it. Small blocks may be off by more: where
// that leaves a doubt, the functions of the blocks around them are tried.
double tolerance_of(int block) {
    return 0.3 / block;
}

/// A sample, or a place halfway between two: twice the indices in the lattice, x from LatticeBoundary::first_x.
struct HalfSample {
    std::int64_t x, y, z;
};

/// A cube of samples.
struct Block {
    std::int64_t x, y, z;  ///< the first one
    int size;

    HalfSample centre() const { return {2 * x + size - 1, 2 * y + size - 1, 2 * z + size - 1}; }
};

/// The samples that open edges hide from the ray: those of a box across the rows, from an x on.
struct Shadow {
    std::int64_t low_y = std::numeric_limits<std::int64_t>::max(), high_y = std::numeric_limits<std::int64_t>::min();
    std::int64_t low_z = low_y, high_z = high_y;
    double low_x = std::numeric_limits<double>::infinity();

    void add(const SweepVertex& vertex) {
        low_y = std::min(low_y, vertex.y);
        high_y = std::max(high_y, vertex.y);
        low_z = std::min(low_z, vertex.z);
        high_z = std::max(high_z, vertex.z);
        low_x = std::min(low_x, vertex.x);
    }
};

/// A loop as a whole.
struct Loop {
    Shadow shadow;
    SweepVertex middle;  ///< of a ball around the loop
    double radius;
    double area;  ///< see film_area()
};

/// The open edges around a block: near loops, and the turns of all others as a linear function.
struct Surroundings {
    const Surroundings* outer = nullptr;  ///< of the block around it, with more near loops; null if all are near
    std::vector<std::uint32_t> loops;
    std::size_t edges = 0;  ///< of these loops
    HalfSample centre{};    ///< at which the linear function has the value `turns`
    double turns = 0;
    Vec3 gradient{};
    double remainder = 0;  ///< it may be off by that in the block
};

/// The open edges, seen from any place of the lattice.
class Film {
public:
    explicit Film(const LatticeBoundary& boundary)
        : boundary_(boundary),
          per_y_(std::ldexp(1.0, -boundary.bits_y)),
          per_z_(std::ldexp(1.0, -boundary.bits_z)),
          loops_(boundary.begins.size() - 1) {
        for_each_index(loops_.size(), [&](std::size_t loop) { loops_[loop] = described(loop); });
        all_.loops.resize(loops_.size());
        for (std::size_t loop = 0; loop < loops_.size(); ++loop) all_.loops[loop] = static_cast<std::uint32_t>(loop);
        all_.edges = boundary.corners.size();
    }

    const Surroundings& all() const { return all_; }

    /// Half the diagonal of a block with half a sample around it: such blocks tile the lattice.
    double radius(const Block& block) const { return 0.5 * block.size * length(boundary_.spacing); }

    /// Whether turns may jump between rows of the block.
    bool is_in_shadow(const Block& block, const Surroundings& around) const {
        return std::ranges::any_of(around.loops, [&](std::uint32_t loop) {
            if (!is_in_shadow(block, loops_[loop].shadow)) return false;
            const std::size_t begin = boundary_.begins[loop], end = boundary_.begins[loop + 1];
            for (std::size_t i = begin; i < end; ++i) {
                Shadow shadow;
                shadow.add(boundary_.corners[i].snapped);
                shadow.add(boundary_.corners[i + 1 < end ? i + 1 : begin].snapped);
                if (is_in_shadow(block, shadow)) return true;
            }
            return false;
        });
    }

    /// What lies around a block within the block that `outer` lies around. Whether the film may meet it is returned,
    /// too.
    std::pair<Surroundings, bool> around(const Block& block, const Surroundings& outer) const {
        Surroundings inner;
        inner.outer = &outer;
        inner.centre = block.centre();
        inner.turns = far_turns(outer, inner.centre);
        inner.gradient = outer.gradient;
        inner.remainder = outer.remainder;
        const double ball = radius(block);
        WindingChange change{length(outer.gradient) * ball + outer.remainder, outer.gradient, outer.remainder};
        double turns = inner.turns;
        std::vector<Far> far;
        for (const std::uint32_t loop : outer.loops) {
            const Far seen = look_at(loop, inner.centre, ball);
            turns += seen.turns;
            change.add(seen.change);
            if (outer.edges > fewest_approximated && seen.change.beside < tolerance_of(block.size) &&
                !is_in_shadow(block, loops_[loop].shadow))
                far.push_back(seen);
            else
                keep(loop, inner);
        }
        std::ranges::sort(far, {}, [](const Far& one) { return std::pair(one.change.beside, one.loop); });
        double remainder = 0;
        for (const Far& one : far) {
            remainder += one.change.beside;
            if (remainder > tolerance_of(block.size)) {
                keep(one.loop, inner);
                continue;
            }
            inner.turns += one.turns;
            for (std::size_t axis = 0; axis < 3; ++axis) inner.gradient[axis] += one.change.gradient[axis];
            inner.remainder += one.change.beside;
        }
        return {std::move(inner), !(change.bound(ball) < distance_to_half(turns) - slack)};
    }

    /// The turns at a sample, rounded.
    int rounded_at(std::int64_t x, std::int64_t y, std::int64_t z, const Surroundings& around) const {
        const HalfSample sample{2 * x, 2 * y, 2 * z};
        for (const Surroundings* seen = &around;; seen = seen->outer)
            if (const auto rounded = rounded_of(turns_at(sample, *seen), sample, *seen)) return *rounded;
    }

    /// The same of samples next to each other.
    std::array<int, lanes> rounded_from(std::int64_t x, std::int64_t y, std::int64_t z,
                                        const Surroundings& around) const {
        const RowPlace place{static_cast<double>(x),
                             y * (std::int64_t{1} << boundary_.bits_y),
                             z * (std::int64_t{1} << boundary_.bits_z),
                             per_y_,
                             per_z_,
                             boundary_.spacing};
        TurnsOfLanes turns;
        for (const std::uint32_t loop : around.loops) {
            const std::size_t begin = boundary_.begins[loop];
            add_loop(boundary_.corners.data() + begin, boundary_.begins[loop + 1] - begin, place, turns);
        }
        std::array<int, lanes> result{};
        for (std::size_t lane = 0; lane < result.size(); ++lane) {
            const std::int64_t at = x + static_cast<std::int64_t>(lane);
            const auto rounded = rounded_of(turns[lane], {2 * at, 2 * y, 2 * z}, around);
            result[lane] = rounded ? *rounded : rounded_at(at, y, z, *around.outer);
        }
        return result;
    }

private:
    struct Far {
        std::uint32_t loop;
        double turns;
        WindingChange change;
    };

    /// Of the near loops' turns and the others; nothing if the linear function leaves a doubt.
    std::optional<int> rounded_of(const Turns& near, const HalfSample& sample, const Surroundings& around) const {
        if (around.remainder == 0) return rounded_turns(near);
        const double raised = turns_of(near) + far_turns(around, sample) + 0.5, whole = std::floor(raised);
        const double unsure = around.remainder + slack;
        if (raised - whole > unsure && raised - whole < 1 - unsure) return static_cast<int>(whole);
        return std::nullopt;
    }

    /// A corner from a place, and the offset of the snapped vertex across the row; in the unit of the spacing.
    struct Offset {
        Vec3 given;
        double snapped_y, snapped_z;
    };
    Offset offset_of(const LatticeCorner& corner, const HalfSample& from) const {
        const SweepVertex& at = corner.snapped;
        const double y = static_cast<double>(at.y - from.y * (std::int64_t{1} << (boundary_.bits_y - 1))) * per_y_,
                     z = static_cast<double>(at.z - from.z * (std::int64_t{1} << (boundary_.bits_z - 1))) * per_z_;
        const auto& [sx, sy, sz] = boundary_.spacing;
        return {{(at.x - 0.5 * static_cast<double>(from.x)) * sx, (y + corner.rest_y) * sy, (z + corner.rest_z) * sz},
                y * sy,
                z * sz};
    }
    SeenVertex seen(const LatticeCorner& corner, const HalfSample& from) const {
        const Offset offset = offset_of(corner, from);
        return seen_vertex(offset.given[0], offset.given[1], offset.given[2], offset.snapped_y, offset.snapped_z);
    }

    void add_turns(std::uint32_t loop, const HalfSample& from, Turns& turns) const {
        const std::size_t begin = boundary_.begins[loop], end = boundary_.begins[loop + 1];
        const SeenVertex first = seen(boundary_.corners[begin], from);
        SeenVertex a = first;
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t next = i + 1 < end ? i + 1 : begin;
            const SeenVertex b = next == begin ? first : seen(boundary_.corners[next], from);
            const double re = edge_re(a, b), im = edge_im(a, b);
            const int side = re < 0 ? side_of(boundary_.corners[i].snapped, boundary_.corners[next].snapped,
                                              from.y * (std::int64_t{1} << (boundary_.bits_y - 1)),
                                              from.z * (std::int64_t{1} << (boundary_.bits_z - 1)))
                                    : 0;
            turns = turned(turns, re, im, side);
            a = b;
        }
    }
    Turns turns_at(const HalfSample& from, const Surroundings& around) const {
        Turns turns = no_turns();
        for (const std::uint32_t loop : around.loops) add_turns(loop, from, turns);
        return turns;
    }

    double far_turns(const Surroundings& around, const HalfSample& at) const {
        if (around.remainder == 0) return 0;
        const HalfSample& centre = around.centre;
        const Vec3 offset{0.5 * static_cast<double>(at.x - centre.x) * boundary_.spacing[0],
                          0.5 * static_cast<double>(at.y - centre.y) * boundary_.spacing[1],
                          0.5 * static_cast<double>(at.z - centre.z) * boundary_.spacing[2]};
        return around.turns + dot(around.gradient, offset);
    }

    void keep(std::uint32_t loop, Surroundings& around) const {
        around.loops.push_back(loop);
        around.edges += boundary_.begins[loop + 1] - boundary_.begins[loop];
    }

    bool is_in_shadow(const Block& block, const Shadow& shadow) const {
        const auto place = [](std::int64_t sample, int bits) { return sample * (std::int64_t{1} << bits); };
        return shadow.low_y <= place(block.y + block.size - 1, boundary_.bits_y) &&
               shadow.high_y >= place(block.y, boundary_.bits_y) &&
               shadow.low_z <= place(block.z + block.size - 1, boundary_.bits_z) &&
               shadow.high_z >= place(block.z, boundary_.bits_z) &&
               shadow.low_x <= static_cast<double>(block.x + block.size);
    }

    Loop described(std::size_t loop) const {
        const std::size_t begin = boundary_.begins[loop], end = boundary_.begins[loop + 1];
        Loop result{};
        double high_x = -std::numeric_limits<double>::infinity();
        for (std::size_t i = begin; i < end; ++i) {
            result.shadow.add(boundary_.corners[i].snapped);
            high_x = std::max(high_x, boundary_.corners[i].snapped.x);
        }
        const Shadow& box = result.shadow;
        result.middle = {box.low_y + (box.high_y - box.low_y) / 2, box.low_z + (box.high_z - box.low_z) / 2,
                         box.low_x + (high_x - box.low_x) / 2};
        const LatticeCorner middle{result.middle, 0, 0};
        double perimeter = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 from = between(middle, boundary_.corners[i]);
            result.radius = std::max(result.radius, length(from));
            perimeter += length(between(boundary_.corners[i], boundary_.corners[i + 1 < end ? i + 1 : begin]));
        }
        result.radius *= 1 + 1e-9;
        result.area = film_area(perimeter);
        return result;
    }
    Vec3 between(const LatticeCorner& a, const LatticeCorner& b) const {
        const auto& [sx, sy, sz] = boundary_.spacing;
        return {(b.snapped.x - a.snapped.x) * sx,
                (static_cast<double>(b.snapped.y - a.snapped.y) * per_y_ + (b.rest_y - a.rest_y)) * sy,
                (static_cast<double>(b.snapped.z - a.snapped.z) * per_z_ + (b.rest_z - a.rest_z)) * sz};
    }

    /// A loop's turns at a place, and their change within a ball around it.
    Far look_at(std::uint32_t loop, const HalfSample& from, double ball) const {
        const Loop& whole = loops_[loop];
        LoopChange change(length(offset_of({whole.middle, 0, 0}, from).given), whole.radius, whole.area, ball);
        const std::size_t begin = boundary_.begins[loop], end = boundary_.begins[loop + 1];
        const Vec3 first = offset_of(boundary_.corners[begin], from).given;
        Vec3 a = first;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 b = i + 1 < end ? offset_of(boundary_.corners[i + 1], from).given : first;
            change.add_edge(a, b);
            a = b;
        }
        Turns turns = no_turns();
        add_turns(loop, from, turns);
        return {loop, turns_of(turns), change.change()};
    }

    const LatticeBoundary& boundary_;
    double per_y_, per_z_;
    std::vector<Loop> loops_;
    Surroundings all_;
};

/// Walks along the rows of a column of blocks, and notes the changes of the rounded turns.
class Column {
public:
    /// (y, z): the first row, counted from the part's.
    Column(const Film& film, const Layout& layout, std::int64_t y, std::int64_t z, FilmCrossings& crossings,
           std::vector<SweepRecord>& records)
        : film_(film), crossings_(crossings), records_(records) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            first_[axis] = std::int64_t{layout.brick_first[axis]} * CLSDF_BRICK;
            size_[axis] = std::int64_t{layout.bricks[axis]} * CLSDF_BRICK;
        }
        row_ = {first_[1] + y, first_[2] + z};
        rows_.fill({0, false});
    }

    /// first_x: LatticeBoundary's.
    void walk(std::int64_t first_x) {
        first_[0] -= first_x;
        for (std::int64_t x = 0; x < size_[0]; x += largest_block)
            search({first_[0] + x, row_[0], row_[1], largest_block}, film_.all());
    }

private:
    struct Row {
        int rounded;
        bool is_known;  ///< the turns round to this from the last sample on, up to the film
    };

    bool is_within(const Block& block) const {
        return block.x < first_[0] + size_[0] && block.y < first_[1] + size_[1] && block.z < first_[2] + size_[2];
    }

    /// Rows run through blocks in the order of x.
    void search(const Block& block, const Surroundings& outer) {
        if (!is_within(block)) return;
        const auto [around, may_meet_film] = film_.around(block, outer);
        if (!may_meet_film) {
            pass(block, around);
        } else if (block.size == smallest_block) {
            for_each_row(block, [&](Row& row, std::int64_t y, std::int64_t z) {
                const std::array<int, lanes> rounded = film_.rounded_from(block.x, y, z, around);
                for (std::size_t i = 0; i < lanes; ++i)
                    set(row, rounded[i], block.x + static_cast<std::int64_t>(i), y, z);
                row.is_known = false;
            });
        } else {
            const int half = block.size / 2;
            for (const int x : {0, half})
                for (const int z : {0, half})
                    for (const int y : {0, half}) search({block.x + x, block.y + y, block.z + z, half}, around);
        }
    }

    /// A block that the film does not meet: along a row nothing changes, and between rows only in shadows.
    void pass(const Block& block, const Surroundings& around) {
        std::optional<bool> is_one;  // all rows have one value
        std::optional<int> value;
        for_each_row(block, [&](Row& row, std::int64_t y, std::int64_t z) {
            if (row.is_known) return;
            if (!is_one) is_one = !film_.is_in_shadow(block, around);
            if (!*is_one || !value) value = film_.rounded_at(block.x, y, z, around);
            set(row, *value, block.x, y, z);
            row.is_known = true;
        });
    }

    template <typename Function>
    void for_each_row(const Block& block, const Function& f) {
        const std::int64_t end_y = std::min(block.y + block.size, first_[1] + size_[1]),
                           end_z = std::min(block.z + block.size, first_[2] + size_[2]);
        for (std::int64_t z = block.z; z < end_z; ++z)
            for (std::int64_t y = block.y; y < end_y; ++y)
                f(rows_[static_cast<std::size_t>((z - row_[1]) * largest_block + (y - row_[0]))], y, z);
    }

    void set(Row& row, int rounded, std::int64_t x, std::int64_t y, std::int64_t z) {
        if (rounded == row.rounded) return;
        const auto number = static_cast<std::uint32_t>((z - first_[2]) * size_[1] + (y - first_[1]));
        const auto sample = static_cast<std::uint32_t>(x - first_[0]);
        std::uint32_t& count = crossings_.row_counts[number];
        for (int i = std::abs(rounded - row.rounded); i > 0; --i)
            records_.push_back({number, 2 * sample + (rounded > row.rounded ? 1U : 0U), count++});
        row.rounded = rounded;
    }

    const Film& film_;
    FilmCrossings& crossings_;
    std::vector<SweepRecord>& records_;
    std::array<std::int64_t, 3> first_{}, size_{};  // samples of the part's bricks
    std::array<std::int64_t, 2> row_{};
    std::array<Row, largest_block * largest_block> rows_{};
};

}  // namespace

FilmCrossings film_crossings(const LatticeBoundary& boundary, const Layout& layout,
                             const std::function<void()>& between) {
    FilmCrossings crossings;
    if (boundary.corners.empty()) return crossings;
    const Film film(boundary);
    const auto rows_y = static_cast<std::size_t>(layout.bricks[1]) * CLSDF_BRICK,
               rows_z = static_cast<std::size_t>(layout.bricks[2]) * CLSDF_BRICK;
    crossings.row_counts.resize(rows_y * rows_z);
    const std::size_t columns_y = chunk_count(rows_y, largest_block), columns_z = chunk_count(rows_z, largest_block);
    constexpr std::size_t at_once = 64;
    for (std::size_t begin = 0; begin < columns_y * columns_z; begin += at_once) {
        if (between) between();
        std::vector<std::vector<SweepRecord>> records(std::min(at_once, columns_y * columns_z - begin));
        for_each_index(
            records.size(),
            [&](std::size_t i) {
                const std::size_t column = begin + i;
                Column(film, layout, static_cast<std::int64_t>(column % columns_y) * largest_block,
                       static_cast<std::int64_t>(column / columns_y) * largest_block, crossings, records[i])
                    .walk(boundary.first_x);
            },
            1);
        for (const auto& some : records) crossings.records.insert(crossings.records.end(), some.begin(), some.end());
    }
    if (crossings.records.empty()) crossings.row_counts.clear();
    return crossings;
}

}  // namespace clsdf::engine
