#include "frusta/kernel_frusta.hpp"
#include "frusta/awkward_meshes.hpp"
#include "frusta/host_part.hpp"
#include "lattice/layout_of.hpp"
#include "launch/programs.hpp"
#include "support/device_memory.hpp"
#include "support/random_meshes.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

// Code of the host that uses exact predicates is the specification of the frusta (docs/architecture.md). The frusta
// that kernels make are at no place smaller.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The host's frusta and those of kernels.
struct BothFrusta {
    std::shared_ptr<const engine::MeshTopology> topology;
    engine::Frusta host;
    engine::Frusta kernels;
    engine::LeftToHost left{};  // by the kernels
    bool is_of_gpu = false;
};

template <class Value>
bool are_same(const KeptArray<Value>& a, const std::vector<Value>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0;
}

BothFrusta both_frusta(const Mesh& mesh, const Grid& grid) {
    const Device device = Device::automatic();
    device::Context& context = device::context_of(device);
    const engine::Programs programs(context, KernelBody::automatic);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    BothFrusta both{std::make_shared<const engine::MeshTopology>(mesh), {}, {}};
    both.host = engine::make_frusta(*both.topology, mesh.vertices());
    both.host.sites = engine::in_groups(both.host.sites, engine::site_blocks(both.host.sites, {}));
    const engine::DeviceSetUp job({context, pool, programs});
    const auto names = std::make_shared<const engine::NamedFaces>(device_names(job, both.topology));
    const auto make = [&](const engine::LatticeView* lattice) {
        if (job.ways.arrays_are_shared)
            return frusta_by_kernels(job, names, std::make_shared<const engine::FrustaSources>(job, *both.topology),
                                     mesh, lattice);
        engine::KeptValues kept;
        engine::HomedTopology topology(kept, engine::MadeOf::triangles, engine::UsedBy::grids, nullptr, nullptr);
        topology.set(both.topology,
                     std::make_shared<const engine::DeviceTopology>(device_topology(job, names, *both.topology)));
        engine::MadeFrusta made =
            frusta_by_kernels(job, topology,
                              std::make_shared<const device::BufferPool::Lease>(
                                  job.upload(ordered_positions(*both.topology, mesh.vertices()), "vertices")),
                              mesh.box(), lattice);
        if (made.faces.part) made.frusta = std::make_shared<const engine::Frusta>(made.faces.read(job));
        return made;
    };
    const engine::LatticeView lattice = engine::lattice_of(grid);
    // Without records, too: the same. The device has the slopes that the host has.
    const engine::MadeFrusta again = make(nullptr);
    engine::MadeFrusta made = make(&lattice);
    const auto slopes = read<engine::FaceSlopes>(context, *made.faces.slopes, both.topology->order.size());
    BOOST_TEST(are_same(made.frusta->slopes, slopes));
    BOOST_TEST(are_same(again.frusta->slopes, slopes));
    BOOST_TEST(again.frusta->sites.size() == made.frusta->sites.size());
    both.kernels = *made.frusta;
    both.left = made.left;
    both.is_of_gpu = programs.mesh_lanes() == 1;
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
            const engine::FaceSlopes &kernel = both.kernels.slopes[face], &host = both.host.slopes[face];
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
    const auto are_equal = [](const engine::SiteFrustum& a, const engine::SiteFrustum& b) {
        return a.face == b.face && a.normal == b.normal && a.slopes.above == b.slopes.above &&
               a.slopes.below == b.slopes.below;
    };
    BOOST_TEST(std::ranges::equal(both.kernels.sites, both.host.sites, are_equal));
    // Edges that are flat up to rounding make a saddle for exact predicates alone.
    BOOST_TEST(both.kernels.saddle_vertices <= both.host.saddle_vertices);
    BOOST_TEST(both.kernels.saddle_vertices >= both.host.saddle_vertices * 4 / 5);
    BOOST_TEST(both.kernels.boxes == both.host.boxes);
}

/// Without every n-th triangle.
Mesh with_holes(const Mesh& mesh, std::size_t n) {
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < mesh.triangles().size(); ++i)
        if (i % n != 0) triangles.push_back(mesh.triangles()[i]);
    return {mesh.vertices(), std::move(triangles), mesh.name() + " with holes"};
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

/// A tetrahedron with a vertex in the middle of its upper edge, which is lifted by so much; with `axis` upward.
Mesh roof(double lift, std::size_t axis) {
    std::vector<Vec3> vertices{{-1, 0, 0}, {1, 0, 0}, {0, 0, lift}, {0, 1, -1}, {0, -1, -1}};
    for (Vec3& vertex : vertices) std::rotate(vertex.begin(), vertex.begin() + 2 - axis, vertex.end());
    return {std::move(vertices), {{0, 2, 3}, {2, 1, 3}, {2, 0, 4}, {1, 2, 4}, {0, 3, 4}, {1, 4, 3}}, "roof"};
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
            Grid grid = Grid::around(mesh, 48, Band::symmetric(0.05 * mesh.box().longest_side()));
            grid.spacing[1] *= 0.7;
            const BothFrusta both = both_frusta(mesh, grid);
            sites += both.kernels.sites.size();
            check_slopes(both);
            check_sites(both);
        }
    }
    BOOST_TEST(sites > 0U);
}

BOOST_AUTO_TEST_CASE(a_gpu_leaves_vertices_with_a_gap_alone_to_the_host) {
    const std::array meshes{subdivided(make_shape("cube"), 4, 0, 1),        // most edges are exactly flat
                            subdivided(make_shape("torus"), 1, 1e-15, 4),   // up to rounding
                            subdivided(make_shape("sphere2"), 3, 0.02, 2),  // saddles at every other vertex
                            subdivided(make_shape("sphere2"), 3, 0.1, 5),   // with gaps
                            shifted(subdivided(make_shape("sphere2"), 3, 0.1, 5), {1e9, 0, 0}),
                            with_holes(subdivided(make_shape("sphere2"), 3, 0.02, 6), 13)};
    std::size_t sites = 0;
    for (const Mesh& mesh : meshes) {
        BOOST_TEST_CONTEXT(mesh.name() << ", " << mesh.triangles().size() << " triangles") {
            const BothFrusta both =
                both_frusta(mesh, Grid::around(mesh, 48, Band::symmetric(0.05 * mesh.box().longest_side())));
            std::vector<std::uint32_t> gaps;
            for (const auto& site : both.host.sites)
                if (!engine::is_filling(site)) gaps.push_back(site.vertex);
            BOOST_TEST(std::ranges::includes(both.left.vertices, gaps));
            if (both.is_of_gpu) {
                BOOST_TEST(both.left.vertices == gaps, boost::test_tools::per_element());
                BOOST_TEST(both.left.gaps == gaps, boost::test_tools::per_element());  // without a test by the host
            }
            sites += gaps.size();
        }
    }
    BOOST_TEST(sites > 0U);
}

// Two edges of the vertex in the middle are flat up to rounding, and the two others convex.
BOOST_AUTO_TEST_CASE(exact_orientations_decide_whether_a_vertex_is_a_saddle) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double lift : {0x1p-60, 0.0, -0x1p-60}) {
            const Mesh mesh = roof(lift, axis);
            const BothFrusta both = both_frusta(mesh, Grid::around(mesh, 16, Band::symmetric(0.2)));
            BOOST_TEST_CONTEXT("lifted by " << lift << ", axis " << axis) {
                BOOST_TEST((both.host.saddle_vertices > 0) == (lift < 0));
                BOOST_TEST((both.kernels.saddle_vertices > 0) == (lift < 0));
            }
        }
}
