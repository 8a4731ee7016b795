if(TARGET clsdf_picture)
  clsdf_test(picture ${CMAKE_CURRENT_LIST_DIR}/iso_lines.cpp ${CMAKE_CURRENT_LIST_DIR}/round_values.cpp
             ${CMAKE_CURRENT_LIST_DIR}/plane.cpp ${CMAKE_CURRENT_LIST_DIR}/slice_pictures.cpp
             ${CMAKE_CURRENT_LIST_DIR}/traced_surface.cpp ${CMAKE_CURRENT_LIST_DIR}/surface_pictures.cpp)
  target_link_libraries(test_picture PRIVATE clsdf::picture OpenCL::OpenCL PkgConfig::cairo)
  target_compile_definitions(test_picture PRIVATE CLSDF_GOLDEN="${CMAKE_CURRENT_LIST_DIR}/golden.png"
                                                  CLSDF_GOLDEN_SURFACE="${CMAKE_CURRENT_LIST_DIR}/golden_surface.png")
endif()
