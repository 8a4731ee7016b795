! Particles fall on a solid and bounce. In each step one call gives the distance, the normal and the triangle of every
! particle near the surface. The solid turns, so its vertices move between the steps. The particles are a structure of
! arrays: position(:, 1) are all x, position(:, 2) all y.
!
! contact_points [PARTICLES [STEPS]]
program contact_points
  use, intrinsic :: iso_c_binding
  use clsdf
  use example
  implicit none
  type :: particles
    real(8), allocatable :: position(:, :), velocity(:, :)
    real(4), allocatable :: distance(:), normal(:, :)
    integer, allocatable :: triangle(:)
  end type
  real(8), parameter :: steps_of_axes(3) = [0.8191725133961645d0, 0.6710436067037893d0, 0.5497004779019703d0]
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_box) :: box
  type(particles), target :: p
  real(8) :: side, radius, time, speed
  real(8), allocatable, target :: rows(:, :)
  real(4), allocatable, target :: normals(:, :)
  integer, allocatable, target :: numbers(:)
  integer :: count, steps, step, i, axis, contacts, inside

  count = argument(1, 20000)
  steps = argument(2, 20)
  call mesh%shape('knot')
  call device%automatic()
  call transform%create(device, mesh)
  box = mesh%box()
  side = maxval(box%upper - box%lower)
  radius = 0.004d0*side
  time = 0.02d0*sqrt(side)

  ! Particles at rest above the solid, which fill a box evenly.
  allocate (p%position(count, 3), p%velocity(count, 3), p%distance(count), p%normal(count, 3), p%triangle(count))
  do i = 1, count
    do axis = 1, 2
      p%position(i, axis) = box%lower(axis) + mod(steps_of_axes(axis)*i, 1d0)*(box%upper(axis) - box%lower(axis))
    end do
    p%position(i, 3) = box%upper(3) + mod(steps_of_axes(3)*i, 1d0)*0.2d0*(box%upper(3) - box%lower(3))
  end do
  p%velocity = 0

  contacts = 0
  do step = 0, steps - 1
    p%velocity(:, 3) = p%velocity(:, 3) - 10*time
    p%position = p%position + time*p%velocity
    call turn(0.05d0*step)
    ! In one step no particle enters the solid deeper than a few hundredths of its longest side. The arrays are of several
    ! kinds.
    call transform%query(clsdf_array(p%position), 0.1d0*side, [clsdf_target(CLSDF_DISTANCE, p%distance), &
        clsdf_target(CLSDF_TRIANGLE, p%triangle), clsdf_target(CLSDF_GRADIENT, p%normal)])
    do i = 1, count
      if (p%distance(i) >= radius .or. p%triangle(i) == 0) cycle
      contacts = contacts + 1
      speed = 0
      do axis = 1, 3
        speed = speed + p%velocity(i, axis)*p%normal(i, axis)
      end do
      p%position(i, :) = p%position(i, :) + (radius - p%distance(i))*p%normal(i, :)
      if (speed < 0) p%velocity(i, :) = p%velocity(i, :) - 1.5d0*speed*p%normal(i, :)
    end do
  end do
  ! As the other languages have them.
  rows = transpose(p%position)
  normals = transpose(p%normal)
  numbers = p%triangle - 1
  call record(c_loc(rows), 8*size(rows))
  call record(c_loc(numbers), 4*size(numbers))
  call record(c_loc(normals), 4*size(normals))
  call transform%query(clsdf_array(p%position), 0.1d0*side, [clsdf_target(CLSDF_DISTANCE, p%distance)])
  call record(c_loc(p%distance), 4*size(p%distance))
  inside = 0
  do i = 1, count
    if (p%distance(i) < 0.99d0*radius) inside = inside + 1
  end do
  print '(3(i0, a))', count, ' particles: ', contacts, ' contacts; ', inside, ' particles overlap the solid at the end'
  if (contacts == 0 .or. inside*100 >= count) error stop 1

contains

  subroutine turn(angle)
    real(8), intent(in) :: angle
    real(8) :: c, s
    c = cos(angle)
    s = sin(angle)
    call transform%set_motion(reshape([c, s, 0d0, -s, c, 0d0, 0d0, 0d0, 1d0], [3, 3]), [0d0, 0d0, 0d0])
  end subroutine

end program
