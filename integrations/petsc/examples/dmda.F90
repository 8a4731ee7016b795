! The distance to a mesh and its gradient in a distributed grid of PETSc, and a file of it in HDF5.
!
! mpirun -n 4 dmda_fortran -mesh bunny.off -n 128 -file bunny.h5
#include <petsc/finclude/petsc.h>
program dmda
  use petsc
  use clsdf
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: lattice
  character(PETSC_MAX_PATH_LEN) :: path, file
  character(500) :: message
  PetscInt :: samples, first(3), size(3)
  PetscScalar, pointer :: state(:, :, :, :)
  PetscMPIInt :: node, rank, ranks, failed, any_failed
  PetscBool :: given
  PetscErrorCode :: ierr
  DM :: grid
  Vec :: local, global
  PetscViewer :: viewer

  PetscCallA(PetscInitialize(ierr))
  samples = 64
  file = 'distance.h5'
  PetscCallA(PetscOptionsGetInt(PETSC_NULL_OPTIONS, PETSC_NULL_CHARACTER, '-n', samples, given, ierr))
  PetscCallA(PetscOptionsGetString(PETSC_NULL_OPTIONS, PETSC_NULL_CHARACTER, '-file', file, given, ierr))
  PetscCallA(PetscOptionsGetString(PETSC_NULL_OPTIONS, PETSC_NULL_CHARACTER, '-mesh', path, given, ierr))

  ! The transform of this rank, with its share of the machine. Without stat, an error of clsdf ends the program.
  PetscCallMPIA(MPI_Comm_split_type(PETSC_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, node, ierr))
  PetscCallMPIA(MPI_Comm_rank(node, rank, ierr))
  PetscCallMPIA(MPI_Comm_size(node, ranks, ierr))
  PetscCallMPIA(MPI_Comm_free(node, ierr))
  call device%of_rank(rank, ranks)
  if (given) then
    call mesh%read(trim(path))
  else
    call mesh%shape('knot')
  end if
  call lattice%around(mesh%box(), resolution=samples, cubic=.true.)
  call transform%create(device, mesh)

  ! Four components: the distance and its gradient. Two samples of ghosts, beyond the boundary, too.
  PetscCallA(DMDACreate(PETSC_COMM_WORLD, grid, ierr))
  PetscCallA(DMSetDimension(grid, 3, ierr))
  PetscCallA(DMDASetSizes(grid, samples, samples, samples, ierr))
  PetscCallA(DMDASetBoundaryType(grid, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED, ierr))
  PetscCallA(DMDASetStencilType(grid, DMDA_STENCIL_BOX, ierr))
  PetscCallA(DMDASetStencilWidth(grid, 2, ierr))
  PetscCallA(DMDASetDof(grid, 4, ierr))
  PetscCallA(DMSetUp(grid, ierr))
  PetscCallA(DMCreateLocalVector(grid, local, ierr))

  ! This rank's block, ghosts included. PETSc counts components and samples from 0, clsdf counts samples from 1.
  PetscCallA(DMDAGetGhostCorners(grid, first(1), first(2), first(3), size(1), size(2), size(3), ierr))
  PetscCallA(DMDAVecGetArrayF90(grid, local, state, ierr))
  call transform%compute(lattice%block(first + 1, size), clsdf_band_full(), state(0, :, :, :), &
      gradient=state(1:3, :, :, :), stat=failed, errmsg=message)
  PetscCallA(DMDAVecRestoreArrayF90(grid, local, state, ierr))
  if (failed /= 0) write (*, '(a)') trim(message)

  ! The next call is collective: all ranks must know of an error on one.
  PetscCallMPIA(MPI_Allreduce(failed, any_failed, 1, MPI_INTEGER, MPI_MAX, PETSC_COMM_WORLD, ierr))
  if (any_failed == 0) then
    PetscCallA(DMCreateGlobalVector(grid, global, ierr))
    PetscCallA(DMLocalToGlobal(grid, local, INSERT_VALUES, global, ierr))
    PetscCallA(PetscObjectSetName(global, 'distance', ierr))
    PetscCallA(PetscViewerCreate(PETSC_COMM_WORLD, viewer, ierr))
    PetscCallA(PetscViewerSetType(viewer, PETSCVIEWERHDF5, ierr))
    PetscCallA(PetscViewerFileSetMode(viewer, FILE_MODE_WRITE, ierr))
    PetscCallA(PetscViewerFileSetName(viewer, file, ierr))
    PetscCallA(VecView(global, viewer, ierr))
    PetscCallA(PetscViewerDestroy(viewer, ierr))
    PetscCallA(VecDestroy(global, ierr))
  end if
  PetscCallA(VecDestroy(local, ierr))
  PetscCallA(DMDestroy(grid, ierr))
  call transform%release()
  PetscCallA(PetscFinalize(ierr))
  if (any_failed /= 0) error stop
end program
