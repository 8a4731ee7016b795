target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/box_places.cpp
          ${CMAKE_CURRENT_LIST_DIR}/curve_order.cpp
          ${CMAKE_CURRENT_LIST_DIR}/face_sides.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_mesh.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_query.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_scan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_signs.cpp)
