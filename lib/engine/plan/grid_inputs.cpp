#include "plan/grid_inputs.hpp"

#include "lists/coarse_lists.hpp"
#include "mesh/box_index.hpp"
#include "plan/field_method.hpp"
#include "plan/near_parts.hpp"

#include <optional>

namespace clsdf::engine {

namespace {

/// One grid, and what its lattice keeps.
class GridInputs {
public:
    GridInputs(KeptMesh& kept_mesh, const Job& job)
        : kept_mesh_(kept_mesh), job_(job), lattice_(kept_mesh.lattice(job.grid)) {}

    void set_records(bool lone, Inputs& inputs) {
        if (kept_mesh_.has_selection()) keep_records();  // with the frusta, by the same launch
        const auto near = near_bricks();
        // All cores pack all of them, and one those of a small grid.
        if (is_own(near, lone, lattice_.records != nullptr, lattice_.faces_packed,
                   [&] { return 0.25 * count(kept_ranges().face_count); })) {
            inputs.records = std::make_shared<const PreparedMesh>(kept_mesh_.records(job_.lattice, *near));
            if (!lone) lattice_.faces_packed += near->face_count;
        } else {
            keep_records();
            inputs.records = lattice_.records;
            select_records(near, inputs);
        }
        if (has_uniform_bounds(job_.layout)) return;
        if (!lattice_.points)
            lattice_.points = std::make_shared<const SurfacePoints>(kept_mesh_.points_of(job_.lattice));
        inputs.points = lattice_.points;
    }

    void set_sweep_mesh(bool lone, Inputs& inputs) {
        const auto near = near_rows();
        // A small grid stores three vertices per face; the whole mesh shares them, about half a vertex per face.
        if (is_own(near, lone, lattice_.sweep_mesh != nullptr, lattice_.faces_swept,
                   [&] { return 0.1 * count(all_faces()); })) {
            inputs.sweep_mesh = std::make_shared<const SweepMesh>(kept_mesh_.near_sweep_mesh(job_, *near));
            if (!lone) lattice_.faces_swept += near->face_count;
        } else {
            if (!lattice_.sweep_mesh)
                lattice_.sweep_mesh = std::make_shared<const SweepMesh>(kept_mesh_.sweep_mesh(job_));
            inputs.sweep_mesh = lattice_.sweep_mesh;
            select_triangles(near, inputs);
        }
    }

    void set_needs_normals(Inputs& inputs) { inputs.needs_normals = kept_mesh_.needs_normals(lattice_); }

    /// Selects from those inputs that the lattice keeps.
    void select(Inputs& inputs) {
        if (inputs.records == lattice_.records) select_records(near_bricks(), inputs);
        if (inputs.sweep_mesh && inputs.sweep_mesh == lattice_.sweep_mesh) select_triangles(near_rows(), inputs);
    }

    std::optional<NearRecords> near_rows() {
        if (kept_mesh_.has_selection()) return kept_mesh_.selected();
        if (!kept_mesh_.has_frusta()) return std::nullopt;
        Box box = box_near_rows(job_);
        if (const double gap = kept_mesh_.sign_surface_gap(); gap > 0) box = widened(box, gap);
        auto near = near_box(box, all_faces());
        return near && is_within_sweep(kept_mesh_.box(), job_.grid, job_.lattice) ? std::move(near) : std::nullopt;
    }

private:
    static double count(std::size_t faces) { return static_cast<double>(faces); }

    /// Whether the grid gets values of its own, of what is near it. Else it gets those that its lattice keeps, or is to
    /// keep: because it is not small, or because small grids of the lattice needed more than most() faces so far and
    /// the budget allows it. made: faces of the values that were made for such grids alone.
    template <class Most>
    bool is_own(const std::optional<NearRecords>& near, bool lone, bool is_kept, std::size_t made, const Most& most) {
        if (!near || kept_mesh_.has_selection()) return false;
        if (lone || !kept_mesh_.ways().selections_by_kernels) return true;
        if (is_kept) return false;
        return count(made + near->face_count) <= most() ||
               kept_mesh_.device_bytes() + kept_mesh_.record_bytes() > kept_mesh_.budget();
    }

    void keep_records() {
        if (!lattice_.records)
            lattice_.records = std::make_shared<const PreparedMesh>(
                kept_mesh_.restriction() != nullptr ? kept_mesh_.records(job_.lattice, kept_ranges())
                                                    : kept_mesh_.all_records(job_.lattice));
    }
    void select_records(const std::optional<NearRecords>& near, Inputs& inputs) {
        if (near) inputs.selection = engine::select_records(kept_mesh_.context(), kept_ranges(), *near);
    }
    void select_triangles(const std::optional<NearRecords>& near, Inputs& inputs) {
        if (near) inputs.sweep_selection = engine::select_triangles(kept_mesh_.context(), *near);
    }

    std::size_t all_faces() const { return kept_mesh_.face_count(); }
    const NearRecords& kept_ranges() { return kept_mesh_.kept_ranges(lattice_); }

    /// The part of the mesh that the grid needs, for its coarse bricks' lists or for its rows' crossings; nothing if
    /// that is more than half of the `faces` that there are.
    std::optional<NearRecords> near_box(const Box& box, std::size_t faces) {
        if (kept_mesh_.options().is_whole || !is_small(share_of(kept_mesh_.box(), box))) return std::nullopt;
        NearRecords near = kept_mesh_.index().near(box);
        if (!is_small(static_cast<double>(near.face_count) / static_cast<double>(faces))) return std::nullopt;
        return near;
    }
    std::optional<NearRecords> near_bricks() {
        if (kept_mesh_.has_selection()) return kept_mesh_.selected();
        const auto box = box_near_bricks(job_);
        if (!box) return std::nullopt;
        return near_box(*box, kept_mesh_.restriction() != nullptr ? kept_ranges().face_count : all_faces());
    }

    KeptMesh& kept_mesh_;
    const Job& job_;
    Lattice& lattice_;
};

}  // namespace

Inputs grid_inputs(KeptMesh& kept_mesh, const Job& job, SignRule sign, bool lone) {
    return kept_mesh.prepare([&] {
        Inputs inputs;
        const auto& method = kept_mesh.options().method;
        if (method) inputs.records = method->prepare(kept_mesh, job);
        if (method && sign == SignRule::none) return inputs;
        GridInputs of_grid(kept_mesh, job);
        if (!method) of_grid.set_records(lone, inputs);
        if (sign != SignRule::none && !job.band.has_exact_signs) of_grid.set_sweep_mesh(lone, inputs);
        if (!method && takes_normals(job.outputs)) of_grid.set_needs_normals(inputs);
        return inputs;
    });
}

std::optional<NearRecords> faces_near_rows(KeptMesh& kept_mesh, const Job& job) {
    return kept_mesh.prepare([&] { return GridInputs(kept_mesh, job).near_rows(); });
}

void select_inputs(KeptMesh& kept_mesh, const Job& part, Inputs& inputs) {
    if (!kept_mesh.ways().selections_by_kernels || kept_mesh.options().method) return;
    kept_mesh.prepare([&] { GridInputs(kept_mesh, part).select(inputs); });
}

std::size_t bytes_beside(const KeptMesh& kept_mesh, const Inputs& inputs) {
    std::size_t bytes = 0;
    if (inputs.records && !kept_mesh.keeps(inputs.records)) bytes += inputs.records->device_bytes();
    if (inputs.sweep_mesh && !kept_mesh.keeps(inputs.sweep_mesh)) bytes += inputs.sweep_mesh->device_bytes();
    return bytes;
}

}  // namespace clsdf::engine
