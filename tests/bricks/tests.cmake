clsdf_field_test(bodies LABELS bricks lists)
clsdf_field_test(slender_polyhedra LABELS bricks)
clsdf_field_test(plain_opencl LABELS bricks launch)
