foreach(name nearest_on_triangle oracle exact_sign check reference_field self_intersections)
  clsdf_test(reference_${name} ${CMAKE_CURRENT_LIST_DIR}/test_${name}.cpp)
  target_link_libraries(test_reference_${name} PRIVATE clsdf::reference)
endforeach()
