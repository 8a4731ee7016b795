foreach(name grid length atomic_file real_numbers field_array)
  clsdf_test(${name} LABELS core)
endforeach()
