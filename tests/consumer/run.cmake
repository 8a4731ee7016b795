# WAY: one of those below; CLSDF: the sources; BUILD: their build tree; SCRATCH: a directory of this test's own; GENERATOR,
# COMPILER and LAUNCHER: as the library was built. For the way "wheel", which packaging/try_consumers.bash takes: PREFIX, what
# `python -m clsdf.cmake` prints, instead of BUILD; FORTRAN, a compiler or empty; BESIDE, if oneTBB and GMP are installed.
cmake_minimum_required(VERSION 3.25)

set(prefix ${SCRATCH}/prefix)
set(source ${CLSDF}/tests/consumer)
set(build ${SCRATCH}/build)
file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${build})

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${build} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# install_package([<component>...])
function(install_package)
  if(NOT ARGN)
    run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
  endif()
  foreach(component IN LISTS ARGN)
    run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix} --component ${component})
  endforeach()
  file(GLOB_RECURSE description ${prefix}/clsdf.pc)
  get_filename_component(directory "${description}" DIRECTORY)
  set(ENV{PKG_CONFIG_PATH} ${directory})
  get_filename_component(directory "${directory}" DIRECTORY)
  set(ENV{LD_LIBRARY_PATH} ${directory})
endfunction()

function(flags_of result)
  execute_process(
    COMMAND pkg-config ${ARGN}
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE
    COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  set(${result} ${flags} PARENT_SCOPE)
endfunction()

# The first program of the README, and the mesh it reads.
function(write_readme_program file)
  file(READ ${CLSDF}/README.md readme)
  if(NOT readme MATCHES "```cpp\n(#include [^`]*)```")
    message(FATAL_ERROR "README.md has no program")
  endif()
  file(WRITE ${file} "${CMAKE_MATCH_1}")
  file(WRITE ${build}/bunny.off "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
endfunction()

# A program of docs/c.md.
function(write_c_program name)
  file(READ ${CLSDF}/docs/c.md page)
  if(NOT page MATCHES "```c\n(/\\* ${name}[.]c: [^`]*)```")
    message(FATAL_ERROR "docs/c.md has no program ${name}.c")
  endif()
  file(WRITE ${build}/${name}.c "${CMAKE_MATCH_1}")
endfunction()

# first.f90 of docs/fortran.md, and a program that uses files of fields.
function(write_fortran_programs)
  file(READ ${CLSDF}/docs/fortran.md page)
  if(NOT page MATCHES "```fortran\n(! first[.]f90: [^`]*)```")
    message(FATAL_ERROR "docs/fortran.md has no program first.f90")
  endif()
  file(WRITE ${build}/first.f90 "${CMAKE_MATCH_1}")
  file(WRITE ${build}/files.f90 "program files\n  use clsdf_io\n  call clsdf_field_check_path('a.nrrd')\nend program\n")
endfunction()

# The line of docs/c.md, as a reader would paste it; and the same with files of fields. The program finds the library by
# itself.
function(try_lines_of_c)
  unset(ENV{LD_LIBRARY_PATH})
  file(REMOVE ${build}/first ${build}/slabs)
  file(STRINGS ${CLSDF}/docs/c.md line REGEX "^cc .*pkg-config" LIMIT_COUNT 1)
  run(sh -c "eval \"${line}\"")
  run(${build}/first)
  string(REPLACE clsdf-c clsdf-c-io line "${line}")
  string(REPLACE first slabs line "${line}")
  run(sh -c "eval \"${line}\"")
  run(${build}/slabs)
endfunction()

# try_lines_of_fortran(<compiler>...): the lines of docs/fortran.md that begin with these, likewise. "fc" is any compiler.
function(try_lines_of_fortran)
  unset(ENV{LD_LIBRARY_PATH})
  file(STRINGS ${CLSDF}/docs/fortran.md rpath REGEX "^rpath=" LIMIT_COUNT 1)
  list(JOIN ARGN "|" compilers)
  file(STRINGS ${CLSDF}/docs/fortran.md lines REGEX "^(${compilers}) .*pkg-config" LIMIT_COUNT 2)
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^fc " "gfortran -J . " line "${line}")
    file(REMOVE ${build}/first)
    run(sh -c "${rpath} && eval \"${line}\"")
    run(${build}/first)
  endforeach()
endfunction()

function(check_readme_program)
  run(${build}/consumer_files)
  if(NOT EXISTS ${build}/outside.nrrd)
    message(FATAL_ERROR "The README's program wrote no field of a sample outside")
  endif()
endfunction()

# configure(<compiler> <argument>...)
function(configure compiler)
  write_readme_program(${build}/readme.cpp)
  run(${CMAKE_COMMAND} -S ${source} -B ${build} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${compiler}
      -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_BUILD_TYPE=Debug -DCMAKE_PREFIX_PATH=${prefix}
      -DREADME_PROGRAM=${build}/readme.cpp ${ARGN})
endfunction()

# exports_of(<library> <result>): the symbols that a shared object exports, each once, but for templates and exceptions of other
# libraries' headers, of which every library may have a copy.
function(exports_of library result)
  find_program(nm nm REQUIRED)
  execute_process(
    COMMAND ${nm} -DC --defined-only ${library}
    OUTPUT_VARIABLE symbols
    COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "[][;]" "_" symbols "${symbols}")  # which divide CMake's lists
  string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
  set(exports "")
  foreach(symbol IN LISTS symbols)
    if(symbol MATCHES "^[0-9a-f]+ [VWu] .*(std|boost)::" AND NOT symbol MATCHES "^[0-9a-f]+ . ${own}")
      continue()
    endif()
    string(REGEX REPLACE "^[0-9a-f]+ . " "" symbol "${symbol}")
    list(APPEND exports "${symbol}")
  endforeach()
  list(REMOVE_DUPLICATES exports)
  set(${result} "${exports}" PARENT_SCOPE)
endfunction()
set(own "(typeinfo for |typeinfo name for |vtable for |VTT for |guard variable for |non-virtual thunk to )?clsdf::")

# check_exports(<library> <most>): a shared library exports what the public headers mark, and nothing else.
function(check_exports library most)
  exports_of(${build}/clsdf/lib/lib${library}.so exports)
  foreach(symbol IN LISTS exports)
    if(NOT symbol MATCHES "^${own}" OR symbol MATCHES "^[^:]*clsdf::(device|scan|points|polyhedra|transform|hdf5)::")
      message(SEND_ERROR "lib${library}.so exports ${symbol}")
    endif()
  endforeach()
  list(FILTER exports EXCLUDE REGEX "^clsdf::FieldArray<")  # a template of a public header
  list(LENGTH exports count)
  message("lib${library}.so exports ${count} symbols of clsdf")
  if(count GREATER most)
    list(JOIN exports "\n" exports)
    message(SEND_ERROR "lib${library}.so exports ${count} symbols, more than ${most}; is one of them marked CLSDF_EXPORT by "
                       "mistake?\n${exports}")
  endif()
endfunction()

# variables_of(<library> <result>): the variables of clsdf that are written to. They begin as zero, as those do that are made at
# their first use. Left out: lists of memory that is kept for good, which may be several, and a byte that stands for empty
# memory.
function(variables_of library result)
  find_program(objdump objdump REQUIRED)
  execute_process(
    COMMAND ${objdump} -t ${library}
    COMMAND grep -E " [.]t?bss.* _Z(Z|GV)*N[VK]*5clsdf"
    COMMAND grep -v -E "13keep_for_good|7nothing$"
    OUTPUT_VARIABLE variables)
  set(${result} "${variables}" PARENT_SCOPE)
endfunction()

# Libraries beside the core contain copies of its functions, and so of the variables in these source files.
function(check_internals_have_no_state)
  variables_of(${build}/clsdf/lib/libclsdf.so variables)
  if(NOT variables MATCHES "UnfinishedFiles")
    message(SEND_ERROR "libclsdf.so has no list of unfinished files: ${variables}")
  endif()
  variables_of(${build}/clsdf/lib/libclsdf_internals.a variables)
  if(variables)
    message(SEND_ERROR "A process may have these variables twice; their source file belongs to STATE_OF_PROCESS of "
                       "clsdf_internals():\n${variables}")
  endif()
endfunction()

# build_and_run([<argument of cmake --build>...])
function(build_and_run)
  run(${CMAKE_COMMAND} --build ${build} ${ARGN})
  run(${build}/consumer)
  run(${build}/consumer_host ${build}/libconsumer_plugin.so)
  # A plug-in with the static library exports one type of clsdf.
  exports_of(${build}/libconsumer_plugin.so exports)
  list(FILTER exports INCLUDE REGEX "^${own}")
  list(FILTER exports EXCLUDE REGEX " for clsdf::Error$")
  foreach(symbol IN LISTS exports)
    message(SEND_ERROR "The plug-in exports ${symbol}")
  endforeach()
endfunction()

if(WAY STREQUAL "find_package" OR WAY STREQUAL "clang")
  # Everything installed, in a project whose compiler may be another one. Neither CGAL nor Eigen is asked for.
  if(WAY STREQUAL "clang")
    find_program(clang NAMES clang++ clang++-19 clang++-18 clang++-16 clang++-14)
    if(NOT clang)
      message("skipped: clang++ is not installed (on Debian: apt-get install clang)")
      return()
    endif()
    set(COMPILER ${clang})
  endif()
  install_package()
  configure(${COMPILER} -DWAY=find_package -DCOMPONENTS=meshes,io,cuda,papers,reference,c -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON
            -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON)
  build_and_run()
  check_readme_program()
  run(${build}/consumer_meshes)
  run(${build}/consumer_cuda)
  run(${build}/consumer_papers)
  run(${build}/consumer_reference)
  run(${build}/consumer_both)

elseif(WAY STREQUAL "add_subdirectory")
  # The core alone; "shared" compiles the other libraries, too.
  configure(${COMPILER} -DWAY=add_subdirectory -DCLSDF=${CLSDF})
  build_and_run(--target consumer consumer_plugin consumer_host)

elseif(WAY STREQUAL "shared")
  configure(${COMPILER} -DWAY=add_subdirectory -DCLSDF=${CLSDF} -DBUILD_SHARED_LIBS=ON)
  run(${CMAKE_COMMAND} --build ${build} --target consumer consumer_cuda consumer_files consumer_interrupted consumer_papers)
  run(${build}/consumer)
  check_readme_program()
  run(${build}/consumer_cuda)
  run(${build}/consumer_papers)
  run(${build}/consumer_interrupted ${build}/cache)
  # A little more than there are.
  check_exports(clsdf 116)
  check_exports(clsdf_meshes 12)
  check_exports(clsdf_io 17)
  check_exports(clsdf_papers 18)
  check_exports(clsdf_cuda 28)
  check_internals_have_no_state()

elseif(WAY STREQUAL "components")
  # The core alone: a project that asks for more is told what is missing; then it gets it.
  install_package(core development)
  configure(${COMPILER} -DWAY=find_package -DCOMPONENTS=core)
  build_and_run()
  foreach(missing meshes io cuda papers openvdb)
    execute_process(
      COMMAND ${CMAKE_COMMAND} -S ${source} -B ${build} -DCOMPONENTS=${missing}
      RESULT_VARIABLE status
      OUTPUT_VARIABLE log
      ERROR_VARIABLE log)
    string(REGEX REPLACE "[ \n]+" " " log "${log}")
    set(said "component \"${missing}\" is not installed")
    if(missing STREQUAL "openvdb")
      set(said "has no component \"openvdb\". Its components are core, meshes, io,")
    endif()
    if(status EQUAL 0 OR NOT log MATCHES "${said}")
      message(FATAL_ERROR "find_package(clsdf COMPONENTS ${missing}) does not name what is missing: ${log}")
    endif()
  endforeach()
  # Another minor version has another interface: a project that asks for one is refused.
  foreach(version 0.0 1)
    execute_process(
      COMMAND ${CMAKE_COMMAND} -S ${source} -B ${SCRATCH}/refused -G ${GENERATOR} -DWAY=find_package -DVERSION=${version}
              -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${prefix}
      RESULT_VARIABLE status
      OUTPUT_VARIABLE log
      ERROR_VARIABLE log)
    string(REGEX REPLACE "[ \n]+" " " log "${log}")
    if(status EQUAL 0 OR NOT log MATCHES "compatible with requested version \"${version}\"")
      message(FATAL_ERROR "find_package(clsdf ${version}) is not refused: ${log}")
    endif()
  endforeach()
  install_package(meshes)
  configure(${COMPILER} -DWAY=find_package -DCOMPONENTS=meshes)
  run(${CMAKE_COMMAND} --build ${build})
  run(${build}/consumer_meshes)
  install_package(io papers)
  configure(${COMPILER} -DWAY=find_package -DCOMPONENTS=io,papers)
  build_and_run()
  run(${build}/consumer_papers)
  check_readme_program()

elseif(WAY STREQUAL "pkg_config")
  install_package()
  flags_of(flags --cflags --libs clsdf)
  set(program ${build}/consumer)

  # The line of docs/install.md, as a reader would paste it; c++ is the compiler that the library was built with.
  # pkg-config escapes blanks in the names of folders, for eval.
  file(STRINGS ${CLSDF}/docs/install.md line REGEX "^c\\+\\+ .*pkg-config" LIMIT_COUNT 1)
  if(NOT line MATCHES "clsdf-meshes")
    message(FATAL_ERROR "docs/install.md has no line that compiles a program with clsdf-meshes")
  endif()
  string(REGEX REPLACE "^c\\+\\+" "'${COMPILER}'" line "${line}")
  file(COPY_FILE ${source}/meshes.cpp ${build}/simulation.cpp)
  run(sh -c "eval \"${line}\"")
  run(${build}/simulation)
  # The same for the README's program.
  write_readme_program(${build}/simulation.cpp)
  string(REPLACE clsdf-meshes clsdf-io line "${line}")
  run(sh -c "eval \"${line}\"")
  file(RENAME ${build}/simulation ${build}/consumer_files)
  check_readme_program()

  run(${COMPILER} -std=c++20 ${source}/consumer.cpp ${flags} -o ${program})
  flags_of(reference_flags --cflags --libs clsdf-reference)
  run(${COMPILER} -std=c++20 ${source}/reference.cpp ${reference_flags} -o ${program}_reference)
  run(${program}_reference)
  flags_of(papers_flags --cflags --libs clsdf-papers)
  run(${COMPILER} -std=c++20 ${source}/papers.cpp ${papers_flags} -o ${program}_papers)
  run(${program}_papers)

  # Linked by a C compiler, with what its description says of a static library.
  flags_of(static_flags --static --libs clsdf)
  run(${COMPILER} -std=c++20 -DCONSUMER_OF_C -c ${source}/consumer.cpp ${flags} -o ${program}.o)
  run(cc ${source}/main.c ${program}.o ${static_flags} -o ${program}_of_c)
  run(${program}_of_c)

  # The version is the same in the header, in the library and in the description.
  flags_of(version --modversion clsdf)
  execute_process(COMMAND ${program} OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
  if(NOT output MATCHES "^clsdf ${version}: ")
    message(FATAL_ERROR "pkg-config says version ${version}, the program '${output}'")
  endif()

  # CGAL and Eigen are how the library works, not what it offers.
  execute_process(
    COMMAND ${COMPILER} -std=c++20 ${source}/consumer.cpp ${flags} -M
    OUTPUT_VARIABLE dependencies
    COMMAND_ERROR_IS_FATAL ANY)
  if(dependencies MATCHES "[^ ]+/(CGAL|Eigen)/[^ ]+")
    message(FATAL_ERROR "A program that includes clsdf/clsdf.hpp gets ${CMAKE_MATCH_0}")
  endif()
  # Nor does it get a library of files, with files of meshes or without.
  flags_of(mesh_flags --cflags --libs --static clsdf-meshes)
  if("${flags};${mesh_flags}" MATCHES "hdf5|expat|-lz|openvdb|cairo")
    message(FATAL_ERROR "A program that links clsdf and clsdf::meshes gets ${CMAKE_MATCH_0}: ${flags};${mesh_flags}")
  endif()

elseif(WAY STREQUAL "c")
  # A project in C alone, with the C interface alone: no C++ compiler, and none of the packages that the C++ libraries link.
  write_readme_program(${build}/readme.cpp)  # and its mesh
  write_c_program(first)
  write_c_program(slabs)
  install_package(c development)
  file(GLOB_RECURSE others ${prefix}/libclsdf.* ${prefix}/libclsdf_meshes.* ${prefix}/libclsdf_c_io.so.*)
  if(others)
    message(FATAL_ERROR "the component c installs ${others}")
  endif()
  set(configure_c ${CMAKE_COMMAND} -S ${source}/c -B ${build} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Debug -DPROGRAMS=${build}
                  -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenCL=ON
                  -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON)
  run(${configure_c} -DCOMPONENTS=c)
  run(${CMAKE_COMMAND} --build ${build})
  run(${build}/first)
  execute_process(COMMAND ${configure_c} -DCOMPONENTS=c_io RESULT_VARIABLE status OUTPUT_VARIABLE log ERROR_VARIABLE log)
  string(REGEX REPLACE "[ \n]+" " " log "${log}")
  if(status EQUAL 0 OR NOT log MATCHES "component \"c_io\" is not installed")
    message(FATAL_ERROR "find_package(clsdf COMPONENTS c_io) does not name what is missing: ${log}")
  endif()
  install_package(c_io)
  run(${configure_c} -DCOMPONENTS=c_io)
  run(${CMAKE_COMMAND} --build ${build})
  run(${build}/slabs)
  if(NOT EXISTS ${build}/knot.nrrd)
    message(FATAL_ERROR "slabs.c wrote no field")
  endif()
  try_lines_of_c()

elseif(WAY STREQUAL "fortran")
  # A project in Fortran alone, with the modules that are installed; and with their sources, as another compiler needs.
  write_readme_program(${build}/readme.cpp)  # and its mesh
  write_fortran_programs()
  install_package(c fortran development)
  set(configure_fortran ${CMAKE_COMMAND} -S ${source}/fortran -B ${build} -G ${GENERATOR} -DPROGRAMS=${build}
                        -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON
                        -DCMAKE_DISABLE_FIND_PACKAGE_OpenCL=ON -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON)
  run(${configure_fortran} -DCOMPONENTS=fortran)
  run(${CMAKE_COMMAND} --build ${build})
  run(${build}/first)
  install_package(c_io fortran_io)
  run(${configure_fortran} -DCOMPONENTS=fortran_io)
  run(${CMAKE_COMMAND} --build ${build})
  run(${build}/files)
  try_lines_of_fortran(gfortran fc)

elseif(WAY STREQUAL "wheel")
  # The libraries in a wheel, from C++, C and Fortran. CMake does not look for the libraries that they need.
  set(prefix ${PREFIX})
  set(ENV{PKG_CONFIG_PATH} ${PKG_CONFIG_PATH})
  set(alone "")
  foreach(package CGAL Eigen3 TBB OpenCL fmt)
    list(APPEND alone -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
  endforeach()
  string(TIMESTAMP began %s UTC)
  configure(${COMPILER} -DWAY=find_package -DCOMPONENTS=meshes,io,papers,c ${alone})
  run(${CMAKE_COMMAND} --build ${build} --target consumer)
  run(${build}/consumer)
  string(TIMESTAMP ended %s UTC)
  math(EXPR seconds "${ended} - ${began}")
  message("The first field by CMake: ${seconds} s")
  run(${CMAKE_COMMAND} --build ${build})
  run(${build}/consumer_host ${build}/libconsumer_plugin.so)
  check_readme_program()
  foreach(program meshes both)
    run(${build}/consumer_${program})
  endforeach()
  # The driver in the wheel has no programs of the papers' methods. An installed driver compiles them.
  execute_process(COMMAND ${build}/consumer_papers RESULT_VARIABLE status ERROR_VARIABLE log)
  if(NOT status EQUAL 0 AND NOT (EXISTS ${PREFIX}/driver AND log MATCHES "not among the programs that are bundled with clsdf"))
    message(FATAL_ERROR "consumer_papers: ${status}: ${log}")
  endif()
  run(${build}/consumer_interrupted ${build}/cache)
  find_program(readelf readelf REQUIRED)
  foreach(program consumer consumer_files consumer_meshes consumer_papers consumer_both)
    execute_process(
      COMMAND ${readelf} -d ${build}/${program}
      OUTPUT_VARIABLE dynamic
      COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE "[][]" " " dynamic "${dynamic}")
    string(REGEX MATCHALL "Shared library: +[^ ]+" libraries "${dynamic}")
    list(TRANSFORM libraries REPLACE ".* " "")
    list(FILTER libraries EXCLUDE REGEX "^(libclsdf.*|libstdc[+][+]|libm|libgcc_s|libc|ld-linux-x86-64)[.]so")
    if(libraries OR NOT dynamic MATCHES "libclsdf")
      message(SEND_ERROR "${program} links ${libraries}, which are not clsdf's: ${dynamic}")
    endif()
  endforeach()

  write_c_program(first)
  write_c_program(slabs)
  set(configure_in ${CMAKE_COMMAND} -G ${GENERATOR} -DPROGRAMS=${build} -DCMAKE_PREFIX_PATH=${prefix} ${alone})
  run(${configure_in} -S ${source}/c -B ${build}/c -DCOMPONENTS=c_io)
  run(${CMAKE_COMMAND} --build ${build}/c)
  run(${build}/c/first)
  run(${build}/c/slabs)
  if(FORTRAN)
    write_fortran_programs()
    run(${configure_in} -S ${source}/fortran -B ${build}/fortran -DCOMPONENTS=fortran_io -DCMAKE_Fortran_COMPILER=${FORTRAN})
    run(${CMAKE_COMMAND} --build ${build}/fortran)
    run(${build}/fortran/first)
    run(${build}/fortran/files)
  endif()
  # A project that has no Fortran is told so.
  execute_process(COMMAND ${configure_in} -S ${source}/c -B ${build}/c -DCOMPONENTS=fortran RESULT_VARIABLE status
                  OUTPUT_VARIABLE log ERROR_VARIABLE log)
  if(status EQUAL 0 OR NOT log MATCHES "enable_language.Fortran.")
    message(SEND_ERROR "find_package(clsdf COMPONENTS fortran) in C does not say what to do: ${log}")
  endif()

  find_program(pkg_config pkg-config)
  if(pkg_config)
    # The lines of the page's section, and those of C and Fortran.
    file(COPY_FILE ${source}/meshes.cpp ${build}/simulation.cpp)
    file(READ ${CLSDF}/docs/install.md page)
    string(REGEX MATCH "\n## C[+][+], C and Fortran on the Python wheel\n.*\n## Systems" section "${page}")
    string(REGEX MATCHALL "\n(c[+][+]|cc|gfortran) [^\n]*pkg-config[^\n]*" lines "${section}")
    list(LENGTH lines count)
    if(NOT count EQUAL 3)
      message(FATAL_ERROR "docs/install.md has ${count} lines that compile on the wheel: ${lines}")
    endif()
    foreach(line IN LISTS lines)
      string(STRIP "${line}" line)
      if(line MATCHES "^gfortran" AND NOT FORTRAN)
        continue()
      endif()
      string(REGEX REPLACE "^gfortran " "gfortran -J . " line "${line}")
      string(REGEX MATCH "[a-z]+$" program "${line}")
      run(sh -c "eval \"${line}\"")
      run(${build}/${program})
      file(REMOVE ${build}/${program})
    endforeach()
    try_lines_of_c()
    if(FORTRAN)
      try_lines_of_fortran(fc)
    endif()
  endif()

  if(BESIDE)
    run(${CMAKE_COMMAND} -S ${source}/beside -B ${build}/beside -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
        -DCMAKE_PREFIX_PATH=${prefix})
    run(${CMAKE_COMMAND} --build ${build}/beside)
    run(${build}/beside/clsdf_first)
    run(${build}/beside/clsdf_last)
  endif()

elseif(WAY STREQUAL "parallel_hdf5")
  find_program(mpirun mpirun)
  execute_process(COMMAND pkg-config --exists hdf5-openmpi RESULT_VARIABLE status)
  if(NOT mpirun OR NOT status EQUAL 0)
    message("skipped: parallel HDF5 is not installed (on Debian: apt-get install libhdf5-openmpi-dev openmpi-bin)")
    return()
  endif()
  install_package()
  flags_of(flags --cflags --libs clsdf-meshes)
  # Behind clsdf, where a serial HDF5 of clsdf's own would come first.
  flags_of(hdf5_flags --cflags --libs hdf5-openmpi)
  run(${COMPILER} -std=c++20 ${source}/parallel_hdf5.cpp ${flags} ${hdf5_flags} -o ${build}/parallel_hdf5)
  set(ENV{OMPI_ALLOW_RUN_AS_ROOT} 1)
  set(ENV{OMPI_ALLOW_RUN_AS_ROOT_CONFIRM} 1)
  run(${mpirun} --oversubscribe -n 2 ${build}/parallel_hdf5)

elseif(WAY STREQUAL "documents")
  # Every link of an installed document to a file leads to an installed file.
  install_package(development)
  file(GLOB_RECURSE documents ${prefix}/*.md)
  set(links 0)
  foreach(document IN LISTS documents)
    get_filename_component(folder ${document} DIRECTORY)
    file(READ ${document} text)
    # Without code, and without brackets and semicolons, which divide CMake's lists.
    string(REGEX REPLACE "`[^`]*`" "" text "${text}")
    string(REPLACE "](" "<link " text "${text}")
    string(REGEX MATCHALL "<link [^]#:;) []+" targets "${text}")
    list(TRANSFORM targets REPLACE "^<link " "")
    list(FILTER targets EXCLUDE REGEX "^https?$")  # cut at the colon
    foreach(target IN LISTS targets)
      math(EXPR links "${links} + 1")
      if(NOT EXISTS ${folder}/${target})
        message(SEND_ERROR "${document} links to ${target}, which is not installed")
      endif()
    endforeach()
  endforeach()
  if(links LESS 100)
    message(SEND_ERROR "The installed documents have only ${links} links")
  endif()

else()
  message(FATAL_ERROR "There is no way '${WAY}'")
endif()
