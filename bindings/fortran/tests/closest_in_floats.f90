! Does not compile: the closest point is a position, and real(4) has `offset`.
program closest_in_floats
  use clsdf
  implicit none
  type(clsdf_transform) :: transform
  real(4) :: points(3, 2), distance(2), closest(3, 2)
  call transform%query(points, 1d0, distance, closest=closest)
end program
