! A solid that moves through a fixed grid: 100 steps of a rigid motion, each with a new field in the simulation's memory. A
! motion is always that of the first positions, so no error adds up: a body that comes back to its first place has its first
! field, byte for byte.
!
! moving_body [STEPS [RESOLUTION]]
program moving_body
  use, intrinsic :: iso_c_binding
  use clsdf
  use example
  implicit none
  real(8), parameter :: pi = 3.14159265358979323846d0
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  type(clsdf_band) :: band
  type(clsdf_box) :: box
  type(clsdf_kept_memory) :: memory
  real(4), allocatable, target :: distance(:, :, :)
  real(4), allocatable :: first(:, :, :)
  real(8) :: identity(3, 3), first_volume, largest_change, side
  integer :: steps, step
  logical :: as_before

  ! The simulation's grid, which has room for all places of the body.
  steps = argument(1, 100)
  call mesh%shape('knot')
  box = mesh%box()
  side = maxval(box%upper - box%lower)
  box%upper = 0.8d0*side
  box%lower = -box%upper
  call grid%around(box, argument(2, 64))
  band = clsdf_band_symmetric(3*grid%voxel())
  allocate (distance(grid%size(1), grid%size(2), grid%size(3)))

  call device%automatic()
  call transform%create(device, mesh)
  call transform%compute(grid, band, distance)
  first = distance
  first_volume = volume()
  largest_change = 0
  do step = 1, steps
    call move(2*pi*(real(step, 8)/steps))
    call transform%compute(grid, band, distance)
    if (mod(step, 25) == 0) call record(c_loc(distance), 4*size(distance))
    largest_change = max(largest_change, abs(volume()/first_volume - 1))
  end do
  memory = transform%memory()

  identity = reshape([1d0, 0d0, 0d0, 0d0, 1d0, 0d0, 0d0, 0d0, 1d0], [3, 3])
  call transform%set_motion(identity, [0d0, 0d0, 0d0])
  call transform%compute(grid, band, distance)
  as_before = all(transfer(distance, [0]) == transfer(first, [0]))
  print '(i0, a, f0.2, a, f0.1, a, f0.1, a)', steps, ' steps: the volume changes by at most ', 100*largest_change, '%; ', &
      1d-6*memory%host_bytes, ' MB kept on the host, ', 1d-6*memory%device_bytes, ' MB on the device'
  print '(3a)', 'back at its first place, the body has ', merge('its first', 'ANOTHER  ', as_before), ' field'
  if (.not. as_before .or. largest_change >= 0.02d0) error stop 1

contains

  ! Once around z, and along x and back.
  subroutine move(angle)
    real(8), intent(in) :: angle
    real(8) :: c, s
    c = cos(angle)
    s = sin(angle)
    ! Column by column.
    call transform%set_motion(reshape([c, s, 0d0, -s, c, 0d0, 0d0, 0d0, 1d0], [3, 3]), [0.2d0*s, 0d0, 0d0])
  end subroutine

  ! The volume inside: a cell that the surface crosses counts by its part, which the distance tells to first order.
  real(8) function volume()
    volume = sum(max(0d0, min(1d0, 0.5d0 - distance/grid%voxel())))*product(grid%spacing)
  end function

end program
