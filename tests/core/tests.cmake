clsdf_test(grid ${CMAKE_CURRENT_LIST_DIR}/grid.cpp)
clsdf_test(length ${CMAKE_CURRENT_LIST_DIR}/length.cpp)
clsdf_test(atomic_file ${CMAKE_CURRENT_LIST_DIR}/atomic_file.cpp)
clsdf_test(field_array ${CMAKE_CURRENT_LIST_DIR}/field_array.cpp)
