if(TARGET clsdf_command)
  clsdf_test(
    command
    ${CMAKE_CURRENT_LIST_DIR}/bench.cpp
    ${CMAKE_CURRENT_LIST_DIR}/command.cpp
    ${CMAKE_CURRENT_LIST_DIR}/compute.cpp
    ${CMAKE_CURRENT_LIST_DIR}/devices.cpp
    ${CMAKE_CURRENT_LIST_DIR}/info.cpp
    ${CMAKE_CURRENT_LIST_DIR}/interruption.cpp
    ${CMAKE_CURRENT_LIST_DIR}/memory.cpp
    ${CMAKE_CURRENT_LIST_DIR}/method.cpp
    ${CMAKE_CURRENT_LIST_DIR}/polyhedra.cpp
    ${CMAKE_CURRENT_LIST_DIR}/render.cpp
    ${CMAKE_CURRENT_LIST_DIR}/slice.cpp)
  add_dependencies(test_command clsdf_command)
  target_compile_definitions(test_command PRIVATE CLSDF_COMMAND="$<TARGET_FILE:clsdf_command>")
  target_link_libraries(test_command PRIVATE nlohmann_json::nlohmann_json)
endif()
