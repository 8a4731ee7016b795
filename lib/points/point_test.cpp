#include "points/point_query.hpp"
#include "transform/known_field.hpp"
#include "transform/self_test.hpp"
#include "transform/stages.hpp"

#include <fmt/format.h>

namespace clsdf::points {

namespace {

/// The known field's grid has the same samples at points, whose distances have no limit.
std::optional<std::string> run_point_test(const Device& device, const transform::Programs& programs, bool are_scanned) {
    transform::KnownFieldKind kind;
    kind.wide = true;
    const transform::KnownField known(kind);
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    transform::Stages stages(context, pool, known.mesh());
    const Grid& grid = known.grid();
    std::vector<Vec3> points;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) points.push_back(grid.position(i, j, k));
    std::vector<float> distance(points.size());
    std::vector<std::uint32_t> triangle(points.size());
    transform::HostArrays arrays;
    arrays.distance = {true, false, reinterpret_cast<std::byte*>(distance.data())};
    arrays.triangle = {true, false, reinterpret_cast<std::byte*>(triangle.data())};
    PointInputs inputs;
    inputs.mesh = stages.points();
    inputs.sign = SignRule::nonzero;
    if (are_scanned) {
        inputs.scanned = stages.scanned_mesh(programs.point_scan(context));
        inputs.sides = stages.face_sides(inputs.sign, true);
    }
    inputs.sites = stages.sites(are_scanned);
    query_points(context, programs, pool, inputs, points, known.band().outside, arrays, {});
    return known.difference(distance, triangle);
}

}  // namespace

bool ensure_points_tested(const Device& device, const transform::Programs& programs, bool are_scanned,
                          const device::BuildWatch& watch) {
    device::Context& context = device::context_of(device);
    const char* const body = programs.body == KernelBody::by_group ? "by_group" : "by_vector";
    transform::TestSubject subject{fmt::format("{} {}points", body, are_scanned ? "many " : ""), {}};
    device::guarded([&] {
        subject.programs.push_back(programs.points(context, watch));
        if (are_scanned) subject.programs.push_back(programs.point_scan(context, watch));
    });
    return transform::test_once(device, subject, watch, [&] { return run_point_test(device, programs, are_scanned); });
}

}  // namespace clsdf::points
