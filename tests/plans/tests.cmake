clsdf_field_test(grids LABELS plans)
clsdf_field_test(runs LABELS plans calls)
clsdf_field_test(points LABELS plans points)
clsdf_field_test(links LABELS plans segments)
