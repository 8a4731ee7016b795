! Patches of three levels of refinement: the start of a level set, or the walls of an adaptive mesh (AMR). The transform says
! which patches the surface may cross: these are refined. Then one call computes the patches of all levels, ghost samples
! included.
program refined_patches
  use, intrinsic :: iso_c_binding
  use clsdf
  use example
  implicit none
  integer, parameter :: levels = 3, side = 16, ghosts = 2, ratio = 2, outer = side + 2*ghosts

  ! A patch of samples at the centres of cells, with its memory in the simulation.
  type :: patch
    real(4) :: distance(outer, outer, outer), gradient(3, outer, outer, outer)
  end type
  type :: level
    type(clsdf_grid) :: lattice
    integer, allocatable :: places(:, :)  ! (3, patches), in patches of the level, from 0; sorted
  end type

  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(level) :: all_levels(levels)
  type(patch), allocatable, target :: patches(:)
  type(clsdf_request), allocatable :: requests(:)
  integer :: n, i, j, total, of_level, different, number

  call mesh%shape('knot')
  call device%automatic()
  call transform%create(device, mesh)
  call first_level(all_levels(1))
  total = size(all_levels(1)%places, 2)
  do n = 2, levels
    call next_level(all_levels(n - 1), all_levels(n))
    total = total + size(all_levels(n)%places, 2)
  end do

  ! The patches of all levels in one call. Each level has its own lattice and band.
  allocate (patches(total), requests(total))
  i = 0
  do n = 1, levels
    do j = 1, size(all_levels(n)%places, 2)
      i = i + 1
      requests(i)%grid = block_at(all_levels(n)%lattice, all_levels(n)%places(:, j))
      requests(i)%grid = requests(i)%grid%grown(ghosts)
      requests(i)%band = clsdf_band_symmetric(4*all_levels(n)%lattice%voxel())
      requests(i)%targets = [clsdf_target(CLSDF_DISTANCE, patches(i)%distance), &
          clsdf_target(CLSDF_GRADIENT, patches(i)%gradient)]
    end do
  end do
  call transform%compute(requests)

  different = 0
  i = 0
  do n = 1, levels
    number = size(all_levels(n)%places, 2)
    of_level = 0
    do j = i + 1, i + number
      call record(c_loc(patches(j)%distance), 4*size(patches(j)%distance))
      call record(c_loc(patches(j)%gradient), 4*size(patches(j)%gradient))
      of_level = of_level + differences(j, i + 1, i + number)
    end do
    print '(4(a, i0), a, i0, a)', 'level ', n - 1, ': ', number, ' patches of ', outer, '**3 samples, ghost samples included; ', &
        of_level, ' of their shared samples differ'
    different = different + of_level
    i = i + number
  end do
  if (different > 0) error stop 1

contains

  type(clsdf_grid) function block_at(lattice, place)
    type(clsdf_grid), intent(in) :: lattice
    integer, intent(in) :: place(3)
    block_at = lattice%block(side*place + 1, [side, side, side])
  end function

  ! The coarsest level covers the mesh.
  subroutine first_level(coarsest)
    type(level), intent(inout) :: coarsest
    integer :: counts(3), x, y, z, n
    call coarsest%lattice%around(mesh, 48, clsdf_band_full())
    coarsest%lattice = coarsest%lattice%cell_centred()
    counts = int((coarsest%lattice%size + side - 1)/side)
    allocate (coarsest%places(3, product(counts)))
    n = 0
    do x = 0, counts(1) - 1
      do y = 0, counts(2) - 1
        do z = 0, counts(3) - 1
          n = n + 1
          coarsest%places(:, n) = [x, y, z]
        end do
      end do
    end do
  end subroutine

  ! The patches of the next level that lie within the given ones and that the surface may cross.
  subroutine next_level(coarse, fine)
    type(level), intent(in) :: coarse
    type(level), intent(inout) :: fine
    type(clsdf_grid) :: block
    type(clsdf_box), allocatable :: boxes(:)
    integer(c_int8_t), allocatable :: answers(:)
    integer, allocatable :: candidates(:, :)
    integer :: i, j, n
    fine%lattice = coarse%lattice%refined_cells(ratio)
    n = size(coarse%places, 2)*ratio**3
    allocate (boxes(n), answers(n), candidates(3, n))
    do i = 1, n
      j = mod(i - 1, ratio**3)
      candidates(:, i) = ratio*coarse%places(:, (i - 1)/ratio**3 + 1) + [mod(j, ratio), mod(j/ratio, ratio), j/ratio**2]
      block = block_at(fine%lattice, candidates(:, i))
      boxes(i) = block%box()
    end do
    call transform%classify(boxes, sqrt(0.75d0)*fine%lattice%voxel(), answers)  ! half the diagonal of a cell
    allocate (fine%places(3, count(answers == CLSDF_WITHIN)))
    n = 0
    do i = 1, size(answers)
      if (answers(i) /= CLSDF_WITHIN) cycle
      ! Insertion keeps them sorted.
      j = n
      do while (j > 0)
        if (.not. comes_before(candidates(:, i), fine%places(:, j))) exit
        fine%places(:, j + 1) = fine%places(:, j)
        j = j - 1
      end do
      fine%places(:, j + 1) = candidates(:, i)
      n = n + 1
    end do
  end subroutine

  logical function comes_before(a, b)
    integer, intent(in) :: a(3), b(3)
    integer :: axis
    comes_before = .false.
    do axis = 1, 3
      if (a(axis) == b(axis)) cycle
      comes_before = a(axis) < b(axis)
      return
    end do
  end function

  ! The number of samples of the lattice that patch `a` shares with one of the others and that have different values.
  integer function differences(a, first, last)
    integer, intent(in) :: a, first, last
    integer :: b, from_a(3), from_b(3), lower(3), upper(3)
    differences = 0
    do b = first, last
      lower = int(max(requests(a)%grid%first, requests(b)%grid%first))
      upper = int(min(requests(a)%grid%last(), requests(b)%grid%last()))
      if (any(lower > upper)) cycle
      from_a = int(requests(a)%grid%first) - 1
      from_b = int(requests(b)%grid%first) - 1
      differences = differences + count( &
          patches(a)%distance(lower(1) - from_a(1):upper(1) - from_a(1), lower(2) - from_a(2):upper(2) - from_a(2), &
          lower(3) - from_a(3):upper(3) - from_a(3)) /= &
          patches(b)%distance(lower(1) - from_b(1):upper(1) - from_b(1), lower(2) - from_b(2):upper(2) - from_b(2), &
          lower(3) - from_b(3):upper(3) - from_b(3)))
    end do
  end function

end program
