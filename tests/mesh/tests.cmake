clsdf_test(mesh ${CMAKE_CURRENT_LIST_DIR}/mesh.cpp)
clsdf_test(mesh_defects ${CMAKE_CURRENT_LIST_DIR}/defects.cpp)
clsdf_test(topology ${CMAKE_CURRENT_LIST_DIR}/topology.cpp)
clsdf_test(sign_surface ${CMAKE_CURRENT_LIST_DIR}/sign_surface.cpp)
clsdf_test(film_tree ${CMAKE_CURRENT_LIST_DIR}/film_tree.cpp)
clsdf_test(topology_of_soups ${CMAKE_CURRENT_LIST_DIR}/topology_of_soups.cpp)
clsdf_test(mesh_file_formats ${CMAKE_CURRENT_LIST_DIR}/file_formats.cpp ${CMAKE_CURRENT_LIST_DIR}/other_writers.cpp
           ${CMAKE_CURRENT_LIST_DIR}/mistaken_files.cpp ${CMAKE_CURRENT_LIST_DIR}/polygons.cpp
           ${CMAKE_CURRENT_LIST_DIR}/stl_files.cpp)
clsdf_test(mesh_file_damage ${CMAKE_CURRENT_LIST_DIR}/file_damage.cpp)

# The shapes' saddle vertices are counted with an exact predicate.
clsdf_test(shapes ${CMAKE_CURRENT_LIST_DIR}/shapes.cpp)
target_link_libraries(test_shapes PRIVATE CGAL::CGAL)
