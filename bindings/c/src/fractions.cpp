#include "handles.hpp"
#include "values.hpp"

#include <clsdf/fractions.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

using namespace clsdf;
using c::Call;
using c::guarded;
using c::of;

namespace {

// A row of C is one of C++.
static_assert(sizeof(clsdf_cell_fraction) == sizeof(CellFraction) &&
              offsetof(clsdf_cell_fraction, pieces) == offsetof(CellFraction, pieces) &&
              offsetof(clsdf_cell_fraction, volume) == offsetof(CellFraction, volume) &&
              offsetof(clsdf_cell_fraction, centroid) == offsetof(CellFraction, centroid) &&
              offsetof(clsdf_cell_fraction, area) == offsetof(CellFraction, area) &&
              offsetof(clsdf_cell_fraction, vector_area) == offsetof(CellFraction, vector_area) &&
              offsetof(clsdf_cell_fraction, surface_centroid) == offsetof(CellFraction, surface_centroid) &&
              offsetof(clsdf_cell_fraction, face_fractions) == offsetof(CellFraction, face_fractions) &&
              offsetof(clsdf_cell_fraction, face_centroids) == offsetof(CellFraction, face_centroids));

FractionOptions options_of(const clsdf_fraction_options* options) {
    const clsdf_fraction_options from = c::read_struct(options, CLSDF_FRACTION_OPTIONS_INIT, "clsdf_fraction_options");
    c::check_reserved(from.reserved, "clsdf_fraction_options");
    FractionOptions result;
    result.part = c::enumerator(from.part, CellPart::fluid, "clsdf_fraction_options.part");
    result.walls = c::enumerator(from.walls, WallCell::fluid, "clsdf_fraction_options.walls");
    result.normals_into_solid = c::flag(from.normals_into_solid, "clsdf_fraction_options.normals_into_solid");
    result.areas_of_faces = c::flag(from.areas_of_faces, "clsdf_fraction_options.areas_of_faces");
    result.centroids_as_points = c::flag(from.centroids_as_points, "clsdf_fraction_options.centroids_as_points");
    result.snap = from.snap;
    result.no_surface_centroid = from.no_surface_centroid;
    return result;
}

/// The surface of a mesh of clsdf_mesh_outer(), or that of another one.
OuterSurface surface_of(const clsdf_mesh& mesh, std::int32_t sign, const CallOptions& call) {
    const SignRule rule = c::sign_rule_of(sign, "sign");
    if (!mesh.given_faces.empty()) return OuterSurface{mesh.mesh, mesh.given_faces};
    return outer(mesh.mesh, rule, call);
}

/// Cells of a grid, or the faces across an axis.
std::size_t items_of(const Grid& grid, std::size_t across) {
    std::size_t items = 1;
    for (std::size_t d = 0; d < 3; ++d) {
        const std::int64_t samples = grid.size[d];
        items *= samples < 1 ? 0 : static_cast<std::size_t>(d == across ? samples : samples - 1);
    }
    return items;
}

FractionRequest request_of(const clsdf_fraction_request& from) {
    FractionRequest request;
    request.grid = c::grid_of(&from.grid);
    const auto count = [&](std::size_t across) { return items_of(request.grid, across); };
    const std::size_t cells = count(3);
    const auto of_cells = [&](const clsdf_array& array, const char* name) {
        return c::items_of(array, cells, "cells", name);
    };
    FractionTargets& to = request.targets;
    to.types = of_cells(from.types, "clsdf_fraction_request.types.count");
    to.pieces = of_cells(from.pieces, "clsdf_fraction_request.pieces.count");
    to.volume = of_cells(from.volume, "clsdf_fraction_request.volume.count");
    to.centroid = of_cells(from.centroid, "clsdf_fraction_request.centroid.count");
    to.area = of_cells(from.area, "clsdf_fraction_request.area.count");
    to.vector_area = of_cells(from.vector_area, "clsdf_fraction_request.vector_area.count");
    to.normal = of_cells(from.normal, "clsdf_fraction_request.normal.count");
    to.surface_centroid = of_cells(from.surface_centroid, "clsdf_fraction_request.surface_centroid.count");
    for (std::size_t d = 0; d < 3; ++d) {
        to.face_fractions[d] =
            c::items_of(from.face_fractions[d], count(d), "faces", "clsdf_fraction_request.face_fractions.count");
        to.face_centroids[d] =
            c::items_of(from.face_centroids[d], count(d), "faces", "clsdf_fraction_request.face_centroids.count");
    }
    return request;
}

FractionRows rows_of(const clsdf_fraction_row_arrays& from, const Grid& grid) {
    FractionRows to;
    to.room = c::count_of(from.room, "clsdf_fraction_row_arrays.room");
    const auto rows = [&](const clsdf_array& array, const char* name) {
        return c::items_of(array, to.room, "rows", name);
    };
    to.cells = rows(from.cells, "clsdf_fraction_row_arrays.cells.count");
    to.pieces = rows(from.pieces, "clsdf_fraction_row_arrays.pieces.count");
    to.volume = rows(from.volume, "clsdf_fraction_row_arrays.volume.count");
    to.centroid = rows(from.centroid, "clsdf_fraction_row_arrays.centroid.count");
    to.area = rows(from.area, "clsdf_fraction_row_arrays.area.count");
    to.vector_area = rows(from.vector_area, "clsdf_fraction_row_arrays.vector_area.count");
    to.surface_centroid = rows(from.surface_centroid, "clsdf_fraction_row_arrays.surface_centroid.count");
    to.face_fractions = rows(from.face_fractions, "clsdf_fraction_row_arrays.face_fractions.count");
    to.face_centroids = rows(from.face_centroids, "clsdf_fraction_row_arrays.face_centroids.count");
    to.full = c::items_of(from.full, items_of(grid, 3), "cells", "clsdf_fraction_row_arrays.full.count");
    return to;
}

const clsdf_cell_fraction* as_c(const std::vector<CellFraction>& cells) {
    return reinterpret_cast<const clsdf_cell_fraction*>(cells.data());
}

}  // namespace

clsdf_status clsdf_fraction_convention(const char* name, clsdf_fraction_options* options) {
    return guarded([&] {
        const FractionOptions found = FractionOptions::of(c::text_of(name, "name"));
        // The members that the caller's version has.
        clsdf_fraction_options result = c::read_given(options, CLSDF_FRACTION_OPTIONS_INIT, "clsdf_fraction_options");
        const std::size_t size = options->struct_size;
        result.part = static_cast<std::int32_t>(found.part);
        result.walls = static_cast<std::int32_t>(found.walls);
        result.normals_into_solid = found.normals_into_solid ? 1 : 0;
        result.areas_of_faces = found.areas_of_faces ? 1 : 0;
        result.centroids_as_points = found.centroids_as_points ? 1 : 0;
        result.snap = found.snap;
        result.no_surface_centroid = found.no_surface_centroid;
        std::memcpy(options, &result, std::min(size, sizeof result));
        options->struct_size = size;
    });
}

clsdf_status clsdf_fractions(const clsdf_mesh* mesh, std::int32_t sign, const clsdf_grid* grids,
                             std::int64_t grid_count, const clsdf_fraction_options* options,
                             clsdf_fraction_function sink, void* user, const clsdf_call_options* call) {
    return guarded([&] {
        const clsdf_mesh& self = of(mesh);
        const Call caller(call);
        const FractionOptions own = options_of(options);
        c::elements(grids, grid_count, "grids");
        if (sink == nullptr) throw c::misuse("sink is null; give a function");
        std::vector<Grid> all;
        for (std::int64_t n = 0; n < grid_count; ++n) all.push_back(c::grid_of(grids + n));
        fractions(
            surface_of(self, sign, caller), all,
            [&](std::size_t n, Fractions& found) {
                clsdf_set_last_error(nullptr);
                c::check_callback(sink(user, static_cast<std::int64_t>(n), as_c(found.cells),
                                       static_cast<std::int64_t>(found.cells.size()), found.full.data()),
                                  "sink");
            },
            own, caller);
    });
}

clsdf_status clsdf_fraction_arrays(const clsdf_mesh* mesh, std::int32_t sign, const clsdf_fraction_request* requests,
                                   std::int64_t request_count, const clsdf_fraction_options* options,
                                   const clsdf_call_options* call) {
    return guarded([&] {
        const clsdf_mesh& self = of(mesh);
        const Call caller(call);
        const FractionOptions own = options_of(options);
        c::elements(requests, request_count, "requests");
        std::vector<FractionRequest> all;
        const auto count = static_cast<std::size_t>(request_count);
        for (std::size_t n = 0; n < count; ++n)
            all.push_back(c::for_request(n, count, [&] { return request_of(requests[n]); }));
        fractions(surface_of(self, sign, caller), all, own, caller);
    });
}

clsdf_status clsdf_fraction_slabs(const clsdf_mesh* mesh, std::int32_t sign, const clsdf_grid* grid,
                                  const clsdf_fraction_options* options, clsdf_fraction_slab_function sink, void* user,
                                  const clsdf_call_options* call) {
    return guarded([&] {
        const clsdf_mesh& self = of(mesh);
        const Call caller(call);
        const FractionOptions own = options_of(options);
        const Grid whole = c::grid_of(grid);
        if (sink == nullptr) throw c::misuse("sink is null; give a function");
        fraction_slabs(
            surface_of(self, sign, caller), whole,
            [&](std::size_t, const Fractions& found) {
                clsdf_set_last_error(nullptr);
                const clsdf_grid part = c::as_c(found.grid);
                c::check_callback(sink(user, &part, as_c(found.cells), static_cast<std::int64_t>(found.cells.size()),
                                       found.full.data()),
                                  "sink");
            },
            own, caller);
    });
}

clsdf_status clsdf_count_fractions(const clsdf_mesh* mesh, std::int32_t sign, const clsdf_grid* grid,
                                   const clsdf_fraction_options* options, const clsdf_call_options* call,
                                   std::int64_t* count) {
    return guarded([&] {
        const clsdf_mesh& self = of(mesh);
        const Call caller(call);
        const FractionOptions own = options_of(options);
        const Grid whole = c::grid_of(grid);
        std::int64_t& told = c::given(count, "count");
        told = static_cast<std::int64_t>(count_fractions(surface_of(self, sign, caller), whole, own, caller));
    });
}

clsdf_status clsdf_fraction_rows(const clsdf_mesh* mesh, std::int32_t sign, const clsdf_device* device,
                                 const clsdf_grid* grid, const clsdf_fraction_row_arrays* arrays,
                                 const clsdf_fraction_options* options, const clsdf_call_options* call,
                                 std::int64_t* count) {
    return guarded([&] {
        const clsdf_mesh& self = of(mesh);
        const Call caller(call);
        const FractionOptions own = options_of(options);
        const Grid whole = c::grid_of(grid);
        const FractionRows rows = rows_of(c::given(arrays, "arrays"), whole);
        std::int64_t& told = c::given(count, "count");
        told = 0;
        std::size_t found = 0;
        try {
            const OuterSurface surface = surface_of(self, sign, caller);
            if (device == nullptr)
                fractions(surface, whole, rows, found, own, caller);
            else
                fractions(of(device).device, surface, whole, rows, found, own, caller);
        } catch (...) {
            told = static_cast<std::int64_t>(found);
            throw;
        }
        told = static_cast<std::int64_t>(found);
    });
}
