# For scripts of tests: run_ranks(<ranks> <variable> <command>...) runs a command by MPIEXEC (with COUNT_FLAG), as root, too,
# and with more ranks than cores. <variable> gets its output, <variable>_STATUS its status. It ends after two minutes.
set(ENV{OMPI_ALLOW_RUN_AS_ROOT} 1)
set(ENV{OMPI_ALLOW_RUN_AS_ROOT_CONFIRM} 1)
# MPI's own libraries keep memory that the leak sanitizer finds.
set(ENV{ASAN_OPTIONS} "$ENV{ASAN_OPTIONS}:detect_leaks=0")
# More ranks than cores, for Open MPI 4 and 5.
set(ENV{OMPI_MCA_rmaps_base_oversubscribe} 1)
set(ENV{PRTE_MCA_rmaps_default_mapping_policy} :oversubscribe)
set(ENV{OMPI_MCA_mpi_yield_when_idle} 1)

function(run_ranks ranks variable)
  execute_process(
    COMMAND ${MPIEXEC} ${COUNT_FLAG} ${ranks} ${ARGN}
    OUTPUT_VARIABLE output
    ERROR_VARIABLE errors
    RESULT_VARIABLE status
    TIMEOUT 120)
  message("${ranks} ranks: ${ARGN}: status ${status}\n${output}${errors}")
  set(${variable} "${output}${errors}" PARENT_SCOPE)
  set(${variable}_STATUS "${status}" PARENT_SCOPE)
endfunction()

# run_ranks_or_fail(<ranks> <variable> <command>...): the test fails if the command does.
function(run_ranks_or_fail ranks variable)
  run_ranks(${ranks} ${variable} ${ARGN})
  if(NOT "${${variable}_STATUS}" STREQUAL "0")
    message(FATAL_ERROR "${ranks} ranks end with ${${variable}_STATUS}")
  endif()
  set(${variable} "${${variable}}" PARENT_SCOPE)
endfunction()
