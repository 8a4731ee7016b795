# The reference uses GPL parts of CGAL (the AABB tree), so it is a library of its own. It includes nothing of the
# engine but lib/engine/surface: it must not share a mistake with what it judges.
add_library(clsdf_reference)
add_library(clsdf::reference ALIAS clsdf_reference)
set_target_properties(clsdf_reference PROPERTIES EXPORT_NAME reference)
target_sources(
  clsdf_reference
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/triangle.cpp
          ${CMAKE_CURRENT_LIST_DIR}/triangle_tree.cpp
          ${CMAKE_CURRENT_LIST_DIR}/oracle.cpp
          ${CMAKE_CURRENT_LIST_DIR}/true_samples.cpp
          ${CMAKE_CURRENT_LIST_DIR}/output_contracts.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mesh_sites.cpp
          ${CMAKE_CURRENT_LIST_DIR}/check.cpp
          ${CMAKE_CURRENT_LIST_DIR}/check_bodies.cpp
          ${CMAKE_CURRENT_LIST_DIR}/check_points.cpp
          ${CMAKE_CURRENT_LIST_DIR}/reference_field.cpp
          ${CMAKE_CURRENT_LIST_DIR}/self_intersections.cpp)
target_include_directories(clsdf_reference PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
# Without contraction the same triangle gives the same bits wherever it is evaluated, on every processor.
target_compile_options(clsdf_reference PRIVATE -ffp-contract=off)
target_link_libraries(
  clsdf_reference
  PUBLIC clsdf::clsdf
  PRIVATE $<BUILD_INTERFACE:clsdf_internals> TBB::tbb ${CLSDF_FMT} $<BUILD_INTERFACE:CGAL::CGAL> $<BUILD_INTERFACE:Eigen3::Eigen> $<BUILD_INTERFACE:clsdf_warnings> $<INSTALL_INTERFACE:mpfr>
          $<INSTALL_INTERFACE:gmp>)
