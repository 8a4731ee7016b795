#include "coarse.h"
#include "polyhedra/awkward_meshes.hpp"
#include "support/random_meshes.hpp"
#include "sweep.h"
#include "transform/layout_of.hpp"
#include "transform/programs.hpp"
#include "transform/stages.hpp"

#include <boost/test/unit_test.hpp>

#include <array>
#include <cstring>
#include <vector>

// A device with memory of its own makes the records, and the vertices of the sign's sweep, that the host would write:
// the same bytes.

using namespace clsdf;
using namespace clsdf::test;

namespace {

template <class Value>
std::vector<Value> read(const device::Context& context, const cl::Buffer& buffer, std::size_t count) {
    std::vector<Value> values(count);
    if (count > 0) context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(Value), values.data());
    return values;
}

/// What the kernels read of a mesh: the sweep's triangles have their vertices in them.
struct Made {
    std::vector<Polyhedron> records;
    std::vector<std::array<SweepVertex, 3>> triangles;
    bool on_device = false;
};

Made made_by(transform::Stages& stages, const device::Context& context, const Grid& grid, const Band& band) {
    const transform::Inputs inputs =
        stages.inputs(grid, transform::layout_of(grid, band, SignRule::parity), SignRule::parity);
    Made made;
    made.records = read<Polyhedron>(context, *inputs.records->polyhedra, inputs.records->record_count);
    const transform::SweepMesh& sweep = *inputs.sweep_mesh;
    made.on_device = sweep.faces != nullptr;
    const auto triangles = read<Triangle>(context, sweep.triangles(), sweep.triangle_count);
    const auto vertices = read<SweepVertex>(context, *sweep.vertices, sweep.vertices.bytes() / sizeof(SweepVertex));
    for (const auto& [a, b, c] : triangles) made.triangles.push_back({vertices[a], vertices[b], vertices[c]});
    return made;
}

/// The device's triangles are in the order of the records, the host's in the caller's.
void check_same(const Made& device, const Made& host) {
    BOOST_TEST_REQUIRE(device.records.size() == host.records.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < host.records.size(); ++i)
        different += std::memcmp(&device.records[i], &host.records[i], sizeof(Polyhedron)) == 0 ? 0U : 1U;
    BOOST_TEST(different == 0U);
    if (!device.on_device || device.triangles.size() != host.triangles.size()) return;
    for (std::size_t i = 0; i < device.triangles.size(); ++i) {
        const auto& own = device.triangles[i];
        const auto& others = host.triangles[device.records[i].triangle];
        BOOST_TEST_REQUIRE(std::memcmp(&own, &others, sizeof own) == 0);
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_device_makes_the_records_that_the_host_writes) {
    const Device device = Device::preferred();
    device::Context& context = device::context_of(device);
    const cl::Program program = context.program(
        "mesh_records.cl", transform::Programs(context, KernelBody::automatic).mesh_records_source().options);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    std::size_t on_device = 0, slivers = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = awkward_mesh(random);
            const Band band = Band::symmetric(0.05 * mesh.box().longest_side());
            Grid grid = Grid::around(mesh, 48, band);
            if (seed % 3 == 0) grid.spacing[seed % 2] *= 0.7;
            if (seed % 7 == 0) grid.origin[0] -= 1e9 * grid.spacing[0];  // far: the host writes all
            transform::Stages plain(context, pool, mesh), stages(context, pool, mesh, {{}, program});
            const Made whole = made_by(stages, context, grid, band);
            check_same(whole, made_by(plain, context, grid, band));
            BOOST_TEST(whole.on_device == (seed % 7 != 0));
            on_device += whole.on_device ? 1U : 0U;
            const auto& [nx, ny, nz] = grid.size;
            const Grid part = grid.part({nx / 4, ny / 4, nz / 4}, {nx / 4 + 1, ny / 4 + 1, nz / 4 + 1});
            check_same(made_by(stages, context, part, band), made_by(plain, context, part, band));
            slivers += polyhedra::make_frusta(polyhedra::MeshTopology(mesh), mesh.vertices()).slivers.size();
        }
    }
    BOOST_TEST(on_device > 0U);
    BOOST_TEST(slivers > 0U);
}
