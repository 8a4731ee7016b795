# Files of fields. HDF5, expat, zlib and OpenVDB stay out of the other libraries: a program with a parallel HDF5 of its own links
# clsdf::clsdf and clsdf::meshes.
add_library(clsdf_io)
add_library(clsdf::io ALIAS clsdf_io)
set_target_properties(clsdf_io PROPERTIES EXPORT_NAME io)
target_sources(
  clsdf_io
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/bricks.cpp
          ${CMAKE_CURRENT_LIST_DIR}/description.cpp
          ${CMAKE_CURRENT_LIST_DIR}/field_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/fraction_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/hdf5_layout.cpp
          ${CMAKE_CURRENT_LIST_DIR}/hdf5_read.cpp
          ${CMAKE_CURRENT_LIST_DIR}/hdf5_write.cpp
          ${CMAKE_CURRENT_LIST_DIR}/hdf5_old_format.cpp
          ${CMAKE_CURRENT_LIST_DIR}/npy.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nrrd.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nvdb_read.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nvdb_tree.cpp
          ${CMAKE_CURRENT_LIST_DIR}/nvdb_write.cpp
          ${CMAKE_CURRENT_LIST_DIR}/part_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sdf.cpp
          ${CMAKE_CURRENT_LIST_DIR}/segment_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sparse_files.cpp
          ${CMAKE_CURRENT_LIST_DIR}/$<IF:$<BOOL:${CLSDF_WITH_OPENVDB}>,vdb_write,vdb_absent>.cpp
          $<$<BOOL:${CLSDF_WITH_OPENVDB}>:${CMAKE_CURRENT_LIST_DIR}/vdb_read.cpp;${CMAKE_CURRENT_LIST_DIR}/vdb_trees.cpp>
          ${CMAKE_CURRENT_LIST_DIR}/vti_document.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vti_read.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vti_write.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vtkhdf_levels.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vtkhdf_read.cpp
          ${CMAKE_CURRENT_LIST_DIR}/vtkhdf_write.cpp)
target_include_directories(clsdf_io PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_options(clsdf_io PRIVATE -ffp-contract=off -fno-math-errno -fno-semantic-interposition)
target_link_libraries(
  clsdf_io
  PUBLIC clsdf::meshes clsdf::clsdf
  PRIVATE $<BUILD_INTERFACE:clsdf_meshes_internals> $<BUILD_INTERFACE:clsdf_internals> TBB::tbb ${CLSDF_FMT} $<BUILD_INTERFACE:nlohmann_json::nlohmann_json> $<BUILD_INTERFACE:clsdf_warnings>
          $<BUILD_INTERFACE:EXPAT::EXPAT> $<BUILD_INTERFACE:ZLIB::ZLIB> $<BUILD_INTERFACE:clsdf_hdf5> $<INSTALL_INTERFACE:expat>
          $<INSTALL_INTERFACE:z> $<INSTALL_INTERFACE:${CLSDF_HDF5_NAME}>)
if(CLSDF_WITH_OPENVDB)
  target_link_libraries(clsdf_io PRIVATE $<BUILD_INTERFACE:clsdf_openvdb> $<INSTALL_INTERFACE:openvdb> $<INSTALL_INTERFACE:Imath>)
endif()
