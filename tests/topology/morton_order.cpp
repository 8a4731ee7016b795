#include "support/random_meshes.hpp"
#include "topology/face_order.hpp"

#include <tbb/global_control.h>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

namespace clsdf::test {

namespace {

/// The bits of `x`, each followed by two zeros.
std::uint32_t spread(std::uint32_t x) {
    std::uint32_t bits = 0;
    for (unsigned bit = 0; bit < 10; ++bit) bits |= (x >> bit & 1) << 3 * bit;
    return bits;
}

/// Codes of centroids in the unit cube, in cells of 2^-bits.
std::vector<std::uint32_t> plain_morton_order(const Mesh& mesh, unsigned bits) {
    std::vector<std::uint32_t> codes;
    for (const Triangle& triangle : mesh.triangles()) {
        std::uint32_t code = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
            double sum = 0;
            for (const std::uint32_t vertex : triangle) sum += mesh.vertices()[vertex][axis];
            code |= spread(static_cast<std::uint32_t>(sum * (std::ldexp(1.0, static_cast<int>(bits)) / 3))) << axis;
        }
        codes.push_back(code);
    }
    std::vector<std::uint32_t> order(codes.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return codes[a] < codes[b]; });
    return order;
}

}  // namespace

// Few triangles have codes of 8 bits a coordinate, many of 10.
BOOST_AUTO_TEST_CASE(triangles_are_sorted_by_the_codes_of_their_centroids) {
    const unsigned seed = 20261121;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    std::vector<Vec3> vertices{{0, 0, 0}, {1, 1, 1}};
    const auto some = [&] { return random.index(20) / 20.0; };  // few, so that many codes are equal
    for (int n = 0; n < 5000; ++n) vertices.push_back({some(), some(), some()});
    for (const std::size_t count : {2U, 5U, 8191U, 131072U, 131073U, 200000U}) {
        std::vector<Triangle> triangles;
        for (std::size_t t = 0; t < count; ++t) {
            const auto any = [&] { return 2 + random.index(5000); };
            triangles.push_back({any(), any(), any()});
        }
        triangles[1] = {0, 0, 1};  // so that the box is the unit cube
        const Mesh mesh(vertices, triangles, "soup");
        const std::vector<std::uint32_t> expected = plain_morton_order(mesh, count <= 131072U ? 8 : 10);
        const auto order = engine::morton_order(mesh);
        BOOST_TEST(std::equal(expected.begin(), expected.end(), order.begin(), order.end()));
        tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        BOOST_TEST((engine::morton_order(mesh) == order));
    }
}

}  // namespace clsdf::test
