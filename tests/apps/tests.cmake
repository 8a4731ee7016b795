# They look at pictures, too.
if(TARGET clsdf_command AND CLSDF_BUILD_PICTURE)
  set(sources bench command compute devices documents exit_status fractions info interruption links memory method part polyhedra progress query rays render slice
              standard_streams warnings)
  list(TRANSFORM sources APPEND .cpp)
  clsdf_test(command ${sources} LABELS command LINK clsdf::papers AS_GPU)
  # Compiles kernels for caches of its own, again and again.
  clsdf_test_program(prepare prepare.cpp)
  clsdf_take_turns(
    prepare COMMAND test_prepare --color_output=no
    CASES commands_that_start*:kernels/are_said*:kernels/are_tested* kernels/of_queries*:kernels/are_right*
          kernels/of_usual*:kernels/of_bricks*:kernels/are_prepared*
    LABELS command device)
  set_tests_properties(command PROPERTIES TIMEOUT 900)
  if(CLSDF_SANITIZE)
    target_compile_definitions(test_command PRIVATE CLSDF_WITHOUT_SCRATCH)
  endif()
  clsdf_test_program(growth growth.cpp)
  clsdf_take_turns(
    growth COMMAND test_growth --color_output=no
    CASES faces_at_an_edge:corners_of_a_polygon faces_at_a_regular_vertex faces_at_a_saddle_vertex
    LABELS command surface topology frusta)
  foreach(test command prepare growth)
    add_dependencies(test_${test} clsdf_command)
    target_compile_definitions(test_${test} PRIVATE CLSDF_COMMAND="$<TARGET_FILE:clsdf_command>"
                                                    CLSDF_SOURCE="${PROJECT_SOURCE_DIR}")
    target_link_libraries(test_${test} PRIVATE nlohmann_json::nlohmann_json)
  endforeach()
endif()

if(TARGET clsdf_command)
  clsdf_test(scratch_memory LABELS command calls LINK clsdf_scratch clsdf::reference OpenCL::OpenCL)
endif()

# The readers of the files that the build makes from the options must understand them; absent readers are skipped.
if(TARGET clsdf_command_documents)
  set(made ${PROJECT_BINARY_DIR}/apps/clsdf)
  add_test(NAME completion_bash COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/completion.bash ${made}/completions/clsdf
                                        ${CMAKE_CURRENT_BINARY_DIR})
  set(documents completion_bash)
  find_program(CLSDF_MANDOC mandoc)
  find_program(CLSDF_MAN man)
  find_program(CLSDF_ZSH zsh)
  find_program(CLSDF_FISH fish)
  mark_as_advanced(CLSDF_MANDOC CLSDF_MAN CLSDF_ZSH CLSDF_FISH)
  if(CLSDF_MANDOC)
    list(APPEND documents manual_mandoc)
    add_test(NAME manual_mandoc COMMAND sh -c "'${CLSDF_MANDOC}' -Tlint '${made}/manual/'*.1")
  endif()
  if(CLSDF_MAN)
    list(APPEND documents manual_man)
    add_test(NAME manual_man COMMAND sh -c "'${CLSDF_MAN}' --warnings -Tutf8 -l '${made}/manual/'*.1 2>&1 >/dev/null | grep . && exit 1; exit 0")
  endif()
  if(CLSDF_ZSH)
    list(APPEND documents completion_zsh)
    add_test(NAME completion_zsh COMMAND ${CLSDF_ZSH} -n ${made}/completions/_clsdf)
  endif()
  if(CLSDF_FISH)
    list(APPEND documents completion_fish)
    add_test(
      NAME completion_fish
      COMMAND ${CLSDF_FISH} --no-config -c
              "source '${made}/completions/clsdf.fish'; and complete -C 'clsdf comp' | string match -q 'compute*'
               and complete -C 'clsdf compute --sign nonz' | string match -q 'nonzero*'
               and complete -C 'clsdf slice --axis ' | count | string match -q 3
               and complete -C 'clsdf shape kn' | string match -q 'knot*'")
  endif()
  set_tests_properties(${documents} PROPERTIES LABELS command)
endif()
