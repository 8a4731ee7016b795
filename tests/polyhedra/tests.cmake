foreach(name counterexamples random_meshes records cone_search one_rings morton_order cluster_index)
  clsdf_test(polyhedra_${name} ${CMAKE_CURRENT_LIST_DIR}/test_${name}.cpp)
  target_link_libraries(test_polyhedra_${name} PRIVATE TBB::tbb)
endforeach()
# Casts to double of constants that the host and the kernels share.
set_property(SOURCE ${CMAKE_CURRENT_LIST_DIR}/test_cone_search.cpp APPEND PROPERTY COMPILE_OPTIONS "-Wno-old-style-cast")
