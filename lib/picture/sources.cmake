# Pictures are drawn with cairo, which the library proper has no use for, so they are a library of their own.
add_library(clsdf_picture)
add_library(clsdf::picture ALIAS clsdf_picture)
set_target_properties(clsdf_picture PROPERTIES EXPORT_NAME picture)
target_sources(
  clsdf_picture
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/camera.cpp
          ${CMAKE_CURRENT_LIST_DIR}/canvas.cpp
          ${CMAKE_CURRENT_LIST_DIR}/panel.cpp
          ${CMAKE_CURRENT_LIST_DIR}/plane.cpp
          ${CMAKE_CURRENT_LIST_DIR}/scene.cpp
          ${CMAKE_CURRENT_LIST_DIR}/slice_pictures.cpp
          ${CMAKE_CURRENT_LIST_DIR}/surface_pictures.cpp
          ${CMAKE_CURRENT_LIST_DIR}/text.cpp
          ${CMAKE_CURRENT_LIST_DIR}/tracer.cpp)
# The kernels of the renderer; they and the host share render.h.
set(picture_kernel_folder ${PROJECT_SOURCE_DIR}/kernels/picture)
file(GLOB picture_kernels CONFIGURE_DEPENDS ${picture_kernel_folder}/*.h ${picture_kernel_folder}/*.cl)
clsdf_embed_kernels(clsdf_picture ${picture_kernels})
target_include_directories(clsdf_picture PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ${picture_kernel_folder})
target_compile_options(clsdf_picture PRIVATE -ffp-contract=off)
target_link_libraries(
  clsdf_picture
  PUBLIC clsdf::clsdf
  PRIVATE $<BUILD_INTERFACE:clsdf_internals> OpenCL::OpenCL TBB::tbb ${CLSDF_FMT} $<BUILD_INTERFACE:PkgConfig::cairo> $<BUILD_INTERFACE:clsdf_warnings>
          $<INSTALL_INTERFACE:cairo>)
