#include "sign/film.hpp"

#include "core/parallel.hpp"
#include "sign/turns_of_lanes.hpp"
#include "solid_angle.h"
#include "surface/film_bounds.hpp"
#include "surface/film_nodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace clsdf::engine {

namespace {

// Blocks of samples: the largest ones lie in columns, and the smallest ones are searched sample by sample.
constexpr int largest_block = 32;
constexpr int smallest_block = lanes;
// Fewer open edges are summed one by one. Of more, pieces far from a block are taken as a linear function,
constexpr std::size_t most_summed = 48;
// which may be off by that, all pieces together.
constexpr double linear_tolerance = 1.0 / 6;

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

    void add(const Shadow& other) {
        low_y = std::min(low_y, other.low_y);
        high_y = std::max(high_y, other.high_y);
        low_z = std::min(low_z, other.low_z);
        high_z = std::max(high_z, other.high_z);
        low_x = std::min(low_x, other.low_x);
    }
    void add(const SweepVertex& vertex) {
        low_y = std::min(low_y, vertex.y);
        high_y = std::max(high_y, vertex.y);
        low_z = std::min(low_z, vertex.z);
        high_z = std::max(high_z, vertex.z);
        low_x = std::min(low_x, vertex.x);
    }
};

/// The open edges around a block: pieces of the film near it, and the turns of all others as a linear function.
struct Surroundings {
    std::vector<std::uint32_t> nodes;   ///< those near it, with all below them
    std::vector<std::uint32_t> leaves;  ///< of these nodes; empty if the film may meet the block
    HalfSample centre{};                ///< at which the linear function has the value `turns`
    double turns = 0;
    Vec3 gradient{};
    double remainder = 0;  ///< it may be off by that in the block
};

/// The nodes near a block, divided for the samples of it: leaves that are summed exactly, and expansions.
struct NearPieces {
    std::vector<std::uint32_t> leaves;
    std::vector<FarPiece> far;
    double error = 0;  ///< the expansions may be off by that at any sample
};

/// The open edges, seen from any place of the lattice.
class Film {
public:
    explicit Film(const LatticeBoundary& boundary)
        : boundary_(boundary),
          per_y_(std::ldexp(1.0, -boundary.bits_y)),
          per_z_(std::ldexp(1.0, -boundary.bits_z)),
          origin_(middle_of(boundary)) {
        const std::vector<LatticeCorner>& all = boundary.corners;
        std::vector<Vec3> positions;
        positions.reserve(all.size());
        for (const LatticeCorner& corner : all) positions.push_back(offset_of(corner, origin_).given);
        nodes_ = FilmNodes(positions, boundary.begins);
        std::vector<std::uint32_t> next(all.size());
        for (std::size_t loop = 0; loop + 1 < boundary.begins.size(); ++loop)
            for (std::size_t i = boundary.begins[loop]; i < boundary.begins[loop + 1]; ++i)
                next[i] = static_cast<std::uint32_t>(i + 1 < boundary.begins[loop + 1] ? i + 1 : boundary.begins[loop]);
        const std::span<const FilmNodes::Node> nodes = nodes_.all();
        shadows_.resize(nodes.size());
        for (std::size_t number = nodes.size(); number-- > 0;) {
            const FilmNodes::Node& node = nodes[number];
            Shadow& shadow = shadows_[number];
            if (!node.is_leaf()) {
                shadow = shadows_[number + 1];
                shadow.add(shadows_[node.second]);
                continue;
            }
            const std::span<const std::uint32_t> corners = nodes_.corners_of(node);
            if (corners_.size() < node.corner + corners.size()) {
                corners_.resize(node.corner + corners.size());
                is_open_.resize(corners_.size());
            }
            for (std::size_t i = 0; i < corners.size(); ++i) {
                corners_[node.corner + i] = all[corners[i]];
                is_open_[node.corner + i] = next[corners[i]] == corners[i + 1 < corners.size() ? i + 1 : 0];
                shadow.add(all[corners[i]].snapped);
            }
        }
        if (!nodes.empty()) all_.nodes = {0};
    }

    const Surroundings& all() const { return all_; }

    /// Half the diagonal of a block with half a sample around it: such blocks tile the lattice.
    double radius(const Block& block) const { return 0.5 * block.size * length(boundary_.spacing); }

    /// Whether turns may jump between rows of the block.
    bool is_in_shadow(const Block& block, const Surroundings& around) const {
        return std::ranges::any_of(around.leaves, [&](std::uint32_t number) {
            if (!is_in_shadow(block, shadows_[number])) return false;
            const std::span<const LatticeCorner> corners = corners_of(number);
            for (std::size_t i = 0; i < corners.size(); ++i) {
                // All that has a chord in whose shadow the block lies is near, so chords cancel.
                if (!is_open_[nodes_.all()[number].corner + i]) continue;
                Shadow shadow;
                shadow.add(corners[i].snapped);
                shadow.add(corners[i + 1 < corners.size() ? i + 1 : 0].snapped);
                if (is_in_shadow(block, shadow)) return true;
            }
            return false;
        });
    }

    /// What lies around a block within the block that `outer` lies around. Whether the film may meet it is returned,
    /// too.
    std::pair<Surroundings, bool> around(const Block& block, const Surroundings& outer) const {
        Surroundings inner;
        inner.centre = block.centre();
        inner.turns = linear_turns(outer, inner.centre);
        inner.gradient = outer.gradient;
        inner.remainder = outer.remainder;
        const double ball = radius(block);
        WindingChange change{length(outer.gradient) * ball + outer.remainder, outer.gradient, outer.remainder};
        for (const std::uint32_t number : outer.nodes)
            if (is_near(number, block, ball, inner, change)) inner.nodes.push_back(number);
        if (!inner.nodes.empty())
            std::ranges::iter_swap(inner.nodes.begin(),
                                   std::ranges::min_element(inner.nodes, {}, [&](std::uint32_t number) {
                                       return distance(number, place_of(inner.centre));
                                   }));
        bool may_meet = std::ranges::any_of(
            inner.nodes, [&](std::uint32_t number) { return may_meet_film(number, ball, inner, change); });
        const double bound = change.bound(ball);
        may_meet = may_meet || !(bound < 0.5);
        if (!may_meet) {
            const double turns = inner.turns + turns_of(turns_at(inner.centre, inner.leaves));
            may_meet = !(bound < distance_to_half(turns) - film_slack);
        }
        if (may_meet) inner.leaves.clear();
        return {std::move(inner), may_meet};
    }

    /// The nodes near a block, for rounded_plane().
    NearPieces pieces(const Block& block, const Surroundings& around) const {
        NearPieces pieces;
        const bool are_many = corners_.size() > most_summed;
        const Vec3 centre = place_of(block.centre());
        const auto visit = [&](const FilmNodes::Node& node) {
            Vec3 away{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                away[axis] = std::max(
                    std::abs(node.centre[axis] - centre[axis]) - 0.5 * (block.size - 1) * boundary_.spacing[axis], 0.0);
            const double error = FilmNodes::error_of(node, length(away) * (1 - 1e-9));
            if (are_many && error <= nodes_.share_of(node, film_tolerances.front()) &&
                !is_in_shadow(block, shadows_[number_of(node)])) {
                pieces.far.push_back({&nodes_.expansion_of(node), node.centre});
                pieces.error += error;
                return true;
            }
            if (node.is_leaf()) pieces.leaves.push_back(number_of(node));
            return false;
        };
        for (const std::uint32_t number : around.nodes) nodes_.walk(visit, number);
        return pieces;
    }

    /// The turns at a sample, rounded.
    int rounded_at(std::int64_t x, std::int64_t y, std::int64_t z, const Surroundings& around) const {
        const HalfSample sample{2 * x, 2 * y, 2 * z};
        const auto rounded = rounded_if_certain(
            turns_of(turns_at(sample, around.leaves)) + linear_turns(around, sample), around.remainder);
        return rounded ? *rounded : rounded_alone(sample);
    }

    /// The same of a plane of a smallest block's samples: its rows one after another. around, pieces: the block's.
    std::array<std::array<int, lanes>, lanes> rounded_plane(const Block& block, std::int64_t z,
                                                            const Surroundings& around,
                                                            const NearPieces& pieces) const {
        const PlanePlace place{static_cast<double>(block.x),
                               block.y * (std::int64_t{1} << boundary_.bits_y),
                               z * (std::int64_t{1} << boundary_.bits_z),
                               std::int64_t{1} << boundary_.bits_y,
                               per_y_,
                               per_z_,
                               boundary_.spacing};
        TurnsOfRows turns;
        for (const std::uint32_t leaf : pieces.leaves) add_loop(corners_of(leaf), place, turns);
        const FarTurns far =
            turns_of_expansions(pieces.far, place_of({2 * block.x, 2 * block.y, 2 * z}), boundary_.spacing);
        std::array<std::array<int, lanes>, lanes> result{};
        for (std::size_t row = 0; row < lanes; ++row)
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const HalfSample sample{2 * (block.x + static_cast<std::int64_t>(lane)),
                                        2 * (block.y + static_cast<std::int64_t>(row)), 2 * z};
                const auto rounded =
                    rounded_if_certain(turns_of(turns[row][lane]) + (far[row][lane] + linear_turns(around, sample)),
                                       around.remainder + pieces.error);
                result[row][lane] = rounded ? *rounded : rounded_alone(sample);
            }
        return result;
    }

private:
    static HalfSample middle_of(const LatticeBoundary& boundary) {
        Shadow box;
        double high_x = -std::numeric_limits<double>::infinity();
        for (const LatticeCorner& corner : boundary.corners) {
            box.add(corner.snapped);
            high_x = std::max(high_x, corner.snapped.x);
        }
        return {2 * static_cast<std::int64_t>(std::floor(box.low_x + (high_x - box.low_x) / 2)),
                2 * ((box.low_y + (box.high_y - box.low_y) / 2) >> boundary.bits_y),
                2 * ((box.low_z + (box.high_z - box.low_z) / 2) >> boundary.bits_z)};
    }
    Vec3 place_of(const HalfSample& at) const {
        return {0.5 * static_cast<double>(at.x - origin_.x) * boundary_.spacing[0],
                0.5 * static_cast<double>(at.y - origin_.y) * boundary_.spacing[1],
                0.5 * static_cast<double>(at.z - origin_.z) * boundary_.spacing[2]};
    }

    std::uint32_t number_of(const FilmNodes::Node& node) const {
        return static_cast<std::uint32_t>(&node - nodes_.all().data());
    }
    std::span<const LatticeCorner> corners_of(std::uint32_t leaf) const {
        const FilmNodes::Node& node = nodes_.all()[leaf];
        return std::span(corners_).subspan(node.corner, node.corners);
    }

    double distance(std::uint32_t number, const Vec3& from) const {
        return length(difference(nodes_.all()[number].centre, from));
    }

    /// Adds the leaves of a node to the surroundings, and how they change. Whether that alone lets the film meet the
    /// block; then leaves are left out. The nearest come first: in a dense mesh a few suffice.
    bool may_meet_film(std::uint32_t number, double ball, Surroundings& inner, WindingChange& change) const {
        const FilmNodes::Node& node = nodes_.all()[number];
        if (node.is_leaf()) {
            inner.leaves.push_back(number);
            change.add(change_by(number, inner.centre, ball));
            // The winding number is at most 1/2 from a half integer.
            return !(std::min(change.most, change.beside) < 0.5);
        }
        const Vec3 centre = place_of(inner.centre);
        std::uint32_t first = number + 1, second = node.second;
        if (distance(second, centre) < distance(first, centre)) std::swap(first, second);
        return may_meet_film(first, ball, inner, change) || may_meet_film(second, ball, inner, change);
    }

    /// Adds what is far of a node to the linear function and its change. Whether all of it is near, so that nothing was
    /// added; else the parts that are near are in inner.nodes.
    bool is_near(std::uint32_t number, const Block& block, double ball, Surroundings& inner,
                 WindingChange& change) const {
        const FilmNodes::Node& node = nodes_.all()[number];
        const double away = distance(number, place_of(inner.centre)) - node.radius - ball;
        // Most nodes near a block are too near by the greatest of the bounds that linear() adds up.
        const bool may_be_linear = away > 0 && 1.5 * ball / away * film_change(node.area, away, ball) <=
                                                   nodes_.share_of(node, linear_tolerance);
        if (corners_.size() > most_summed && may_be_linear && !is_in_shadow(block, shadows_[number])) {
            const FilmNodes::Linear far = FilmNodes::linear(node, place_of(inner.centre), ball);
            if (far.change.beside <= nodes_.share_of(node, linear_tolerance)) {
                change.add(far.change);
                inner.turns += far.turns;
                for (std::size_t axis = 0; axis < 3; ++axis) inner.gradient[axis] += far.change.gradient[axis];
                inner.remainder += far.change.beside;
                return false;
            }
        }
        // Nodes much smaller than the block lie at about the same distance, and are as near.
        if (node.is_leaf() || node.radius < ball) return true;
        const bool is_first_near = is_near(number + 1, block, ball, inner, change),
                   is_second_near = is_near(node.second, block, ball, inner, change);
        if (is_first_near && is_second_near) return true;
        if (is_first_near) inner.nodes.push_back(number + 1);
        if (is_second_near) inner.nodes.push_back(node.second);
        return false;
    }

    /// Of turns that may be off by `error`; nothing if that leaves a doubt.
    static std::optional<int> rounded_if_certain(double turns, double error) {
        const double raised = turns + 0.5, whole = std::floor(raised), unsure = error + film_slack;
        if (raised - whole > unsure && raised - whole < 1 - unsure) return static_cast<int>(whole);
        return std::nullopt;
    }
    /// By the tree, at last by the sum over all open edges.
    int rounded_alone(const HalfSample& sample) const {
        if (corners_.size() > most_summed)
            for (const double tolerance : std::span(film_tolerances).subspan(1)) {
                Turns near = no_turns();
                const Block block{sample.x / 2, sample.y / 2, sample.z / 2, 1};
                const FilmNodes::Sum far = nodes_.sum(
                    place_of(sample), tolerance,
                    [&](const FilmNodes::Node& node) { return is_in_shadow(block, shadows_[number_of(node)]); },
                    [&](const FilmNodes::Node& leaf) { add_turns(corners_of(number_of(leaf)), sample, near); });
                if (const auto rounded = rounded_if_certain(turns_of(near) + far.turns, far.error)) return *rounded;
            }
        Turns turns = no_turns();
        for (std::size_t loop = 0; loop + 1 < boundary_.begins.size(); ++loop)
            add_turns(std::span(boundary_.corners)
                          .subspan(boundary_.begins[loop], boundary_.begins[loop + 1] - boundary_.begins[loop]),
                      sample, turns);
        return rounded_turns(turns);
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

    void add_turns(std::span<const LatticeCorner> corners, const HalfSample& from, Turns& turns) const {
        const SeenVertex first = seen(corners[0], from);
        SeenVertex a = first;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const std::size_t next = i + 1 < corners.size() ? i + 1 : 0;
            const SeenVertex b = next == 0 ? first : seen(corners[next], from);
            const double re = edge_re(a, b), im = edge_im(a, b);
            const int side = re < 0 ? side_of(corners[i].snapped, corners[next].snapped,
                                              from.y * (std::int64_t{1} << (boundary_.bits_y - 1)),
                                              from.z * (std::int64_t{1} << (boundary_.bits_z - 1)))
                                    : 0;
            turns = turned(turns, re, im, side);
            a = b;
        }
    }
    Turns turns_at(const HalfSample& from, std::span<const std::uint32_t> leaves) const {
        Turns turns = no_turns();
        for (const std::uint32_t leaf : leaves) add_turns(corners_of(leaf), from, turns);
        return turns;
    }

    double linear_turns(const Surroundings& around, const HalfSample& at) const {
        if (around.remainder == 0) return 0;
        const HalfSample& centre = around.centre;
        const Vec3 offset{0.5 * static_cast<double>(at.x - centre.x) * boundary_.spacing[0],
                          0.5 * static_cast<double>(at.y - centre.y) * boundary_.spacing[1],
                          0.5 * static_cast<double>(at.z - centre.z) * boundary_.spacing[2]};
        return around.turns + dot(around.gradient, offset);
    }

    bool is_in_shadow(const Block& block, const Shadow& shadow) const {
        const auto place = [](std::int64_t sample, int bits) { return sample * (std::int64_t{1} << bits); };
        return shadow.low_y <= place(block.y + block.size - 1, boundary_.bits_y) &&
               shadow.high_y >= place(block.y, boundary_.bits_y) &&
               shadow.low_z <= place(block.z + block.size - 1, boundary_.bits_z) &&
               shadow.high_z >= place(block.z, boundary_.bits_z) &&
               shadow.low_x <= static_cast<double>(block.x + block.size);
    }

    /// How a leaf's turns change within a ball around a place.
    WindingChange change_by(std::uint32_t leaf, const HalfSample& from, double ball) const {
        const FilmNodes::Node& node = nodes_.all()[leaf];
        const Vec3 at = place_of(from);
        LoopChange change(length({node.centre[0] - at[0], node.centre[1] - at[1], node.centre[2] - at[2]}), node.radius,
                          node.area, ball);
        const std::span<const LatticeCorner> corners = corners_of(leaf);
        const Vec3 first = offset_of(corners[0], from).given;
        Vec3 a = first;
        for (std::size_t i = 1; i <= corners.size(); ++i) {
            const Vec3 b = i < corners.size() ? offset_of(corners[i], from).given : first;
            change.add_edge(a, b);
            a = b;
        }
        return change.change();
    }

    const LatticeBoundary& boundary_;
    double per_y_, per_z_;
    HalfSample origin_;  ///< of nodes_
    FilmNodes nodes_;
    std::vector<Shadow> shadows_;         // of nodes
    std::vector<LatticeCorner> corners_;  // leaf after leaf
    std::vector<char> is_open_;           // whether an open edge follows a corner, not a chord
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
            const NearPieces pieces = film_.pieces(block, around);
            std::array<std::array<int, lanes>, lanes> plane{};
            for_each_row(block, [&](Row& row, std::int64_t y, std::int64_t z) {
                if (y == block.y) plane = film_.rounded_plane(block, z, around, pieces);
                const std::array<int, lanes>& rounded = plane[static_cast<std::size_t>(y - block.y)];
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
        for (const auto& found : records) crossings.records.insert(crossings.records.end(), found.begin(), found.end());
    }
    if (crossings.records.empty()) crossings.row_counts.clear();
    return crossings;
}

}  // namespace clsdf::engine
