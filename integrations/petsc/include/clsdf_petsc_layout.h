#ifndef CLSDF_PETSC_LAYOUT_H
#define CLSDF_PETSC_LAYOUT_H

/* How a vector of a DMDA lies in memory: what clsdf_petsc.h (C) and clsdf_petsc.hpp (C++) share. */

#include <petscdmda.h>

#if defined(PETSC_USE_COMPLEX)
#error \
    "clsdf writes real numbers, and this PETSc has complex scalars; build with a real one (Debian: libpetsc-real-dev)"
#endif
#if !defined(PETSC_USE_REAL_DOUBLE) && !defined(PETSC_USE_REAL_SINGLE)
#error "clsdf writes floats or doubles, and this PETSc has other scalars"
#endif

#if defined(__cplusplus) && defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast" /* this file is C, too */
#endif

/* The samples of a rank. x is fastest in memory, and the components of a sample lie side by side. */
typedef struct {
    PetscInt first[3]; /* sample of the DMDA; negative in ghosts beyond the boundary */
    PetscInt size[3];
    PetscInt components;
} clsdf_petsc_layout;

/* The samples of `vector` on this rank: with ghosts if it is a local vector of the DMDA, without if it is a global one.
 * The DMDA has three dimensions and samples[3] nodes. Sends no message. */
static inline PetscErrorCode clsdf_petsc_find_layout(DM da, Vec vector, const PetscInt* samples,
                                                     clsdf_petsc_layout* layout) {
    PetscBool is_dmda;
    PetscInt dimensions, nodes[3], owned[6], ghosted[6], count, n;
    DMBoundaryType boundary[3];
    const char* names[3] = {"x", "y", "z"};
    PetscFunctionBegin;
    PetscCall(PetscObjectTypeCompare((PetscObject)da, DMDA, &is_dmda));
    PetscCheck(is_dmda, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "The DM is no DMDA");
    PetscCall(DMDAGetInfo(da, &dimensions, &nodes[0], &nodes[1], &nodes[2], NULL, NULL, NULL, &layout->components, NULL,
                          &boundary[0], &boundary[1], &boundary[2], NULL));
    PetscCheck(dimensions == 3, PETSC_COMM_SELF, PETSC_ERR_SUP,
               "The DMDA has %" PetscInt_FMT " dimensions, and a mesh of triangles has 3; use DMDACreate3d()",
               dimensions);
    for (n = 0; n < 3; ++n)
        PetscCheck(nodes[n] == samples[n], PETSC_COMM_SELF, PETSC_ERR_ARG_INCOMP,
                   "The DMDA has %" PetscInt_FMT " nodes along %s, and the lattice %" PetscInt_FMT
                   " samples; give both the same size",
                   nodes[n], names[n], samples[n]);
    PetscCall(DMDAGetCorners(da, &owned[0], &owned[1], &owned[2], &owned[3], &owned[4], &owned[5]));
    PetscCall(DMDAGetGhostCorners(da, &ghosted[0], &ghosted[1], &ghosted[2], &ghosted[3], &ghosted[4], &ghosted[5]));
    PetscCall(VecGetLocalSize(vector, &count));
    if (count == owned[3] * owned[4] * owned[5] * layout->components) {
        for (n = 0; n < 6; ++n) (n < 3 ? layout->first : layout->size)[n % 3] = owned[n];
        PetscFunctionReturn((PetscErrorCode)0);
    }
    PetscCheck(count == ghosted[3] * ghosted[4] * ghosted[5] * layout->components, PETSC_COMM_SELF,
               PETSC_ERR_ARG_INCOMP,
               "The vector has %" PetscInt_FMT
               " numbers on this rank, and fits neither the DMDA's own nodes nor those "
               "with ghosts; make it by DMCreateLocalVector() or DMCreateGlobalVector() of this DMDA",
               count);
    for (n = 0; n < 6; ++n) (n < 3 ? layout->first : layout->size)[n % 3] = ghosted[n];
    for (n = 0; n < 3; ++n)
        PetscCheck(boundary[n] == DM_BOUNDARY_NONE || boundary[n] == DM_BOUNDARY_GHOSTED, PETSC_COMM_SELF,
                   PETSC_ERR_SUP,
                   "The boundary along %s is %s, and the distance to a mesh is not; compute a global vector, then use "
                   "DMGlobalToLocal()",
                   names[n], DMBoundaryTypes[boundary[n]]);
    PetscFunctionReturn((PetscErrorCode)0);
}

/* That an output of `width` numbers has room from component `first` on. */
static inline PetscErrorCode clsdf_petsc_check_component(const clsdf_petsc_layout* layout, PetscInt first,
                                                         PetscInt width, const char* output) {
    PetscFunctionBegin;
    PetscCheck(first >= 0 && width <= layout->components - first, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "The %s takes %" PetscInt_FMT " components from %" PetscInt_FMT " on, and the DMDA has %" PetscInt_FMT,
               output, width, first, layout->components);
    PetscFunctionReturn((PetscErrorCode)0);
}

/* The number of this process among those of its machine, and how many they are: for Device::of_rank. Collective. */
static inline PetscErrorCode clsdf_petsc_rank_on_node(MPI_Comm comm, PetscMPIInt* rank, PetscMPIInt* ranks) {
    MPI_Comm node;
    PetscFunctionBegin;
    PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node));
    PetscCallMPI(MPI_Comm_rank(node, rank));
    PetscCallMPI(MPI_Comm_size(node, ranks));
    PetscCallMPI(MPI_Comm_free(&node));
    PetscFunctionReturn((PetscErrorCode)0);
}

#if defined(__cplusplus) && defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#endif
