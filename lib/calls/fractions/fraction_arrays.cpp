// Fractions of cells in the caller's arrays.
#include <clsdf/device.hpp>
#include <clsdf/error.hpp>
#include <clsdf/fractions.hpp>

#include "calls/fractions/fraction_calls.hpp"
#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/vectors.hpp"
#include "cutting/fraction_checks.hpp"
#include "device/context.hpp"
#include "device/opencl.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/row_arrays.hpp"
#include "targets/target_overlap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

using targets::ResultArray;

/// Arrays may be in buffers, too, which are mapped; without it, on the host alone.
using Memory = std::optional<targets::MappedMemory>;

ResultArray result_array(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                         const ElementTypes& types, Memory& memory, bool are_fields) {
    if (!memory) return ResultArray::on_host(given, name, size, components, types, are_fields);
    return {given, name, size, components, types, *memory, are_fields};
}

/// The caller's arrays of one grid.
class CellArrays {
public:
    CellArrays(const FractionRequest& request, Memory& memory) : grid_(request.grid) {
        const auto array = [&](const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                               const ElementTypes& types) {
            return result_array(with_strides(given, size, components, types), name, size, components, types, memory,
                                true);
        };
        const FractionTargets& to = request.targets;
        const Index3 cells{grid_.size[0] - 1, grid_.size[1] - 1, grid_.size[2] - 1};
        types_ = array(to.types, "the array of types", cells, 1, {ElementType::uint8});
        pieces_ = array(to.pieces, "the array of pieces", cells, 1,
                        {ElementType::uint32, ElementType::int32, ElementType::uint8});
        volume_ = array(to.volume, "the array of volumes", cells, 1, real_types);
        centroid_ = array(to.centroid, "the array of centroids", cells, 3, real_types);
        area_ = array(to.area, "the array of areas", cells, 1, real_types);
        vector_area_ = array(to.vector_area, "the array of vector areas", cells, 3, real_types);
        normal_ = array(to.normal, "the array of normals", cells, 3, real_types);
        surface_centroid_ = array(to.surface_centroid, "the array of the surface's centroids", cells, 3, real_types);
        for (std::size_t d = 0; d < 3; ++d) {
            Index3 faces = cells;
            ++faces[d];
            face_fractions_[d] = array(to.face_fractions[d], face_fraction_names[d], faces, 1, real_types);
            face_centroids_[d] = array(to.face_centroids[d], face_centroid_names[d], faces, 2, real_types);
        }
    }

    void add_to(std::vector<targets::WrittenArray>& written) {
        for (const ResultArray* const one : all())
            if (one->is_given()) written.push_back(one->written());
    }
    void set_mapped(const targets::MappedMemory& memory) {
        for (ResultArray* const one : all()) one->set_mapped(memory);
    }

    void write(const Fractions& found) const {
        const auto [nx, ny, nz] = found.counts();
        for_each_index(
            nz,
            [&, nx = nx, ny = ny](std::size_t k) {
                for (std::size_t j = 0; j < ny; ++j)
                    for (std::size_t i = 0; i < nx; ++i) write_uncut(found, i, j, k);
            },
            1);
        // Neighbours write the face between them, with the same value.
        for (const CellFraction& cell : found.cells) write(cell);
    }

private:
    static constexpr std::array<const char*, 3> face_fraction_names{"the array of fractions of the faces across x",
                                                                    "the array of fractions of the faces across y",
                                                                    "the array of fractions of the faces across z"};
    static constexpr std::array<const char*, 3> face_centroid_names{"the array of centroids of the faces across x",
                                                                    "the array of centroids of the faces across y",
                                                                    "the array of centroids of the faces across z"};

    /// Packed arrays have their components side by side; with a component_stride alone the items are.
    static OutputArray with_strides(OutputArray given, const Index3& size, std::size_t components,
                                    const ElementTypes& types) {
        const ElementType type = given.type == ElementType::automatic ? *types.begin() : given.type;
        const auto width = static_cast<std::ptrdiff_t>(bytes_of(type));
        const bool has_strides = given.strides != std::array<std::ptrdiff_t, 3>{};
        if (!has_strides && components > 1) {
            const bool are_items_side_by_side = given.component_stride != 0 && given.component_stride != width;
            const std::ptrdiff_t item =
                are_items_side_by_side ? width : width * static_cast<std::ptrdiff_t>(components);
            given.strides = {item, item * size[0], item * size[0] * size[1]};
        }
        if ((has_strides || components > 1) && given.component_stride == 0) given.component_stride = width;
        return given;
    }

    static void set(const ResultArray& to, const Index3& item, std::size_t component, double value) {
        if (!to.is_given()) return;
        if (to.type() == ElementType::float64)
            to.set(item, component, value);
        else
            to.set(item, component, static_cast<float>(value));
    }
    static void set(const ResultArray& to, const Index3& item, const Vec3& values) {
        for (std::size_t d = 0; d < 3; ++d) set(to, item, d, values[d]);
    }
    void set_pieces(const Index3& item, std::uint32_t pieces) const {
        if (!pieces_.is_given()) return;
        if (pieces_.type() == ElementType::uint8)
            pieces_.set(item, 0, static_cast<std::uint8_t>(std::min(pieces, 255U)));
        else
            pieces_.set(item, 0, pieces);
    }
    void set_type(const Index3& item, CellType type) const {
        if (types_.is_given()) types_.set(item, 0, static_cast<std::uint8_t>(type));
    }
    Vec3 middle(const Index3& item, bool as_point) const {
        if (!as_point) return {};
        Vec3 point = grid_.position(item[0], item[1], item[2]);
        for (std::size_t d = 0; d < 3; ++d) point[d] += 0.5 * grid_.spacing[d];
        return point;
    }

    void write_uncut(const Fractions& found, std::size_t i, std::size_t j, std::size_t k) const {
        const bool is_full = found.is_full(i, j, k);
        const Index3 item{static_cast<std::int64_t>(i), static_cast<std::int64_t>(j), static_cast<std::int64_t>(k)};
        const double value = is_full ? 1 : 0;
        const Vec3 of_cell = middle(item, found.options.centroids_as_points);
        set_type(item, is_full ? CellType::full : CellType::empty);
        set_pieces(item, 0);
        set(volume_, item, 0, value);
        set(centroid_, item, of_cell);
        set(area_, item, 0, 0);
        set(vector_area_, item, {});
        set(normal_, item, {});
        const double none = found.options.no_surface_centroid;
        set(surface_centroid_, item, {none, none, none});
        // The low faces, and those at the end of the grid: cells that the surface meets set theirs afterwards.
        for (std::size_t d = 0; d < 3; ++d)
            for (const std::int64_t step : {0, 1}) {
                if (step == 1 && item[d] + 2 != grid_.size[d]) continue;
                Index3 face = item;
                face[d] += step;
                set(face_fractions_[d], face, 0, value);
                for (std::size_t n = 0; n < 2; ++n) set(face_centroids_[d], face, n, of_cell[n < d ? n : n + 1]);
            }
    }

    void write(const CellFraction& cell) const {
        Index3 item;
        for (std::size_t d = 0; d < 3; ++d) item[d] = cell.cell[d] - grid_.first[d];
        set_type(item, CellType::cut);
        set_pieces(item, cell.pieces);
        set(volume_, item, 0, std::clamp(cell.volume, 0.0, 1.0));
        set(centroid_, item, cell.centroid);
        set(area_, item, 0, cell.area);
        set(vector_area_, item, cell.vector_area);
        const double whole = length(cell.vector_area);
        for (std::size_t d = 0; d < 3; ++d) set(normal_, item, d, whole > 0 ? cell.vector_area[d] / whole : 0);
        set(surface_centroid_, item, cell.surface_centroid);
        for (std::size_t face = 0; face < 6; ++face) {
            Index3 at = item;
            at[face / 2] += static_cast<std::int64_t>(face % 2);
            set(face_fractions_[face / 2], at, 0, std::clamp(cell.face_fractions[face], 0.0, 1.0));
            for (std::size_t n = 0; n < 2; ++n) set(face_centroids_[face / 2], at, n, cell.face_centroids[face][n]);
        }
    }

    std::array<ResultArray*, 14> all() {
        return {&types_,
                &pieces_,
                &volume_,
                &centroid_,
                &area_,
                &vector_area_,
                &normal_,
                &surface_centroid_,
                &face_fractions_[0],
                &face_fractions_[1],
                &face_fractions_[2],
                &face_centroids_[0],
                &face_centroids_[1],
                &face_centroids_[2]};
    }

    Grid grid_;
    ResultArray types_, pieces_, volume_, centroid_, area_, vector_area_, normal_, surface_centroid_;
    std::array<ResultArray, 3> face_fractions_, face_centroids_;
};

/// The caller's arrays for the rows of a grid.
class RowArrays {
public:
    RowArrays(const FractionRows& to, const Grid& grid, Memory& memory)
        : rows_(cell_columns, to,
                [&](const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                    const ElementTypes& types) {
                    return result_array(given, name, size, components, types, memory, false);
                }) {
        const auto [nx, ny, nz] = Fractions{grid, {}, {}}.counts();
        const std::size_t cells = to.full.is_given() ? nx * ny * nz : 0;
        full_ = result_array(to.full, "the array of full cells", {static_cast<std::int64_t>(cells), 1, 1}, 1,
                             {ElementType::uint8}, memory, false);
        std::vector<targets::WrittenArray> written;
        rows_.add_to(written);
        if (full_.is_given()) written.push_back(full_.written());
        targets::refuse_overlap(written);
    }

    /// Throws Error(invalid_argument) if the rows have less room.
    void require_room(std::size_t rows) const {
        if (rows > rows_.room() && (rows_.has_rows() || !full_.is_given()))
            throw calls::too_little_room(rows, rows_.room());
    }
    void set_mapped(const targets::MappedMemory& memory) {
        rows_.set_mapped(memory);
        full_.set_mapped(memory);
    }

    void write(const Fractions& found) const {
        rows_.store(found.cells);
        const auto [nx, ny, nz] = found.counts();
        if (full_.is_given())
            for_each_index(nx * ny * nz,
                           [&](std::size_t cell) { full_.set(cell, 0, std::uint8_t{found.is_full(cell)}); });
    }

private:
    targets::RowArrays<CellColumn> rows_;
    ResultArray full_;
};

/// Calls write() while what the arrays have in buffers is mapped.
template <typename Arrays, typename Write>
void with_mapped(Memory& memory, std::span<Arrays> arrays, const CallOptions& call, const Write& write) {
    if (memory) {
        memory->map(call.wait_list);
        for (Arrays& one : arrays) one.set_mapped(*memory);
    }
    write();
    if (memory) memory->unmap();
}

void write_requests(Memory& memory, const OuterSurface& surface, std::span<const FractionRequest> requests,
                    const FractionOptions& options, const CallOptions& call) {
    std::vector<Grid> grids;
    std::vector<CellArrays> arrays;
    std::vector<targets::WrittenArray> written;
    for (const FractionRequest& request : requests) {
        request.grid.validate();
        grids.push_back(request.grid);
        arrays.emplace_back(request, memory).add_to(written);
    }
    targets::refuse_overlap(written);
    with_mapped(memory, std::span(arrays), call, [&] {
        fractions(
            surface, grids, [&](std::size_t n, Fractions& found) { arrays[n].write(found); }, options, call);
    });
}

void write_rows(Memory& memory, const OuterSurface& surface, const Grid& grid, const FractionRows& rows,
                std::size_t& count, const FractionOptions& options, const CallOptions& call) {
    count = 0;
    grid.validate();
    RowArrays arrays(rows, grid, memory);
    const Fractions found = fractions(surface, grid, options, call);
    count = found.cells.size();
    arrays.require_room(count);
    try {
        with_mapped(memory, std::span(&arrays, 1), call, [&] { arrays.write(found); });
    } catch (...) {
        count = 0;
        throw;
    }
}

}  // namespace

void fractions(const OuterSurface& surface, std::span<const FractionRequest> requests, const FractionOptions& options,
               const CallOptions& call) {
    Memory none;
    write_requests(none, surface, requests, options, call);
}

void fractions(const OuterSurface& surface, const Grid& grid, const FractionRows& rows, std::size_t& count,
               const FractionOptions& options, const CallOptions& call) {
    Memory none;
    write_rows(none, surface, grid, rows, count, options, call);
}

void fractions(const Device& device, const OuterSurface& surface, std::span<const FractionRequest> requests,
               const FractionOptions& options, const CallOptions& call) {
    Memory memory(std::in_place, device::context_of(device));
    device::guarded([&] { write_requests(memory, surface, requests, options, call); });
}

void fractions(const Device& device, const OuterSurface& surface, const Grid& grid, const FractionRows& rows,
               std::size_t& count, const FractionOptions& options, const CallOptions& call) {
    count = 0;
    cutting::check_cells(grid);
    if (calls::are_found_by_kernels(device, surface, grid, rows)) {
        try {
            with_host_memory("for the cells of the grid; give a smaller one",
                             [&] { calls::fractions_by_kernels(device, surface, grid, rows, count, options, call); });
            return;
        } catch (const Error& error) {
            // Kernels have memory for each layer in the box of a triangle, of which a slender one meets few.
            if (error.code() != ErrorCode::out_of_memory) throw;
        }
    }
    Memory memory(std::in_place, device::context_of(device));
    device::guarded([&] { write_rows(memory, surface, grid, rows, count, options, call); });
}

}  // namespace clsdf
