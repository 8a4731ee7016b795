// Fields in DMDAs of several kinds: every sample and ghost has the bytes of the whole, what PETSc would send is what is
// there, other components stay, nothing is sent, and wrong uses are refused. Writes one field to the file of the
// argument, in PETSc's natural order.
#include <petscviewer.h>
#include <clsdf_petsc.hpp>

#include <array>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

extern "C" long messages_of_mpi;

namespace {

using clsdf::Output;
using clsdf::petsc::Component;

constexpr PetscScalar untouched = -7;
constexpr PetscInt samples[3] = {25, 18, 21};

struct Case {
    DMBoundaryType boundary;
    PetscInt components, ghosts;
    std::vector<Component> outputs;
};

std::size_t failures = 0;

void check(bool holds, const char* what, std::size_t number) {
    if (holds) return;
    std::fprintf(stderr, "case %zu: %s\n", number, what);
    ++failures;
}

PetscErrorCode make(DMBoundaryType boundary, PetscInt components, PetscInt ghosts, DM& grid) {
    PetscFunctionBegin;
    PetscCall(DMDACreate3d(PETSC_COMM_WORLD, boundary, boundary, boundary, DMDA_STENCIL_BOX, samples[0], samples[1],
                           samples[2], PETSC_DECIDE, PETSC_DECIDE, PETSC_DECIDE, components, ghosts, nullptr, nullptr,
                           nullptr, &grid));
    PetscCall(DMSetUp(grid));
    PetscFunctionReturn(PetscErrorCode{});
}

/// The same field in an array of the whole lattice, ghosts of this block included, against the vector.
bool has_the_bytes_of_the_whole(const clsdf::DistanceTransform& transform, const clsdf::Grid& lattice,
                                const clsdf::Band& band, const Case& each, const clsdf_petsc_layout& part,
                                const PetscScalar* values) {
    const clsdf::Grid whole = lattice.grown(each.ghosts);
    std::vector<std::vector<PetscScalar>> fields(each.outputs.size());
    clsdf::OutputTargets targets;
    for (std::size_t o = 0; o < fields.size(); ++o) {
        fields[o].resize(whole.sample_count() * clsdf::info_of(each.outputs[o].output).components);
        targets[each.outputs[o].output] = fields[o];
    }
    transform.compute(whole, band, targets);
    const auto dof = static_cast<std::size_t>(each.components);
    std::vector<PetscScalar> expected(dof);
    std::size_t at = 0;
    for (PetscInt k = 0; k < part.size[2]; ++k)
        for (PetscInt j = 0; j < part.size[1]; ++j)
            for (PetscInt i = 0; i < part.size[0]; ++i, at += dof) {
                const std::size_t sample = whole.offset(
                    part.first[0] + i + each.ghosts, part.first[1] + j + each.ghosts, part.first[2] + k + each.ghosts);
                expected.assign(dof, untouched);
                for (std::size_t o = 0; o < fields.size(); ++o) {
                    const std::size_t width = clsdf::info_of(each.outputs[o].output).components;
                    for (std::size_t c = 0; c < width; ++c)
                        expected[static_cast<std::size_t>(each.outputs[o].first) + c] = fields[o][sample * width + c];
                }
                if (std::memcmp(expected.data(), values + at, dof * sizeof(PetscScalar)) != 0) return false;
            }
    return true;
}

PetscErrorCode try_case(const clsdf::DistanceTransform& transform, const clsdf::Grid& lattice, const Case& each,
                        std::size_t number) {
    const clsdf::Band band = clsdf::Band::symmetric(4 * lattice.voxel());
    DM grid = nullptr;
    Vec local = nullptr, global = nullptr, again = nullptr;
    clsdf_petsc_layout part;
    const PetscScalar *values = nullptr, *sent = nullptr;
    PetscInt count = 0;
    PetscFunctionBegin;
    PetscCall(make(each.boundary, each.components, each.ghosts, grid));
    PetscCall(DMCreateLocalVector(grid, &local));
    PetscCall(VecSet(local, untouched));
    const long before = messages_of_mpi;
    PetscCall(clsdf::petsc::compute(transform, grid, lattice, band, local, each.outputs));
    check(messages_of_mpi == before, "a message was sent", number);

    PetscCall(clsdf_petsc_find_layout(grid, local, samples, &part));
    PetscCall(VecGetArrayRead(local, &values));
    check(has_the_bytes_of_the_whole(transform, lattice, band, each, part, values),
          "the bytes are not those of the whole", number);

    // What the owners would send.
    PetscCall(DMCreateGlobalVector(grid, &global));
    PetscCall(VecSet(global, untouched));
    PetscCall(clsdf::petsc::compute(transform, grid, lattice, band, global, each.outputs));
    PetscCall(VecDuplicate(local, &again));
    PetscCall(VecCopy(local, again));
    const long before_sending = messages_of_mpi;
    PetscCall(DMGlobalToLocal(grid, global, INSERT_VALUES, again));
    PetscMPIInt ranks = 1;
    PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
    check(ranks == 1 || each.ghosts == 0 || messages_of_mpi > before_sending, "messages are not counted", number);
    PetscCall(VecGetLocalSize(local, &count));
    PetscCall(VecGetArrayRead(again, &sent));
    check(std::memcmp(values, sent, static_cast<std::size_t>(count) * sizeof(PetscScalar)) == 0,
          "a ghost differs from its owner", number);
    PetscCall(VecRestoreArrayRead(again, &sent));
    PetscCall(VecRestoreArrayRead(local, &values));
    PetscCall(VecDestroy(&again));
    PetscCall(VecDestroy(&global));
    PetscCall(VecDestroy(&local));
    PetscCall(DMDestroy(&grid));
    PetscFunctionReturn(PetscErrorCode{});
}

std::string last_message;

PetscErrorCode keep_message(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                            const char* message, void*) {
    if (type == PETSC_ERROR_INITIAL) last_message = message;
    return code;
}

void refused(PetscErrorCode found, PetscErrorCode expected, const char* part) {
    if (found == expected && last_message.find(part) != std::string::npos) return;
    std::fprintf(stderr, "error %d, '%s', not %d, '... %s ...'\n", static_cast<int>(found), last_message.c_str(),
                 static_cast<int>(expected), part);
    ++failures;
}

PetscErrorCode try_refusals(const clsdf::DistanceTransform& transform, const clsdf::Grid& lattice) {
    const clsdf::Band band = clsdf::Band::full();
    DM grid = nullptr, ring = nullptr, flat = nullptr;
    Vec local = nullptr, of_ring = nullptr, whole_ring = nullptr, of_flat = nullptr;
    clsdf::Grid other = lattice;
    other.size[1] = 17;
    PetscFunctionBegin;
    PetscCall(make(DM_BOUNDARY_GHOSTED, 2, 1, grid));
    PetscCall(DMCreateLocalVector(grid, &local));
    PetscCall(make(DM_BOUNDARY_PERIODIC, 1, 1, ring));
    PetscCall(DMCreateLocalVector(ring, &of_ring));
    PetscCall(DMCreateGlobalVector(ring, &whole_ring));
    PetscCall(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX, 16, 16, PETSC_DECIDE,
                           PETSC_DECIDE, 1, 1, nullptr, nullptr, &flat));
    PetscCall(DMSetUp(flat));
    PetscCall(DMCreateLocalVector(flat, &of_flat));
    PetscCall(clsdf::petsc::compute(transform, ring, lattice, band, whole_ring));
    PetscCall(PetscPushErrorHandler(keep_message, nullptr));
    using clsdf::petsc::compute;
    refused(compute(transform, grid, other, band, local), PETSC_ERR_ARG_INCOMP, "18 nodes along y, and the lattice 17");
    refused(compute(transform, ring, lattice, band, of_ring), PETSC_ERR_SUP, "The boundary along x is PERIODIC");
    refused(compute(transform, flat, lattice, band, of_flat), PETSC_ERR_SUP, "has 2 dimensions");
    refused(compute(transform, grid, lattice, band, of_ring), PETSC_ERR_ARG_INCOMP, "fits neither");
    refused(compute(transform, grid, lattice, band, local, 2), PETSC_ERR_ARG_OUTOFRANGE,
            "The distance takes 1 components from 2 on, and the DMDA has 2");
    refused(compute(transform, grid, lattice, band, local, -1), PETSC_ERR_ARG_OUTOFRANGE, "from -1 on");
    refused(compute(transform, grid, lattice, clsdf::Band::symmetric(-1), local), PETSC_ERR_LIB, "invalid_argument");
    const std::vector<Component> overlap{{Output::distance, 0}, {Output::triangle, 1}};
    refused(compute(transform, grid, lattice, band, local, overlap), PETSC_ERR_SUP, "unsupported");
    PetscCall(PetscPopErrorHandler());
    PetscCall(compute(transform, grid, lattice, band, local, 1));  // the vector is as usable as before
    for (Vec* vector : {&local, &of_ring, &whole_ring, &of_flat}) PetscCall(VecDestroy(vector));
    for (DM* dm : {&grid, &ring, &flat}) PetscCall(DMDestroy(dm));
    PetscFunctionReturn(PetscErrorCode{});
}

/// Two levels of a multigrid hierarchy in one call, against a call for each.
PetscErrorCode try_levels(const clsdf::DistanceTransform& transform, const clsdf::Grid& lattice,
                          const clsdf::Band& band) {
    DM grids[2] = {nullptr, nullptr};
    Vec levels[2] = {nullptr, nullptr};
    PetscFunctionBegin;
    PetscCall(make(DM_BOUNDARY_NONE, 1, 1, grids[0]));

    PetscCall(DMRefine(grids[0], PETSC_COMM_WORLD, &grids[1]));
    const std::array<clsdf::Grid, 2> lattices{lattice, lattice.refined(2)};
    const clsdf::petsc::Component distance{clsdf::Output::distance, 0};
    std::array<clsdf::Request, 2> requests;
    std::array<PetscScalar*, 2> values{};
    for (std::size_t n = 0; n < 2; ++n) {
        PetscCall(DMCreateLocalVector(grids[n], &levels[n]));
        PetscCall(VecGetArray(levels[n], &values[n]));
        PetscCall(clsdf::petsc::request_of(grids[n], lattices[n], band, levels[n], values[n], std::span(&distance, 1),
                                           requests[n]));
    }
    PetscCall(clsdf::petsc::guarded([&] { transform.compute(requests); }));
    for (std::size_t n = 0; n < 2; ++n) PetscCall(VecRestoreArray(levels[n], &values[n]));

    for (std::size_t n = 0; n < 2; ++n) {
        Vec alone = nullptr;
        PetscBool same = PETSC_FALSE;
        PetscCall(VecDuplicate(levels[n], &alone));
        PetscCall(VecSet(alone, untouched));
        PetscCall(clsdf::petsc::compute(transform, grids[n], lattices[n], band, alone));
        PetscCall(VecEqual(levels[n], alone, &same));
        check(same == PETSC_TRUE, "a level differs from a call of its own", n);
        PetscCall(VecDestroy(&alone));
        PetscCall(VecDestroy(&levels[n]));
        PetscCall(DMDestroy(&grids[n]));
    }
    PetscFunctionReturn(PetscErrorCode{});
}

PetscErrorCode write_field(const clsdf::DistanceTransform& transform, const clsdf::Grid& lattice, const char* file) {
    DM grid = nullptr;
    Vec global = nullptr;
    PetscViewer viewer = nullptr;
    const std::vector<Component> outputs{{Output::gradient, 0}, {Output::distance, 3}};
    PetscFunctionBegin;
    PetscCall(make(DM_BOUNDARY_NONE, 4, 1, grid));
    PetscCall(DMCreateGlobalVector(grid, &global));
    PetscCall(clsdf::petsc::compute(transform, grid, lattice, clsdf::Band::full(), global, outputs));
    PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, file, FILE_MODE_WRITE, &viewer));
    PetscCall(VecView(global, viewer));
    PetscCall(PetscViewerDestroy(&viewer));
    PetscCall(VecDestroy(&global));
    PetscCall(DMDestroy(&grid));
    PetscFunctionReturn(PetscErrorCode{});
}

}  // namespace

int main(int argc, char** argv) {
    PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
    {
        PetscMPIInt rank = 0, ranks = 1;
        PetscCall(clsdf_petsc_rank_on_node(PETSC_COMM_WORLD, &rank, &ranks));
        const clsdf::Mesh mesh = clsdf::make_shape("torus");
        clsdf::Grid lattice = clsdf::Grid::around(mesh, 20, clsdf::Band::full());
        for (std::size_t axis = 0; axis < 3; ++axis) lattice.size[axis] = samples[axis];
        const auto device = clsdf::Device::of_rank(static_cast<std::size_t>(rank), static_cast<std::size_t>(ranks));
        const clsdf::DistanceTransform transform(device, mesh);
        const std::vector<Case> cases{
            {DM_BOUNDARY_NONE, 1, 1, {{Output::distance, 0}}},
            {DM_BOUNDARY_GHOSTED, 1, 2, {{Output::distance, 0}}},
            {DM_BOUNDARY_GHOSTED, 3, 2, {{Output::distance, 1}}},
            {DM_BOUNDARY_GHOSTED, 9, 3, {{Output::closest, 1}, {Output::distance, 4}, {Output::gradient, 5}}},
            {DM_BOUNDARY_NONE, 5, 0, {{Output::gradient, 0}, {Output::distance, 4}}},
        };
        for (std::size_t n = 0; n < cases.size(); ++n) PetscCall(try_case(transform, lattice, cases[n], n));
        PetscCall(try_levels(transform, lattice, clsdf::Band::symmetric(4 * lattice.voxel())));
        PetscCall(try_refusals(transform, lattice));
        if (argc > 1) PetscCall(write_field(transform, lattice, argv[1]));
    }
    PetscCall(PetscFinalize());
    return failures == 0 ? 0 : 1;
}
