#include "coarse.h"
#include "core/parallel.hpp"
#include "launch/programs.hpp"
#include "plan/stages.hpp"
#include "polyhedra/awkward_meshes.hpp"
#include "prepare/kernel_frusta.hpp"
#include "prepare/layout_of.hpp"
#include "support/device_memory.hpp"
#include "support/random_meshes.hpp"
#include "sweep.h"

#include <clsdf/tuning.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

// Kernels make the records, and the vertices of the sign's sweep, that the host would write of the same frusta: the
// same bytes. The frusta that they make are at no place smaller than those that the host makes by exact predicates.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A mesh as the kernels read it; the sweep's triangles contain their vertices.
struct Made {
    std::vector<Polyhedron> records;
    std::vector<std::array<SweepVertex, 3>> triangles;
    bool on_device = false;
};

Made made_by(transform::Stages& stages, const device::Context& context, const Grid& grid, const Band& band) {
    const transform::Inputs inputs =
        stages.inputs(grid, scan::layout_of(grid, band, SignRule::parity), SignRule::parity);
    Made made;
    made.records = read<Polyhedron>(context, *inputs.records->polyhedra, inputs.records->record_count);
    const scan::SweepMesh& sweep = *inputs.sweep_mesh;
    made.on_device = sweep.faces != nullptr;
    const auto triangles = read<Triangle>(context, sweep.triangles(), sweep.triangle_count);
    const auto vertices = read<SweepVertex>(context, *sweep.vertices, sweep.vertices.bytes() / sizeof(SweepVertex));
    for (const auto& [a, b, c] : triangles) made.triangles.push_back({vertices[a], vertices[b], vertices[c]});
    return made;
}

std::string bytes_of(const Polyhedron& record) {
    return {reinterpret_cast<const char*>(&record), sizeof record};
}

/// Those of the whole mesh, by the host.
std::vector<Polyhedron> host_records(transform::Stages& stages, const Grid& grid) {
    const polyhedra::MeshTopology& topology = stages.topology();
    const polyhedra::Frusta& frusta = stages.frusta();
    const polyhedra::LatticeView lattice = scan::lattice_of(grid);
    const std::size_t faces = topology.order.size(), first_site = scan::in_record_groups(faces);
    std::vector<Polyhedron> records(first_site + frusta.sites.size());
    const std::span<Polyhedron> all(records);
    write_face_records(topology, frusta, lattice, all.first(faces));
    std::fill(records.begin() + static_cast<std::ptrdiff_t>(faces),
              records.begin() + static_cast<std::ptrdiff_t>(first_site), Polyhedron(records[faces - 1]));
    write_site_records(topology, frusta, lattice, 0, all.subspan(first_site));
    return records;
}

std::size_t count_different(const std::vector<Polyhedron>& a, const std::vector<Polyhedron>& b) {
    BOOST_TEST_REQUIRE(a.size() == b.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different += bytes_of(a[i]) == bytes_of(b[i]) ? 0U : 1U;
    return different;
}

/// The device's triangles are in the order of the records, the host's in the caller's.
void check_same_sweep(const Made& device, const Made& host) {
    if (!device.on_device) return;
    BOOST_TEST_REQUIRE(device.triangles.size() == host.triangles.size());
    for (std::size_t i = 0; i < device.triangles.size(); ++i) {
        const auto& own = device.triangles[i];
        const auto& others = host.triangles[device.records[i].triangle];
        BOOST_TEST_REQUIRE(std::memcmp(&own, &others, sizeof own) == 0);
    }
}

}  // namespace

BOOST_AUTO_TEST_CASE(kernels_make_the_records_that_the_host_writes) {
    const Device device = Device::automatic();
    device::Context& context = device::context_of(device);
    const scan::Programs programs(context, KernelBody::automatic);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    std::size_t on_device = 0, slivers = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = awkward_mesh(random);
            const Band band = Band::symmetric(0.05 * mesh.box().longest_side());
            Grid grid = Grid::around(mesh, 48, band);
            if (seed % 3 == 0) grid.spacing[seed % 2] *= 0.7;
            const bool is_far = seed % 7 == 0;  // the host writes the records that are near, if there are any
            if (is_far) grid.origin[0] -= 1e9 * grid.spacing[0];
            transform::Stages plain(context, pool, mesh),
                stages(context, pool, mesh, {{}, {programs.mesh_records, programs.mesh_lanes()}});
            const Made whole = made_by(stages, context, grid, band);
            const std::vector<Polyhedron> expected = host_records(stages, grid);
            if (!is_far) BOOST_TEST(count_different(whole.records, expected) == 0U);
            check_same_sweep(whole, made_by(plain, context, grid, band));
            BOOST_TEST(whole.on_device == !is_far);
            on_device += whole.on_device ? 1U : 0U;

            const auto& [nx, ny, nz] = grid.size;
            const Grid part = grid.part({nx / 4, ny / 4, nz / 4}, {nx / 4 + 1, ny / 4 + 1, nz / 4 + 1});
            std::set<std::string> all;
            for (const Polyhedron& record : expected) all.insert(bytes_of(record));
            for (const Grid& some : {grid, part})
                for (const Polyhedron& record : made_by(stages, context, some, band).records)
                    BOOST_TEST_REQUIRE(all.contains(bytes_of(record)));
            slivers += stages.frusta().slivers.size();
        }
    }
    BOOST_TEST(on_device > 0U);
    BOOST_TEST(slivers > 0U);
}

namespace {

/// The host's frusta and those of kernels.
struct BothFrusta {
    std::shared_ptr<const polyhedra::MeshTopology> topology;
    polyhedra::Frusta host;
    polyhedra::Frusta kernels;
};

template <class Value>
bool are_same(const UninitializedVector<Value>& a, const std::vector<Value>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0;
}

BothFrusta both_frusta(const Mesh& mesh) {
    const Device device = Device::automatic();
    device::Context& context = device::context_of(device);
    const scan::Programs programs(context, KernelBody::automatic);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    BothFrusta both{std::make_shared<const polyhedra::MeshTopology>(mesh), {}, {}};
    both.host = polyhedra::make_frusta(*both.topology, mesh.vertices());
    const scan::DeviceSetUp job{context, pool, programs.mesh_records, programs.mesh_lanes()};
    const auto names = std::make_shared<const scan::DeviceFaces::Names>(device_names(job, both.topology));
    const auto sources = std::make_shared<const scan::FrustaSources>(job, *both.topology);
    scan::MadeFrusta made = frusta_by_kernels(job, names, sources, mesh);
    // The device has the slopes that the host has.
    const auto slopes = read<polyhedra::FaceSlopes>(context, *made.faces.slopes, both.topology->order.size());
    BOOST_TEST(are_same(made.frusta.slopes, slopes));
    both.kernels = std::move(made.frusta);
    return both;
}

void check_slopes(const BothFrusta& both) {
    // For the roundings of a slope; far below the slack.
    const auto is_wide = [](float kernel, float host) {
        return kernel >= host - 1e-8F - 1e-6F * host || kernel >= CLSDF_OPEN_SLOPE;
    };
    std::size_t narrow = 0, wider = 0;
    for (std::size_t face = 0; face < both.host.slopes.size(); ++face)
        for (std::size_t k = 0; k < 3; ++k) {
            const polyhedra::FaceSlopes &kernel = both.kernels.slopes[face], &host = both.host.slopes[face];
            narrow += is_wide(kernel.above[k], host.above[k]) && is_wide(kernel.below[k], host.below[k]) ? 0U : 1U;
            wider += is_wide(host.above[k], kernel.above[k]) && is_wide(host.below[k], kernel.below[k]) ? 0U : 1U;
        }
    BOOST_TEST(narrow == 0U);
    BOOST_TEST(wider <= both.host.slopes.size() / 100);
}

void check_sites(const BothFrusta& both) {
    std::vector<std::uint32_t> host, kernels;
    for (const auto& site : both.host.sites) host.push_back(site.vertex);
    for (const auto& site : both.kernels.sites) kernels.push_back(site.vertex);
    BOOST_TEST(kernels == host, boost::test_tools::per_element());
    // Edges that are flat up to rounding make a saddle for exact predicates alone.
    BOOST_TEST(both.kernels.saddle_vertices <= both.host.saddle_vertices);
    BOOST_TEST(both.kernels.saddle_vertices >= both.host.saddle_vertices * 4 / 5);
    BOOST_TEST(both.kernels.boxes == both.host.boxes);
}

/// Every triangle in four, `times` times; new vertices lie in their edges' middles, moved by `noise` of the edge.
Mesh subdivided(const Mesh& mesh, int times, double noise, unsigned seed) {
    Random random(seed);
    std::vector<Vec3> vertices = mesh.vertices();
    std::vector<Triangle> triangles = mesh.triangles();
    for (; times > 0; --times) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        std::vector<Triangle> finer;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [it, is_new] =
                middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices.size()));
            if (is_new) {
                Vec3 point;
                const double length = std::hypot(vertices[a][0] - vertices[b][0], vertices[a][1] - vertices[b][1],
                                                 vertices[a][2] - vertices[b][2]);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    point[axis] = (vertices[a][axis] + vertices[b][axis]) / 2 + noise * length * random.uniform(-1, 1);
                vertices.push_back(point);
            }
            return it->second;
        };
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }
    return {std::move(vertices), std::move(triangles), mesh.name() + " subdivided"};
}

/// From flat to spiky, of 3 to 13 faces, one in eight around its tip twice, one in two inside out; beside each other.
Mesh random_fans(Random& random, std::size_t fans) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::size_t n = 0; n < fans; ++n) {
        const auto tip = static_cast<std::uint32_t>(vertices.size());
        const auto count = static_cast<std::uint32_t>(3 + random.index(11));
        const double turns = random.index(8) == 0 ? 2 : 1;
        const double waves = std::pow(10, random.uniform(-5, 1));
        const double slant = random.index(3) == 0 ? random.uniform(-6, 6) : 0;
        const double x = 8 * static_cast<double>(n % 32), y = 8 * static_cast<double>(n / 32);
        const bool is_inside_out = random.index(2) == 0;
        vertices.push_back({x, y, 0});
        for (std::uint32_t i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * turns * (i + random.uniform(-0.4, 0.4)) / count;
            const double radius = random.uniform(0.5, 3);
            vertices.push_back(
                {x + radius * std::cos(angle), y + radius * std::sin(angle), slant + waves * random.uniform(-1, 1)});
            const std::uint32_t own = tip + 1 + i, next = tip + 1 + (i + 1) % count;
            triangles.push_back(is_inside_out ? Triangle{tip, next, own} : Triangle{tip, own, next});
        }
    }
    return {std::move(vertices), std::move(triangles), "fans"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(kernels_make_the_frusta_of_the_host) {
    std::vector<Mesh> meshes{make_shape("sphere5"), make_shape("torus"), make_shape("cube")};
    meshes.push_back(subdivided(make_shape("cube"), 4, 0, 1));        // most edges are exactly flat
    meshes.push_back(subdivided(make_shape("sphere2"), 3, 0.02, 2));  // saddles at every other vertex
    meshes.push_back(subdivided(make_shape("sphere2"), 3, 0.2, 3));   // folds, sharp edges
    meshes.push_back(subdivided(make_shape("torus"), 1, 1e-15, 4));   // edges flat up to rounding
    std::size_t sites = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
        Random random(seed);
        meshes.push_back(awkward_mesh(random));
    }
    Random random(61);
    meshes.push_back(random_fans(random, 1500));
    // More faces around a vertex than kernels take; 261 and 265 are 5 and 9 in a byte.
    std::vector<Mesh> tips;
    for (const std::uint32_t faces : {12U, 13U, 25U, 261U, 265U, 1000U})
        for (const double height : {7.0, 0.5, 0.0})
            for (const double wave : {0.0, 0.5, 5.0})
                tips.push_back(shifted(tip(faces, height, wave), {30 * static_cast<double>(tips.size()), 0, 0}));
    meshes.push_back(together(tips, "tips"));
    for (const Mesh& mesh : meshes) {
        BOOST_TEST_CONTEXT(mesh.name() << ", " << mesh.triangles().size() << " triangles") {
            const BothFrusta both = both_frusta(mesh);
            sites += both.kernels.sites.size();
            check_slopes(both);
            check_sites(both);
        }
    }
    BOOST_TEST(sites > 0U);
}
