# The program behind scripts/same-bytes, which compiles it with the headers of both builds. It is compiled here so that
# it stays right.
add_executable(library_bytes ${CMAKE_CURRENT_LIST_DIR}/library_bytes.cpp)
target_include_directories(library_bytes PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(library_bytes PRIVATE clsdf::clsdf clsdf_warnings OpenCL::OpenCL)
