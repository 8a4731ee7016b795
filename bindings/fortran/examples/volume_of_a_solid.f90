! From arrays in memory to a signed distance field, and a use of it.
!
! A simulation has a solid as arrays of vertices and triangles. It needs to know which of its cells are solid, the solid
! share of a cell on the surface, and the triangle of the wall that is nearest to a fluid particle.
program volume_of_a_solid
  use, intrinsic :: iso_c_binding
  use clsdf
  use example
  implicit none
  integer, parameter :: around = 120, across = 48
  real(8), parameter :: pi = 3.14159265358979323846d0
  real(8) :: vertices(3, around*across)
  integer :: triangles(3, 2*around*across)  ! from 1
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  type(clsdf_band) :: band
  type(clsdf_call_options) :: options
  real(4), allocatable, target :: distance(:, :, :)
  integer, allocatable, target :: triangle(:, :, :), from_0(:, :, :)
  real(8) :: h, exact, by_counting, by_distance
  integer :: at(3)
  logical :: right

  call make_torus(1d0, 0.4d0)
  options%log => say

  ! A mesh is a checked copy of the arrays. One transform serves many grids.
  call mesh%create(vertices, triangles, 'torus')
  call device%automatic()
  call transform%create(device, mesh, options=options)

  ! Distances up to a tenth of a unit on both sides of the surface; 96 samples on the longest side.
  band = clsdf_band_symmetric(0.1d0)
  call grid%around(mesh, 96, band)
  allocate (distance(grid%size(1), grid%size(2), grid%size(3)), triangle(grid%size(1), grid%size(2), grid%size(3)))
  call transform%compute(grid, band, distance, triangle)
  call record(c_loc(distance), 4*size(distance))
  from_0 = triangle - 1  ! as the other languages count
  call record(c_loc(from_0), 4*size(from_0))

  ! A cell is solid if its centre is inside, in the band or beyond it. The distance gives the solid share of a cell on the
  ! surface.
  h = grid%voxel()
  by_counting = count(distance < 0)*h**3
  by_distance = sum(max(0d0, min(1d0, 0.5d0 - distance/h)))*h**3
  exact = exact_volume()
  print '(3(a, f0.5))', 'volume: ', exact, ' by the triangles, ', by_counting, ' by counting cells, ', by_distance, &
      ' by the distance'

  ! A particle beside the tube's outer rim: its distance to the wall, and the nearest triangle.
  at = nint(([1.45d0, 0d0, 0d0] - grid%origin)/h) + 1
  print '(a, f0.5, a, i0)', 'a particle ', distance(at(1), at(2), at(3)), ' from the wall, nearest to triangle ', &
      triangle(at(1), at(2), at(3))

  right = abs(by_counting - exact) < 0.01d0*exact .and. abs(by_distance - exact) < 0.001d0*exact .and. &
      triangle(at(1), at(2), at(3)) >= 1 .and. triangle(at(1), at(2), at(3)) <= size(triangles, 2)
  print '(a)', merge('as it should be', 'WRONG          ', right)
  if (.not. right) error stop 1

contains

  integer function vertex(a, b)
    integer, intent(in) :: a, b
    vertex = mod(a, around)*across + mod(b, across) + 1
  end function

  subroutine make_torus(ring_radius, tube_radius)
    real(8), intent(in) :: ring_radius, tube_radius
    real(8) :: u, w, radius
    integer :: i, j, t
    t = 1
    do i = 0, around - 1
      do j = 0, across - 1
        u = 2*pi*i/around
        w = 2*pi*j/across
        radius = ring_radius + tube_radius*cos(w)
        vertices(:, vertex(i, j)) = [radius*cos(u), radius*sin(u), tube_radius*sin(w)]
        triangles(:, t) = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)]
        triangles(:, t + 1) = [vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)]
        t = t + 2
      end do
    end do
  end subroutine

  ! By the divergence theorem.
  real(8) function exact_volume()
    real(8) :: a(3), b(3), c(3)
    integer :: t
    exact_volume = 0
    do t = 1, size(triangles, 2)
      a = vertices(:, triangles(1, t))
      b = vertices(:, triangles(2, t))
      c = vertices(:, triangles(3, t))
      exact_volume = exact_volume + (a(1)*(b(2)*c(3) - b(3)*c(2)) + a(2)*(b(3)*c(1) - b(1)*c(3)) + &
          a(3)*(b(1)*c(2) - b(2)*c(1)))/6
    end do
  end function

  subroutine say(options, message, status)
    class(clsdf_call_options), intent(inout) :: options
    character(*), intent(in) :: message
    integer(c_int32_t), intent(inout) :: status
    print '(2a)', 'clsdf says: ', message
    if (.not. associated(options%log)) status = CLSDF_UNEXPECTED
  end subroutine

end program
