# Runs PROGRAM, example_blocks_by_rank, with 1, 2 and 7 ranks: their lines must be equal. OTHER, if it is set: the same example in
# another language, which must print the same line.
set(ENV{OMPI_ALLOW_RUN_AS_ROOT} 1)
# MPI's own libraries keep memory that the leak sanitizer finds.
set(ENV{ASAN_OPTIONS} "$ENV{ASAN_OPTIONS}:detect_leaks=0")
set(ENV{OMPI_ALLOW_RUN_AS_ROOT_CONFIRM} 1)
# More ranks than cores, for Open MPI 4 and 5.
set(ENV{OMPI_MCA_rmaps_base_oversubscribe} 1)
set(ENV{PRTE_MCA_rmaps_default_mapping_policy} :oversubscribe)
if(OTHER)
  execute_process(
    COMMAND ${MPIEXEC} ${COUNT_FLAG} 1 ${OTHER} 64
    OUTPUT_VARIABLE expected
    COMMAND_ERROR_IS_FATAL ANY)
  message("${OTHER}: ${expected}")
endif()
foreach(ranks 1 2 7)
  execute_process(
    COMMAND ${MPIEXEC} ${COUNT_FLAG} ${ranks} ${PROGRAM} 64
    OUTPUT_VARIABLE line
    RESULT_VARIABLE status)
  message("${ranks} ranks: ${line}")
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ranks} ranks end with ${status}")
  endif()
  if(DEFINED expected AND NOT line STREQUAL expected)
    message(FATAL_ERROR "the fields depend on the number of ranks, or on the language")
  endif()
  set(expected "${line}")
endforeach()
