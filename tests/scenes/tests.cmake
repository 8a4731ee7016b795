clsdf_field_test(points outer.cpp single_bodies.cpp LABELS scenes points)
clsdf_field_test(fields LABELS scenes bricks)
