# Cross-compiles for 64-bit Arm with Debian's g++-aarch64-linux-gnu, and runs what it builds under
# qemu-user. GLUEVO_ARM64_SYSROOT has the libraries (tests/run_arm64.sh unpacks them there); the
# compiler brings its own C and C++ libraries.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(GLUEVO_ARM64_SYSROOT "${CMAKE_CURRENT_LIST_DIR}/../build/arm64-sysroot" CACHE PATH
    "Folder that Debian packages for arm64 are unpacked in")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES GLUEVO_ARM64_SYSROOT)
get_filename_component(sysroot "${GLUEVO_ARM64_SYSROOT}" ABSOLUTE)

set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_ASM_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_FIND_ROOT_PATH ${sysroot} /usr/aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# Headers that the architectures share lie beside those of this one.
include_directories(SYSTEM ${sysroot}/usr/include/aarch64-linux-gnu)

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)
