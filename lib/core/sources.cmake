target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/atomic_file.cpp
          ${CMAKE_CURRENT_LIST_DIR}/grid.cpp
          ${CMAKE_CURRENT_LIST_DIR}/large_memory.cpp
          ${CMAKE_CURRENT_LIST_DIR}/parallel_read.cpp
          ${CMAKE_CURRENT_LIST_DIR}/quoted.cpp
          ${CMAKE_CURRENT_LIST_DIR}/unfinished_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/version.cpp)
