if(TARGET clsdf_picture)
  clsdf_test(picture iso_lines.cpp round_values.cpp plane.cpp slice_pictures.cpp traced_surface.cpp surface_pictures.cpp upright.cpp
             LABELS picture LINK clsdf::picture clsdf_picture_internals OpenCL::OpenCL PkgConfig::cairo AS_GPU)
  target_compile_definitions(test_picture PRIVATE CLSDF_SOURCE="${PROJECT_SOURCE_DIR}")
endif()

# The messages of a command that is built without clsdf::picture.
clsdf_test(picture_absent absent.cpp LABELS picture LINK clsdf_picture_absent)
