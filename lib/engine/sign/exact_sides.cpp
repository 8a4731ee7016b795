#include "sign/exact_sides.hpp"

#include "launch/commands.hpp"
#include "launch/programs.hpp"

#include <utility>

namespace clsdf::engine {

namespace {

// The first room for crossings, per row on average.
constexpr std::size_t records_per_row = 4;

constexpr double seconds_per_row = 1e-6;  // of sides; an upper estimate for one core

}  // namespace

std::optional<ExactSides> find_exact_sides(const DeviceTools& tools, const ShortLaunches& launches,
                                           const CrossedMesh& mesh, SignRule rule, const SampleRows& samples,
                                           const cl::Buffer& at) {
    const cl::Program program = tools.programs.exact_sides;
    const std::size_t rows = static_cast<std::size_t>(samples.size[1]) * static_cast<std::size_t>(samples.size[2]);
    device::LentKernel kernel = tools.kernel(program, "exact_crossings");
    const cl_uint arguments = set_arguments(kernel, 0, samples, *mesh.faces->triangles, **mesh.positions, at);
    RowRecords records({.tools = tools,
                        .launches = launches,
                        .program = program,
                        .kernel = std::move(kernel),
                        .arguments = arguments,
                        .rows = rows,
                        .triangles = mesh.faces->face_count,
                        .first_room = records_per_row * rows,
                        .purpose = "crossings of rows of samples",
                        .listed = "crossings of the surface by rows of samples",
                        .seconds_per_row = 2e-7,
                        .seconds_per_triangle = 5e-6});
    records.begin();
    std::optional<ExactSides> sides(std::in_place);
    sides->crossings = records.finish();
    if (records.totals().inexact != 0) return std::nullopt;
    sides->bits = tools.pool->lease(rows * samples.words * sizeof(cl_uint), "sides of samples");
    device::LentKernel sweep = tools.kernel(program, "exact_rows");
    const cl_uint of_all = set_arguments(sweep, 0, samples, cl_int{rule == SignRule::parity ? 1 : 0},
                                         *sides->crossings.starts, *sides->crossings.keys, *sides->bits);
    launches.over_items(sweep, rows, seconds_per_row,
                        [&](cl_uint begin, cl_uint end) { set_arguments(sweep, of_all, begin, end); });
    return sides;
}

}  // namespace clsdf::engine
