#pragma once

/// Distance fields on deal.II's distributed meshes in three dimensions. docs/dealii.md has a whole program. Link
/// clsdf::clsdf and deal.II. Nothing here sends a message but what is marked so.
#include <clsdf/clsdf.hpp>

#include <deal.II/base/function.h>
#include <deal.II/base/point.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/mapping.h>
#include <deal.II/grid/tria.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <vector>

namespace clsdf::deal_ii {

/// deal.II's points for query(): three doubles each.
inline InputArray points_of(const std::vector<dealii::Point<3>>& points) {
    static_assert(sizeof(dealii::Point<3>) == 3 * sizeof(double));
    InputArray array;
    array.type = ElementType::float64;
    array.host = points.data();
    array.count = points.size();
    array.bytes = points.size() * sizeof(dealii::Point<3>);
    return array;
}

/// The smallest box around the cell's vertices, which holds a cell with straight edges.
template <typename Cell>
Box box_of(const Cell& cell) {
    const auto corners = cell->bounding_box().get_boundary_points();
    return {{corners.first[0], corners.first[1], corners.first[2]},
            {corners.second[0], corners.second[1], corners.second[2]}};
}

/// The locally owned active cells, in deal.II's order.
inline std::vector<dealii::Triangulation<3>::active_cell_iterator> owned_cells(const dealii::Triangulation<3>& mesh) {
    std::vector<dealii::Triangulation<3>::active_cell_iterator> cells;
    for (const auto& cell : mesh.active_cell_iterators())
        if (cell->is_locally_owned()) cells.push_back(cell);
    return cells;
}

/// Flags the owned cells within half_width of the surface for refinement if they are coarser than `finest`, and the
/// others for coarsening if they are finer than `coarsest`. Then call execute_coarsening_and_refinement(), which also
/// repartitions. Returns whether a cell of this rank is flagged for refinement.
inline bool flag_cells(const DistanceTransform& transform, dealii::Triangulation<3>& mesh, double half_width,
                       int coarsest, int finest) {
    const auto cells = owned_cells(mesh);
    std::vector<Box> boxes;
    for (const auto& cell : cells) boxes.push_back(box_of(cell));
    std::vector<BoxPlace> places(boxes.size());
    transform.classify(boxes, half_width, places);
    bool refines = false;
    for (std::size_t n = 0; n < cells.size(); ++n)
        if (places[n] != BoxPlace::within) {
            if (cells[n]->level() > coarsest) cells[n]->set_coarsen_flag();
        } else if (cells[n]->level() < finest) {
            cells[n]->set_refine_flag();
            refines = true;
        }
    return refines;
}

/// The signed distance at the support points, for owned and for ghost values at once: they have ghosts, and
/// update_ghost_values() is not needed. The finite element has support points and one component. The vector was made
/// from the locally owned and the locally relevant degrees of freedom.
inline void interpolate(const DistanceTransform& transform, const dealii::Mapping<3>& mapping,
                        const dealii::DoFHandler<3>& dofs, double half_width,
                        dealii::LinearAlgebra::distributed::Vector<double>& values) {
    std::map<dealii::types::global_dof_index, dealii::Point<3>> support;
    dealii::DoFTools::map_dofs_to_support_points(mapping, dofs, support);
    // In memory: owned values, then ghosts.
    const auto& part = *values.get_partitioner();
    std::vector<dealii::Point<3>> points(part.locally_owned_size() + part.n_ghost_indices());
    for (const auto& [dof, point] : support)
        if (part.in_local_range(dof) || part.is_ghost_entry(dof)) points[part.global_to_local(dof)] = point;
    OutputArray distance(values.begin());
    distance.bytes = points.size() * sizeof(double);
    if (!points.empty()) transform.query(points_of(points), half_width, distance);
    values.set_ghost_state(true);
}

/// What this rank's cells need of the mesh, for restrict_to(): interpolate(), classify and points within half_width in
/// owned cells and ghosts.
inline std::vector<Region> regions_of(const dealii::Triangulation<3>& mesh, double half_width) {
    std::vector<Region> regions;
    for (const auto& cell : mesh.active_cell_iterators())
        if (!cell->is_artificial()) regions.push_back({box_of(cell), half_width, 0});
    return regions;
}

/// The distance as a function, for code of deal.II that wants one. value_list() and gradient_list() are one query each;
/// value() is one for a point. The transform must outlive it.
class DistanceFunction : public dealii::Function<3> {
public:
    explicit DistanceFunction(const DistanceTransform& transform,
                              double half_width = std::numeric_limits<double>::infinity())
        : transform_(&transform), half_width_(half_width) {}

    double value(const dealii::Point<3>& point, unsigned = 0) const override {
        std::vector<double> value(1);
        value_list({point}, value);
        return value[0];
    }

    void value_list(const std::vector<dealii::Point<3>>& points, std::vector<double>& values,
                    unsigned = 0) const override {
        if (!points.empty()) transform_->query(points_of(points), half_width_, values);
    }

    /// NaN beyond the half width.
    dealii::Tensor<1, 3> gradient(const dealii::Point<3>& point, unsigned = 0) const override {
        std::vector<dealii::Tensor<1, 3>> gradient(1);
        gradient_list({point}, gradient);
        return gradient[0];
    }

    void gradient_list(const std::vector<dealii::Point<3>>& points, std::vector<dealii::Tensor<1, 3>>& gradients,
                       unsigned = 0) const override {
        if (points.empty()) return;
        std::vector<double> distances(points.size());
        OutputArray normals(&gradients[0][0]);
        normals.bytes = gradients.size() * sizeof(dealii::Tensor<1, 3>);
        transform_->query(points_of(points), half_width_, {{Output::distance, distances}, {Output::gradient, normals}});
    }

private:
    const DistanceTransform* transform_;
    double half_width_;
};

}  // namespace clsdf::deal_ii
