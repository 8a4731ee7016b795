// The distance to a mesh and its gradient in a distributed grid of PETSc, and a file of it in HDF5.
//
// mpirun -n 4 dmda -mesh bunny.off -n 128 -file bunny.h5
#include <petscviewer.h>
#include <clsdf/mesh_files.hpp>
#include <clsdf_petsc.hpp>

#include <array>
#include <optional>

int main(int argc, char** argv) {
    PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
    char path[PETSC_MAX_PATH_LEN] = "", file[PETSC_MAX_PATH_LEN] = "distance.h5";
    PetscInt samples = 64;
    PetscCall(PetscOptionsGetString(nullptr, nullptr, "-mesh", path, sizeof path, nullptr));
    PetscCall(PetscOptionsGetString(nullptr, nullptr, "-file", file, sizeof file, nullptr));
    PetscCall(PetscOptionsGetInt(nullptr, nullptr, "-n", &samples, nullptr));

    // The transform of this rank, with its share of the machine. An error in PetscCall() in main() ends all ranks.
    PetscMPIInt rank = 0, ranks = 1;
    PetscCall(clsdf_petsc_rank_on_node(PETSC_COMM_WORLD, &rank, &ranks));
    std::optional<clsdf::DistanceTransform> transform;
    clsdf::Grid lattice;
    PetscCall(clsdf::petsc::guarded([&] {
        const clsdf::Mesh mesh = path[0] != 0 ? clsdf::read_mesh(path) : clsdf::make_shape("knot");
        clsdf::GridOptions options;
        options.resolution = samples;
        options.cubic = true;
        lattice = clsdf::Grid::around(mesh.box(), options);
        const auto device = clsdf::Device::of_rank(static_cast<std::size_t>(rank), static_cast<std::size_t>(ranks));
        transform.emplace(device, mesh);
    }));

    // Four components: the distance and its gradient. Two samples of ghosts, beyond the boundary, too.
    DM grid = nullptr;
    PetscCall(DMDACreate3d(PETSC_COMM_WORLD, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED,
                           DMDA_STENCIL_BOX, samples, samples, samples, PETSC_DECIDE, PETSC_DECIDE, PETSC_DECIDE, 4, 2,
                           nullptr, nullptr, nullptr, &grid));
    PetscCall(DMSetUp(grid));
    Vec local = nullptr, global = nullptr;
    PetscCall(DMCreateLocalVector(grid, &local));
    const std::array<clsdf::petsc::Component, 2> components{
        {{clsdf::Output::distance, 0}, {clsdf::Output::gradient, 1}}};
    int failed = clsdf::petsc::compute(*transform, grid, lattice, clsdf::Band::full(), local, components) != 0;

    // The next call is collective: all ranks must know of an error on one.
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
    if (failed == 0) {
        PetscCall(DMCreateGlobalVector(grid, &global));
        PetscCall(DMLocalToGlobal(grid, local, INSERT_VALUES, global));
        PetscReal length = 0, largest = 0;
        PetscCall(VecStrideNorm(global, 0, NORM_INFINITY, &largest));
        PetscCall(VecStrideNorm(global, 1, NORM_INFINITY, &length));
        PetscCall(PetscPrintf(PETSC_COMM_WORLD, "largest distance %.9g, largest x of a gradient %.9g\n",
                              static_cast<double>(largest), static_cast<double>(length)));
        PetscViewer viewer = nullptr;
        PetscCall(PetscObjectSetName(reinterpret_cast<PetscObject>(global), "distance"));
        PetscCall(PetscViewerCreate(PETSC_COMM_WORLD, &viewer));
        PetscCall(PetscViewerSetType(viewer, PETSCVIEWERHDF5));
        PetscCall(PetscViewerFileSetMode(viewer, FILE_MODE_WRITE));
        PetscCall(PetscViewerFileSetName(viewer, file));
        PetscCall(VecView(global, viewer));
        PetscCall(PetscViewerDestroy(&viewer));
    }
    PetscCall(VecDestroy(&global));
    PetscCall(VecDestroy(&local));
    PetscCall(DMDestroy(&grid));
    transform.reset();
    PetscCall(PetscFinalize());
    return failed;
}
