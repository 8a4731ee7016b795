! The start of a level set method: the signed distance, its gradient and the closest point in a narrow band, from one call.
! The distance is exact, so no reinitialisation is needed, and velocities of the surface are extended along the normals by
! looking them up at the closest point.
!
! level_set_start [RESOLUTION]
program level_set_start
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use clsdf
  use example
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  real(4), allocatable, target :: phi(:, :, :), normal(:, :, :, :)
  real(8), allocatable, target :: closest(:, :, :, :)
  real(8) :: fastest, largest_gap, speed, gap(3)
  integer :: i, j, k, in_band

  call mesh%shape('knot')
  call grid%around(mesh%box(), argument(1, 96), margin=clsdf_length(4, CLSDF_VOXELS))
  allocate (phi(grid%size(1), grid%size(2), grid%size(3)), normal(3, grid%size(1), grid%size(2), grid%size(3)), &
      closest(3, grid%size(1), grid%size(2), grid%size(3)))
  call device%automatic()
  call transform%create(device, mesh)
  ! Arrays of several kinds: as targets.
  call transform%compute(grid, clsdf_band_symmetric(4*grid%voxel()), [clsdf_target(CLSDF_DISTANCE, phi), &
      clsdf_target(CLSDF_CLOSEST, closest), clsdf_target(CLSDF_GRADIENT, normal)])
  call record(c_loc(phi), 4*size(phi))
  call record(c_loc(closest), 8*size(closest))
  call record(c_loc(normal), 4*size(normal))

  in_band = 0
  fastest = 0
  largest_gap = 0
  do k = 1, size(phi, 3)
    do j = 1, size(phi, 2)
      do i = 1, size(phi, 1)
        if (ieee_is_nan(closest(1, i, j, k))) cycle  ! beyond the band
        in_band = in_band + 1
        ! The velocity on the surface, of a body that turns around z, carried along the normal.
        speed = dot_product([-closest(2, i, j, k), closest(1, i, j, k), 0d0], normal(:, i, j, k))
        gap = grid%position(i, j, k) - phi(i, j, k)*real(normal(:, i, j, k), 8) - closest(:, i, j, k)
        fastest = max(fastest, speed)
        largest_gap = max(largest_gap, norm2(gap)/grid%voxel())
      end do
    end do
  end do
  print '(2(i0, a), f0.3)', in_band, ' of ', size(phi), ' samples in the band; the largest speed along the normal is ', fastest
  print '(a, es8.1, a)', 'position - phi * normal is the closest point within', largest_gap, ' voxel'
  if (in_band == 0 .or. fastest <= 0 .or. largest_gap >= 1d-4) error stop 1
end program
