// A body that moves through a distributed adaptive mesh of deal.II and p4est: in each of ten steps the mesh is refined
// near the surface and repartitioned, the distance is computed at all degrees of freedom, ghosts included, and the
// cells that the surface cuts are counted. Writes the last step as VTU.
//
// mpirun -n 4 forest [MESH]
#include <clsdf/mesh_files.hpp>
#include <clsdf_dealii.hpp>

#include <deal.II/base/mpi.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_q1.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/non_matching/mesh_classifier.h>
#include <deal.II/numerics/data_out.h>

#include <cmath>
#include <cstdio>

namespace {

void run(const std::string& path) {
    using dealii::Utilities::MPI::sum;
    const MPI_Comm comm = MPI_COMM_WORLD;
    const auto rank = dealii::Utilities::MPI::this_mpi_process(comm);
    MPI_Comm node = MPI_COMM_NULL;
    MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    const auto device = clsdf::Device::of_rank(dealii::Utilities::MPI::this_mpi_process(node),
                                               dealii::Utilities::MPI::n_mpi_processes(node));
    MPI_Comm_free(&node);
    const clsdf::Mesh mesh = path.empty() ? clsdf::make_shape("torus") : clsdf::read_mesh(path);
    clsdf::DistanceTransform transform(device, mesh);

    // A cube with room to move.
    const clsdf::Box box = mesh.box();
    const double side = 2 * box.longest_side();
    dealii::Point<3> corner, opposite;
    for (unsigned axis = 0; axis < 3; ++axis) {
        corner[axis] = 0.5 * (box.lower.at(axis) + box.upper.at(axis)) - 0.5 * side;
        opposite[axis] = corner[axis] + side;
    }
    dealii::parallel::distributed::Triangulation<3> forest(comm);
    dealii::GridGenerator::hyper_rectangle(forest, corner, opposite);
    constexpr int coarsest = 2, finest = 5;
    forest.refine_global(coarsest);
    const double half_width = 4 * side / (1 << finest);

    const dealii::FE_Q<3> element(1);
    const dealii::MappingQ1<3> mapping;
    for (int step = 0; step < 10; ++step) {
        const double angle = 0.1 * step;
        const std::array<clsdf::Vec3, 3> rotation{
            {{std::cos(angle), -std::sin(angle), 0}, {std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
        transform.set_motion(rotation, {0.01 * side * step, 0, 0});

        // Each round refines by one level.
        for (int level = coarsest; level < finest; ++level) {
            clsdf::deal_ii::flag_cells(transform, forest, 0, coarsest, finest);
            forest.execute_coarsening_and_refinement();
        }
        dealii::DoFHandler<3> dofs(forest);
        dofs.distribute_dofs(element);
        dealii::IndexSet relevant;
        dealii::DoFTools::extract_locally_relevant_dofs(dofs, relevant);
        dealii::LinearAlgebra::distributed::Vector<double> distance(dofs.locally_owned_dofs(), relevant, comm);
        clsdf::deal_ii::interpolate(transform, mapping, dofs, half_width, distance);

        dealii::NonMatching::MeshClassifier<3> classifier(dofs, distance);
        classifier.reclassify();
        long cut = 0, inside = 0;
        for (const auto& cell : clsdf::deal_ii::owned_cells(forest)) {
            const auto place = classifier.location_to_level_set(cell);
            cut += place == dealii::NonMatching::LocationToLevelSet::intersected ? 1 : 0;
            inside += place == dealii::NonMatching::LocationToLevelSet::inside ? 1 : 0;
        }
        cut = sum(cut, comm);
        inside = sum(inside, comm);
        const auto norm = distance.l2_norm();
        if (rank == 0)
            std::printf("step %d: %llu cells, %llu dofs, %ld cut, %ld inside, norm %.6g\n", step,
                        static_cast<unsigned long long>(forest.n_global_active_cells()),
                        static_cast<unsigned long long>(dofs.n_dofs()), cut, inside, norm);
        if (step < 9) continue;
        dealii::DataOut<3> out;
        out.attach_dof_handler(dofs);
        out.add_data_vector(distance, "distance");
        out.build_patches();
        out.write_vtu_in_parallel("forest.vtu", comm);
    }
}

}  // namespace

int main(int argc, char** argv) {
    const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);  // one thread for each rank's loops
    try {
        run(argc > 1 ? argv[1] : "");
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
}
