# MPI for examples and integrations: MPI_CXX_FOUND, MPI_C_FOUND. On systems that have MPI's compiler without its headers,
# find_package would end the configuration with an error.
find_program(MPI_CXX_COMPILER NAMES mpicxx mpic++)
set(mpi_works 1)
if(MPI_CXX_COMPILER)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/mpi.cpp "#include <mpi.h>\n")
  execute_process(COMMAND ${MPI_CXX_COMPILER} -fsyntax-only ${CMAKE_CURRENT_BINARY_DIR}/mpi.cpp
                  RESULT_VARIABLE mpi_works OUTPUT_QUIET ERROR_QUIET)
endif()
if(mpi_works EQUAL 0)
  enable_language(C)
  find_package(MPI COMPONENTS C CXX QUIET)
endif()
