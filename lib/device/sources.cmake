target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/buffer_pool.cpp
          ${CMAKE_CURRENT_LIST_DIR}/context.cpp
          ${CMAKE_CURRENT_LIST_DIR}/device.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mapped_memory.cpp
          ${CMAKE_CURRENT_LIST_DIR}/opencl.cpp
          ${CMAKE_CURRENT_LIST_DIR}/pinned_reads.cpp
          ${CMAKE_CURRENT_LIST_DIR}/program_cache.cpp
          ${CMAKE_CURRENT_LIST_DIR}/requirements.cpp)
