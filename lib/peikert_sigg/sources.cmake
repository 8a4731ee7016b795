target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/classify.cpp ${CMAKE_CURRENT_LIST_DIR}/examine_saddles.cpp
          ${CMAKE_CURRENT_LIST_DIR}/fan_signs.cpp ${CMAKE_CURRENT_LIST_DIR}/gap_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/peikert_sigg_polyhedra.cpp ${CMAKE_CURRENT_LIST_DIR}/peikert_sigg_solids.cpp
          ${CMAKE_CURRENT_LIST_DIR}/subdivide.cpp
          ${CMAKE_CURRENT_LIST_DIR}/surface.cpp)
