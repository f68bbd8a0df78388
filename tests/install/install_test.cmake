# cmake -P: installs a build into a fresh folder, and builds and runs a project that finds gluevo
# there. Takes BINARY_DIR (of gluevo), SOURCE_DIR (of gluevo), WORK_DIR, CONFIG, CXX_COMPILER and
# LIBDIR.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output
                  ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}: ${result}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

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

run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/consumer
    -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
    -DCMAKE_BUILD_TYPE=${CONFIG})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer)
run(${WORK_DIR}/consumer/consumer)
message("${output}")
foreach(program gluevo gluevo-weights)
  run(${prefix}/bin/${program} --version)
  message("${output}")
endforeach()
file(REMOVE_RECURSE ${WORK_DIR})
