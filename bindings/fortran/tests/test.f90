!> What the tests share.
module test
  use clsdf
  implicit none
contains

  subroutine check(right, what)
    logical, intent(in) :: right
    character(*), intent(in) :: what
    if (right) return
    print '(2a)', 'WRONG: ', what
    error stop 1
  end subroutine

  !> A call gave this status, and a message with these words.
  subroutine fails(stat, expected, errmsg, words)
    integer, intent(in) :: stat, expected
    character(*), intent(in) :: errmsg, words
    if (stat == expected .and. index(errmsg, words) > 0) return
    print '(a, i0, a, i0, 4a)', 'WRONG: status ', stat, ' for ', expected, ', message "', trim(errmsg), '" without ', words
    error stop 1
  end subroutine

  !> Four triangles, from 1.
  subroutine tetrahedron(x, triangles)
    real(8), intent(out) :: x(3, 4)
    integer, intent(out) :: triangles(3, 4)
    x = reshape([0d0, 0d0, 0d0, 1d0, 0d0, 0d0, 0d0, 1d0, 0d0, 0d0, 0d0, 1d0], [3, 4])
    triangles = reshape([1, 3, 2, 1, 2, 4, 1, 4, 3, 2, 3, 4], [3, 4])
  end subroutine

end module
