// Fractions of cells of many boxes, by slabs, and in the caller's arrays.

#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include "core/vectors.hpp"
#include "device/opencl.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fractions.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

bool are_same(std::span<const CellFraction> a, std::span<const CellFraction> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

/// Arrays of the caller's for rows, and some that are none's.
struct Rows {
    explicit Rows(std::size_t room)
        : cells(3 * room, -7),
          pieces(room, 77),
          volume(room, -7),
          centroid(3 * room, -7),
          area(2 * room, -7),
          vector_area(3 * room, -7),
          surface_centroid(3 * room, -7),
          face_fractions(6 * room, -7),
          face_centroids(12 * room, -7) {
        to.room = room;
        to.cells = cells;
        to.pieces = pieces;
        to.volume = volume;
        // The first components one after another, then the second ones.
        to.centroid = centroid;
        to.centroid.component_stride = static_cast<std::ptrdiff_t>(room * sizeof(float));
        to.area = area;
        to.area.strides[0] = 2 * sizeof(double);
        to.vector_area = vector_area;
        to.surface_centroid = surface_centroid;
        to.face_fractions = face_fractions;
        to.face_centroids = face_centroids;
    }

    /// How many items differ from the rows, or from what was there beyond them.
    std::size_t wrong(std::span<const CellFraction> rows) const {
        std::size_t wrong = 0;
        for (std::size_t n = 0; n < to.room; ++n) {
            const bool is_row = n < rows.size();
            const CellFraction row = is_row ? rows[n] : CellFraction{};
            const auto differ = [&](auto found, auto known) { return found != (is_row ? known : decltype(known)(-7)); };
            wrong += pieces[n] != (is_row ? row.pieces : 77);
            wrong += differ(volume[n], row.volume) || differ(area[2 * n], row.area) || area[2 * n + 1] != -7;
            for (std::size_t d = 0; d < 3; ++d)
                wrong += differ(cells[3 * n + d], row.cell[d]) ||
                         differ(centroid[d * to.room + n], static_cast<float>(row.centroid[d])) ||
                         differ(vector_area[3 * n + d], row.vector_area[d]) ||
                         differ(surface_centroid[3 * n + d], row.surface_centroid[d]);
            for (std::size_t face = 0; face < 6; ++face)
                wrong += differ(face_fractions[6 * n + face], row.face_fractions[face]) ||
                         differ(face_centroids[12 * n + 2 * face], row.face_centroids[face][0]) ||
                         differ(face_centroids[12 * n + 2 * face + 1], row.face_centroids[face][1]);
        }
        return wrong;
    }

    std::vector<std::int32_t> cells;
    std::vector<std::uint32_t> pieces;
    std::vector<double> volume;
    std::vector<float> centroid;
    std::vector<double> area, vector_area, surface_centroid, face_fractions, face_centroids;
    FractionRows to;
};

}  // namespace

BOOST_AUTO_TEST_CASE(many_boxes_have_the_bytes_of_one_each) {
    const Mesh mesh = make_shape("knot");
    const OuterSurface surface = outer(mesh);
    const Grid coarse = Grid::around(mesh.box(), {.resolution = 17}), fine = coarse.refined(2);
    std::vector<Grid> grids;
    for (const Grid& level : {coarse, fine})
        for (std::int64_t n = 0; n < 4; ++n)
            grids.push_back(
                level.block({level.first[0] + 4 * n - 1, level.first[1] + 3, level.first[2] - n}, {7, 9, 8}));
    std::size_t next = 0;
    for (const FractionOptions& options : {FractionOptions(), FractionOptions::of("amrex")}) {
        next = 0;
        fractions(
            surface, grids,
            [&](std::size_t n, Fractions& found) {
                BOOST_TEST(n == next++);
                const Fractions known = fractions(mesh, grids[n], options);
                BOOST_TEST((found.grid == known.grid && found.full == known.full));
                BOOST_REQUIRE(found.cells.size() == known.cells.size());
                for (std::size_t row = 0; row < known.cells.size(); ++row)
                    BOOST_TEST(std::memcmp(&found.cells[row], &known.cells[row], sizeof(CellFraction)) == 0);
            },
            options);
        BOOST_TEST(next == grids.size());
    }
    CallOptions call;
    std::vector<double> progress;
    call.progress = [&](const Progress& told) { progress.push_back(told.fraction); };
    fractions(surface, fine, {}, call);
    BOOST_TEST(progress.size() > 2U);
    BOOST_TEST(std::ranges::is_sorted(progress));
    BOOST_TEST(progress.back() == 1);
    call.should_stop = [] { return true; };
    check_throws(ErrorCode::cancelled, {"cut cells", "cancelled"}, [&] { fractions(surface, coarse, {}, call); });
}

BOOST_AUTO_TEST_CASE(dense_arrays_are_the_rows) {
    const Mesh mesh = make_shape("knot");
    const OuterSurface surface = outer(mesh);
    const Grid whole = Grid::around(mesh.box(), {.resolution = 21});
    const FractionOptions options = FractionOptions::of("amrex");
    const std::array grids{whole.part({2, 3, 1}, {9, 8, 7}), whole};
    // As AMReX has them: components one after the other, faces in arrays of their own.
    struct Fab {
        std::vector<double> volume, centroid, area, normal, surface_centroid;
        std::array<std::vector<double>, 3> face_fractions, face_centroids;
        std::vector<std::uint8_t> types, pieces;
    };
    std::vector<Fab> fabs(grids.size());
    std::vector<FractionRequest> requests;
    for (std::size_t n = 0; n < grids.size(); ++n) {
        const auto [nx, ny, nz] = Fractions{grids[n], {}, {}}.counts();
        const std::size_t cells = nx * ny * nz;
        Fab& fab = fabs[n];
        FractionTargets& to = requests.emplace_back(FractionRequest{grids[n], {}}).targets;
        const auto array = [](std::vector<double>& values, std::size_t items, std::size_t components) {
            values.assign(items * components, -7);
            OutputArray to_values = values;
            if (components > 1) to_values.component_stride = static_cast<std::ptrdiff_t>(items * sizeof(double));
            return to_values;
        };
        fab.types.assign(cells, 9);
        fab.pieces.assign(cells, 9);
        to.types = fab.types;
        to.pieces = fab.pieces;
        to.volume = array(fab.volume, cells, 1);
        to.centroid = array(fab.centroid, cells, 3);
        to.area = array(fab.area, cells, 1);
        to.normal = array(fab.normal, cells, 3);
        to.surface_centroid = array(fab.surface_centroid, cells, 3);
        for (std::size_t d = 0; d < 3; ++d) {
            const std::size_t faces = (nx + (d == 0)) * (ny + (d == 1)) * (nz + (d == 2));
            to.face_fractions[d] = array(fab.face_fractions[d], faces, 1);
            to.face_centroids[d] = array(fab.face_centroids[d], faces, 2);
        }
    }
    fractions(surface, requests, options);
    for (std::size_t n = 0; n < grids.size(); ++n) {
        const Fab& fab = fabs[n];
        const Fractions found = fractions(surface, grids[n], options);
        const auto [nx, ny, nz] = found.counts();
        const std::size_t cells = nx * ny * nz;
        std::map<std::size_t, const CellFraction*> rows;
        for (const CellFraction& cell : found.cells) {
            const Index3& first = grids[n].first;
            rows[(static_cast<std::size_t>(cell.cell[2] - first[2]) * ny +
                  static_cast<std::size_t>(cell.cell[1] - first[1])) *
                     nx +
                 static_cast<std::size_t>(cell.cell[0] - first[0])] = &cell;
        }
        std::size_t wrong = 0;
        for (std::size_t k = 0; k < nz; ++k)
            for (std::size_t j = 0; j < ny; ++j)
                for (std::size_t i = 0; i < nx; ++i) {
                    const std::size_t cell = (k * ny + j) * nx + i;
                    const auto row = rows.find(cell);
                    const bool is_cut = row != rows.end();
                    const double volume = is_cut                   ? std::clamp(row->second->volume, 0.0, 1.0)
                                          : found.is_full(i, j, k) ? 1
                                                                   : 0;
                    wrong += fab.types[cell] != (is_cut ? 2 : static_cast<std::uint8_t>(volume));
                    wrong += fab.pieces[cell] != (is_cut ? row->second->pieces : 0);
                    wrong += fab.volume[cell] != volume;
                    wrong += fab.area[cell] != (is_cut ? row->second->area : 0);
                    double normal = 0;
                    for (std::size_t d = 0; d < 3; ++d) {
                        wrong += fab.centroid[d * cells + cell] != (is_cut ? row->second->centroid[d] : 0);
                        wrong +=
                            fab.surface_centroid[d * cells + cell] != (is_cut ? row->second->surface_centroid[d] : -1);
                        normal += fab.normal[d * cells + cell] * fab.normal[d * cells + cell];
                        for (std::size_t side = 0; side < 2; ++side) {
                            const std::size_t ni = nx + (d == 0), nj = ny + (d == 1), nk = nz + (d == 2);
                            const std::size_t at = ((k + (d == 2 ? side : 0)) * nj + j + (d == 1 ? side : 0)) * ni + i +
                                                   (d == 0 ? side : 0);
                            const double fraction = fab.face_fractions[d][at];
                            // A face between an uncut cell and a cut one has the value of the latter.
                            wrong += std::abs(fraction -
                                              (is_cut ? row->second->face_fractions[2 * d + side] : volume)) > 1e-12;
                            if (is_cut && fraction > 0 && fraction < 1)
                                for (std::size_t c = 0; c < 2; ++c)
                                    wrong += fab.face_centroids[d][c * ni * nj * nk + at] !=
                                             row->second->face_centroids[2 * d + side][c];
                        }
                    }
                    wrong += std::abs(normal - (is_cut ? 1 : 0)) > 1e-12;
                }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST(rows.size() > 50U);
    }
    std::vector<float> few(7);
    FractionRequest request{whole, {}};
    request.targets.volume = few;
    check_throws(ErrorCode::invalid_argument, {"array of volumes", "room for 7 numbers"},
                 [&] { fractions(surface, std::span(&request, 1)); });
    request.targets.volume = requests[1].targets.volume;
    request.targets.area = requests[1].targets.volume;
    check_throws(ErrorCode::invalid_argument, {"array of volumes", "array of areas"},
                 [&] { fractions(surface, std::span(&request, 1)); });
    check_throws(ErrorCode::invalid_argument, {"'amrx'", "amrex"}, [] { FractionOptions::of("amrx"); });
}

BOOST_AUTO_TEST_CASE(slabs_have_the_rows_of_the_whole) {
    // Layers of 512 x 300 cells: a slab has the fewest layers that there may be.
    const Mesh mesh = make_shape("knot");
    const Vec3 side = difference(mesh.box().upper, mesh.box().lower);
    const Grid grid{mesh.box().lower, {side[0] / 511, side[1] / 299, side[2] / 40}, {513, 301, 42}};
    const OuterSurface surface = outer(mesh);
    for (const FractionOptions& options : {FractionOptions(), FractionOptions::of("amrex")}) {
        const Fractions whole = fractions(surface, grid, options);
        std::vector<CellFraction> rows;
        std::size_t slabs = 0, wrong = 0;
        std::int64_t layers = 0;
        fraction_slabs(
            surface, grid,
            [&](std::size_t n, const Fractions& found) {
                BOOST_TEST(n == slabs++);
                const auto [nx, ny, nz] = found.counts();
                BOOST_TEST((found.grid == grid.part({0, 0, layers}, found.grid.size)));
                for (std::size_t k = 0; k < nz; ++k)
                    for (std::size_t j = 0; j < ny; ++j)
                        for (std::size_t i = 0; i < nx; ++i)
                            wrong +=
                                found.is_full(i, j, k) != whole.is_full(i, j, k + static_cast<std::size_t>(layers));
                layers += static_cast<std::int64_t>(nz);
                rows.insert(rows.end(), found.cells.begin(), found.cells.end());
            },
            options);
        BOOST_TEST(slabs > 2U);
        BOOST_TEST(layers == grid.size[2] - 1);
        BOOST_TEST(wrong == 0U);
        BOOST_TEST(are_same(rows, whole.cells));
        BOOST_TEST(count_fractions(surface, grid, options) == rows.size());
    }
    check_throws(ErrorCode::invalid_argument, {"sink", "empty"}, [&] { fraction_slabs(surface, grid, {}); });
    struct Stop {};
    std::size_t calls = 0;
    BOOST_CHECK_THROW(fraction_slabs(surface, grid,
                                     [&](std::size_t, const Fractions&) {
                                         ++calls;
                                         throw Stop();
                                     }),
                      Stop);
    BOOST_TEST(calls == 1U);
}

BOOST_AUTO_TEST_CASE(rows_are_written_into_the_callers_arrays) {
    const Mesh mesh = make_shape("sphere3");
    const OuterSurface surface = outer(mesh);
    const Grid grid = Grid::around(mesh.box(), {.resolution = 20});
    const Fractions known = fractions(surface, grid);
    const std::size_t needed = known.cells.size();
    Rows rows(needed + 3);
    const auto [nx, ny, nz] = known.counts();
    std::vector<std::uint8_t> full(nx * ny * nz, 9);
    rows.to.full = full;
    std::size_t count = 0;
    fractions(surface, grid, rows.to, count);
    BOOST_TEST(count == needed);
    BOOST_TEST(rows.wrong(known.cells) == 0U);
    BOOST_TEST(std::ranges::count(full, 1) > 100);
    for (std::size_t cell = 0; cell < full.size(); ++cell)
        BOOST_REQUIRE(full[cell] == (known.full[cell / 8] >> cell % 8 & 1));

    // With less room nothing is written, and the needed room is told; the cells that are full need none.
    Rows few(needed - 1);
    std::ranges::fill(full, std::uint8_t{9});
    few.to.full = full;
    check_throws(ErrorCode::invalid_argument, {std::to_string(needed), "room for " + std::to_string(needed - 1)},
                 [&] { fractions(surface, grid, few.to, count); });
    BOOST_TEST(count == needed);
    BOOST_TEST(few.wrong({}) == 0U);
    BOOST_TEST(std::ranges::count(full, 9) == static_cast<std::ptrdiff_t>(full.size()));
    FractionRows none;
    none.full = full;
    fractions(surface, grid, none, count);
    BOOST_TEST(std::ranges::count(full, 9) == 0);

    few.to.area = few.volume;
    check_throws(ErrorCode::invalid_argument, {"array of volumes", "array of areas"},
                 [&] { fractions(surface, grid, few.to, count); });
    BOOST_TEST(count == 0U);
    few.to.area = few.pieces;
    check_throws(ErrorCode::unsupported, {"array of areas", "uint32"},
                 [&] { fractions(surface, grid, few.to, count); });
}

BOOST_AUTO_TEST_CASE(results_are_written_to_memory_of_the_device) {
    const Mesh mesh = make_shape("knot");
    const OuterSurface surface = outer(mesh);
    const Grid grid = Grid::around(mesh.box(), {.resolution = 18});
    const Fractions known = fractions(surface, grid);
    const auto [nx, ny, nz] = known.counts();
    const std::size_t cells = nx * ny * nz, rows = known.cells.size();
    const cl::Context context(test_device().context(), true);
    const cl::CommandQueue queue(context, context.getInfo<CL_CONTEXT_DEVICES>().front());
    const cl::Buffer volumes(context, CL_MEM_READ_WRITE, sizeof(double) * (rows + cells)),
        places(context, CL_MEM_READ_WRITE, 3 * sizeof(std::int32_t) * rows);
    // Rows and an array of all cells in one buffer.
    OutputArray dense(volumes(), ElementType::float64);
    dense.offset = sizeof(double) * rows;
    std::size_t count = 0;
    FractionRows to;
    to.room = rows;
    to.volume = {volumes(), ElementType::float64};
    to.cells = {places(), ElementType::int32};
    fractions(test_device(), surface, grid, to, count);
    FractionRequest request{grid, {}};
    request.targets.volume = dense;
    fractions(test_device(), surface, std::span(&request, 1));
    BOOST_TEST(count == rows);
    std::vector<double> found(rows + cells), expected(cells);
    std::vector<std::array<std::int32_t, 3>> found_places(rows);
    queue.enqueueReadBuffer(volumes, CL_TRUE, 0, sizeof(double) * found.size(), found.data());
    queue.enqueueReadBuffer(places, CL_TRUE, 0, sizeof found_places[0] * rows, found_places.data());
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < rows; ++n)
        wrong += found[n] != known.cells[n].volume || found_places[n] != known.cells[n].cell;
    BOOST_TEST(wrong == 0U);
    request.targets.volume = expected;
    fractions(surface, std::span(&request, 1));
    BOOST_TEST(std::ranges::equal(std::span(found).subspan(rows), expected));

    request.targets.volume = dense;
    check_throws(ErrorCode::unsupported, {"array of volumes", "memory of a device"},
                 [&] { fractions(surface, std::span(&request, 1)); });
    to.room = rows + 1;
    check_throws(ErrorCode::invalid_argument, {"array of cells", "buffer"},
                 [&] { fractions(test_device(), surface, grid, to, count); });
    BOOST_TEST(count == 0U);
}

}  // namespace clsdf
