target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/brick_kernel.cpp
          ${CMAKE_CURRENT_LIST_DIR}/brick_scan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/bricks_by_group.cpp
          ${CMAKE_CURRENT_LIST_DIR}/bricks_by_vector.cpp
          ${CMAKE_CURRENT_LIST_DIR}/coarse_lists.cpp
          ${CMAKE_CURRENT_LIST_DIR}/distance_transform.cpp
          ${CMAKE_CURRENT_LIST_DIR}/layout_of.cpp
          ${CMAKE_CURRENT_LIST_DIR}/plan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/prepared_mesh.cpp
          ${CMAKE_CURRENT_LIST_DIR}/programs.cpp
          ${CMAKE_CURRENT_LIST_DIR}/scan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sign_sweep.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slab_pipeline.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slabs.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slice_launches.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slice_scan.cpp)
