! Links and crossings of a sphere agree with each other and with the sides of its samples.
program links
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use clsdf
  use test
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  type(clsdf_links), target :: found
  type(clsdf_crossings) :: edges(3)
  integer(4), allocatable :: directions(:, :)
  integer(1), allocatable :: inside(:, :, :)
  integer(8) :: count, n, i, along_x
  integer :: stat
  character(300) :: errmsg

  call device%automatic()
  call mesh%shape('sphere3')
  call transform%create(device, mesh)
  call grid%around(mesh, 24, clsdf_band_symmetric(0.1d0))
  call clsdf_stencil('D3Q19', 'OpenLB', directions)
  call check(size(directions, 2) == 19 .and. all(directions(:, 11) == [1, 0, 0]), 'the stencil')
  call clsdf_stencil('D3Q20', 'OpenLB', directions, stat, errmsg)
  call check(stat == CLSDF_INVALID_ARGUMENT .and. index(errmsg, 'D3Q20') > 0, 'no stencil')
  call clsdf_stencil('D3Q19', 'OpenLB', directions)

  call transform%count_links(grid, directions, count)
  call transform%links(grid, directions, found)
  call check(size(found%q, kind=8) == count .and. count > 1000, 'the number of links')
  call check(all(found%q >= 0 .and. found%q <= 1 .and. found%counts == 1 .and. found%flags == 0), 'the parts')
  call check(all(found%triangles >= 1 .and. found%triangles <= 1280), 'the triangles')
  call transform%crossings(grid, edges, inside, with_counts=.true.)
  call check(all(inside == found%inside) .and. any(inside == 1), 'the sides')
  along_x = 0
  do n = 1, count
    if (found%directions(n) /= 11) cycle
    along_x = along_x + 1
    i = found%samples(1, n)
    if (i > grid%size(1) - 1) cycle
    call check(abs(edges(1)%coordinates(i, found%samples(2, n), found%samples(3, n)) - grid%origin(1) - &
        grid%spacing(1)*(i - 1 + found%q(n))) < 1d-14, 'a crossing')
    call check(edges(1)%triangles(i, found%samples(2, n), found%samples(3, n)) == found%triangles(n), 'a triangle')
  end do
  call check(along_x > 100, 'links along x')
  call check(sum(edges(1)%counts) == 2*along_x .and. ieee_is_nan(edges(1)%coordinates(1, 1, 1)), 'the counts')
end program
