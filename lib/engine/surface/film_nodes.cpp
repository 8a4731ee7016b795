#include "surface/film_nodes.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace clsdf {

namespace {

// A piece of film has no more corners than that.
constexpr std::size_t most_corners = 12;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Half the cross product.
Vec3 area_vector(const Vec3& a, const Vec3& b) {
    return {0.5 * (a[1] * b[2] - a[2] * b[1]), 0.5 * (a[2] * b[0] - a[0] * b[2]), 0.5 * (a[0] * b[1] - a[1] * b[0])};
}

/// Adds n_j y_k, made symmetric.
void add_moment(std::array<double, 6>& moment, const Vec3& n, const Vec3& y) {
    for (std::size_t axis = 0; axis < 3; ++axis) moment[axis] += n[axis] * y[axis];
    moment[3] += 0.5 * (n[0] * y[1] + n[1] * y[0]);
    moment[4] += 0.5 * (n[0] * y[2] + n[2] * y[0]);
    moment[5] += 0.5 * (n[1] * y[2] + n[2] * y[1]);
}

// Fewer corners cost no more than an expansion.
constexpr std::size_t few_corners = 4;

/// A piece of film while the tree is built: a fan of triangles around an apex.
struct Piece {
    std::uint32_t corner, corners;  ///< its range in PieceCorners::numbers
    double area = 0;
    Vec3 apex{};    ///< the mean of the corners; of a triangle the first one
    Vec3 middle{};  ///< the centre of gravity
};

/// The corners of all pieces.
struct PieceCorners {
    std::span<const Vec3> positions;
    std::vector<std::uint32_t> numbers;
    std::vector<double> weights;  ///< a third of the area of the fan's triangles at each

    std::uint32_t next(const Piece& piece, std::uint32_t i) const {
        return i + 1 < piece.corner + piece.corners ? i + 1 : piece.corner;
    }
    const Vec3& at(std::uint32_t i) const { return positions[numbers[i]]; }
    /// The area vectors and corners of the fan's triangles, the apex first.
    template <typename Function>
    void for_each_triangle(const Piece& piece, const Function& f) const {
        for (std::uint32_t i = piece.corner; i < piece.corner + piece.corners; ++i) {
            const Vec3 &a = at(i), &b = at(next(piece, i));
            f(area_vector(difference(a, piece.apex), difference(b, piece.apex)), i,
              std::array<Vec3, 3>{piece.apex, a, b});
        }
    }
};

/// Halves pieces.
class TreeOfPieces {
public:
    struct Result {
        std::vector<std::uint32_t>& corners;
        std::vector<FilmNodes::Node>& nodes;
        std::vector<FilmExpansion>& expansions;
    };

    TreeOfPieces(std::vector<Piece> pieces, PieceCorners corners, const Result& result)
        : pieces_(std::move(pieces)), corners_(std::move(corners)), result_(result) {
        corners_.weights.resize(corners_.numbers.size());
        for (Piece& piece : pieces_) describe(piece);
        result_.nodes.reserve(2 * pieces_.size() - 1);
        result_.corners.reserve(corners_.numbers.size());
        FilmMoments moments;
        build(pieces_, moments);
        result_.expansions.shrink_to_fit();
    }

private:
    void describe(Piece& piece) {
        for (std::uint32_t i = piece.corner; i < piece.corner + piece.corners; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                piece.apex[axis] += corners_.at(i)[axis] / static_cast<double>(piece.corners);
        if (piece.corners == 3) piece.apex = corners_.at(piece.corner);
        Vec3 sum{};
        corners_.for_each_triangle(piece, [&](const Vec3& normal, std::uint32_t i, const std::array<Vec3, 3>& at) {
            const double area = length(normal);
            piece.area += area;
            corners_.weights[i] += area / 3;
            corners_.weights[corners_.next(piece, i)] += area / 3;
            for (std::size_t axis = 0; axis < 3; ++axis)
                sum[axis] += area / 3 * (at[0][axis] + at[1][axis] + at[2][axis]);
        });
        piece.middle = piece.apex;
        if (piece.area > 0)
            for (std::size_t axis = 0; axis < 3; ++axis) piece.middle[axis] = sum[axis] / piece.area;
    }

    /// The ball around the centre of gravity.
    void set_ball(FilmNodes::Node& node, std::span<const Piece> pieces) const {
        Vec3 sum{};
        node.lower.fill(infinity);
        node.upper.fill(-infinity);
        for (const Piece& piece : pieces) {
            node.area += piece.area;
            for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += piece.area * piece.middle[axis];
            for (std::uint32_t i = piece.corner; i < piece.corner + piece.corners; ++i)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    node.lower[axis] = std::min(node.lower[axis], corners_.at(i)[axis]);
                    node.upper[axis] = std::max(node.upper[axis], corners_.at(i)[axis]);
                }
        }
        for (std::size_t axis = 0; axis < 3; ++axis)
            node.centre[axis] = node.area > 0 ? sum[axis] / node.area : (node.lower[axis] + node.upper[axis]) / 2;
        const auto to = [&](const Vec3& at) {
            const double square = dot(difference(at, node.centre), difference(at, node.centre));
            return std::pair(square, square * square * std::sqrt(square));
        };
        static_assert(film_degree == 5);
        double most = 0;
        for (const Piece& piece : pieces) {
            // |y|^5 is convex: its mean over a triangle is at most that of the corners.
            node.spread += piece.area / 3 * to(piece.apex).second;
            for (std::uint32_t i = piece.corner; i < piece.corner + piece.corners; ++i) {
                const auto [square, power] = to(corners_.at(i));
                most = std::max(most, square);
                node.spread += corners_.weights[i] * power;
            }
        }
        node.radius = std::sqrt(most) * (1 + 1e-9);
        node.spread *= 1 + 1e-9;
    }

    /// moments: of the node that is made, around its centre.
    std::uint32_t build(std::span<Piece> pieces, FilmMoments& moments) {
        const auto number = static_cast<std::uint32_t>(result_.nodes.size());
        FilmNodes::Node node{};
        set_ball(node, pieces);
        node.corner = static_cast<std::uint32_t>(result_.corners.size());
        result_.nodes.emplace_back();
        if (pieces.size() == 1)
            add_leaf(pieces.front(), node, moments);
        else
            add_children(pieces, node, moments);
        node.corners = static_cast<std::uint32_t>(result_.corners.size()) - node.corner;
        node.expansion = FilmNodes::no_expansion;
        if (node.corners > few_corners) {
            node.expansion = static_cast<std::uint32_t>(result_.expansions.size());
            result_.expansions.emplace_back(moments);
        }
        result_.nodes[number] = node;
        return number;
    }

    void add_leaf(const Piece& piece, FilmNodes::Node& node, FilmMoments& moments) {
        corners_.for_each_triangle(piece, [&](const Vec3& normal, std::uint32_t i, const std::array<Vec3, 3>& at) {
            result_.corners.push_back(corners_.numbers[i]);
            if (normal == Vec3{}) return;
            std::array<Vec3, 3> from_centre{};
            Vec3 middle{};
            for (std::size_t k = 0; k < 3; ++k) {
                from_centre[k] = difference(at[k], node.centre);
                for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] += from_centre[k][axis] / 3;
            }
            for (std::size_t axis = 0; axis < 3; ++axis) node.normal[axis] += normal[axis];
            add_moment(node.moment, normal, middle);
            moments.add_triangle(normal, from_centre);
        });
    }

    void add_children(std::span<Piece> pieces, FilmNodes::Node& node, FilmMoments& moments) {
        Vec3 lower = pieces.front().middle, upper = lower;
        for (const Piece& piece : pieces)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                lower[axis] = std::min(lower[axis], piece.middle[axis]);
                upper[axis] = std::max(upper[axis], piece.middle[axis]);
            }
        const Vec3 extent = difference(upper, lower);
        const auto axis = static_cast<std::size_t>(std::ranges::max_element(extent) - extent.begin());
        const std::size_t half = pieces.size() / 2;
        std::ranges::nth_element(pieces, pieces.begin() + static_cast<std::ptrdiff_t>(half), {},
                                 [&](const Piece& piece) { return std::pair(piece.middle[axis], piece.corner); });
        for (const bool is_first : {true, false}) {
            FilmMoments of_child;
            const std::uint32_t number = build(is_first ? pieces.first(half) : pieces.subspan(half), of_child);
            if (!is_first) node.second = number;
            const FilmNodes::Node& child = result_.nodes[number];
            const Vec3 shift = difference(child.centre, node.centre);
            for (std::size_t i = 0; i < 3; ++i) node.normal[i] += child.normal[i];
            for (std::size_t i = 0; i < node.moment.size(); ++i) node.moment[i] += child.moment[i];
            add_moment(node.moment, child.normal, shift);
            moments.add_shifted(of_child, shift);
        }
    }

    std::vector<Piece> pieces_;
    PieceCorners corners_;
    Result result_;
};

/// Cuts a loop by chords. A chord counts in both directions, so that the pieces together turn as the loop does.
void cut(std::span<const std::uint32_t> polygon, std::vector<Piece>& pieces, std::vector<std::uint32_t>& corners) {
    if (polygon.size() <= most_corners) {
        pieces.push_back({static_cast<std::uint32_t>(corners.size()), static_cast<std::uint32_t>(polygon.size())});
        corners.insert(corners.end(), polygon.begin(), polygon.end());
        return;
    }
    const std::size_t half = polygon.size() / 2;
    cut(polygon.first(half + 1), pieces, corners);
    std::vector<std::uint32_t> rest(polygon.begin() + static_cast<std::ptrdiff_t>(half), polygon.end());
    rest.push_back(polygon.front());
    cut(rest, pieces, corners);
}

}  // namespace

FilmNodes::FilmNodes(std::span<const Vec3> positions, std::span<const std::size_t> begins) {
    std::vector<Piece> pieces;
    PieceCorners corners{positions, {}, {}};
    for (std::size_t loop = 0; loop + 1 < begins.size(); ++loop) {
        std::vector<std::uint32_t> polygon(begins[loop + 1] - begins[loop]);
        std::iota(polygon.begin(), polygon.end(), static_cast<std::uint32_t>(begins[loop]));
        cut(polygon, pieces, corners.numbers);
    }
    if (pieces.empty()) return;
    TreeOfPieces(std::move(pieces), std::move(corners), {corners_, nodes_, expansions_});
}

// With r = centre - point and d its length, the moments give 4 pi turns = (n.r + tr M) / d^3 - 3 r.Mr / d^5. What they
// leave out is at most 3 area radius^2 / gap^4, its gradient 12 area radius^2 / gap^5; the second derivative of the
// whole is at most 6 area / gap^4.
FilmNodes::Linear FilmNodes::linear(const Node& node, const Vec3& point, double ball) {
    const Vec3 r = difference(node.centre, point);
    const double distance = length(r), gap = distance - node.radius, away = gap - ball;
    if (!(away > nearest * node.radius)) return {0, {infinity, {}, infinity}};
    const double per = 1 / distance, per_3 = per * per * per, per_5 = per_3 * per * per;
    const auto& [xx, yy, zz, xy, xz, yz] = node.moment;
    const Vec3 moved{xx * r[0] + xy * r[1] + xz * r[2], xy * r[0] + yy * r[1] + yz * r[2],
                     xz * r[0] + yz * r[1] + zz * r[2]};
    const double along = dot(r, moved), level = dot(node.normal, r) + xx + yy + zz;
    Linear result{per_sphere * (level * per_3 - 3 * along * per_5), {}};
    for (std::size_t axis = 0; axis < 3; ++axis)
        result.change.gradient[axis] =
            -per_sphere * (node.normal[axis] * per_3 - (3 * level * r[axis] + 6 * moved[axis]) * per_5 +
                           15 * along * r[axis] * per_5 * per * per);
    const double per_gap = node.radius / (gap * gap);
    const double left_out = 3 * per_sphere * node.area * per_gap * per_gap;
    const double most = film_change(node.area, away, ball);
    result.change.most = most + left_out;
    result.change.beside = 1.5 * ball / away * most + left_out + 4 * left_out * ball / gap;
    return result;
}

}  // namespace clsdf
