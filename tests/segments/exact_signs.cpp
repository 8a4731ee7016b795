// Fields with exact signs: below 0 at exactly the samples that links and crossings call inside.
#include "segments/segment_families.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/throws.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr float least = std::numeric_limits<float>::min();

/// One flag a sample, x fastest.
std::vector<bool> sides_of(const DistanceTransform& transform, const Grid& grid) {
    const SampleSides sides = transform.links(grid, stencil("D3Q15")).inside;
    std::vector<bool> inside;
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x) inside.push_back(sides.is_inside({x, y, z}));
    return inside;
}

template <typename Values>
std::vector<bool> negative(const Values& values) {
    std::vector<bool> result;
    for (const auto value : values) result.push_back(value < 0);
    return result;
}

struct Totals {
    std::size_t samples = 0, inside = 0, on_surface = 0, inside_on_surface = 0;
};

/// Whether each value is the usual one but for its sign, or the least normal float instead of 0.
void check_values(const Field& exact, const Field& usual, Totals& totals) {
    const double voxel = usual.grid.voxel();
    const bool is_symmetric = usual.band.inside == usual.band.outside;
    std::size_t wrong = 0, far = 0;
    for (std::size_t n = 0; n < usual.distance().size(); ++n) {
        const float value = exact.distance()[n], was = usual.distance()[n];
        const bool same_side = (value < 0) == std::signbit(was);
        if (is_symmetric || same_side)
            wrong += std::abs(value) != std::abs(was) && !(std::abs(was) < least && value == -least);
        far += !same_side && static_cast<double>(std::abs(was)) > 1e-6 * voxel;
        ++totals.samples;
        totals.inside += value < 0;
        totals.on_surface += was == 0;
        totals.inside_on_surface += was == 0 && value < 0;
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(far == 0U);
}

/// The other outputs are the usual ones, but for gradients, which turn with the side.
void check_outputs(const Field& exact, const Field& usual) {
    for (const OutputInfo& info : output_table()) {
        if (info.output == Output::distance || info.output == Output::gradient) continue;
        const auto one = exact.bytes(info.output), other = usual.bytes(info.output);
        BOOST_TEST(std::equal(one.begin(), one.end(), other.begin(), other.end()), info.name);
    }
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < usual.gradient().size(); ++n)
        wrong += std::abs(exact.gradient()[n]) != std::abs(usual.gradient()[n]) &&
                 !(std::isnan(exact.gradient()[n]) && std::isnan(usual.gradient()[n]));
    BOOST_TEST(wrong == 0U);
}

std::vector<Band> bands_on(const Grid& grid) {
    const double voxel = grid.voxel();
    return {Band::symmetric(2 * voxel), Band::full(), Band::signs_only(), {0, 2 * voxel}, {1.5 * voxel, 0}};
}

std::vector<Family> meshes() {
    std::vector<Family> all = families();
    const Mesh knot = tilted(make_shape("knot"));
    all.push_back({"tilted knot", knot, Grid::around(knot, 40, Band::full())});
    const Mesh box = open_box({1, 1, 1}, {7, 6, 5}, 5);
    all.push_back({"open box", box, {{0, 0, 0}, {1, 1, 1}, {9, 8, 8}, {0, 0, 0}}, SignRule::solid_angle});
    return all;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(exact_signs)

BOOST_AUTO_TEST_CASE(fields_are_below_0_at_the_samples_that_links_call_inside) {
    Totals totals;
    for (const Family& family : meshes()) BOOST_TEST_CONTEXT(family.name) {
            const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
            const std::vector<bool> inside = sides_of(transform, family.grid);
            for (const Band& band : bands_on(family.grid))
                BOOST_TEST_CONTEXT("band " << band.inside << " " << band.outside) {
                    const Field exact = transform.compute(family.grid, band.with_exact_signs());
                    BOOST_TEST((negative(exact.distance()) == inside));
                    BOOST_TEST((exact.band == band.with_exact_signs()));
                    check_values(exact, transform.compute(family.grid, band), totals);
                }
        }
    BOOST_TEST_MESSAGE(totals.samples << " samples, " << totals.inside << " inside, " << totals.on_surface
                                      << " on the surface, of which inside " << totals.inside_on_surface);
    BOOST_TEST(totals.inside_on_surface > 0U);
    BOOST_TEST(totals.inside_on_surface < totals.on_surface);
}

BOOST_AUTO_TEST_CASE(all_outputs_are_those_of_the_usual_field) {
    const OutputSet all = [] {
        OutputSet outputs = Output::distance;
        for (const OutputInfo& info : output_table()) outputs.insert(info.output);
        return outputs;
    }();
    for (const Family& family : meshes()) BOOST_TEST_CONTEXT(family.name) {
            const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
            const Band band = Band::symmetric(2 * family.grid.voxel());
            const Field exact = transform.compute(family.grid, band.with_exact_signs(), all);
            const Field usual = transform.compute(family.grid, band, all);
            Totals totals;
            check_values(exact, usual, totals);
            check_outputs(exact, usual);
            BOOST_TEST((negative(exact.distance()) == sides_of(transform, family.grid)));
        }
}

BOOST_AUTO_TEST_CASE(doubles_are_below_0_where_floats_are) {
    for (const Family& family : meshes()) BOOST_TEST_CONTEXT(family.name) {
            const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
            const std::vector<bool> inside = sides_of(transform, family.grid);
            for (const Band& band : bands_on(family.grid)) {
                std::vector<double> values(family.grid.sample_count());
                transform.compute(family.grid, band.with_exact_signs(), values);
                BOOST_TEST((negative(values) == inside));
                std::vector<float> rounded(values.begin(), values.end());
                BOOST_TEST((negative(rounded) == inside));
            }
        }
}

BOOST_AUTO_TEST_CASE(sparse_fields_have_the_values_of_dense_ones) {
    for (const Family& family : meshes()) BOOST_TEST_CONTEXT(family.name) {
            const DistanceTransform transform(test_device(), family.mesh, {.sign = family.rule});
            for (const Band& band : {Band::symmetric(family.grid.voxel()), Band{0, family.grid.voxel()}}) {
                const Field dense = transform.compute(family.grid, band.with_exact_signs());
                const SparseField sparse = transform.compute_sparse(family.grid, band.with_exact_signs());
                std::size_t n = 0, different = 0;
                for (std::int64_t z = 0; z < family.grid.size[2]; ++z)
                    for (std::int64_t y = 0; y < family.grid.size[1]; ++y)
                        for (std::int64_t x = 0; x < family.grid.size[0]; ++x) {
                            const Index3& first = family.grid.first;
                            const float value = sparse.distance_at({first[0] + x, first[1] + y, first[2] + z});
                            different += std::memcmp(&value, &dense.distance()[n++], sizeof value) != 0;
                        }
                BOOST_TEST(different == 0U);
            }
        }
}

BOOST_AUTO_TEST_CASE(parts_have_the_bytes_of_the_whole) {
    const Mesh mesh = moved(octahedron({40, 40, 40}, 36), 1, {0, 0, 0}).mesh("octahedron on samples");
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {81, 81, 81}, {0, 0, 0}};
    const Band band = Band::symmetric(2).with_exact_signs();
    const DistanceTransform transform(test_device(), mesh);
    const Field whole = transform.compute(grid, band);
    const auto part_of = [&](const Grid& part) {
        std::vector<float> values;
        for (std::int64_t z = 0; z < part.size[2]; ++z)
            for (std::int64_t y = 0; y < part.size[1]; ++y)
                for (std::int64_t x = 0; x < part.size[0]; ++x)
                    values.push_back(
                        whole.distance()[grid.offset(x + part.first[0], y + part.first[1], z + part.first[2])]);
        return bits_of(values);
    };
    const std::vector<Grid> parts{grid.part({3, 5, 7}, {20, 30, 9}), grid.part({40, 4, 36}, {41, 9, 9}),
                                  grid.part({70, 70, 70}, {8, 8, 8}), grid.part({33, 30, 3}, {9, 20, 1})};
    // Requests of two bands: they are not mixed up.
    std::vector<std::vector<float>> of_requests, usual;
    std::vector<Request> requests;
    for (const Grid& part : parts) {
        of_requests.emplace_back(part.sample_count());
        usual.emplace_back(part.sample_count());
    }
    for (std::size_t n = 0; n < parts.size(); ++n) {
        requests.push_back({parts[n], band, of_requests[n]});
        requests.push_back({parts[n], Band::symmetric(2), usual[n]});
    }
    transform.compute(requests);
    for (std::size_t n = 0; n < parts.size(); ++n) {
        BOOST_TEST((bits_of(of_requests[n]) == part_of(parts[n])));
        BOOST_TEST((bits_of(usual[n]) == bits_of(transform.compute(parts[n], Band::symmetric(2)).distance())));
        BOOST_TEST((bits_of(transform.compute(parts[n], band).distance()) == part_of(parts[n])));
    }
    const std::vector<Index3> first{{0, 0, 0}, {36, 36, 0}, {72, 40, 32}};
    std::vector<float> blocks(3 * 512);
    transform.compute(BlockSet{grid, band, {8, 8, 8}, first, blocks});
    for (std::size_t n = 0; n < first.size(); ++n)
        BOOST_TEST((bits_of(std::span(blocks).subspan(512 * n, 512)) == part_of(grid.block(first[n], {8, 8, 8}))));
    // Slabs: by little memory of the device.
    TransformStatistics unlimited;
    const Grid fine = grid.refined(2).part({0, 0, 0}, {161, 161, 161});
    const Field expected = transform.compute(fine, band, Output::distance, {}, &unlimited);
    const DistanceTransform small(test_device().limited({.memory = unlimited.device_bytes / 2}), mesh);
    TransformStatistics limited;
    const Field in_slabs = small.compute(fine, band, Output::distance, {}, &limited);
    BOOST_TEST_MESSAGE(limited.slabs << " slabs");
    BOOST_TEST((bits_of(in_slabs.distance()) == bits_of(expected.distance())));
    const Region region{{{2, 4, 6}, {24, 36, 17}}, 2, 1};
    const DistanceTransform restricted = transform.restrict_to(region);
    BOOST_TEST((bits_of(restricted.compute(parts[0], band).distance()) == part_of(parts[0])));
}

BOOST_AUTO_TEST_CASE(plans_have_the_exact_signs_of_the_present_positions) {
    const Family family = families()[2];
    DistanceTransform transform(test_device(), family.mesh);
    const Band band = Band::symmetric(2).with_exact_signs();
    const DeviceMemory memory(test_device().context(), family.grid.sample_count());
    const device::Context& context = device::context_of(test_device());
    Plan plan = transform.plan(Request{family.grid, band, memory.handle()});
    const auto check = [&] {
        enqueue(plan, nullptr).wait();
        const std::vector<std::uint32_t> bits = memory.read({context.context(), context.device()});
        BOOST_TEST((bits == bits_of(transform.compute(family.grid, band).distance())));
        std::vector<float> values;
        for (const std::uint32_t word : bits) values.push_back(std::bit_cast<float>(word));
        BOOST_TEST((negative(values) == sides_of(transform, family.grid)));
    };
    check();
    std::vector<Vec3> positions = family.mesh.vertices();
    for (Vec3& p : positions) p = {p[1] * 0.75, p[0] - 1, p[2]};
    for (Vec3& p : positions) std::swap(p[0], p[1]);
    transform.set_positions(positions);
    plan.update(transform);
    check();
    // From memory of the device.
    for (Vec3& p : positions) p[2] = 4 + (p[2] - 4) / 3;
    cl::Buffer moved(context.context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, positions.size() * sizeof(Vec3),
                     positions.data());
    const InputArray array(moved(), ElementType::float64, positions.size());
    transform.set_positions(array);
    plan.update(transform);
    check();
}

BOOST_AUTO_TEST_CASE(what_has_no_exact_signs_is_refused) {
    const Mesh mesh = make_shape("cube");
    const Grid grid = Grid::around(mesh, 10, Band::full());
    const DistanceTransform without(test_device(), mesh, {.sign = SignRule::none});
    const Band band = Band::full().with_exact_signs();
    check_throws(ErrorCode::invalid_argument, {"exact signs of cube", "no sign", "leave exact signs out"},
                 [&] { without.compute(grid, band); });
    check_throws(ErrorCode::invalid_argument, {"exact signs"}, [&] { without.plan(grid, band); });
    Grid far = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) far.first[axis] = std::int64_t{1} << 28;
    far.origin = {1e10, 1e10, 1e10};
    check_throws(ErrorCode::invalid_argument, {"exact signs", "last bit"},
                 [&] { DistanceTransform(test_device(), mesh).compute(far, band); });
}

BOOST_AUTO_TEST_SUITE_END()
