target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/call.cpp
          ${CMAKE_CURRENT_LIST_DIR}/distance_transform.cpp
          ${CMAKE_CURRENT_LIST_DIR}/known_field.cpp
          ${CMAKE_CURRENT_LIST_DIR}/grid_plan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/plans.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_calls.cpp
          ${CMAKE_CURRENT_LIST_DIR}/plan_state.cpp
          ${CMAKE_CURRENT_LIST_DIR}/requests.cpp
          ${CMAKE_CURRENT_LIST_DIR}/restriction.cpp
          ${CMAKE_CURRENT_LIST_DIR}/self_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slab_run.cpp
          ${CMAKE_CURRENT_LIST_DIR}/stages.cpp
          ${CMAKE_CURRENT_LIST_DIR}/stored_boxes.cpp
          ${CMAKE_CURRENT_LIST_DIR}/transform_state.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vertices.cpp)
