clsdf_test(segment_crossings LABELS segments)
