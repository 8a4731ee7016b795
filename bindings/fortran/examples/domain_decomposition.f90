! A grid is divided among the ranks of a parallel simulation. Each rank has a layer of ghost samples, and keeps only what its
! block needs of the mesh.
!
! A part of a grid keeps the origin and spacing of the grid, and has the same bytes as the whole. So ghost samples are equal
! on both sides and need no exchange. A transform that is restricted to the block gives these bytes, too.
program domain_decomposition
  use, intrinsic :: iso_c_binding
  use clsdf
  use example
  implicit none
  integer, parameter :: ranks = 3, ghosts = 2
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: all_of_it
  type(clsdf_field) :: field
  type(clsdf_grid) :: domain
  type(clsdf_band) :: band
  type(clsdf_box) :: box
  real(4), pointer :: whole(:, :, :)
  integer :: rank, wrong

  call mesh%shape('knot')
  box = mesh%box()
  band = clsdf_band_symmetric(0.03d0*maxval(box%upper - box%lower))
  call grid_of_domain(domain)

  ! This example is one process; in a simulation every rank makes its own transform.
  call device%automatic()
  call all_of_it%create(device, mesh)
  call all_of_it%compute_field(domain, band, field)
  call field%array(CLSDF_DISTANCE, whole)
  wrong = 0
  do rank = 0, ranks - 1
    wrong = wrong + differences(block_of(rank))
  end do
  print '(a)', merge('as it should be', 'WRONG          ', wrong == 0)
  if (wrong > 0) error stop 1

contains

  subroutine grid_of_domain(grid)
    type(clsdf_grid), intent(out) :: grid
    call grid%around(mesh, 100, band)
  end subroutine

  ! The samples of one rank along x, with a ghost layer on each side that has a neighbour.
  type(clsdf_grid) function block_of(rank)
    integer, intent(in) :: rank
    integer(8) :: samples, first, last
    samples = domain%size(1)
    first = max(samples*rank/ranks + 1 - ghosts, 1_8)
    last = min(samples*(rank + 1)/ranks + ghosts, samples)
    block_of = domain%part([first, 1_8, 1_8], [last - first + 1, domain%size(2:3)])
  end function

  ! The number of samples that differ between the block, by the transform of its rank, and the whole.
  integer function differences(block)
    type(clsdf_grid), intent(in) :: block
    type(clsdf_transform) :: transform
    real(4), allocatable, target :: distance(:, :, :)  ! memory of the simulation, with the domain's indices
    integer(8) :: first(3), last(3)
    ! The largest spacing of the block is its voxel, as all three are equal.
    call all_of_it%restrict([clsdf_region(block%box(), band%outside, block%voxel())], transform)
    first = block%first
    last = block%last()
    allocate (distance(first(1):last(1), first(2):last(2), first(3):last(3)))
    call transform%compute(block, band, distance)
    call record(c_loc(distance), 4*size(distance))
    differences = count(transfer(distance, [0]) /= transfer(whole(first(1):last(1), :, :), [0]))
    print '(a, 2(i0, a), i0, a)', 'a rank with samples ', first(1), ' to ', last(1), ' of x, ', differences, &
        ' of them different from the whole''s'
  end function

end program
