#include "transform/coarse_lists.hpp"

#include "support/hostile_meshes.hpp"
#include "transform/layout_of.hpp"
#include "transform/prepared_mesh.hpp"
#include "transform/programs.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <functional>
#include <map>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The numbers of the polyhedra in the list of each coarse brick of the lattice.
using Lists = std::map<Index3, std::vector<cl_uint>>;

template <class Value>
std::vector<Value> read(const device::Context& context, const cl::Buffer& buffer, std::size_t count) {
    std::vector<Value> values(count);
    if (count > 0) context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(Value), values.data());
    return values;
}

Lists lists_of(const Mesh& mesh, const Grid& grid, const Band& band, KernelBody body) {
    const Device device = Device::best();
    device::Context& context = device.internal();
    const transform::Programs programs(context, body);
    const auto pool = std::make_shared<device::BufferPool>(device.shared());
    ScratchMemory scratch;
    const Layout layout = transform::layout_of(grid, band, SignRule::nonzero);
    const transform::PreparedMesh prepared =
        transform::prepare_mesh(context, pool, scratch, mesh, grid, layout, {}, Scan::bricks);
    const transform::CoarseLists coarse =
        transform::make_coarse_lists(context, programs, pool, layout, *prepared.polyhedra, prepared.record_count,
                                     transform::ShortLaunches(context, {}));
    const std::size_t bricks = transform::coarse_brick_count(layout);
    const auto starts = read<cl_uint>(context, *coarse.starts, bricks * coarse.parts + 1);
    const auto entries = read<cl_uint>(context, *coarse.entries, coarse.pairs);
    Lists lists;
    std::size_t brick = 0;
    for (int z = 0; z < layout.coarse_bricks[2]; ++z)
        for (int y = 0; y < layout.coarse_bricks[1]; ++y)
            for (int x = 0; x < layout.coarse_bricks[0]; ++x, ++brick)
                lists[{x + layout.coarse_first[0], y + layout.coarse_first[1], z + layout.coarse_first[2]}] = {
                    entries.begin() + starts[brick * coarse.parts],
                    entries.begin() + starts[(brick + 1) * coarse.parts]};
    return lists;
}

}  // namespace

// Also where a part is so thin that it has fewer coarse bricks on an axis than are taken together, and begins anywhere
// among them.
BOOST_AUTO_TEST_CASE(coarse_lists_are_ascending_and_those_of_the_whole_in_every_part) {
    Random random(7);
    const Mesh mesh = random_sphere(random, "sphere4", 0.1);
    constexpr std::int64_t size = 200;
    Grid grid;
    grid.size = {size, size, size};
    grid.first = {-70, -41, 9};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.spacing[axis] = 1.1 * mesh.box().longest_side() / static_cast<double>(size);
        grid.origin[axis] = mesh.box().lower[axis] - grid.spacing[axis] * static_cast<double>(grid.first[axis] + 9);
    }
    const std::vector<std::pair<Index3, Index3>> parts{{{0, 0, 0}, {200, 9, 200}},    {{0, 60, 0}, {200, 70, 200}},
                                                       {{90, 0, 0}, {8, 200, 200}},   {{30, 0, 40}, {64, 200, 96}},
                                                       {{100, 100, 0}, {1, 1, 200}},  {{0, 3, 77}, {200, 40, 30}},
                                                       {{11, 100, 50}, {99, 17, 33}}, {{33, 70, 130}, {96, 96, 20}}};
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
        for (const Band& band :
             {Band::symmetric(10 * grid.voxel()), Band::symmetric(40 * grid.voxel()), Band::full()}) {
            const Lists whole = lists_of(mesh, grid, band, body);
            std::size_t pairs = 0;
            for (const auto& [brick, list] : whole) {
                BOOST_TEST((std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end()));
                pairs += list.size();
            }
            BOOST_TEST(pairs > mesh.triangles().size());
            for (const auto& [offset, part_size] : parts)
                BOOST_TEST_CONTEXT("part of " << part_size[0] << " x " << part_size[1] << " x " << part_size[2]
                                              << " from (" << offset[0] << ", " << offset[1] << ", " << offset[2]
                                              << "), width " << band.outside)
            for (const auto& [brick, list] : lists_of(mesh, grid.part(offset, part_size), band, body))
                BOOST_TEST((list == whole.at(brick)));
        }
}
