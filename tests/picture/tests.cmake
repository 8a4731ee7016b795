if(TARGET clsdf_picture)
  clsdf_test(picture ${CMAKE_CURRENT_LIST_DIR}/iso_lines.cpp ${CMAKE_CURRENT_LIST_DIR}/round_values.cpp
             ${CMAKE_CURRENT_LIST_DIR}/plane.cpp ${CMAKE_CURRENT_LIST_DIR}/slice_pictures.cpp
             ${CMAKE_CURRENT_LIST_DIR}/traced_surface.cpp ${CMAKE_CURRENT_LIST_DIR}/surface_pictures.cpp
             ${CMAKE_CURRENT_LIST_DIR}/upright.cpp)
  target_link_libraries(test_picture PRIVATE clsdf::picture clsdf_picture_internals OpenCL::OpenCL PkgConfig::cairo)
  target_compile_definitions(test_picture PRIVATE CLSDF_SOURCE="${PROJECT_SOURCE_DIR}")
endif()

# The messages of a command that is built without clsdf::picture.
clsdf_test(picture_absent ${CMAKE_CURRENT_LIST_DIR}/absent.cpp)
target_link_libraries(test_picture_absent PRIVATE clsdf_picture_absent)
