target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/grid.cpp
          ${CMAKE_CURRENT_LIST_DIR}/large_memory.cpp
          ${CMAKE_CURRENT_LIST_DIR}/outputs.cpp
          ${CMAKE_CURRENT_LIST_DIR}/text.cpp)
