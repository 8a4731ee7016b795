foreach(name counterexamples random_meshes records cone_search one_rings morton_order cluster_index)
  clsdf_test(polyhedra_${name} ${CMAKE_CURRENT_LIST_DIR}/test_${name}.cpp)
  target_link_libraries(test_polyhedra_${name} PRIVATE TBB::tbb)
endforeach()
