#include "handles.hpp"
#include "values.hpp"

#include <clsdf/sparse.hpp>

#include <algorithm>

using namespace clsdf;
using c::given;
using c::grid_of;
using c::guarded;

namespace {

Index3 triple(const std::int64_t* values, const char* name) {
    given(values, name);
    return {values[0], values[1], values[2]};
}

}  // namespace

clsdf_status clsdf_box_longest_side(const clsdf_box* box, double* side) {
    return guarded([&] { given(side, "side") = c::box_of(box).longest_side(); });
}

clsdf_status clsdf_length_resolve(const clsdf_length* length, double voxel, double extent, double* resolved) {
    return guarded([&] { given(resolved, "resolved") = c::length_of(length, "length").resolve(voxel, extent); });
}

clsdf_status clsdf_band_validate(const clsdf_band* band) {
    return guarded([&] { c::band_of(band).validate(); });
}

clsdf_status clsdf_grid_around_box(const clsdf_box* box, const clsdf_grid_options* options, clsdf_grid* grid) {
    return guarded([&] {
        const clsdf_grid_options from = c::read_struct(options, CLSDF_GRID_OPTIONS_INIT, "clsdf_grid_options");
        GridOptions to;
        to.resolution = from.resolution;
        const Vec3 spacing{from.spacing[0], from.spacing[1], from.spacing[2]};
        if (spacing != Vec3{}) to.spacing = spacing;
        to.margin = c::length_of(&from.margin, "clsdf_grid_options.margin");
        to.cubic = c::flag(from.cubic, "clsdf_grid_options.cubic");
        to.cell_centred = c::flag(from.cell_centred, "clsdf_grid_options.cell_centred");
        given(grid, "grid") = c::as_c(Grid::around(c::box_of(box), to));
    });
}

clsdf_status clsdf_grid_between(const clsdf_box* box, const clsdf_grid_division* division, clsdf_grid* grid) {
    return guarded([&] {
        const clsdf_grid_division from = c::read_struct(division, CLSDF_GRID_DIVISION_INIT, "clsdf_grid_division");
        const auto counts = [](const std::int64_t* each) {
            const Index3 numbers{each[0], each[1], each[2]};
            return numbers == Index3{} ? AxisCounts() : AxisCounts(numbers);
        };
        GridDivision to;
        to.samples = counts(from.samples);
        to.cells = counts(from.cells);
        to.cell_centred = c::flag(from.cell_centred, "clsdf_grid_division.cell_centred");
        c::check_reserved(from.reserved, "clsdf_grid_division");
        const Box corners = c::box_of(box);
        given(grid, "grid") = c::as_c(Grid::between(corners.lower, corners.upper, to));
    });
}

clsdf_status clsdf_grid_around_mesh(const clsdf_mesh* mesh, std::int64_t resolution, const clsdf_band* band,
                                    clsdf_grid* grid) {
    return guarded(
        [&] { given(grid, "grid") = c::as_c(Grid::around(c::of(mesh).mesh, resolution, c::band_of(band))); });
}

clsdf_status clsdf_grid_part(const clsdf_grid* grid, const std::int64_t* offset, const std::int64_t* size,
                             clsdf_grid* result) {
    return guarded(
        [&] { given(result, "result") = c::as_c(grid_of(grid).part(triple(offset, "offset"), triple(size, "size"))); });
}

clsdf_status clsdf_grid_block(const clsdf_grid* grid, const std::int64_t* first, const std::int64_t* size,
                              clsdf_grid* result) {
    return guarded(
        [&] { given(result, "result") = c::as_c(grid_of(grid).block(triple(first, "first"), triple(size, "size"))); });
}

clsdf_status clsdf_grid_grown(const clsdf_grid* grid, std::int64_t samples, clsdf_grid* result) {
    return guarded([&] { given(result, "result") = c::as_c(grid_of(grid).grown(samples)); });
}

clsdf_status clsdf_grid_refined(const clsdf_grid* grid, std::int64_t ratio, clsdf_grid* result) {
    return guarded([&] { given(result, "result") = c::as_c(grid_of(grid).refined(ratio)); });
}

clsdf_status clsdf_grid_refined_cells(const clsdf_grid* grid, std::int64_t ratio, clsdf_grid* result) {
    return guarded([&] { given(result, "result") = c::as_c(grid_of(grid).refined_cells(ratio)); });
}

clsdf_status clsdf_grid_in_whole_bricks(const clsdf_grid* grid, clsdf_grid* result) {
    return guarded([&] { given(result, "result") = c::as_c(in_whole_bricks(grid_of(grid))); });
}

clsdf_status clsdf_grid_cell_centred(const clsdf_grid* grid, clsdf_grid* result) {
    return guarded([&] { given(result, "result") = c::as_c(grid_of(grid).cell_centred()); });
}

clsdf_status clsdf_grid_position(const clsdf_grid* grid, std::int64_t i, std::int64_t j, std::int64_t k,
                                 double* position) {
    return guarded([&] {
        const Vec3 found = grid_of(grid).position(i, j, k);
        std::copy(found.begin(), found.end(), &given(position, "position"));
    });
}

clsdf_status clsdf_grid_box(const clsdf_grid* grid, clsdf_box* box) {
    return guarded([&] { given(box, "box") = c::as_c(grid_of(grid).box()); });
}

clsdf_status clsdf_grid_voxel(const clsdf_grid* grid, double* voxel) {
    return guarded([&] { given(voxel, "voxel") = grid_of(grid).voxel(); });
}

clsdf_status clsdf_grid_sample_count(const clsdf_grid* grid, std::int64_t* count) {
    return guarded([&] {
        const Grid of = grid_of(grid);
        of.validate();
        given(count, "count") = static_cast<std::int64_t>(of.sample_count());
    });
}

clsdf_status clsdf_grid_validate(const clsdf_grid* grid) {
    return guarded([&] { grid_of(grid).validate(); });
}
