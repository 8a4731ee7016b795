#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/temporary_folder.hpp"

#include <clsdf/io.hpp>

#include <vector>

// A file that is written from bricks has the bytes of the file that is written from the dense field.

using namespace clsdf;
using namespace clsdf::test;

namespace {

void check_same_file(const DistanceTransform& transform, const Grid& grid, const Band& band, OutputSet outputs,
                     const std::string& ending) {
    const TemporaryFolder folder;
    const std::string dense = folder.file("dense" + ending), bricks = folder.file("bricks" + ending),
                      at_once = folder.file("at_once" + ending);
    write_field(transform.compute(grid, band, outputs), dense);
    const FieldDescription description{grid, band, transform.sign(), transform.compute_sparse(grid, band).mesh_name};
    SparseFieldWriter writer(bricks, description, outputs);
    transform.compute_sparse(grid, band, outputs, [&](const SparseSlab& slab) { writer.append(slab); });
    writer.finish();
    BOOST_TEST((content_of(bricks) == content_of(dense)));
    write_field(transform.compute_sparse(grid, band, outputs), at_once);
    BOOST_TEST((content_of(at_once) == content_of(dense)));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_file_from_bricks_has_the_bytes_of_one_from_slices) {
    Random random(7);
    const Mesh sphere = random_sphere(random, "sphere3", 0.2), open = open_box({0, 0, 0}, {1, 1, 1}, 0);
    const std::vector<std::string> endings{".nvdb", CLSDF_WITH_OPENVDB ? ".vdb" : ".nvdb"};
    for (const std::string& ending : endings) {
        const OutputSet outputs = ending == ".vdb" ? Output::triangle | Output::closest : OutputSet();
        for (const Index3& first : {Index3{0, 0, 0}, {-16, 8, 24}, {3, -5, 9}}) {
            Grid grid = grid_around(sphere, 75, 9);
            for (std::size_t axis = 0; axis < 3; ++axis)
                grid.origin[axis] -= grid.spacing[axis] * static_cast<double>(first[axis]);
            grid.first = first;
            const double h = grid.voxel();
            const DistanceTransform transform(test_device(), sphere);
            for (const Band& band : {Band{3 * h, 3 * h}, Band{h, 4 * h}, Band{0, 2 * h}, Band{2 * h, 0}})
                BOOST_TEST_CONTEXT(ending << ", first sample " << first[0] << ", band " << band.inside / h << " "
                                          << band.outside / h)
            check_same_file(transform, grid, band, outputs, ending);
            // The last bricks, which the grid cuts off, are inside.
            check_same_file(transform, grid.part({10, 20, 15}, {31, 22, 23}), Band::symmetric(2 * h), outputs, ending);
            check_same_file(DistanceTransform(test_device(), sphere, {.sign = SignRule::none}), grid,
                            Band::symmetric(2 * h), outputs, ending);
        }
        const Grid around = grid_around(open, 60, 10);
        check_same_file(DistanceTransform(test_device(), open, {.sign = SignRule::solid_angle}), around,
                        Band::symmetric(2 * around.voxel()), outputs, ending);
    }
}
