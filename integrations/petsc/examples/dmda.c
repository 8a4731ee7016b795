/* The distance to a mesh and its gradient in a distributed grid of PETSc, and a file of it in HDF5.
 *
 * mpirun -n 4 dmda_c -mesh bunny.off -n 128 -file bunny.h5 */
#include <clsdf_petsc.h>
#include <petscviewer.h>

int main(int argc, char** argv) {
    const clsdf_petsc_component components[2] = {{CLSDF_DISTANCE, 0}, {CLSDF_GRADIENT, 1}};
    const clsdf_band band = clsdf_band_full();
    char path[PETSC_MAX_PATH_LEN] = "", file[PETSC_MAX_PATH_LEN] = "distance.h5";
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_box box;
    clsdf_grid lattice;
    PetscInt samples = 64;
    PetscMPIInt rank, ranks, failed;
    DM grid;
    Vec local, global;
    PetscViewer viewer;

    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    PetscCall(PetscOptionsGetString(NULL, NULL, "-mesh", path, sizeof path, NULL));
    PetscCall(PetscOptionsGetString(NULL, NULL, "-file", file, sizeof file, NULL));
    PetscCall(PetscOptionsGetInt(NULL, NULL, "-n", &samples, NULL));

    /* The transform of this rank, with its share of the machine. An error in PetscCall() in main() ends all ranks. */
    PetscCall(clsdf_petsc_rank_on_node(PETSC_COMM_WORLD, &rank, &ranks));
    PetscCall(clsdf_petsc_error(clsdf_device_of_rank(rank, ranks, &device)));
    PetscCall(clsdf_petsc_error(path[0] != 0 ? clsdf_mesh_read(path, &mesh) : clsdf_mesh_shape("knot", &mesh)));
    PetscCall(clsdf_petsc_error(clsdf_mesh_box(mesh, &box)));
    options.resolution = samples;
    options.cubic = 1;
    PetscCall(clsdf_petsc_error(clsdf_grid_around_box(&box, &options, &lattice)));
    PetscCall(clsdf_petsc_error(clsdf_transform_create(device, mesh, NULL, NULL, &transform)));

    /* Four components: the distance and its gradient. Two samples of ghosts, beyond the boundary, too. */
    PetscCall(DMDACreate3d(PETSC_COMM_WORLD, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED,
                           DMDA_STENCIL_BOX, samples, samples, samples, PETSC_DECIDE, PETSC_DECIDE, PETSC_DECIDE, 4, 2,
                           NULL, NULL, NULL, &grid));
    PetscCall(DMSetUp(grid));
    PetscCall(DMCreateLocalVector(grid, &local));
    failed = clsdf_petsc_compute(transform, grid, &lattice, &band, local, components, 2, NULL) != 0;

    /* The next call is collective: all ranks must know of an error on one. */
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
    if (!failed) {
        PetscCall(DMCreateGlobalVector(grid, &global));
        PetscCall(DMLocalToGlobal(grid, local, INSERT_VALUES, global));
        PetscCall(PetscObjectSetName((PetscObject)global, "distance"));
        PetscCall(PetscViewerCreate(PETSC_COMM_WORLD, &viewer));
        PetscCall(PetscViewerSetType(viewer, PETSCVIEWERHDF5));
        PetscCall(PetscViewerFileSetMode(viewer, FILE_MODE_WRITE));
        PetscCall(PetscViewerFileSetName(viewer, file));
        PetscCall(VecView(global, viewer));
        PetscCall(PetscViewerDestroy(&viewer));
        PetscCall(VecDestroy(&global));
    }
    PetscCall(VecDestroy(&local));
    PetscCall(DMDestroy(&grid));
    clsdf_transform_release(transform);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    PetscCall(PetscFinalize());
    return failed;
}
