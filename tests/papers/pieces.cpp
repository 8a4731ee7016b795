#include "papers/pieces.hpp"
#include "frusta/awkward_meshes.hpp"
#include "frusta/pointwise.hpp"
#include "papers/scans.hpp"

#include <clsdf/tuning.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <map>

using namespace clsdf;
using namespace clsdf::test;
using papers::ConvexPieces;
using papers::PieceSlices;
using papers::SliceLaunch;
using papers::SliceLimits;
using papers::SliceSchedule;

namespace {

constexpr double half_width = 5;
constexpr double slack = 1e-3 + 2e-5 * half_width;

Layout layout_at(const std::array<std::int32_t, 3>& first, const std::array<std::int32_t, 3>& size) {
    Layout layout{};
    std::copy(first.begin(), first.end(), layout.first);
    std::copy(size.begin(), size.end(), layout.size);
    return layout;
}

bool holds(const ConvexPieces& pieces, const Piece& piece, const Vec3& point) {
    for (std::uint32_t n = 0; n < piece.plane_count; ++n) {
        const PiecePlane& plane = pieces.planes[piece.plane_begin + n];
        double value = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) value += plane.normal[axis] * (point[axis] - piece.origin[axis]);
        if (value > plane.offset + CLSDF_PIECE_SLACK) return false;
    }
    return true;
}

/// Points near the surfaces of polyhedra: of their planes, and anywhere around.
Vec3 point_near(Random& random, const Mesh& mesh) {
    const Triangle& triangle = mesh.triangles()[random.index(mesh.triangles().size())];
    const Vec3& corner = mesh.vertices()[triangle[random.index(3)]];
    return along(corner, random.uniform(0, 1.1 * half_width), random.direction());
}

}  // namespace

// The records' polyhedra are cut by slices. The least distance of those that hold a point is the least of all.
BOOST_AUTO_TEST_CASE(pieces_hold_what_the_records_hold_and_are_exact) {
    std::size_t held = 0, exact = 0;
    for (std::uint64_t seed = 1; seed <= 150; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = awkward_mesh(random);
            const engine::LatticeView lattice{{0.3, -0.2, 0.1}, 1, {1, 1.3, 1.7}};
            const LeanedFrusta frusta = leaned_frusta(mesh, lattice);
            const Layout everywhere = layout_at({-1000, -1000, -1000}, {2000, 2000, 2000});
            const ConvexPieces pieces = papers::leaned_pieces(frusta.polyhedra, half_width, slack, everywhere);
            std::vector<std::vector<Piece>> pieces_of(frusta.polyhedra.size());
            for (const Piece& piece : pieces.pieces) pieces_of[piece.polyhedron].push_back(piece);
            for (int i = 0; i < 200; ++i) {
                const Vec3 position = point_near(random, mesh);
                Vec3 point{};
                for (std::size_t axis = 0; axis < 3; ++axis)
                    point[axis] = (position[axis] - lattice.origin[axis]) / lattice.spacing_in_units[axis];
                point[2] = std::round(point[2]);  // pieces between two slices are left out
                double least = uncovered, least_held = uncovered;
                for (std::size_t p = 0; p < frusta.polyhedra.size(); ++p) {
                    const Polyhedron& record = frusta.polyhedra[p];
                    const PointwisePolyhedron pointwise(record, half_width, slack);
                    const double distance = pointwise.distance(point);
                    least = std::min(least, distance);
                    const bool in_piece = std::any_of(pieces_of[p].begin(), pieces_of[p].end(),
                                                      [&](const Piece& piece) { return holds(pieces, piece, point); });
                    if (in_piece) least_held = std::min(least_held, distance);
                    if (std::abs(pointwise.frame(point)[2]) > slack && pointwise.contains(point)) {
                        ++held;
                        BOOST_REQUIRE(in_piece);
                    }
                    // Compact ones are bounded by their lateral planes, without the record's bound along the base.
                    const double hair = 2 * CLSDF_PIECE_SLACK * 1e3;
                    if (in_piece && !(record.flags & CLSDF_POLYHEDRON_COMPACT))
                        BOOST_REQUIRE(PointwisePolyhedron(record, half_width, slack + hair).contains(point));
                }
                if (least > half_width) continue;
                ++exact;
                BOOST_REQUIRE(least_held <= least + 1e-9);
            }
        }
    BOOST_TEST(held > 100000U);
    BOOST_TEST(exact > 10000U);
}

// A box from (1.5, 2.5, 3.25) to (4.5, 9, 6) of the lattice.
BOOST_AUTO_TEST_CASE(a_piece_has_the_slices_that_it_cuts_within_the_grid) {
    const std::array<PiecePlane, 6> box{PiecePlane{{1, 0, 0}, 4.5 - 3}, PiecePlane{{-1, 0, 0}, 3 - 1.5},
                                        PiecePlane{{0, 1, 0}, 9.0 - 4}, PiecePlane{{0, -1, 0}, 4 - 2.5},
                                        PiecePlane{{0, 0, 1}, 6.0 - 5}, PiecePlane{{0, 0, -1}, 5 - 3.25}};
    const auto slices_in = [&](const std::array<std::int32_t, 3>& first, const std::array<std::int32_t, 3>& size) {
        ConvexPieces pieces;
        const Layout grid = layout_at(first, size);
        papers::PieceCollector(grid, pieces).add({3, 4, 5}, 7, box);
        if (pieces.pieces.empty()) return std::pair(0, 0);
        const Piece& piece = pieces.pieces.front();
        BOOST_TEST((piece.polyhedron == 7U && piece.plane_begin == 0U && piece.plane_count == 6U));
        BOOST_TEST((piece.origin[0] == 3 && piece.origin[1] == 4 && piece.origin[2] == 5));
        return std::pair(piece.slice_begin, piece.slice_end);
    };
    // The last slice touches the box.
    BOOST_TEST((slices_in({0, 0, 0}, {20, 20, 20}) == std::pair(4, 7)));
    BOOST_TEST((slices_in({0, 0, 5}, {20, 20, 20}) == std::pair(5, 7)));
    BOOST_TEST((slices_in({0, 0, 0}, {20, 20, 5}) == std::pair(4, 5)));
    BOOST_TEST((slices_in({0, 0, 7}, {20, 20, 20}) == std::pair(0, 0)));
    BOOST_TEST((slices_in({6, 0, 0}, {20, 20, 20}) == std::pair(0, 0)));
    BOOST_TEST((slices_in({0, 11, 0}, {20, 20, 20}) == std::pair(0, 0)));
    BOOST_TEST((slices_in({0, 0, -9}, {20, 20, 9}) == std::pair(0, 0)));
}

BOOST_AUTO_TEST_CASE(a_paper_polyhedron_is_one_piece_of_five_planes) {
    const Mesh mesh = b2().mesh;
    const engine::LatticeView lattice{{0, 0, 0}, 0.125, {1, 1, 1}};
    const papers::PeikertSiggPieces paper =
        papers::peikert_sigg_pieces(mesh, lattice, 8, true, layout_at({-100, -100, -100}, {200, 200, 200}));
    BOOST_TEST(paper.polyhedra.size() == 4U);
    BOOST_TEST(paper.pieces.pieces.size() == 4U);
    BOOST_TEST(paper.closed_gaps == 0U);
    for (const Piece& piece : paper.pieces.pieces) BOOST_TEST(piece.plane_count == 5U);
}

BOOST_AUTO_TEST_CASE(launches_divide_the_active_list_and_keep_their_limits) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            std::vector<PieceSlices> pieces(1 + random.index(300));
            constexpr std::int32_t first = -7, count = 50;
            std::size_t active = 0;
            for (PieceSlices& piece : pieces) {
                piece.begin = first - 5 + static_cast<std::int32_t>(random.index(count + 5));
                piece.end = piece.begin + 1 + static_cast<std::int32_t>(random.index(20));
                // Their costs differ by up to four orders of magnitude.
                piece.cost = {4, static_cast<float>(std::pow(10, random.uniform(0, 4)))};
                active += static_cast<std::size_t>(
                    std::max(0, std::min(piece.end, first + count) - std::max(piece.begin, first)));
            }
            const SliceLimits limits{1 + random.index(9), 200, 30000, 1 + static_cast<std::int32_t>(random.index(2))};
            const SliceSchedule schedule = schedule_slices(pieces, first, count, limits);

            std::int32_t slice = first;
            std::size_t position = 0;
            for (const papers::SliceChunk& chunk : schedule.chunks) {
                BOOST_TEST(chunk.begin == slice);
                BOOST_TEST(chunk.active_begin == position);
                BOOST_TEST(static_cast<std::size_t>(chunk.end - chunk.begin) <= limits.slices_at_once);
                const bool is_single = chunk.end == chunk.begin + 1;
                BOOST_TEST((is_single || chunk.active_end - chunk.active_begin <= limits.active_at_once));
                BOOST_TEST(chunk.active_end - chunk.active_begin <= schedule.most_active);
                BOOST_TEST(static_cast<std::size_t>(chunk.end - chunk.begin) <= schedule.most_slices);
                slice = chunk.end;
                position = chunk.active_end;
            }
            BOOST_TEST(slice == first + count);
            BOOST_TEST(position == active);

            // The cost of each entry of the active list, in its order.
            std::vector<double> costs;
            for (std::int32_t s = first; s < first + count; ++s)
                for (const PieceSlices& piece : pieces)
                    if (piece.begin <= s && s < piece.end) costs.push_back(papers::cost_of(piece.cost));
            std::map<std::pair<std::size_t, std::int32_t>, std::size_t> reached;
            double fraction = -1;
            for (const SliceLaunch& launch : schedule.launches) {
                std::size_t& at = reached[{launch.chunk, launch.pass}];
                BOOST_TEST(launch.begin == at);
                at = launch.end;
                double cost = 0;
                for (std::size_t i = launch.begin; i < launch.end; ++i)
                    cost += costs[schedule.chunks[launch.chunk].active_begin + i];
                BOOST_TEST((launch.end - launch.begin == 1 || cost <= limits.cost_per_launch * (1 + 1e-9)));
                BOOST_TEST(launch.fraction_before > fraction);
                fraction = launch.fraction_before;
            }
            BOOST_TEST(fraction < 1);
            BOOST_TEST(reached.size() == schedule.chunks.size() * static_cast<std::size_t>(limits.passes));
            for (const auto& [key, at] : reached) {
                const papers::SliceChunk& chunk = schedule.chunks[key.first];
                BOOST_TEST(at == chunk.active_end - chunk.active_begin);
            }
        }
}
