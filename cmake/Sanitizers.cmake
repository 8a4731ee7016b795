# CLSDF_SANITIZE, a list of sanitizers, applies to everything built here; an error ends the program.
if(CLSDF_SANITIZE)
  list(JOIN CLSDF_SANITIZE "," sanitizers)
  add_compile_options(-fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  # GCC 12 then takes the states of <regex> for uninitialized.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_link_options(-fsanitize=${sanitizers})
endif()

# CLSDF_FUZZ: everything reports the branches it takes, and tests/fuzz links libFuzzer.
if(CLSDF_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "CLSDF_FUZZ needs libFuzzer, which is clang's; configure with -DCMAKE_CXX_COMPILER=clang++ "
                        "(on Debian: apt-get install clang libclang-rt-dev)")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
