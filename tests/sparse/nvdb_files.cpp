#include "support/exact_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/io.hpp>

#include <functional>
#include <string>
#include <vector>

// A file of a sparse field is that of the dense field.

using namespace clsdf;
using namespace clsdf::test;

namespace {

void check_file(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign) {
    const TemporaryFolder folder;
    const DistanceTransform transform(test_device(), mesh, {.sign = sign});
    const Field dense = transform.compute(grid, band);
    write_field(dense, folder.file("dense.nvdb"));

    SparseFieldWriter writer(folder.file("sparse.nvdb"), dense);
    transform.compute_sparse(grid, band, Output::distance, [&](const SparseSlab& slab) { writer.append(slab); });
    writer.finish();
    BOOST_CHECK(content_of(folder.file("sparse.nvdb")) == content_of(folder.file("dense.nvdb")));
    BOOST_CHECK(same_bytes(read_field(folder.file("sparse.nvdb")), dense));
    BOOST_TEST(folder.file_count() == 2U);
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_sparse_nvdb_file)

BOOST_AUTO_TEST_CASE(has_the_bytes_of_the_dense_fields_file) {
    const Mesh mesh = make_shape("sphere4");
    Grid grid = grid_around(mesh, 75, 5);
    const double h = grid.voxel();
    for (const Band& band : {Band::symmetric(3 * h), Band{5 * h, 2 * h}, Band{0, 3 * h}, Band::symmetric(h / 4)})
        check_file(mesh, grid, band, SignRule::nonzero);
    check_file(mesh, grid, Band::symmetric(3 * h), SignRule::none);
    check_file(mesh, grid, {Band::full().inside, 3 * h}, SignRule::none);
    grid.spacing[1] *= 0.75;
    check_file(mesh, grid, Band::symmetric(3 * h), SignRule::nonzero);
}

BOOST_AUTO_TEST_CASE(has_them_where_the_grid_cuts_the_body_and_begins_anywhere_on_its_lattice) {
    const Mesh mesh = make_shape("sphere4");
    const Grid whole = grid_around(mesh, 75, 5);
    const Band band = Band::symmetric(3 * whole.voxel());
    for (const Grid& grid : {whole.part({3, 20, 37}, {60, 13, 21}), whole.part({30, 30, 30}, {9, 9, 9}),
                             whole.block({-20, -3, 5}, {64, 40, 16})})
        check_file(mesh, grid, band, SignRule::nonzero);
}

BOOST_AUTO_TEST_CASE(needs_layers_in_their_order_and_all_of_them) {
    const TemporaryFolder folder;
    const Mesh mesh = make_shape("sphere4");
    const Grid grid = grid_around(mesh, 75, 5);
    const Band band = Band::symmetric(3 * grid.voxel());
    const DistanceTransform transform(test_device(), mesh);
    const SparseField sparse = transform.compute_sparse(grid, band);
    const auto refused = [&](const std::string& what, const std::function<void(SparseSlab&)>& change) {
        SparseSlab slab = sparse.slab();
        change(slab);
        SparseFieldWriter writer(folder.file("sparse.nvdb"), sparse);
        check_throws(ErrorCode::invalid_argument, {"sparse field writer", what}, [&] {
            writer.append(slab);
            writer.finish();
        });
        check_throws(ErrorCode::invalid_argument, {"after a failure"}, [&] { writer.append(sparse.slab()); });
    };
    std::vector<Index3> turned(sparse.bricks.rbegin(), sparse.bricks.rend());
    refused("order", [&](SparseSlab& slab) { slab.bricks = turned; });
    refused("bytes", [&](SparseSlab& slab) { slab.bricks = slab.bricks.first(1); });
    refused("whole layers", [&](SparseSlab& slab) { slab.part.size[0] -= 8; });
    refused("do not follow", [&](SparseSlab& slab) { slab.part.first[2] += 8; });
    refused("not in the bricks", [&](SparseSlab& slab) { slab.part.size[2] -= 8; });
    std::vector<BrickRun> far = sparse.inside;
    far.back().count += 100;
    refused("not in the bricks", [&](SparseSlab& slab) { slab.inside = far; });
    refused("missing", [&](SparseSlab& slab) {
        slab.part.size[2] = 8;
        slab.bricks = {};
        slab.values = {};
        slab.inside = {};
    });
    BOOST_TEST(folder.file_count() == 0U);
    check_throws(ErrorCode::invalid_argument, {"half widths"}, [&] {
        FieldDescription endless = sparse;
        endless.band.outside = Band::full().outside;
        SparseFieldWriter(folder.file("sparse.nvdb"), endless);
    });
    check_throws(ErrorCode::unsupported, {".nrrd", "sparse"},
                 [&] { SparseFieldWriter(folder.file("sparse.nrrd"), sparse); });
}

BOOST_AUTO_TEST_SUITE_END()
