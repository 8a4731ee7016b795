#ifndef CLSDF_PETSC_H
#define CLSDF_PETSC_H

/* Distance fields in vectors of PETSc's structured grids (DMDA) in three dimensions, in C. docs/petsc.md has a whole
 * program. Link libclsdf_c and PETSc. */

#include <clsdf.h>
#include <clsdf_petsc_layout.h>

#if defined(PETSC_USE_REAL_DOUBLE)
#define CLSDF_PETSC_SCALAR CLSDF_FLOAT64
#else
#define CLSDF_PETSC_SCALAR CLSDF_FLOAT32
#endif

/* An output and the component of the DMDA that holds its first number. */
typedef struct {
    int32_t output; /* CLSDF_DISTANCE ... */
    PetscInt first;
} clsdf_petsc_component;

/* For PetscCall(): an error of clsdf as one of PETSc, with clsdf's message. */
static inline PetscErrorCode clsdf_petsc_error(clsdf_status status) {
    PetscFunctionBegin;
    PetscCheck(status == CLSDF_OK, PETSC_COMM_SELF,
               status == CLSDF_OUT_OF_MEMORY ? PETSC_ERR_MEM
               : status == CLSDF_UNSUPPORTED ? PETSC_ERR_SUP
                                             : PETSC_ERR_LIB,
               "clsdf, %s: %s", clsdf_status_name(status), clsdf_last_error());
    PetscFunctionReturn((PetscErrorCode)0);
}

/* Computes the samples that this rank has of `vector`, in place: with ghosts for a local vector, those beyond the
 * boundary, too; without for a global one. Sample (0, 0, 0) of the lattice is node (0, 0, 0) of the DMDA. The other
 * components of the vector stay. components[count]: one is the distance. Not collective; sends no message. */
static inline PetscErrorCode clsdf_petsc_compute(const clsdf_transform* transform, DM da, const clsdf_grid* lattice,
                                                 const clsdf_band* band, Vec vector,
                                                 const clsdf_petsc_component* components, PetscInt count,
                                                 const clsdf_call_options* call) {
    clsdf_target targets[8];
    clsdf_petsc_layout layout;
    clsdf_grid block;
    clsdf_status status;
    PetscScalar* values;
    PetscInt samples[3], numbers, n, axis;
    PetscFunctionBegin;
    for (axis = 0; axis < 3; ++axis) samples[axis] = (PetscInt)lattice->size[axis];
    PetscCall(clsdf_petsc_find_layout(da, vector, samples, &layout));
    PetscCheck(count <= 8, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "There are not %" PetscInt_FMT " outputs", count);
    block = *lattice;
    for (axis = 0; axis < 3; ++axis) {
        block.first[axis] = layout.first[axis];
        block.size[axis] = layout.size[axis];
    }
    PetscCall(VecGetLocalSize(vector, &numbers));
    for (n = 0; n < count; ++n) {
        clsdf_output_info info = CLSDF_OUTPUT_INFO_INIT;
        clsdf_array* array = &targets[n].array;
        PetscCall(clsdf_petsc_error(clsdf_output_describe(components[n].output, &info)));
        PetscCall(clsdf_petsc_check_component(&layout, components[n].first, (PetscInt)info.components, info.name));
        targets[n] = clsdf_host_target(components[n].output, CLSDF_PETSC_SCALAR, NULL, 0);
        array->bytes = (int64_t)sizeof *values * numbers;
        array->offset = (int64_t)sizeof *values * components[n].first;
        array->strides[0] = (int64_t)sizeof *values * layout.components;
        array->strides[1] = array->strides[0] * layout.size[0];
        array->strides[2] = array->strides[1] * layout.size[1];
    }
    PetscCall(VecGetArray(vector, &values));
    for (n = 0; n < count; ++n) targets[n].array.host = values;
    status = clsdf_compute(transform, &block, band, targets, count, call, NULL);
    PetscCall(VecRestoreArray(vector, &values));
    PetscCall(clsdf_petsc_error(status));
    PetscFunctionReturn((PetscErrorCode)0);
}

#endif
