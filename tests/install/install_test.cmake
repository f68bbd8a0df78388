# cmake -P: installs a build into a fresh folder, and builds and runs a project that finds gluevo
# there. Takes BINARY_DIR (of gluevo), SOURCE_DIR (of gluevo), WORK_DIR, CONFIG, CXX_COMPILER,
# GENERATOR and LIBDIR; with NN_ONLY, for a build of the networks alone, the project is nn/, which then is to do
# without what the other layers need.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
set(prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} --install ${BINARY_DIR} --config ${CONFIG} --prefix ${prefix})

# What is installed must not need where it was built.
file(GLOB_RECURSE files ${prefix}/${LIBDIR}/cmake/*.cmake)
list(LENGTH files count)
if(count LESS 4)
  message(FATAL_ERROR "package files: ${files}")
endif()
foreach(file IN LISTS files)
  file(READ ${file} text)
  string(FIND "${text}" "${SOURCE_DIR}" at)
  if(NOT at EQUAL -1)
    message(FATAL_ERROR "${file} names ${SOURCE_DIR}")
  endif()
endforeach()

set(consumer ${CMAKE_CURRENT_LIST_DIR})
set(programs gluevo gluevo-weights)
set(absent)
if(NN_ONLY)
  set(consumer ${CMAKE_CURRENT_LIST_DIR}/nn)
  set(programs)
  foreach(package OpenCV Ceres yaml-cpp HDF5)
    list(APPEND absent -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
  endforeach()
endif()
run(${CMAKE_COMMAND} -S ${consumer} -B ${WORK_DIR}/consumer -G ${GENERATOR}
    -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
    -DCMAKE_BUILD_TYPE=${CONFIG} ${absent})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer)
run(${WORK_DIR}/consumer/consumer)
message("${output}")
if(NOT NN_ONLY)
  run(${prefix}/bin/gluevo simulate -o ${WORK_DIR}/flight --start 3 --duration 0.5 --width 320
      --height 240 --threads 2)
  run(${WORK_DIR}/consumer/ten_lines ${WORK_DIR}/flight)
  message("${output}")
  string(REGEX MATCHALL "\n" lines "${output}")
  list(LENGTH lines count)
  if(NOT count EQUAL 5)
    message(FATAL_ERROR "${count} poses of 5 frames")
  endif()
endif()
foreach(program IN LISTS programs)
  run(${prefix}/bin/${program} --version)
  message("${output}")
endforeach()
file(REMOVE_RECURSE ${WORK_DIR})
