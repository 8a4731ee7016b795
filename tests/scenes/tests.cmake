clsdf_field_test(points single_bodies.cpp LABELS scenes points)
