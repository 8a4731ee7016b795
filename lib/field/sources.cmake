target_sources(clsdf PRIVATE ${CMAKE_CURRENT_LIST_DIR}/outputs.cpp)
