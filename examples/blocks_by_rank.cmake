# Runs PROGRAM, example_blocks_by_rank, with 1, 2 and 7 ranks: their lines must be equal. OTHER, if it is set: the same example in
# another language, which must print the same line. RUN_RANKS: cmake/RunRanks.cmake.
include(${RUN_RANKS})
if(OTHER)
  run_ranks_or_fail(1 expected ${OTHER} 64)
endif()
foreach(ranks 1 2 7)
  run_ranks_or_fail(${ranks} line ${PROGRAM} 64)
  if(DEFINED expected AND NOT line STREQUAL expected)
    message(FATAL_ERROR "the fields depend on the number of ranks, or on the language")
  endif()
  set(expected "${line}")
endforeach()
