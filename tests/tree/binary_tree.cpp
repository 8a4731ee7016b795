// The tree that GPUs search for points, against a plain one of the host, and the bound of its distances in float.
#include "support/counted_searches.hpp"
#include "support/deep_mesh.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"

#include "device/buffer_pool.hpp"
#include "launch/programs.hpp"
#include "spread_bits.h"
#include "tree/binary_tree.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A mesh and its tree on the device.
class Made {
public:
    explicit Made(const Mesh& mesh, std::shared_ptr<const engine::MeshTopology> topology = nullptr,
                  std::shared_ptr<const engine::DividedFaces> before = nullptr)
        : context(device::context_of(test_device())),
          points(engine::make_point_mesh(tools(), mesh, {},
                                         topology ? topology : std::make_shared<const engine::MeshTopology>(mesh))),
          tree(engine::fitted_tree(tools(), points, *device::uploaded(context, pool, points.positions, "positions"),
                                   *device::uploaded(context, pool, points.topology->faces.triangles, "triangles"),
                                   std::move(before))),
          order(read<std::uint32_t>(context, *tree.divided->order, points.face_count())),
          nodes(read<BinaryNode>(context, *tree.nodes, tree.divided->node_count)),
          places(read<NodePlaces>(context, *tree.divided->nodes, tree.divided->node_count)),
          faces(read<PlacedFace>(context, *tree.faces, points.face_count())) {}

    engine::DeviceTools tools() const { return {context, pool, programs}; }

    device::Context& context;
    std::shared_ptr<device::BufferPool> pool =
        std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    engine::Programs programs{device::context_of(test_device()), KernelBody::by_group};
    engine::PointMesh points;
    engine::FittedTree tree;
    std::vector<std::uint32_t> order;
    std::vector<BinaryNode> nodes;
    std::vector<NodePlaces> places;
    std::vector<PlacedFace> faces;
};

std::uint32_t face_at(const Made& made, std::size_t place) {
    return made.order[place] & CLSDF_PLACE_FACE;
}

/// (code, place) of each place, in the specification's words.
std::vector<std::uint64_t> keys_of(const Made& made) {
    const std::size_t count = made.points.face_count();
    const double cells = count <= std::size_t{1} << 17 ? 256 : 1024;
    const double side = made.points.box.longest_side() / made.points.lattice.unit;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> coded;
    for (std::uint32_t face = 0; face < count; ++face) {
        const auto corners = made.points.corners(face);
        std::uint32_t code = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            double sum = made.points.in_units(corners[0])[axis];
            sum += made.points.in_units(corners[1])[axis];
            sum += made.points.in_units(corners[2])[axis];
            const double cell = side > 0 ? sum * (cells / (3 * side)) : 0;
            code |= spread_bits(static_cast<std::uint32_t>(std::clamp(cell, 0.0, cells - 1))) << axis;
        }
        coded.emplace_back(code, face);
    }
    std::ranges::sort(coded);
    std::vector<std::uint64_t> keys;
    for (std::uint32_t place = 0; place < count; ++place) {
        BOOST_TEST(face_at(made, place) == coded[place].second);
        keys.push_back(std::uint64_t{coded[place].first} << 32 | place);
    }
    return keys;
}

float below(double x) {
    const auto rounded = static_cast<float>(x);
    return rounded - std::abs(rounded) * 0x1p-23F;
}

FaceBox box_of(const Made& made, std::size_t begin, std::size_t end) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    FaceBox box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (std::size_t place = begin; place < end; ++place)
        for (const Vec3& corner : made.points.corners(face_at(made, place)))
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double x = made.points.in_units(corner)[axis];
                box.lower[axis] = std::min(box.lower[axis], below(x));
                box.upper[axis] = std::max(box.upper[axis], -below(-x));
            }
    return box;
}

/// The plane of the boxes' lattice, by trial.
std::uint32_t plane_below(float x) {
    auto plane = static_cast<std::uint32_t>(static_cast<double>(x) / 0.0079);
    while (static_cast<double>(plane + 1) * 129 / 16384 <= static_cast<double>(x)) ++plane;
    return plane;
}
std::uint32_t plane_above(float x) {
    const std::uint32_t plane = plane_below(x);
    return static_cast<double>(plane) * 129 / 16384 < static_cast<double>(x) ? plane + 1 : plane;
}

/// Goes down the tree beside a plain one.
class Comparison {
public:
    explicit Comparison(const Made& made) : made_(made) {}

    /// Checks a node, or a leaf, of the places [begin, end) and all below. has_keys: the faces were divided at these
    /// positions.
    void check(std::uint32_t link, std::size_t begin, std::size_t end, unsigned depth,
               const std::vector<std::uint64_t>* keys) {
        const BinaryTree& tree = made_.tree.divided->tree;
        if (end - begin <= CLSDF_LEAF_PLACES) {
            wrong += link != (tree.leaf | begin);
            for (std::size_t place = begin; place < end; ++place) {
                wrong += made_.order[place] >> CLSDF_PLACE_SHIFT != end - 1 - place;
                wrong += std::signbit(made_.faces[place].right) != (place + 1 < end);
            }
            return;
        }
        if (link >= made_.nodes.size()) {
            ++wrong;
            return;
        }
        ++visited;
        deepest = std::max(deepest, depth + 1);
        const NodePlaces& places = made_.places[link];
        std::size_t middle = places.middle;
        if (keys != nullptr) {
            const std::uint64_t bit = std::bit_floor((*keys)[begin] ^ (*keys)[end - 1]);
            middle = begin;
            while (((*keys)[middle] & bit) == 0) ++middle;
        }
        wrong += places.first != begin || places.middle != middle || places.end != end;
        if (wrong > 0) return;
        const std::array<std::size_t, 3> ends{begin, middle, end};
        for (std::size_t child = 0; child < 2; ++child) {
            const FaceBox box = box_of(made_, ends[child], ends[child + 1]);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                wrong += made_.nodes[link].box[child][axis] !=
                         (plane_below(box.lower[axis]) | plane_above(box.upper[axis]) << 16);
                area += static_cast<double>(box.upper[axis] - box.lower[axis]) *
                        static_cast<double>(box.upper[(axis + 1) % 3] - box.lower[(axis + 1) % 3]);
            }
            wrong += made_.nodes[link].link[child] != places.link[child];
            check(places.link[child], ends[child], ends[child + 1], depth + 1, keys);
        }
    }

    std::size_t wrong = 0, visited = 0;
    unsigned deepest = 0;
    double area = 0;

private:
    const Made& made_;
};

void check_tree(const Made& made, bool is_divided_here = true) {
    std::vector<std::uint64_t> keys;
    if (is_divided_here) keys = keys_of(made);
    Comparison comparison(made);
    const std::size_t count = made.points.face_count();
    comparison.check(made.tree.divided->tree.root, 0, count, 0, is_divided_here ? &keys : nullptr);
    BOOST_TEST(comparison.wrong == 0U);
    BOOST_TEST(comparison.visited == made.nodes.size());
    BOOST_TEST(comparison.deepest == made.tree.divided->depth);
    const double side = made.points.box.longest_side() / made.points.lattice.unit;
    if (side > 0) BOOST_TEST(made.tree.area == comparison.area / (side * side), boost::test_tools::tolerance(1e-4));
}

/// The first faces of a mesh.
Mesh first_faces(const Mesh& mesh, std::size_t count) {
    return {mesh.vertices(),
            {mesh.triangles().begin(), mesh.triangles().begin() + static_cast<std::ptrdiff_t>(count)},
            "first faces"};
}

Mesh repeated(const Mesh& mesh, std::size_t times) {
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < times; ++i)
        triangles.insert(triangles.end(), mesh.triangles().begin(), mesh.triangles().end());
    return {mesh.vertices(), std::move(triangles), mesh.name() + " repeated"};
}

std::vector<Mesh> meshes(Random& random) {
    std::vector<Mesh> all{cube(1),
                          cone(300),
                          fins(),
                          sliver(),
                          tilted(make_shape("noisy")),
                          repeated(cube(1), 7),
                          random_slivers(random, 60),
                          random_soup(random, 40, 333),
                          shifted(make_shape("torus"), {1e9, -1e9, 3}),
                          scaled(make_shape("knot"), 1e-30),
                          deep_mesh(4096)};
    for (const std::size_t count : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U, 9U}) all.push_back(first_faces(cube(1), count));
    return all;
}

Mesh twisted(const Mesh& mesh, double turns) {
    return moved(mesh, [&](const Vec3& p) {
        const double angle = turns * p[2], c = std::cos(angle), s = std::sin(angle);
        return Vec3{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    });
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_tree_is_that_of_a_plain_division) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Mesh& mesh : meshes(random))
        BOOST_TEST_CONTEXT("seed " << seed << ", " << mesh.name() << ", " << mesh.triangles().size() << " triangles")
    check_tree(Made(mesh));
}

BOOST_AUTO_TEST_CASE(many_equal_codes_make_a_tree_deeper_than_the_small_stack) {
    BOOST_TEST(Made(make_shape("noisy")).tree.divided->depth <= engine::stack_entries);
    const unsigned depth = Made(deep_mesh(4096)).tree.divided->depth;
    BOOST_TEST(depth > engine::stack_entries);
    BOOST_TEST(depth <= engine::deep_stack_entries);
}

BOOST_AUTO_TEST_CASE(moved_vertices_change_the_boxes_alone_until_these_are_twice_as_large) {
    const Mesh mesh = tilted(make_shape("noisy"));
    const auto topology = std::make_shared<const engine::MeshTopology>(mesh);
    const Made first(mesh, topology);
    const Made bent(twisted(mesh, 0.3), topology, first.tree.divided);
    BOOST_TEST(bent.tree.divided == first.tree.divided);
    BOOST_TEST(bent.tree.area != first.tree.area);
    check_tree(bent, false);
    const Made larger(scaled(mesh, 37), topology, first.tree.divided);
    BOOST_TEST(larger.tree.divided == first.tree.divided);
    Random random(7);
    const Made mixed(moved(mesh, [&](const Vec3&) { return random.point(-1, 1); }), topology, first.tree.divided);
    BOOST_TEST(mixed.tree.divided != first.tree.divided);
    check_tree(mixed);
}

// Points on, beside and far from vertices, edges and faces, which lie in all halves and beyond all edges.
BOOST_AUTO_TEST_CASE(distances_in_float_are_within_their_bound) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    double greatest = 0;
    for (const Mesh& mesh : meshes(random)) {
        const Made made(mesh);
        const auto polyhedra = read<Polyhedron>(made.context, **made.points.polyhedra, made.points.face_count());
        const auto faces = read<PointFace>(made.context, **made.points.faces, made.points.face_count());
        std::size_t wrong = 0;
        for (int i = 0; i < 40000; ++i) {
            const std::size_t place = random.index(made.points.face_count());
            const std::uint32_t face = face_at(made, place);
            const auto corners = made.points.corners(face);
            const double first = i % 4 == 0 ? i / 4 % 2 : random.uniform(0, 1),
                         second = i % 3 == 0 ? 0 : (1 - first) * random.uniform(0, 1);
            Vec3 p{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                p[axis] = first * made.points.in_units(corners[0])[axis] +
                          second * made.points.in_units(corners[1])[axis] +
                          (1 - first - second) * made.points.in_units(corners[2])[axis];
            if (i % 5 != 0) p = along(p, std::pow(10, random.uniform(-12, i % 7 == 0 ? 13 : 3)), random.direction());
            const one_lane::double3 at{p[0], p[1], p[2]};
            const auto d = one_lane::placed_distance(&made.faces[place], one_lane::tree_point(at));
            const double exact =
                std::sqrt(one_lane::face_distance(&polyhedra[face], &faces[face], at.x, at.y, at.z).squared);
            const double off = std::abs(static_cast<double>(d.distance) - exact) / static_cast<double>(d.error);
            wrong += !(off <= 1);
            greatest = std::max(greatest, off);
        }
        BOOST_TEST(wrong == 0U, "seed " << seed << ", " << mesh.name() << ": " << wrong);
    }
    BOOST_TEST_MESSAGE("at most " << greatest << " of the bound");
    BOOST_TEST(greatest > 0.01);
}

// No box is farther than its faces.
BOOST_AUTO_TEST_CASE(boxes_are_never_farther_than_their_faces) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Mesh& mesh : meshes(random)) {
        const Made made(mesh);
        if (made.nodes.empty()) continue;
        const auto polyhedra = read<Polyhedron>(made.context, **made.points.polyhedra, made.points.face_count());
        const auto faces = read<PointFace>(made.context, **made.points.faces, made.points.face_count());
        std::size_t wrong = 0;
        for (int i = 0; i < 4000; ++i) {
            const std::size_t number = random.index(made.nodes.size());
            const BinaryNode& node = made.nodes[number];
            const NodePlaces& places = made.places[number];
            const std::size_t child = random.index(2);
            const std::uint32_t begin = child == 0 ? places.first : places.middle;
            const std::uint32_t end = child == 0 ? places.middle : places.end;
            const std::uint32_t face = face_at(made, begin + random.index(end - begin));
            const Vec3 corner = made.points.in_units(made.points.corners(face)[random.index(3)]);
            const Vec3 p = along(corner, std::pow(10, random.uniform(-9, i % 7 == 0 ? 13 : 3)), random.direction());
            const one_lane::double3 at{p[0], p[1], p[2]};
            const auto& [x, y, z] = node.box[child];
            const double squared =
                static_cast<double>(one_lane::squared_to_box(LOWER_OF(x), LOWER_OF(y), LOWER_OF(z), UPPER_OF(x),
                                                             UPPER_OF(y), UPPER_OF(z), one_lane::tree_point(at)));
            wrong += !(squared <= one_lane::face_distance(&polyhedra[face], &faces[face], at.x, at.y, at.z).squared);
        }
        BOOST_TEST(wrong == 0U, "seed " << seed << ", " << mesh.name() << ": " << wrong);
    }
}
