#include <clsdf/error.hpp>
#include <clsdf/fractions.hpp>

#include "core/floating_point.hpp"
#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "core/vectors.hpp"
#include "cutting/cancellation.hpp"
#include "cutting/cut_slab.hpp"
#include "cutting/fraction_checks.hpp"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

using cutting::Cancellation;
using cutting::CellRange;
using cutting::CutPoint;
using cutting::Slab;

double place_of(const Vec3& vertex, const Grid& lattice, std::size_t axis) {
    return (vertex[axis] - lattice.origin[axis]) / lattice.spacing[axis];
}

/// Slabs one after another, counted on the lattice.
struct SlabRange {
    std::int64_t first, end;
};

/// Ranges that neither meet nor touch, ascending.
std::vector<SlabRange> united(std::vector<SlabRange> ranges) {
    std::ranges::sort(ranges, {}, &SlabRange::first);
    std::vector<SlabRange> apart;
    for (const SlabRange& range : ranges)
        if (!apart.empty() && range.first <= apart.back().end)
            apart.back().end = std::max(apart.back().end, range.end);
        else
            apart.push_back(range);
    return apart;
}

/// A mesh as the grids of one lattice see it.
class OnLattice {
public:
    /// ranges: the slabs that are asked for, as united() has them.
    OnLattice(const Mesh& mesh, const Grid& lattice, const std::vector<SlabRange>& ranges,
              const FractionOptions& options)
        : origin_(lattice.origin),
          spacing_(lattice.spacing),
          triangles_(mesh.triangles()),
          positions_(mesh.vertices().size()) {
        const DefaultFloatingPoint as_kernels;
        for (const SlabRange& range : ranges)
            parts_.push_back({range.first, std::vector<std::vector<std::uint32_t>>(
                                               static_cast<std::size_t>(range.end - range.first))});
        const CutGrid cut = cutting::cut_grid_of(lattice, options);
        std::atomic<bool> are_near = true;
        for_each_index(positions_.size(), [&](std::size_t v) {
            for (int axis = 0; axis < 3; ++axis)
                if (!cutting::place_coordinate(&cut, axis, mesh.vertices()[v][static_cast<std::size_t>(axis)],
                                               &positions_[v]))
                    are_near = false;
        });
        if (!are_near) cutting::refuse_far_vertices(mesh, lattice);
        for (std::uint32_t face = 0; face < triangles_.size(); ++face) {
            const auto& [a, b, c] = triangles_[face];
            const std::array corners{positions_[a], positions_[b], positions_[c]};
            auto [least, most] = cutting::cells_of_corners(corners, 2);
            if (least == most && cutting::moved_axis(corners.data(), cut.walls) == 2) --least;
            for (Part& part : parts_) {
                const CellRange range =
                    cutting::cells_between(least, most, part.first, static_cast<std::int64_t>(part.faces.size()));
                for (std::int64_t k = range.low; k <= range.high; ++k)
                    part.faces[static_cast<std::size_t>(k)].push_back(face);
            }
        }
    }

    bool is_of(const Grid& grid) const { return grid.origin == origin_ && grid.spacing == spacing_; }
    std::span<const Triangle> triangles() const { return triangles_; }
    /// In cells of the lattice.
    std::span<const CutPoint> positions() const { return positions_; }
    /// Those with a part in a slab, counted on the lattice.
    std::span<const std::uint32_t> faces(std::int64_t slab) const {
        const auto part = std::prev(std::ranges::upper_bound(parts_, slab, {}, &Part::first));
        return part->faces[static_cast<std::size_t>(slab - part->first)];
    }

private:
    struct Part {
        std::int64_t first;
        std::vector<std::vector<std::uint32_t>> faces;  ///< of each slab
    };

    Vec3 origin_, spacing_;
    std::span<const Triangle> triangles_;
    std::vector<CutPoint> positions_;
    std::vector<Part> parts_;
};

/// The lattices of grids, each prepared when it is used first. Those of all levels stay.
class Lattices {
public:
    Lattices(const Mesh& mesh, std::span<const Grid> grids, const FractionOptions& options)
        : mesh_(mesh), grids_(grids), options_(options) {}

    const OnLattice& of(const Grid& grid) {
        for (const std::unique_ptr<OnLattice>& known : known_)
            if (known->is_of(grid)) return *known;
        std::vector<SlabRange> ranges;
        for (const Grid& other : grids_)
            if (other.origin == grid.origin && other.spacing == grid.spacing)
                ranges.push_back({other.first[2], other.first[2] + other.size[2] - 1});
        return *known_.emplace_back(std::make_unique<OnLattice>(mesh_, grid, united(std::move(ranges)), options_));
    }

private:
    const Mesh& mesh_;
    std::span<const Grid> grids_;
    const FractionOptions& options_;
    std::vector<std::unique_ptr<OnLattice>> known_;
};

/// Grids that are computed at once.
class Batch {
public:
    Batch(std::span<const Grid> grids, Lattices& lattices, const FractionOptions& options) : options_(options) {
        for (const Grid& grid : grids) {
            results_.push_back({grid, {}, {}, options});
            const auto [nx, ny, nz] = results_.back().counts();
            if (static_cast<double>(nx) * static_cast<double>(ny) * static_cast<double>(nz) > 0x1p62)
                throw std::bad_alloc();
            results_.back().full.assign((nx * ny * nz + 7) / 8, 0);  // now, so that too many cells are refused now
            const OnLattice& lattice = lattices.of(grid);
            for (std::int64_t k = 0; k < grid.size[2] - 1; ++k) slabs_.push_back({&grid, &lattice, k, {}, {}});
            widest_ = std::max(widest_, nx * ny);
        }
    }

    /// progress(fraction) is called on the caller's thread.
    void run(const Cancellation& cancellation, const auto& progress) {
        const DefaultFloatingPoint as_kernels;
        tbb::enumerable_thread_specific<Worker> workers;
        std::atomic<std::size_t> done = 0;
        for_each_index(
            slabs_.size(),
            [&](std::size_t n) {
                cancellation.check();
                run(slabs_[n], workers.local());
                ++done;
                if (cancellation.is_callers_thread())
                    progress(static_cast<double>(done) / static_cast<double>(slabs_.size()));
            },
            slabs_per_task());
        std::size_t at = 0;
        for (Fractions& result : results_) {
            const std::size_t nz = result.counts()[2];
            finish(result, std::span(slabs_).subspan(at, nz));
            at += nz;
        }
    }
    std::vector<Fractions>& results() { return results_; }

private:
    struct OneSlab {
        const Grid* grid;
        const OnLattice* lattice;
        std::int64_t k;
        std::vector<CellFraction> rows;
        std::vector<std::uint8_t> full;  ///< bytes of Fractions::full, with this slab's bits alone
    };
    /// The memory of a thread.
    struct Worker {
        const Grid* grid = nullptr;
        std::unique_ptr<Slab> slab;
        std::vector<CellFraction> rows;
        std::vector<CellType> types;
    };

    /// So many that the workers of all tasks have bytes_of_workers together, or there is one worker. A loop divides
    /// ranges until they have so many slabs or fewer, so a task has more than half as many.
    std::size_t slabs_per_task() const {
        constexpr std::size_t bytes_of_cell = 64;  // of a layer: sums of its lines, and types
        constexpr std::size_t bytes_of_workers = std::size_t{4} << 30;
        const std::size_t workers = std::max<std::size_t>(1, bytes_of_workers / bytes_of_cell / widest_);
        return std::max<std::size_t>(1, 2 * slabs_.size() / workers);
    }

    void run(OneSlab& one, Worker& worker) const {
        const Grid& grid = *one.grid;
        const auto cells = static_cast<std::size_t>((grid.size[0] - 1) * (grid.size[1] - 1));
        // In whole bytes of bits; cells of other slabs are never full.
        const std::size_t shift = static_cast<std::size_t>(one.k) * cells % 8;
        one.full.resize((shift + cells + 7) / 8);
        worker.types.assign(8 * one.full.size(), CellType::cut);
        const std::span<CellType> types = std::span(worker.types).subspan(shift, cells);
        if (const auto faces = one.lattice->faces(grid.first[2] + one.k); faces.empty()) {
            std::ranges::fill(types, CellType::empty);
        } else {
            if (worker.grid != one.grid)
                worker.slab = std::make_unique<Slab>(one.lattice->triangles(), one.lattice->positions(),
                                                     cutting::cut_grid_of(grid, options_));
            worker.grid = one.grid;
            worker.rows.clear();
            worker.slab->run(one.k, faces, worker.rows, types);
            one.rows = worker.rows;
        }
        const CellType wanted = options_.part == CellPart::solid ? CellType::full : CellType::empty;
        for (std::size_t byte = 0; byte < one.full.size(); ++byte) {
            unsigned bits = 0;
            for (std::size_t bit = 0; bit < 8; ++bit) bits |= (worker.types[8 * byte + bit] == wanted ? 1U : 0U) << bit;
            one.full[byte] = static_cast<std::uint8_t>(bits);
        }
    }

    static void finish(Fractions& result, std::span<OneSlab> slabs) {
        const auto [nx, ny, nz] = result.counts();
        std::size_t count = 0;
        for (const OneSlab& slab : slabs) count += slab.rows.size();
        result.cells.reserve(count);
        for (std::size_t k = 0; k < slabs.size(); ++k) {
            const std::size_t first = k * nx * ny / 8;
            for (std::size_t byte = 0; byte < slabs[k].full.size(); ++byte)
                result.full[first + byte] = static_cast<std::uint8_t>(result.full[first + byte] | slabs[k].full[byte]);
            result.cells.insert(result.cells.end(), slabs[k].rows.begin(), slabs[k].rows.end());
            slabs[k] = {};
        }
    }

    const FractionOptions& options_;
    std::vector<Fractions> results_;
    std::vector<OneSlab> slabs_;
    std::size_t widest_ = 1;  // cells of a layer
};

/// Cells of grids that are in memory together, if there are several.
constexpr std::int64_t batch_cells = std::int64_t{1} << 21;
/// Layers of cells of a slab, at least: they are what cores share.
constexpr std::int64_t least_layers = 16;

}  // namespace

void cutting::check_cells(const Grid& grid) {
    grid.validate();
    constexpr std::int64_t farthest = std::numeric_limits<std::int32_t>::max();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (grid.size[axis] < 2)
            refuse("the grid has {} sample along {}, so no cells: give two samples or more on each axis",
                   grid.size[axis], "xyz"[axis]);
        const std::int64_t first = grid.first[axis], last = first + grid.size[axis] - 1;
        if (first < -farthest || last > farthest)
            refuse(
                "the grid's samples {} to {} along {} lie beyond 2^31 - 1 samples from its origin, "
                "and cells are numbered from there; move the origin nearer",
                first, last, "xyz"[axis]);
    }
}

void cutting::check_options(const FractionOptions& options) {
    if (!(options.snap >= 0 && options.snap <= 1e-3)) refuse("snap is {}; it is in cells, 0 to 0.001", options.snap);
}

void cutting::refuse_far_vertices(const Mesh& mesh, const Grid& grid) {
    for (std::size_t v = 0;; ++v)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (const double cells = place_of(mesh.vertices()[v], grid, axis);
                !(std::abs(cells) <= CLSDF_FARTHEST_VERTEX))
                refuse(
                    "{}: vertex {} lies {:g} cells along {} from the grid's origin, and beyond 2^53 a cell "
                    "has no place within; choose a larger spacing, or an origin near the mesh",
                    mesh.name(), v, cells, "xyz"[axis]);
}

FractionOptions FractionOptions::of(std::string_view convention) {
    FractionOptions options;
    if (convention == "plain") return options;
    if (convention == "vtk") {
        options.centroids_as_points = true;
        return options;
    }
    if (convention != "amrex" && convention != "chombo")
        refuse("there is no convention '{}': choose plain, amrex, chombo or vtk", convention);
    options.part = CellPart::fluid;
    options.walls = WallCell::fluid;
    options.areas_of_faces = true;
    options.normals_into_solid = convention == "amrex";
    options.no_surface_centroid = convention == "amrex" ? -1 : 0;
    return options;
}

FractionOptions FractionOptions::of(std::string_view convention, CellPart part) {
    FractionOptions options = of(convention);
    if (part == options.part) return options;
    options.part = part;
    if (options.walls == WallCell::fluid) {
        options.walls = WallCell::solid;
        options.normals_into_solid = !options.normals_into_solid;
    }
    return options;
}

namespace {

/// Triangles that run across planes between cells, and of which snap leaves nothing: what they bound is flattened.
void warn_of_flattened(const Mesh& mesh, const Grid& grid, double snap, const CallOptions& call) {
    if (!call.log || snap == 0) return;
    std::size_t count = 0, first = 0;
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face) {
        std::array<Vec3, 3> corners;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t axis = 0; axis < 3; ++axis)
                corners[i][axis] = place_of(mesh.vertices()[mesh.triangles()[face][i]], grid, axis);
        const Vec3 normal = cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double plane = std::nearbyint(corners[0][axis]);
            const auto is_snapped = [&](const Vec3& corner) { return std::abs(corner[axis] - plane) <= snap; };
            if (!std::ranges::all_of(corners, is_snapped) || !(std::abs(normal[axis]) < 0.5 * length(normal))) continue;
            if (count++ == 0) first = face;
            break;
        }
    }
    if (count > 0)
        call.log(
            fmt::format("{}: snap {:g} moves all corners of {} (the first is triangle {}) onto one plane between "
                        "cells: the wall there "
                        "is thinner than that, and is flattened; choose a smaller snap",
                        mesh.name(), snap, count == 1 ? "1 triangle" : fmt::format("{} triangles", count), first));
}

}  // namespace

void fractions(const OuterSurface& surface, std::span<const Grid> grids, const FractionSink& sink,
               const FractionOptions& options, const CallOptions& call) {
    cutting::check_options(options);
    for (const Grid& grid : grids) cutting::check_cells(grid);
    if (!sink) refuse("fractions of cells need a sink, and it is empty");
    with_host_memory("for the cells of the grids; take parts of them, one after the other", [&] {
        const Cancellation cancellation(call.should_stop, "the search for cut cells");
        if (!grids.empty()) warn_of_flattened(surface.mesh, grids.front(), options.snap, call);
        Lattices lattices(surface.mesh, grids, options);
        for (std::size_t begin = 0, end = 0; begin < grids.size(); begin = end) {
            double cells = 0;  // of any size
            do {
                const auto [nx, ny, nz] = grids[end].size;
                cells += static_cast<double>(nx - 1) * static_cast<double>(ny - 1) * static_cast<double>(nz - 1);
                ++end;
            } while (end < grids.size() && cells < batch_cells);
            Batch batch(grids.subspan(begin, end - begin), lattices, options);
            const auto tell = [&](double fraction) {
                const double grids_done = static_cast<double>(begin) + fraction * static_cast<double>(end - begin);
                if (call.progress) call.progress({.fraction = grids_done / static_cast<double>(grids.size())});
            };
            batch.run(cancellation, tell);
            for (std::size_t n = begin; n < end; ++n) {
                try {
                    sink(n, batch.results()[n - begin]);
                } catch (const std::bad_alloc&) {
                    throw Error(ErrorCode::out_of_memory, "the function that takes fractions of cells got no memory");
                }
                batch.results()[n - begin] = {};
            }
            tell(1);
        }
    });
}

void fraction_slabs(const OuterSurface& surface, const Grid& grid, const FractionSink& sink,
                    const FractionOptions& options, const CallOptions& call) {
    cutting::check_cells(grid);
    const auto [nx, ny, nz] = grid.size;
    const std::int64_t layers = std::max(least_layers, batch_cells / (nx - 1) / (ny - 1));
    std::vector<Grid> slabs;
    for (std::int64_t k = 0; k < nz - 1; k += layers)
        slabs.push_back(grid.part({0, 0, k}, {nx, ny, std::min(layers, nz - 1 - k) + 1}));
    fractions(surface, slabs, sink, options, call);
}

std::size_t count_fractions(const OuterSurface& surface, const Grid& grid, const FractionOptions& options,
                            const CallOptions& call) {
    std::size_t count = 0;
    fraction_slabs(
        surface, grid, [&](std::size_t, const Fractions& found) { count += found.cells.size(); }, options, call);
    return count;
}

Fractions fractions(const OuterSurface& surface, const Grid& grid, const FractionOptions& options,
                    const CallOptions& call) {
    Fractions result;
    fractions(
        surface, std::span(&grid, 1), [&](std::size_t, Fractions& found) { result = std::move(found); }, options, call);
    return result;
}

Fractions fractions(const Mesh& mesh, const Grid& grid, const FractionOptions& options, SignRule sign,
                    const CallOptions& call) {
    cutting::check_options(options);
    cutting::check_cells(grid);
    return fractions(outer(mesh, sign, call), grid, options, call);
}

Fractions fractions(const Mesh& mesh, const Grid& grid, SignRule sign, const CallOptions& call) {
    return fractions(mesh, grid, FractionOptions{}, sign, call);
}

}  // namespace clsdf
