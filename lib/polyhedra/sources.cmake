target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/cluster_index.cpp
          ${CMAKE_CURRENT_LIST_DIR}/complete_frusta.cpp
          ${CMAKE_CURRENT_LIST_DIR}/cone_search.cpp
          ${CMAKE_CURRENT_LIST_DIR}/edge_batches.cpp
          ${CMAKE_CURRENT_LIST_DIR}/edge_slopes.cpp
          ${CMAKE_CURRENT_LIST_DIR}/edges.cpp
          ${CMAKE_CURRENT_LIST_DIR}/fan_batch.cpp
          ${CMAKE_CURRENT_LIST_DIR}/frame_batch.cpp
          ${CMAKE_CURRENT_LIST_DIR}/frusta.cpp
          ${CMAKE_CURRENT_LIST_DIR}/gaps.cpp
          ${CMAKE_CURRENT_LIST_DIR}/kernel_topology.cpp
          ${CMAKE_CURRENT_LIST_DIR}/lateral_planes.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mesh_part.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mesh_topology.cpp
          ${CMAKE_CURRENT_LIST_DIR}/morton_order.cpp
          ${CMAKE_CURRENT_LIST_DIR}/one_rings.cpp
          ${CMAKE_CURRENT_LIST_DIR}/records.cpp
          ${CMAKE_CURRENT_LIST_DIR}/side_of_plane.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sites.cpp
          ${CMAKE_CURRENT_LIST_DIR}/triangle_frame.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vertex_fans.cpp)
# CGAL asks for code that is right in any rounding mode; these run in the usual one, and roots and quotients then come
# by vectors.
set_source_files_properties(
  ${CMAKE_CURRENT_LIST_DIR}/edge_batches.cpp ${CMAKE_CURRENT_LIST_DIR}/fan_batch.cpp
  ${CMAKE_CURRENT_LIST_DIR}/frame_batch.cpp ${CMAKE_CURRENT_LIST_DIR}/morton_order.cpp
  PROPERTIES COMPILE_OPTIONS "-fno-rounding-math;-fopenmp-simd")
