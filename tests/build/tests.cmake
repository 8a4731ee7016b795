# Promises that the build itself makes.

# Texts full of what CMake's lists and C++'s literals trip over come out of the embedding as they went in.
set(treacherous ${CMAKE_CURRENT_BINARY_DIR}/treacherous.cl)
string(REPEAT "${CMAKE_CURRENT_LIST_DIR}/treacherous.txt;" 256 copies)
execute_process(COMMAND ${CMAKE_COMMAND} -E cat ${copies} OUTPUT_FILE ${treacherous} COMMAND_ERROR_IS_FATAL ANY)
clsdf_test(embedding ${CMAKE_CURRENT_LIST_DIR}/embedding.cpp)
clsdf_embed_kernels(test_embedding ${treacherous} ${CMAKE_CURRENT_LIST_DIR}/empty.h)
target_compile_definitions(test_embedding PRIVATE TREACHEROUS="${treacherous}")

# Nothing of the library proper is compiled with a header of CGAL that is under the GPL.
add_test(
  NAME licences
  COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/licences
          -P ${CMAKE_CURRENT_LIST_DIR}/licences.cmake)

# Sections that comments cite by their titles are there.
add_test(NAME citations COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -P
                                ${CMAKE_CURRENT_LIST_DIR}/citations.cmake)
