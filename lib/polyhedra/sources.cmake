target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/cluster_index.cpp
          ${CMAKE_CURRENT_LIST_DIR}/face_order.cpp
          ${CMAKE_CURRENT_LIST_DIR}/frames.cpp
          ${CMAKE_CURRENT_LIST_DIR}/frusta.cpp
          ${CMAKE_CURRENT_LIST_DIR}/gaps.cpp
          ${CMAKE_CURRENT_LIST_DIR}/kernel_topology.cpp
          ${CMAKE_CURRENT_LIST_DIR}/records.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sites.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slopes.cpp
          ${CMAKE_CURRENT_LIST_DIR}/topology.cpp)
# CGAL asks for code that is right in any rounding mode; these run in the usual one, and roots and quotients then come
# by vectors.
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/face_order.cpp ${CMAKE_CURRENT_LIST_DIR}/frames.cpp
  PROPERTIES COMPILE_OPTIONS "-fno-rounding-math;-fopenmp-simd")
