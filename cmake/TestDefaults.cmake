# Long tests take turns: a build runs those of its turn, 0 to 2, by the number of commits. With -C nightly all run, and
# scripts/nightly keeps the record of each.
set(CLSDF_TURN 0)
find_package(Git QUIET)
if(Git_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-list --count HEAD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE commits
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(commits)
    math(EXPR CLSDF_TURN "${commits} % 3")
  endif()
endif()

# clsdf_turn(<turn> <variable>): the arguments of add_test() for that turn.
function(clsdf_turn turn variable)
  set(${variable} CONFIGURATIONS nightly PARENT_SCOPE)
  if(turn EQUAL CLSDF_TURN)
    set(${variable} "" PARENT_SCOPE)
  endif()
endfunction()

# clsdf_take_turns(<test> COMMAND <argument>... CASES <filter 0> <filter 1> <filter 2> LABELS <label>...): the cases of a long
# test of Boost.Test, in three tests, <test>_0 to <test>_2.
function(clsdf_take_turns test)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "COMMAND;CASES;LABELS")
  foreach(turn RANGE 2)
    clsdf_turn(${turn} configurations)
    list(GET arg_CASES ${turn} filter)
    add_test(NAME ${test}_${turn} COMMAND ${arg_COMMAND} ${configurations})
    set_tests_properties(${test}_${turn} PROPERTIES LABELS "${arg_LABELS}" TIMEOUT 900 ENVIRONMENT BOOST_TEST_RUN_FILTERS=${filter})
  endforeach()
endfunction()

# clsdf_test_defaults([<label>...]): at the end of a directory that adds tests. Every test gets these labels, a time limit,
# and an environment in which nothing of the user's decides the outcome. A test has a label that says what it is about
# (docs/architecture.md, "Folders"). Tests with a limit of their own are the long ones, and start first: in a new build
# folder CTest knows no durations, and at the end one core would wait for a long test on the other.
function(clsdf_test_defaults)
  set(limit 300)
  if(CLSDF_SANITIZE OR CMAKE_CROSSCOMPILING) # under emulation
    set(limit 3600)
  endif()
  get_property(tests DIRECTORY PROPERTY TESTS)
  foreach(test IN LISTS tests)
    set_property(TEST ${test} APPEND PROPERTY LABELS ${ARGN})
    get_test_property(${test} LABELS subjects)
    list(REMOVE_ITEM subjects NOTFOUND arm as_gpu implementation nightly threads)
    if(NOT subjects)
      message(SEND_ERROR "The test ${test} has no label that says what it is about (docs/architecture.md, \"Folders\")")
    endif()
    get_test_property(${test} TIMEOUT timeout)
    if(NOT timeout)
      set_tests_properties(${test} PROPERTIES TIMEOUT ${limit})
    else()
      set_tests_properties(${test} PROPERTIES COST ${timeout})
    endif()
    set_property(
      TEST ${test}
      APPEND
      PROPERTY ENVIRONMENT
               "POCL_CACHE_DIR=${PROJECT_BINARY_DIR}/pocl-cache"
               "CLSDF_CACHE_DIR=${PROJECT_BINARY_DIR}/program-cache"
               # LLVM, in PoCL's threads, has an alternate stack for signals too. Up to g++ 13 and clang 16 the interceptor of
               # __tls_get_addr takes a block of the heap for a header of glibc 2.19, depending on its address, and the leak
               # sanitizer then crashes ("Tracer caught signal 11", github.com/google/sanitizers/issues/1322).
               "ASAN_OPTIONS=use_sigaltstack=0:intercept_tls_get_addr=0"
               "LSAN_OPTIONS=suppressions='${PROJECT_SOURCE_DIR}/cmake/leak_suppressions.txt':print_suppressions=0"
               "UBSAN_OPTIONS=print_stacktrace=1"
               "TSAN_OPTIONS=ignore_noninstrumented_modules=1:die_after_fork=0:suppressions='${PROJECT_SOURCE_DIR}/cmake/thread_suppressions.txt'")
  endforeach()
endfunction()
