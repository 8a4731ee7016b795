clsdf_field_test(compute LABELS calls moves)
clsdf_field_test(requests LABELS calls)
clsdf_field_test(blocks LABELS calls)
clsdf_field_test(slabs LABELS calls lists)
clsdf_field_test(streams LABELS calls plan targets)
clsdf_field_test(restricted LABELS calls plan frusta points)
clsdf_field_test(stored_parts LABELS calls plan frusta points)
clsdf_field_test(shared_transforms LABELS calls plan points segments)
clsdf_field_test(moving_parts LABELS calls plan frusta points)
clsdf_field_test(same_bytes LABELS calls plans targets)
clsdf_field_test(promises LABELS calls)
clsdf_field_test(hostile_callers LABELS calls plans)
target_link_libraries(test_calls_promises PRIVATE clsdf::papers)

# 10,000 steps of a moving body.
add_test(NAME calls_steps COMMAND test_calls_compute --color_output=no
                                  --run_test=steps_of_a_moving_body_leave_memory_as_it_was CONFIGURATIONS nightly)
set_tests_properties(calls_steps PROPERTIES ENVIRONMENT CLSDF_STEPS=10000 LABELS "calls;moves;nightly" TIMEOUT 3600)
