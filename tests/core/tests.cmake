clsdf_test(grid ${CMAKE_CURRENT_LIST_DIR}/grid.cpp)
clsdf_test(length ${CMAKE_CURRENT_LIST_DIR}/length.cpp)
