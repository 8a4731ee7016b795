clsdf_field_test(kept_values LABELS moves homes plan)
