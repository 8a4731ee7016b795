target_sources(
  clsdf
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/description.cpp
          ${CMAKE_CURRENT_LIST_DIR}/field.cpp
          ${CMAKE_CURRENT_LIST_DIR}/field_writer.cpp
          ${CMAKE_CURRENT_LIST_DIR}/formats.cpp
          ${CMAKE_CURRENT_LIST_DIR}/npy.cpp
          ${CMAKE_CURRENT_LIST_DIR}/npy_header.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nrrd_header.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nrrd_read.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nrrd_write.cpp
          ${CMAKE_CURRENT_LIST_DIR}/outputs.cpp
          ${CMAKE_CURRENT_LIST_DIR}/raw_values.cpp)
