! Handles: copies are references to one object, which lives as long as the last of them; nothing leaks.
module bodies  ! of a program
  use clsdf
  implicit none
  type :: body
    type(clsdf_mesh) :: mesh
    type(clsdf_transform) :: transform
  contains
    procedure, private :: assign_body
    generic :: assignment(=) => assign_body
  end type

contains

  ! docs/fortran.md says why: gfortran 12 ends the copies of an intrinsic assignment twice.
  subroutine assign_body(left, right)
    class(body), intent(inout) :: left
    type(body), intent(in) :: right
    left%mesh = right%mesh
    left%transform = right%transform
  end subroutine

end module

program objects
  use clsdf
  use bodies
  use test
  implicit none
  type(clsdf_device) :: device
  integer :: i
  integer(8) :: before

  call device%automatic()
  call copies()
  call members()
  call once()
  before = resident()
  do i = 1, 60
    call once()
  end do
  call check(resident() - before < 60000, 'memory does not grow')  ! of 60 meshes and more

contains

  subroutine copies()
    type(clsdf_mesh) :: a, b, many(3)
    type(clsdf_mesh), allocatable :: c
    real(8), pointer :: vertices(:, :)
    integer :: count
    call check(.not. a%is_set(), 'a handle is not set at first')
    call a%shape('sphere2')
    b = a
    call a%release()
    call check(b%is_set() .and. .not. a%is_set(), 'a copy is another reference')
    call b%vertices(vertices)
    call check(abs(norm2(vertices(:, 7)) - norm2(vertices(:, 1))) < 1d-12, 'and its object is alive')
    b = b
    call b%vertices(vertices)
    count = size(vertices, 2)
    call check(count < 1000, 'assignment to itself')
    many(2) = b
    many(3:) = many(2:2)
    call b%shape('torus')
    call many(3)%vertices(vertices)
    call check(size(vertices, 2) == count, 'elements of an array; a new object in a handle leaves copies alone')
    allocate (c)
    c = many(3)
    deallocate (c)
    call many(3)%vertices(vertices)
    call check(size(vertices, 2) == count, 'the end of a copy')
    many = b
    call check(all(many%is_set()), 'an array of copies')
  end subroutine

  ! A type of the program with handles, whose assignment assigns them.
  subroutine members()
    type(body) :: first, second
    real(8) :: x(3, 1), d(1)
    call first%mesh%shape('sphere2')
    call first%transform%create(device, first%mesh)
    second = first
    call first%mesh%release()
    call first%transform%release()
    x = 0
    call second%transform%query(x, 10d0, d)
    call check(d(1) < -0.1d0, 'a copy of a type with handles')
    second = second
    call second%transform%query(x, 10d0, d)
    call check(d(1) < -0.1d0, 'which is assigned to itself')
  end subroutine

  subroutine once()
    type(clsdf_mesh) :: mesh, copy
    type(clsdf_mesh), allocatable :: list(:)
    type(body) :: whole
    call mesh%shape('sphere6')
    copy = mesh
    whole%mesh = mesh
    allocate (list(2))
    list(1) = mesh
    list(2) = copy
    call copy%shape('sphere6')
  end subroutine

  ! Kilobytes in memory.
  integer(8) function resident()
    character(200) :: line
    integer :: unit, status
    resident = 0
    open (newunit=unit, file='/proc/self/status', action='read')
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(:6) == 'VmRSS:') read (line(7:), *) resident
    end do
    close (unit)
  end function

end program
