# cmake -P: builds the networks alone, as GLUEVO_NN_ONLY does, without what the other layers need, and
# goes on as install_test.cmake does. Takes what that takes but BINARY_DIR, and CXX_FLAGS
# (of CONFIG); the build is kept beside WORK_DIR for the next time.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
set(BINARY_DIR ${WORK_DIR}_build)
string(TOUPPER "${CONFIG}" upper_config)
run(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${BINARY_DIR} -G ${GENERATOR}
    -DGLUEVO_NN_ONLY=ON -DGLUEVO_BUILD_TESTS=OFF -DCMAKE_BUILD_TYPE=${CONFIG}
    -DCMAKE_CXX_COMPILER=${CXX_COMPILER} "-DCMAKE_CXX_FLAGS_${upper_config}=${CXX_FLAGS}"
    -DCMAKE_DISABLE_FIND_PACKAGE_OpenCV=ON -DCMAKE_DISABLE_FIND_PACKAGE_Ceres=ON)
run(${CMAKE_COMMAND} --build ${BINARY_DIR} --config ${CONFIG} --target gluevo_nn)

set(NN_ONLY ON)
include(${CMAKE_CURRENT_LIST_DIR}/install_test.cmake)
