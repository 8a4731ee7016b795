foreach(name outer fractions)
  clsdf_test(cutting_${name} ${name}.cpp LABELS cutting mesh)
endforeach()
