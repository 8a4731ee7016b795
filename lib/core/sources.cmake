target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/atomic_file.cpp
          ${CMAKE_CURRENT_LIST_DIR}/descriptor.cpp
          ${CMAKE_CURRENT_LIST_DIR}/grid.cpp
          ${CMAKE_CURRENT_LIST_DIR}/large_memory.cpp
          ${CMAKE_CURRENT_LIST_DIR}/outputs.cpp
          ${CMAKE_CURRENT_LIST_DIR}/text.cpp
          ${CMAKE_CURRENT_LIST_DIR}/version.cpp)
