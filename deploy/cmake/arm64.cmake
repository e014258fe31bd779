# Toolchain of an arm64 agent: Debian's cross compiler, and arm64 libraries unpacked by deploy/arm64-root in FAULTLAB_ROOT.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH "${FAULTLAB_ROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)  # lcm-gen, ccache and mold run here
set(CMAKE_EXE_LINKER_FLAGS_INIT
  "-Wl,-rpath-link,${FAULTLAB_ROOT}/usr/lib/aarch64-linux-gnu:${FAULTLAB_ROOT}/lib/aarch64-linux-gnu")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FAULTLAB_ROOT)
set(CMAKE_SKIP_RPATH ON)
