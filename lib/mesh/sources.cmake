target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/defects.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mesh.cpp
          ${CMAKE_CURRENT_LIST_DIR}/shape_surfaces.cpp
          ${CMAKE_CURRENT_LIST_DIR}/shapes.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sign.cpp
          ${CMAKE_CURRENT_LIST_DIR}/topology.cpp
          ${CMAKE_CURRENT_LIST_DIR}/triples.cpp)
