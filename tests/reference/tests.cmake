foreach(name nearest_on_triangle oracle exact_sign check reference_field self_intersections)
  clsdf_test(reference_${name} ${CMAKE_CURRENT_LIST_DIR}/test_${name}.cpp)
  target_link_libraries(test_reference_${name} PRIVATE clsdf::reference)
endforeach()

# The messages of a command that is built without clsdf::reference.
clsdf_test(reference_absent ${CMAKE_CURRENT_LIST_DIR}/absent.cpp)
target_link_libraries(test_reference_absent PRIVATE clsdf_reference_absent)
