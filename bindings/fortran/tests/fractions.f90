! Fractions of cells of a bar of two cubes that overlap: rows, and arrays in AMReX's order.
program fractions
  use, intrinsic :: iso_c_binding
  use clsdf
  use test
  implicit none
  real(8), parameter :: cube(3, 8) = reshape([-1d0, -1d0, -1d0, 1d0, -1d0, -1d0, -1d0, 1d0, -1d0, 1d0, 1d0, -1d0, -1d0, &
      -1d0, 1d0, 1d0, -1d0, 1d0, -1d0, 1d0, 1d0, 1d0, 1d0, 1d0], [3, 8])
  integer(4), parameter :: sides(3, 12) = reshape([1, 3, 4, 1, 4, 2, 5, 6, 8, 5, 8, 7, 1, 2, 6, 1, 6, 5, 3, 7, 8, 3, 8, 4, &
      1, 5, 7, 1, 7, 3, 2, 4, 8, 2, 8, 6], [3, 12])
  integer, parameter :: nx = 7, ny = 5, nz = 5
  real(8) :: vertices(3, 16)
  integer(4) :: faces(3, 24)
  real(8), target :: volume(nx, ny, nz), normal(nx, ny, nz, 3), across_y(nx, ny + 1, nz)
  integer(1), target :: types(nx, ny, nz)
  type(clsdf_mesh) :: mesh, surface
  type(clsdf_grid) :: grid
  type(clsdf_fraction_request) :: request
  type(clsdf_fraction_options) :: options
  type(clsdf_cell_fraction), allocatable :: cells(:)
  integer :: stat, j
  character(400) :: errmsg

  vertices(:, 1:8) = cube
  vertices(:, 9:) = cube
  vertices(1, 9:) = vertices(1, 9:) + 1
  faces(:, 1:12) = sides
  faces(:, 13:) = sides + 8
  call mesh%create(vertices, faces, 'bar')
  ! Samples a quarter of a cell beyond the walls; the first one is number 1.
  grid%origin = -1.25d0
  grid%spacing = 0.5d0
  grid%size = [nx + 1, ny + 1, nz + 1]
  call mesh%fractions(grid, cells)
  call check(size(cells) == nx*ny*nz - 5*3*3 .and. all(cells%pieces == 1), 'the cells of the walls')
  call check(abs(sum(cells%volume)*0.125d0 + 45*0.125d0 - 12) < 1d-12, 'the volume')
  call check(abs(sum(cells%area) - 32) < 1d-12, 'the area')
  call check(all(cells(1)%cell == int(grid%first)) .and. all(abs(cells(1)%centroid - 0.25d0) < 1d-12) .and. &
      abs(cells(1)%face_fractions(2) - 0.25d0) < 1d-12, 'a corner')

  call mesh%outer(surface)
  options = clsdf_fraction_convention('amrex')
  call check(options%part == CLSDF_PART_FLUID .and. options%walls == CLSDF_WALL_FLUID .and. &
      options%no_surface_centroid == -1, 'a convention')
  request%grid = grid
  request%types = clsdf_array(types)
  request%volume = clsdf_array(volume)
  request%normal = clsdf_array(normal)
  request%face_fractions(2) = clsdf_array(across_y)
  call surface%fraction_arrays([request], options)
  call check(abs(sum(1 - volume)*0.125d0 - 12) < 1d-12, 'the volume of the fluid')
  call check(count(types == CLSDF_CELL_CUT) == size(cells) .and. all(types(2:6, 2:4, 2:4) == CLSDF_CELL_EMPTY), 'types')
  call check(all(normal(3, 1, 3, :) == [0d0, 1d0, 0d0]) .and. volume(3, 1, 3) == 0.5d0, 'a wall across y')
  do j = 1, ny + 1
    call check(across_y(3, j, 3) == merge(1d0, 0d0, j == 1 .or. j == ny + 1), 'faces across y')
  end do

  request%volume = clsdf_array(across_y)
  call surface%fraction_arrays([request], options, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'volume')
  ! Memory of a device is no array of the host.
  request = clsdf_fraction_request()
  request%grid = grid
  request%volume = clsdf_array(c_loc(volume), CLSDF_FLOAT64)
  call surface%fraction_arrays([request], options, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'device')
  options = clsdf_fraction_convention('vof', stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'vof')
end program
