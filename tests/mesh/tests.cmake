clsdf_test(mesh ${CMAKE_CURRENT_LIST_DIR}/mesh.cpp)
