target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/buffer_pool.cpp
          ${CMAKE_CURRENT_LIST_DIR}/build_records.cpp
          ${CMAKE_CURRENT_LIST_DIR}/context.cpp
          ${CMAKE_CURRENT_LIST_DIR}/device.cpp
          ${CMAKE_CURRENT_LIST_DIR}/host_filling.cpp
          ${CMAKE_CURRENT_LIST_DIR}/kernel_text.cpp
          ${CMAKE_CURRENT_LIST_DIR}/known_faults.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mapped_memory.cpp
          ${CMAKE_CURRENT_LIST_DIR}/opencl.cpp
          ${CMAKE_CURRENT_LIST_DIR}/pinned_reads.cpp
          ${CMAKE_CURRENT_LIST_DIR}/program_cache.cpp)
