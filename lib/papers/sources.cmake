# The published methods, for comparisons. The core offers one seam, engine/plan/field_method.hpp.
add_library(clsdf_papers)
add_library(clsdf::papers ALIAS clsdf_papers)
set_target_properties(clsdf_papers PROPERTIES EXPORT_NAME papers)
target_sources(
  clsdf_papers
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/brute_force.cpp
          ${CMAKE_CURRENT_LIST_DIR}/classification.cpp
          ${CMAKE_CURRENT_LIST_DIR}/convex_polyhedron.cpp
          ${CMAKE_CURRENT_LIST_DIR}/gap_tests.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mauch.cpp
          ${CMAKE_CURRENT_LIST_DIR}/method.cpp
          ${CMAKE_CURRENT_LIST_DIR}/names.cpp
          ${CMAKE_CURRENT_LIST_DIR}/peikert_sigg.cpp
          ${CMAKE_CURRENT_LIST_DIR}/pieces.cpp
          ${CMAKE_CURRENT_LIST_DIR}/site_solids.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slice_launches.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slice_scan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/software_scan.cpp
          ${CMAKE_CURRENT_LIST_DIR}/solids.cpp)
# Mauch's scan in software may round as the processor does it fastest.
set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/site_solids.cpp ${CMAKE_CURRENT_LIST_DIR}/software_scan.cpp
                            PROPERTIES COMPILE_OPTIONS -ffp-contract=fast SKIP_PRECOMPILE_HEADERS ON)
set(papers_kernel_folder ${PROJECT_SOURCE_DIR}/kernels/papers)
file(GLOB papers_kernels CONFIGURE_DEPENDS ${papers_kernel_folder}/*.h ${papers_kernel_folder}/*.cl)
clsdf_embed_kernels(clsdf_papers ${papers_kernels})
target_include_directories(clsdf_papers PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ${papers_kernel_folder})
target_compile_options(clsdf_papers PRIVATE -ffp-contract=off -fno-math-errno -fno-semantic-interposition)
target_link_libraries(
  clsdf_papers
  PUBLIC clsdf::clsdf
  PRIVATE $<BUILD_INTERFACE:clsdf_internals> OpenCL::OpenCL TBB::tbb ${CLSDF_FMT} $<BUILD_INTERFACE:CGAL::CGAL> $<BUILD_INTERFACE:Eigen3::Eigen>
          $<BUILD_INTERFACE:clsdf_warnings> $<INSTALL_INTERFACE:mpfr> $<INSTALL_INTERFACE:gmp>)
# Only the LGPL parts of CGAL, as in the library proper.
target_compile_definitions(clsdf_papers PRIVATE CGAL_LICENSE_ERROR=1)
