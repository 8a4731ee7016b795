target_sources(clsdf PRIVATE ${CMAKE_CURRENT_LIST_DIR}/convex_pieces.cpp ${CMAKE_CURRENT_LIST_DIR}/leaned_pieces.cpp
                             ${CMAKE_CURRENT_LIST_DIR}/mauch_cone.cpp ${CMAKE_CURRENT_LIST_DIR}/mauch_pieces.cpp
                             ${CMAKE_CURRENT_LIST_DIR}/peikert_sigg_pieces.cpp)
