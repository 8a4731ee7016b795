clsdf_field_test(points single_bodies.cpp LABELS scenes points)
clsdf_field_test(fields LABELS scenes bricks)
