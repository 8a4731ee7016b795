target_sources(clsdf PRIVATE ${CMAKE_CURRENT_LIST_DIR}/equal_vertices.cpp ${CMAKE_CURRENT_LIST_DIR}/mesh.cpp
                             ${CMAKE_CURRENT_LIST_DIR}/weld.cpp)
