foreach(name leaned mauch paper scan pieces)
  clsdf_test(slices_${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp)
  target_link_libraries(test_slices_${name} PRIVATE clsdf::reference OpenCL::OpenCL)
endforeach()
