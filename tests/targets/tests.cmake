clsdf_field_test(arrays LABELS targets)
clsdf_field_test(overlap LABELS targets)
clsdf_field_test(shared_memory LABELS targets mesh points)
clsdf_field_test(callers_memory LABELS targets mesh points moves)
