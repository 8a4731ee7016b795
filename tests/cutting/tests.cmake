clsdf_test(cutting_outer outer.cpp LABELS cutting mesh sign)
