# clsdf_warnings: our own targets compile without a warning, or not at all.
add_library(clsdf_warnings INTERFACE)
target_compile_options(
  clsdf_warnings
  INTERFACE -Wall
            -Wextra
            -Wpedantic
            -Wshadow
            -Wconversion
            -Wsign-conversion
            -Wold-style-cast
            -Wnon-virtual-dtor
            -Woverloaded-virtual
            -Wdouble-promotion
            -Wformat=2)
if(PROJECT_IS_TOP_LEVEL)
  target_compile_options(clsdf_warnings INTERFACE -Werror)
endif()
