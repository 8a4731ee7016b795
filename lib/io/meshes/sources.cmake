# Files of meshes and points, shapes and defects (lib/tools): no HDF5, expat or JSON, so a program with a parallel HDF5 of its own may link it. clsdf::io
# stands on it, and uses its private helpers.
add_library(clsdf_meshes)
add_library(clsdf::meshes ALIAS clsdf_meshes)
set_target_properties(clsdf_meshes PROPERTIES EXPORT_NAME meshes)
target_sources(
  clsdf_meshes
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/face_groups.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mesh_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mistaken_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/npy_header.cpp
          ${CMAKE_CURRENT_LIST_DIR}/placement.cpp
          ${CMAKE_CURRENT_LIST_DIR}/ply_header.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_arrays.cpp
          ${CMAKE_CURRENT_LIST_DIR}/point_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/polygons.cpp
          ${CMAKE_CURRENT_LIST_DIR}/raw_values.cpp
          ${CMAKE_CURRENT_LIST_DIR}/read_off_obj.cpp
          ${CMAKE_CURRENT_LIST_DIR}/read_ply.cpp
          ${CMAKE_CURRENT_LIST_DIR}/read_stl.cpp
          ${CMAKE_CURRENT_LIST_DIR}/read_stl_text.cpp
          ${CMAKE_CURRENT_LIST_DIR}/text_scanner.cpp
          ${CMAKE_CURRENT_LIST_DIR}/write_meshes.cpp
          ${CMAKE_CURRENT_SOURCE_DIR}/tools/defects.cpp
          ${CMAKE_CURRENT_SOURCE_DIR}/tools/shape_surfaces.cpp
          ${CMAKE_CURRENT_SOURCE_DIR}/tools/shapes.cpp
          ${CMAKE_CURRENT_SOURCE_DIR}/tools/text.cpp
          ${CMAKE_CURRENT_SOURCE_DIR}/tools/weld_report.cpp)
target_include_directories(clsdf_meshes PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_options(clsdf_meshes PRIVATE -ffp-contract=off -fno-math-errno -fno-semantic-interposition)
target_link_libraries(
  clsdf_meshes
  PUBLIC clsdf::clsdf
  PRIVATE $<BUILD_INTERFACE:clsdf_internals> TBB::tbb ${CLSDF_FMT} $<BUILD_INTERFACE:CGAL::CGAL> $<BUILD_INTERFACE:clsdf_warnings>
          $<INSTALL_INTERFACE:mpfr> $<INSTALL_INTERFACE:gmp>)
