// On a refined and repartitioned forest: ghosts equal their owners, the values are those of a sphere, a restricted
// transform and a Function give the same bytes. Prints a hash of all values, which does not depend on the ranks.
#include <clsdf_dealii.hpp>

#include <deal.II/base/mpi.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_q1.h>
#include <deal.II/grid/grid_generator.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>

namespace {

std::size_t failures = 0;

void check(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "not so: %s\n", what);
    ++failures;
}

/// Of one degree of freedom: its point and its value.
std::uint64_t hash_of(const dealii::Point<3>& point, double value) {
    std::uint64_t hash = 0;
    for (const double number : {point[0], point[1], point[2], value}) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(number)) * 0x9E3779B97F4A7C15U;
        hash ^= hash >> 32;
    }
    return hash;
}

void run() {
    using Vector = dealii::LinearAlgebra::distributed::Vector<double>;
    const MPI_Comm comm = MPI_COMM_WORLD;
    const clsdf::Mesh mesh = clsdf::make_shape("sphere5");
    const double radius = mesh.box().upper[0];
    // All ranks of the tests are on one machine.
    const auto device = clsdf::Device::of_rank(dealii::Utilities::MPI::this_mpi_process(comm),
                                               dealii::Utilities::MPI::n_mpi_processes(comm));
    const clsdf::DistanceTransform transform(device, mesh);
    dealii::parallel::distributed::Triangulation<3> forest(comm);
    dealii::GridGenerator::hyper_cube(forest, -2 * radius, 2 * radius);
    forest.refine_global(2);
    std::size_t refined = 0;
    for (int level = 2; level < 5; ++level) {
        refined += clsdf::deal_ii::flag_cells(transform, forest, 0, 2, 5) ? 1 : 0;
        forest.execute_coarsening_and_refinement();
    }
    check(!clsdf::deal_ii::flag_cells(transform, forest, 0, 2, 5), "the finest cells stay");
    check(forest.n_global_active_cells() > 500, "more than 500 cells");
    check(dealii::Utilities::MPI::sum(refined, comm) >= 3, "each round refines");

    const dealii::FE_Q<3> element(2);
    const dealii::MappingQ1<3> mapping;
    dealii::DoFHandler<3> dofs(forest);
    dofs.distribute_dofs(element);
    dealii::IndexSet relevant;
    dealii::DoFTools::extract_locally_relevant_dofs(dofs, relevant);
    const double limit = std::numeric_limits<double>::infinity(), half_width = 0.5 * radius;
    Vector values(dofs.locally_owned_dofs(), relevant, comm), near(values), of_part(values);
    clsdf::deal_ii::interpolate(transform, mapping, dofs, limit, values);
    const auto bytes = [](const Vector& vector) {
        const auto& part = *vector.get_partitioner();
        return (part.locally_owned_size() + part.n_ghost_indices()) * sizeof(double);
    };
    const auto equal = [&](const Vector& one, const Vector& other) {
        return std::memcmp(one.begin(), other.begin(), bytes(one)) == 0;
    };

    // What the owners would send.
    Vector sent(values);
    sent.zero_out_ghost_values();
    sent.update_ghost_values();
    check(equal(values, sent), "ghosts have the bytes of their owners");
    check(dealii::Utilities::MPI::n_mpi_processes(comm) == 1 || values.get_partitioner()->n_ghost_indices() > 0,
          "there are ghosts");

    // A rank's part of the mesh.
    clsdf::deal_ii::interpolate(transform, mapping, dofs, half_width, near);
    const auto regions = clsdf::deal_ii::regions_of(forest, half_width);
    const clsdf::DistanceTransform part = transform.restrict_to(regions);
    clsdf::deal_ii::interpolate(part, mapping, dofs, half_width, of_part);
    check(equal(near, of_part), "a part has the bytes of the whole");

    // As a function; the surface is within 1% of a sphere.
    std::map<dealii::types::global_dof_index, dealii::Point<3>> support;
    dealii::DoFTools::map_dofs_to_support_points(mapping, dofs, support);
    const clsdf::deal_ii::DistanceFunction function(transform);
    std::vector<dealii::Point<3>> points;
    for (const auto& [dof, point] : support) points.push_back(point);
    std::vector<double> distances(points.size());
    std::vector<dealii::Tensor<1, 3>> gradients(points.size());
    function.value_list(points, distances);
    function.gradient_list(points, gradients);
    std::uint64_t hash = 0;
    std::size_t n = 0, wrong = 0, other = 0;
    for (const auto& [dof, point] : support) {
        const double exact = point.norm() - radius, value = values(dof);
        wrong += std::fabs(value - exact) > 0.01 * radius ? 1 : 0;
        wrong += std::fabs(exact) > 0.01 * radius && std::signbit(value) != std::signbit(exact) ? 1 : 0;
        if (point.norm() > 0.1 * radius) wrong += gradients[n] * point < 0.9 * point.norm() ? 1 : 0;
        other += distances[n] != value ? 1 : 0;
        if (dofs.locally_owned_dofs().is_element(dof)) hash += hash_of(point, value);
        ++n;
    }
    check(wrong == 0, "distances, signs and gradients are those of a sphere");
    check(other == 0, "the function has the same values");
    check(function.value(points[0]) == distances[0], "one point has the value of the list");
    check(function.gradient(points[0]) == gradients[0], "one point has the gradient of the list");
    std::uint64_t total = 0;
    MPI_Reduce(&hash, &total, 1, MPI_UINT64_T, MPI_SUM, 0, comm);
    if (dealii::Utilities::MPI::this_mpi_process(comm) == 0)
        std::printf("%llu cells, %llu dofs, hash %016llx\n",
                    static_cast<unsigned long long>(forest.n_global_active_cells()),
                    static_cast<unsigned long long>(dofs.n_dofs()), static_cast<unsigned long long>(total));
}

}  // namespace

int main(int argc, char** argv) {
    const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
    try {
        run();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    return failures == 0 ? 0 : 1;
}
