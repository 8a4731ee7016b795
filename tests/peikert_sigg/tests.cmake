clsdf_test(classification ${CMAKE_CURRENT_LIST_DIR}/classification.cpp)
clsdf_test(root_sums ${CMAKE_CURRENT_LIST_DIR}/root_sums.cpp)
target_link_libraries(test_root_sums PRIVATE CGAL::CGAL)
# These look inside the library: at fans, planes and polyhedra.
clsdf_test(saddles ${CMAKE_CURRENT_LIST_DIR}/saddles.cpp)
target_link_libraries(test_saddles PRIVATE CGAL::CGAL)
clsdf_test(peikert_sigg_polyhedra ${CMAKE_CURRENT_LIST_DIR}/polyhedra.cpp)
target_link_libraries(test_peikert_sigg_polyhedra PRIVATE clsdf::reference)
