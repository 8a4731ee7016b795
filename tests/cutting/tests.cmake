foreach(name outer fractions)
  clsdf_test(cutting_${name} ${name}.cpp LABELS cutting mesh)
endforeach()
clsdf_test(cutting_fraction_arrays fraction_arrays.cpp LABELS cutting mesh LINK clsdf::reference OpenCL::OpenCL)
clsdf_test(cutting_fraction_plans fraction_plans.cpp LABELS cutting mesh LINK clsdf::reference OpenCL::OpenCL AS_GPU)
# With their sites, on every body of the kernels.
clsdf_test(cutting_transforms transforms.cpp LABELS cutting calls points LINK clsdf::papers clsdf::reference OpenCL::OpenCL AS_GPU)
