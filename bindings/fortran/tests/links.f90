module taken_links
  use, intrinsic :: iso_c_binding
  use clsdf
  use test
  implicit none
  type, extends(clsdf_link_sink) :: collector
    type(clsdf_links) :: whole
    integer(8) :: links = 0, slabs = 0
  contains
    procedure :: take_links => take
  end type

contains

  subroutine take(sink, part, links, status)
    class(collector), intent(inout) :: sink
    type(clsdf_grid), intent(in) :: part
    type(clsdf_links), intent(in) :: links
    integer(c_int32_t), intent(inout) :: status
    integer(8) :: n, first, last
    n = size(links%q, kind=8)
    if (n == 0) then
      status = CLSDF_CANCELLED
      return
    end if
    first = sink%links + 1
    last = sink%links + n
    call check(all(shape(links%inside) == part%size) .and. any(links%inside == 1), 'the sides of a slab')
    call check(all(links%samples == sink%whole%samples(:, first:last)) .and. &
        all(links%directions == sink%whole%directions(first:last)) .and. all(links%q == sink%whole%q(first:last)) .and. &
        all(links%triangles == sink%whole%triangles(first:last)) .and. all(links%counts == 1) .and. &
        all(links%flags == 0), 'the rows of a slab')
    sink%links = last
    sink%slabs = sink%slabs + 1
  end subroutine
end module

! Links and crossings of a sphere agree with each other and with the sides of its samples.
program links
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use clsdf
  use test
  use taken_links
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  type(clsdf_links), target :: found
  type(clsdf_crossings) :: edges(3)
  type(collector) :: slabs
  type(clsdf_statistics) :: statistics
  real(8), allocatable :: dense(:, :, :, :)
  real(4), allocatable :: floats(:, :, :, :)
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
  slabs%whole = found
  call transform%link_slabs(grid, directions, slabs, statistics=statistics)
  call check(slabs%links == count .and. slabs%slabs == 1 .and. statistics%slabs == 1, 'the links of the slabs')
  call transform%link_slabs(grid%part([1_8, 1_8, 1_8], [3_8, 3_8, 3_8]), directions, slabs, stat=stat, errmsg=errmsg)
  call check(stat == CLSDF_CANCELLED, 'a sink that ends the call')
  allocate (dense(grid%size(1), grid%size(2), grid%size(3), 19), floats(grid%size(1), grid%size(2), grid%size(3), 19))
  allocate (inside(grid%size(1), grid%size(2), grid%size(3)))
  call transform%links_dense(grid, directions, dense, inside)
  call transform%links_dense(grid, directions, floats)
  call check(size(pack(dense, dense >= 0), kind=8) == count .and. all(dense >= 0 .or. dense == -1), 'the dense array')
  call check(all(abs(floats - dense) < 1e-7) .and. all(inside == found%inside), 'the dense array of floats')
  do n = 1, count
    call check(dense(found%samples(1, n), found%samples(2, n), found%samples(3, n), found%directions(n)) == found%q(n), &
        'a part in the dense array')
  end do
  call transform%links_dense(grid, directions(:, :18), dense, stat=stat, errmsg=errmsg)
  call check(stat == CLSDF_INVALID_ARGUMENT .and. index(errmsg, 'dense array has the shape') > 0, 'a dense array too large')
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
