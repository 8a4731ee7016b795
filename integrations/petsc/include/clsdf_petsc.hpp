#pragma once

/// Distance fields in vectors of PETSc's structured grids (DMDA) in three dimensions. docs/petsc.md has a whole
/// program. Link clsdf::clsdf and PETSc.
#include <clsdf_petsc_layout.h>
#include <clsdf/clsdf.hpp>

#include <array>
#include <cstddef>
#include <exception>
#include <new>
#include <span>
#include <string>

namespace clsdf::petsc {

/// An output and the component of the DMDA that holds its first number.
struct Component {
    Output output = Output::distance;
    PetscInt first = 0;
};

/// The work() of clsdf; what it throws becomes an error of PETSc with the same message.
template <typename Work>
PetscErrorCode guarded(const Work& work) {
    PetscErrorCode code{};
    std::string message;
    PetscFunctionBegin;
    try {
        work();
    } catch (const Error& error) {
        message = std::string(name_of(error.code())) + ": " + error.what();
        code = error.code() == ErrorCode::out_of_memory ? PETSC_ERR_MEM
               : error.code() == ErrorCode::unsupported ? PETSC_ERR_SUP
                                                        : PETSC_ERR_LIB;
    } catch (const std::bad_alloc&) {
        code = PETSC_ERR_MEM;
        message = "the host's memory is exhausted";
    } catch (const std::exception& error) {
        code = PETSC_ERR_LIB;
        message = error.what();
    }
    PetscCheck(code == PetscErrorCode{}, PETSC_COMM_SELF, code, "clsdf, %s", message.c_str());
    PetscFunctionReturn(PetscErrorCode{});
}

/// The block that this rank has of `vector`, and the arrays of the components in its memory, `values` (VecGetArray):
/// for a Request, or a call of one's own.
inline PetscErrorCode request_of(DM da, const Grid& lattice, const Band& band, Vec vector, PetscScalar* values,
                                 std::span<const Component> components, Request& request) {
    clsdf_petsc_layout layout;
    std::array<PetscInt, 3> samples{};
    PetscInt numbers = 0;
    PetscFunctionBegin;
    for (std::size_t axis = 0; axis < 3; ++axis) samples[axis] = static_cast<PetscInt>(lattice.size[axis]);
    PetscCall(clsdf_petsc_find_layout(da, vector, samples.data(), &layout));
    PetscCall(VecGetLocalSize(vector, &numbers));
    request = {lattice, band, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        request.grid.first[axis] = layout.first[axis];
        request.grid.size[axis] = layout.size[axis];
    }
    const auto width = static_cast<std::ptrdiff_t>(sizeof(PetscScalar)) * layout.components;
    for (const Component& component : components) {
        const OutputInfo& info = info_of(component.output);
        PetscCall(
            clsdf_petsc_check_component(&layout, component.first, static_cast<PetscInt>(info.components), info.name));
        OutputArray array(values, {width, width * layout.size[0], width * layout.size[0] * layout.size[1]});
        array.bytes = sizeof(PetscScalar) * static_cast<std::size_t>(numbers);
        array.offset = sizeof(PetscScalar) * static_cast<std::size_t>(component.first);
        if (request.targets[component.output].is_given())
            SETERRQ(PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "two components are '%s'; ask for each output once",
                    info.name);
        request.targets[component.output] = array;
    }
    PetscFunctionReturn(PetscErrorCode{});
}

/// Computes the samples that this rank has of `vector`, in place: with ghosts for a local vector, those beyond the
/// boundary, too; without for a global one. Sample (0, 0, 0) of the lattice is node (0, 0, 0) of the DMDA. The other
/// components of the vector stay. One of the components is the distance. Not collective; sends no message.
inline PetscErrorCode compute(const DistanceTransform& transform, DM da, const Grid& lattice, const Band& band,
                              Vec vector, std::span<const Component> components, const CallOptions& call = {}) {
    PetscScalar* values = nullptr;
    Request request;
    PetscErrorCode code{};
    PetscFunctionBegin;
    PetscCall(VecGetArray(vector, &values));
    code = request_of(da, lattice, band, vector, values, components, request);
    if (code == PetscErrorCode{}) code = guarded([&] { transform.compute(request, call); });
    PetscCall(VecRestoreArray(vector, &values));
    PetscCall(code);
    PetscFunctionReturn(PetscErrorCode{});
}

/// The distance alone, in one component.
inline PetscErrorCode compute(const DistanceTransform& transform, DM da, const Grid& lattice, const Band& band,
                              Vec vector, PetscInt component = 0, const CallOptions& call = {}) {
    const Component distance{Output::distance, component};
    return compute(transform, da, lattice, band, vector, std::span(&distance, 1), call);
}

}  // namespace clsdf::petsc
