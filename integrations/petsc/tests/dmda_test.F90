! Fields in DMDAs from Fortran: every sample and ghost has the bytes of the whole, ghosts are what their owners would
! send, and other components stay.
#include <petsc/finclude/petsc.h>
program dmda_test
  use petsc
  use clsdf
  implicit none
  PetscInt, parameter :: samples(3) = [19, 14, 16], ghosts = 2
  PetscScalar, parameter :: untouched = -7
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: lattice
  type(clsdf_band) :: band
  PetscScalar, allocatable :: distance(:, :, :), gradient(:, :, :, :)
  PetscMPIInt :: node, rank, ranks
  PetscErrorCode :: ierr
  integer :: failures = 0

  PetscCallA(PetscInitialize(ierr))
  PetscCallMPIA(MPI_Comm_split_type(PETSC_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, node, ierr))
  PetscCallMPIA(MPI_Comm_rank(node, rank, ierr))
  PetscCallMPIA(MPI_Comm_size(node, ranks, ierr))
  PetscCallMPIA(MPI_Comm_free(node, ierr))
  call device%of_rank(rank, ranks)
  call mesh%shape('torus')
  call transform%create(device, mesh)
  call lattice%around(mesh, 16, clsdf_band_full())
  lattice%size = samples
  band = clsdf_band_symmetric(4*lattice%voxel())

  ! The whole, with the ghosts beyond the boundary, in arrays of this rank.
  associate (low => 1 - ghosts, high => samples + ghosts)
    allocate (distance(low:high(1), low:high(2), low:high(3)), gradient(3, low:high(1), low:high(2), low:high(3)))
  end associate
  call transform%compute(lattice%grown(int(ghosts)), band, distance, gradient=gradient)
  call one_component()
  call four_of_six()
  PetscCallA(PetscFinalize(ierr))
  if (failures > 0) error stop

contains

  subroutine check(holds, what)
    logical, intent(in) :: holds
    character(*), intent(in) :: what
    if (holds) return
    print '(2a)', 'dmda_test: ', what
    failures = failures + 1
  end subroutine

  !> The same bytes, those of NaN included.
  logical function same(a, b)
    PetscScalar, intent(in) :: a(:, :, :), b(:, :, :)
    integer(1), parameter :: mold(1) = 0
    same = all(transfer(a, mold) == transfer(b, mold))
  end function

  subroutine make(components, grid, local)
    PetscInt, intent(in) :: components
    DM, intent(out) :: grid
    Vec, intent(out) :: local
    PetscCallA(DMDACreate(PETSC_COMM_WORLD, grid, ierr))
    PetscCallA(DMSetDimension(grid, 3, ierr))
    PetscCallA(DMDASetSizes(grid, samples(1), samples(2), samples(3), ierr))
    PetscCallA(DMDASetBoundaryType(grid, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED, DM_BOUNDARY_GHOSTED, ierr))
    PetscCallA(DMDASetStencilType(grid, DMDA_STENCIL_BOX, ierr))
    PetscCallA(DMDASetStencilWidth(grid, ghosts, ierr))
    PetscCallA(DMDASetDof(grid, components, ierr))
    PetscCallA(DMSetUp(grid, ierr))
    PetscCallA(DMCreateLocalVector(grid, local, ierr))
    PetscCallA(VecSet(local, untouched, ierr))
  end subroutine

  !> The first and the last sample of this rank's local part, counted from 1.
  subroutine bounds(grid, first, last)
    DM, intent(in) :: grid
    PetscInt, intent(out) :: first(3), last(3)
    PetscInt :: size(3)
    PetscCallA(DMDAGetGhostCorners(grid, first(1), first(2), first(3), size(1), size(2), size(3), ierr))
    first = first + 1
    last = first + size - 1
  end subroutine

  !> What the owners send over the ghosts is there already.
  subroutine check_sent(grid, local)
    DM, intent(in) :: grid
    Vec, intent(in) :: local
    Vec :: global, sent
    PetscScalar, pointer :: a(:), b(:)
    integer(1), parameter :: mold(1) = 0
    PetscCallA(DMCreateGlobalVector(grid, global, ierr))
    PetscCallA(DMLocalToGlobal(grid, local, INSERT_VALUES, global, ierr))
    PetscCallA(VecDuplicate(local, sent, ierr))
    PetscCallA(VecCopy(local, sent, ierr))
    PetscCallA(DMGlobalToLocal(grid, global, INSERT_VALUES, sent, ierr))
    PetscCallA(VecGetArrayReadF90(local, a, ierr))
    PetscCallA(VecGetArrayReadF90(sent, b, ierr))
    call check(all(transfer(a, mold) == transfer(b, mold)), 'a ghost differs from its owner')
    PetscCallA(VecRestoreArrayReadF90(local, a, ierr))
    PetscCallA(VecRestoreArrayReadF90(sent, b, ierr))
    PetscCallA(VecDestroy(global, ierr))
    PetscCallA(VecDestroy(sent, ierr))
  end subroutine

  subroutine one_component()
    DM :: grid
    Vec :: local
    PetscScalar, pointer :: phi(:, :, :)
    PetscInt :: a(3), b(3)
    call make(1, grid, local)
    call bounds(grid, a, b)
    PetscCallA(DMDAVecGetArrayF90(grid, local, phi, ierr))
    call transform%compute(lattice%block(a, b - a + 1), band, phi)
    call check(all(lbound(phi) == a - 1), 'samples of PETSc count from 0')
    call check(same(phi, distance(a(1):b(1), a(2):b(2), a(3):b(3))), 'one component: the bytes are not those of the whole')
    PetscCallA(DMDAVecRestoreArrayF90(grid, local, phi, ierr))
    call check_sent(grid, local)
    PetscCallA(VecDestroy(local, ierr))
    PetscCallA(DMDestroy(grid, ierr))
  end subroutine

  subroutine four_of_six()
    DM :: grid
    Vec :: local
    PetscScalar, pointer :: state(:, :, :, :)
    PetscInt :: a(3), b(3), c
    call make(6, grid, local)
    call bounds(grid, a, b)
    PetscCallA(DMDAVecGetArrayF90(grid, local, state, ierr))
    call transform%compute(lattice%block(a, b - a + 1), band, state(4, :, :, :), gradient=state(1:3, :, :, :))
    call check(all(lbound(state) == [0, a - 1]), 'components and samples of PETSc count from 0')
    call check(same(state(4, :, :, :), distance(a(1):b(1), a(2):b(2), a(3):b(3))), 'another distance')
    do c = 1, 3
      call check(same(state(c, :, :, :), gradient(c, a(1):b(1), a(2):b(2), a(3):b(3))), 'another gradient')
    end do
    call check(all(state(0, :, :, :) == untouched) .and. all(state(5, :, :, :) == untouched), 'other components changed')
    PetscCallA(DMDAVecRestoreArrayF90(grid, local, state, ierr))
    call check_sent(grid, local)
    PetscCallA(VecDestroy(local, ierr))
    PetscCallA(DMDestroy(grid, ierr))
  end subroutine
end program
