clsdf_field_test(points outer.cpp single_bodies.cpp LABELS scenes points)
clsdf_field_test(fields LABELS scenes bricks)
clsdf_test(scenes_union union.cpp LABELS scenes points cutting LINK OpenCL::OpenCL)
