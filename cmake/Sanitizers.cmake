# CLSDF_SANITIZE, a list of sanitizers, applies to everything built here; an error ends the program.
if(CLSDF_SANITIZE)
  list(JOIN CLSDF_SANITIZE "," sanitizers)
  add_compile_options(-fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  # GCC 12 then takes the states of <regex> for uninitialized.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_link_options(-fsanitize=${sanitizers})
endif()
