#include "scan/coarse_lists.hpp"

#include "coarse.h"
#include "launch/programs.hpp"
#include "plan/stages.hpp"
#include "prepare/layout_of.hpp"
#include "support/device_memory.hpp"
#include "support/float_width.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// The numbers of the polyhedra in the list of each coarse brick of the lattice.
using Lists = std::map<Index3, std::vector<cl_uint>>;

/// The input of the lists, and the lists.
struct Coarse {
    Layout layout;
    std::vector<Polyhedron> polyhedra;
    std::map<Index3, double> bounds;  ///< of each brick of the part
    Lists lists;
    std::size_t passes = 0;
    std::size_t peak = 0;  ///< bytes on the device
};

std::size_t place_of_cap(const Layout& layout, const Index3& brick) {
    std::array<std::int64_t, 3> group{};
    for (int axis = 0; axis < 3; ++axis)
        group[static_cast<std::size_t>(axis)] =
            (brick[static_cast<std::size_t>(axis)] >> 2) - first_coarse_group(layout, axis);
    const std::int64_t number = (group[2] * coarse_groups(layout, 1) + group[1]) * coarse_groups(layout, 0) + group[0];
    return static_cast<std::size_t>(number * CLSDF_COARSE_GROUP + (brick[2] & 3) * 16 + (brick[1] & 3) * 4 +
                                    (brick[0] & 3));
}

Coarse coarse_of(const Device& device, const Mesh& mesh, const Grid& grid, const Band& band, KernelBody body) {
    device::Context& context = device::context_of(device);
    const scan::Programs programs(context, body);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    Coarse found{scan::layout_of(grid, band, SignRule::nonzero), {}, {}, {}};
    const Layout& layout = found.layout;
    transform::Stages stages(context, pool, mesh);
    const transform::Inputs inputs = stages.inputs(grid, layout, SignRule::none);
    const scan::PreparedMesh& prepared = *inputs.records;
    found.polyhedra = read<Polyhedron>(context, *prepared.polyhedra, prepared.record_count);
    const scan::ShortLaunches launches(context, {});
    const scan::CoarseLists coarse = scan::make_coarse_lists({.context = context,
                                                              .programs = programs,
                                                              .pool = pool,
                                                              .layout = layout,
                                                              .mesh = prepared,
                                                              .launches = launches,
                                                              .selection = inputs.selection,
                                                              .points = inputs.points});
    found.passes = coarse.passes;
    found.peak = pool->peak();
    const std::size_t bricks = scan::coarse_brick_count(layout);
    const auto starts = read<cl_uint>(context, *coarse.starts, bricks * coarse.parts + 1);
    const auto entries = read<cl_uint>(context, *coarse.entries, coarse.pairs);
    const auto bounds = read<float>(context, *coarse.bounds, coarse.bounds.bytes() / sizeof(float));
    std::size_t number = 0;
    for (int z = 0; z < layout.coarse_bricks[2]; ++z)
        for (int y = 0; y < layout.coarse_bricks[1]; ++y)
            for (int x = 0; x < layout.coarse_bricks[0]; ++x, ++number) {
                const Index3 brick{x + layout.coarse_first[0], y + layout.coarse_first[1], z + layout.coarse_first[2]};
                found.bounds[brick] = static_cast<double>(bounds[place_of_cap(layout, brick)]);
                found.lists[brick] = {entries.begin() + starts[number * coarse.parts],
                                      entries.begin() + starts[(number + 1) * coarse.parts]};
            }
    return found;
}

/// A polyhedron without its number, which differs in a small part: it has only the records near it.
Triangle name_of(const Polyhedron& record) {
    return {record.triangle, std::bit_cast<cl_uint>(record.base[0]), std::bit_cast<cl_uint>(record.foot[0])};
}

/// A polyhedron and its triangle as polyhedron.h states them, in double, without slack.
class PlainPolyhedron {
public:
    explicit PlainPolyhedron(const Polyhedron& polyhedron) : p_(polyhedron) {}

    /// Whether the sample lies within, and its triangle within the bound.
    bool holds(const Index3& sample, double bound) const {
        const auto i = static_cast<double>(sample[0] - p_.origin_x), j = static_cast<double>(sample[1] - p_.origin_y),
                   k = static_cast<double>(sample[2] - p_.origin_z);
        std::array<double, 3> at{};
        for (std::size_t n = 0; n < 3; ++n)
            at[n] = i * p_.exact_gradient_x[n] + j * p_.exact_gradient_y[n] + k * p_.exact_gradient_z[n] +
                    p_.exact_constant_at_origin[n];
        const auto [x, y, z] = at;
        if (std::abs(z) > bound || x > right_ + bound || -x > left_ + bound) return false;
        const std::array<double, 3> outward{
            -y, p_.exact_normal_along[CLSDF_HALF_RIGHT] * (x - right_) + p_.exact_normal_across[CLSDF_HALF_RIGHT] * y,
            p_.exact_normal_along[CLSDF_HALF_LEFT] * (-x - left_) + p_.exact_normal_across[CLSDF_HALF_LEFT] * y};
        for (std::size_t edge = 0; edge < 3; ++edge) {
            const double width =
                std::max(static_cast<double>(p_.slope_above[edge]) * z, static_cast<double>(p_.slope_below[edge]) * -z);
            if (outward[edge] > std::min(width, bound)) return false;
        }
        if (*std::max_element(outward.begin(), outward.end()) <= 0) return true;
        const std::array<double, 2> apex{0, p_.exact_altitude}, right{right_, 0}, left{-left_, 0};
        const double in_plane = std::min(
            {to_segment({x, y}, left, right), to_segment({x, y}, right, apex), to_segment({x, y}, apex, left)});
        return std::hypot(z, in_plane) <= bound;
    }

private:
    static double to_segment(const std::array<double, 2>& p, const std::array<double, 2>& a,
                             const std::array<double, 2>& b) {
        const double along_x = b[0] - a[0], along_y = b[1] - a[1];
        const double length = along_x * along_x + along_y * along_y;
        const double t =
            length == 0 ? 0 : std::clamp(((p[0] - a[0]) * along_x + (p[1] - a[1]) * along_y) / length, 0.0, 1.0);
        return std::hypot(p[0] - a[0] - t * along_x, p[1] - a[1] - t * along_y);
    }

    const Polyhedron& p_;
    double right_ = p_.exact_base[CLSDF_HALF_RIGHT];
    double left_ = p_.exact_base[CLSDF_HALF_LEFT];
};

/// The polyhedra that hold samples of a brick and are not in its list. On each axis every second sample, from the first
/// or the second on.
std::vector<cl_uint> missing_in(const Coarse& coarse, const Index3& brick, Random& random) {
    const std::vector<cl_uint>& list = coarse.lists.at(brick);
    const double bound = coarse.bounds.at(brick);
    Index3 first{};
    for (std::size_t axis = 0; axis < 3; ++axis) first[axis] = brick[axis] * CLSDF_COARSE + random.index(2);
    const auto is_missing = [&](const PlainPolyhedron& polyhedron) {
        for (std::int64_t z = 0; z < CLSDF_COARSE; z += 2)
            for (std::int64_t y = 0; y < CLSDF_COARSE; y += 2)
                for (std::int64_t x = 0; x < CLSDF_COARSE; x += 2)
                    if (polyhedron.holds({first[0] + x, first[1] + y, first[2] + z}, bound)) return true;
        return false;
    };
    std::vector<cl_uint> missing;
    for (cl_uint n = 0; n < coarse.polyhedra.size(); ++n)
        if (!std::binary_search(list.begin(), list.end(), n) && is_missing(PlainPolyhedron(coarse.polyhedra[n])))
            missing.push_back(n);
    return missing;
}

/// Whether a brick's list in a part of the lattice is that of the whole, but for polyhedra that hold none of the part's
/// samples.
bool is_list_of_part(const Coarse& part, const Coarse& whole, const Index3& brick) {
    const std::vector<cl_uint>& of_part = part.lists.at(brick);
    auto next = of_part.begin();
    for (const cl_uint number : whole.lists.at(brick)) {
        const Polyhedron& record = whole.polyhedra[number];
        if (next != of_part.end() && name_of(part.polyhedra[*next]) == name_of(record)) {
            ++next;
            continue;
        }
        const PlainPolyhedron polyhedron(record);
        const double bound = whole.bounds.at(brick);
        Index3 first{}, end{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t begin = part.layout.first[axis];
            first[axis] = std::max(begin, brick[axis] * CLSDF_COARSE);
            end[axis] = std::min(begin + part.layout.size[axis], (brick[axis] + 1) * CLSDF_COARSE);
        }
        for (std::int64_t z = first[2]; z < end[2]; ++z)
            for (std::int64_t y = first[1]; y < end[1]; ++y)
                for (std::int64_t x = first[0]; x < end[0]; ++x)
                    if (polyhedron.holds({x, y, z}, bound)) return false;
    }
    return next == of_part.end();
}

}  // namespace

// Also if a part is so thin that it has fewer coarse bricks on an axis than a group, and begins anywhere among them.
BOOST_AUTO_TEST_CASE(coarse_lists_are_ascending_and_have_in_a_part_what_holds_its_samples) {
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
            const Coarse of_whole = coarse_of(Device::strongest(), mesh, grid, band, body);
            std::size_t pairs = 0;
            for (const auto& [brick, list] : of_whole.lists) {
                BOOST_TEST((std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end()));
                pairs += list.size();
            }
            BOOST_TEST(pairs > mesh.triangles().size());
            for (const auto& [offset, part_size] : parts)
                BOOST_TEST_CONTEXT("part of " << part_size[0] << " x " << part_size[1] << " x " << part_size[2]
                                              << " from (" << offset[0] << ", " << offset[1] << ", " << offset[2]
                                              << "), width " << band.outside) {
                    const Coarse part = coarse_of(Device::strongest(), mesh, grid.part(offset, part_size), band, body);
                    for (const auto& [brick, list] : part.lists)
                        BOOST_TEST(is_list_of_part(part, of_whole, brick),
                                   "brick " << brick[0] << ", " << brick[1] << ", " << brick[2]);
                }
        }
}

// Compared with brute force. A list may contain polyhedra without a sample. The size of the buffer of pairs is guessed.
// If there is no memory for the guess, they are counted first, and the buffer has just their size.
BOOST_AUTO_TEST_CASE(coarse_lists_are_the_same_where_there_is_no_memory_for_a_guess) {
    const Mesh mesh = make_shape("sphere6");
    // Few polyhedra overlap this part, so the guess is far too large.
    const Grid grid = grid_around(mesh, 40, 4).part({0, 0, 0}, {16, 16, 16});
    const auto coarse_with = [&](const DeviceLimits& limits) {
        return coarse_of(Device::strongest().limited(limits), mesh, grid, Band::full(), KernelBody::by_vector);
    };
    const Coarse unlimited = coarse_with({});
    BOOST_TEST(unlimited.passes == 1U);
    // The guess is five touches a polyhedron or more, of which one is enough here.
    const std::size_t memory = unlimited.peak - 4 * sizeof(ClusterPair) * unlimited.polyhedra.size();
    const Coarse limited = coarse_with({.memory = memory});
    BOOST_TEST(limited.passes == 2U);
    BOOST_TEST(limited.peak <= memory);
    BOOST_CHECK(limited.lists == unlimited.lists);
}

BOOST_AUTO_TEST_CASE(every_polyhedron_that_holds_a_sample_is_in_the_list_of_its_coarse_brick) {
    for (const unsigned seed : {1U, 2U, 3U, 4U}) {
        Random random(seed);
        const Mesh mesh = seed % 2 == 0 ? random_sphere(random, "sphere2", 0.2) : random_soup(random, 60, 80);
        Grid grid;
        grid.size = {70, 90, 80};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            grid.spacing[axis] = random.uniform(1, 1.5) * mesh.box().longest_side() / 64;
            grid.first[axis] = static_cast<std::int64_t>(random.index(200)) - 100;
            grid.origin[axis] = mesh.box().lower[axis] - grid.spacing[axis] * static_cast<double>(grid.first[axis] + 7);
        }
        for (const Band& band : {Band::symmetric(3 * grid.voxel()), Band::symmetric(12 * grid.voxel()), Band::full()})
            for (const auto& [body, width] :
                 {std::pair(KernelBody::by_vector, 16U), std::pair(KernelBody::by_vector, 8U),
                  std::pair(KernelBody::by_group, 1U)}) {
                const Coarse coarse = coarse_of(with_float_width(width), mesh, grid, band, body);
                BOOST_TEST_CONTEXT("seed " << seed << ", half width " << band.outside / grid.voxel() << " voxels, "
                                           << width << " lanes")
                for (const auto& [brick, list] : coarse.lists)
                    BOOST_TEST(missing_in(coarse, brick, random).empty(),
                               "brick " << brick[0] << ", " << brick[1] << ", " << brick[2]);
            }
    }
}
