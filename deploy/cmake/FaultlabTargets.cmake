# Declares libraries, tests and benchmarks of faultlab: one place for flags and warnings.
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # ccache requires the sloppiness before it stores objects that use a precompiled header. With the base
  # folder, an object compiled in one checkout serves every other; the debugger then finds sources
  # relative to the build folder.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
    CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CMAKE_CXX_COMPILER_LAUNCHER})
endif()
find_program(MOLD mold)
if(MOLD AND NOT CMAKE_CROSSCOMPILING)  # a cross compiler does not find it
  add_link_options(-fuse-ld=mold)
endif()
find_package(Threads REQUIRED)

add_library(faultlab_flags INTERFACE)
if(FAULTLAB_WARNINGS)
  target_compile_options(faultlab_flags INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
else()
  target_compile_options(faultlab_flags INTERFACE -w)  # gcc 12 has false ones on by default, about std::string at -O2
endif()
if(FAULTLAB_WERROR)
  target_compile_options(faultlab_flags INTERFACE -Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # The compiler collects its garbage less often: 6 to 12 % of the time of three units.
  add_compile_options(--param=ggc-min-expand=300 --param=ggc-min-heapsize=524288)
endif()
file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/generated")  # the compiler cache names a folder that is there otherwise
target_include_directories(faultlab_flags INTERFACE "${CMAKE_SOURCE_DIR}" "${CMAKE_BINARY_DIR}/generated")
target_link_libraries(faultlab_flags INTERFACE Threads::Threads)
# All targets get the sanitizers, because a mix of instrumented and plain objects hides errors. (Two files, which
# allocate nothing, have them in one program only: core/filter/CMakeLists.txt.)
# UBSan's pointer checks (null, alignment, object size, vptr) are left out: with them a typical file
# compiles in 19 s instead of 9 s, and AddressSanitizer finds most of the same errors.
if(FAULTLAB_SANITIZE)
  add_compile_options(-fsanitize=${FAULTLAB_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(FAULTLAB_SANITIZE MATCHES undefined)
    add_compile_options(-fno-sanitize=vptr,null,alignment,object-size)
    if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
      add_compile_options(-fno-sanitize=function)  # clang 14 cannot compile it in coroutines
    endif()
  endif()
  if(FAULTLAB_SANITIZE MATCHES thread)
    add_compile_options(-Wno-tsan)  # Boost.Asio's headers use atomic_thread_fence
  endif()
  add_link_options(-fsanitize=${FAULTLAB_SANITIZE})
endif()

# faultlab_batches(SOURCES NAME [APART b.cc ..]): replaces the list SOURCES by files that include
# FAULTLAB_UNITY of them each, because three quarters of a compile are the headers that sources share.
# Not CMake's own unity build: its files name the sources by absolute paths, which differ between
# checkouts, so that the compiler cache would serve only one of them.
function(faultlab_batches sources name)
  cmake_parse_arguments(ARG "" "" "APART" ${ARGN})
  list(LENGTH ${sources} length)
  if(FAULTLAB_UNITY LESS 2 OR length LESS 2)
    return()
  endif()
  set(batches)
  set(count 0)
  foreach(source IN LISTS ${sources})
    get_source_file_property(apart "${source}" SKIP_UNITY_BUILD_INCLUSION)
    cmake_path(ABSOLUTE_PATH source NORMALIZE OUTPUT_VARIABLE file)
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${CMAKE_SOURCE_DIR}")
    if(apart STREQUAL ON OR source IN_LIST ARG_APART OR NOT source MATCHES "\\.cc$")
      list(APPEND batches "${source}")
      continue()
    endif()
    math(EXPR batch "${count} / ${FAULTLAB_UNITY}")
    string(APPEND text_${batch} "#include \"${file}\"\n")
    math(EXPR count "${count} + 1")
  endforeach()
  if(count GREATER 0)
    foreach(at RANGE ${batch})
      set(unity "${CMAKE_CURRENT_BINARY_DIR}/${name}_unity_${at}.cc")
      file(GENERATE OUTPUT "${unity}" CONTENT "${text_${at}}")
      list(APPEND batches "${unity}")
    endforeach()
  endif()
  set(${sources} ${batches} PARENT_SCOPE)
endfunction()

# faultlab_headers(NAME HEADERS <a> .. DEPS ..): what the libraries of this folder and below parse once, where sources
# are compiled in batches (release, ci). The preset dev has no such header: it checks that each source includes what
# it uses. gcc takes it only for sources of the same -O and -f options; a folder with others calls
# faultlab_no_headers(). In <>, also our own: an absolute path would keep the compiler cache from serving other checkouts.
function(faultlab_headers name)
  cmake_parse_arguments(ARG "" "" "HEADERS;DEPS" ${ARGN})
  set(FAULTLAB_HEADERS "" PARENT_SCOPE)
  if(FAULTLAB_UNITY LESS 2 OR NOT CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    return()
  endif()
  set(empty "${CMAKE_CURRENT_BINARY_DIR}/${name}.cc")
  file(GENERATE OUTPUT "${empty}" CONTENT "")
  add_library(${name} OBJECT "${empty}")
  add_library(${name}_uses INTERFACE)  # gcc asks each source for the definitions that these headers know
  foreach(library IN LISTS ARG_DEPS)
    target_include_directories(${name}_uses SYSTEM INTERFACE $<TARGET_PROPERTY:${library},INTERFACE_INCLUDE_DIRECTORIES>)
    target_compile_definitions(${name}_uses INTERFACE $<TARGET_PROPERTY:${library},INTERFACE_COMPILE_DEFINITIONS>)
  endforeach()
  target_compile_options(${name}_uses INTERFACE -fpch-preprocess)  # for ccache
  target_link_libraries(${name} PRIVATE faultlab_flags ${name}_uses)
  target_compile_options(${name} PRIVATE -dD)  # or ccache does not see a macro that has changed, and gives the old header
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
  set(FAULTLAB_HEADERS ${name} PARENT_SCOPE)
endfunction()

macro(faultlab_no_headers)
  set(FAULTLAB_HEADERS "")
endmacro()

# faultlab_library(NAME SOURCES a.cc .. [APART b.cc ..] [DEPS public..] [PRIVATE_DEPS ..])
# APART: sources that every build compiles separately, for a reason said there.
function(faultlab_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;APART;DEPS;PRIVATE_DEPS" ${ARGN})
  faultlab_batches(ARG_SOURCES ${name} APART ${ARG_APART})
  if(ARG_SOURCES)
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC faultlab_flags ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
    if(FAULTLAB_HEADERS)
      set_source_files_properties(${ARG_APART} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
      target_link_libraries(${name} PRIVATE ${FAULTLAB_HEADERS}_uses)
      target_precompile_headers(${name} REUSE_FROM ${FAULTLAB_HEADERS})
    endif()
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE faultlab_flags ${ARG_DEPS})
  endif()
endfunction()

# faultlab_test_headers(NAME): GoogleTest and the headers that it includes, parsed once for all
# tests of this folder and below, which saves a third of a test's compile time.
function(faultlab_test_headers name)
  find_package(GTest REQUIRED)
  set(empty "${CMAKE_CURRENT_BINARY_DIR}/${name}.cc")
  file(GENERATE OUTPUT "${empty}" CONTENT "")
  add_library(${name} OBJECT "${empty}")
  target_link_libraries(${name} PRIVATE faultlab_flags GTest::gmock)
  target_compile_options(${name} PRIVATE -fpch-preprocess)  # for ccache
  target_precompile_headers(${name} PRIVATE <gmock/gmock.h> <gtest/gtest.h> <chrono> <thread>)
  set(FAULTLAB_TEST_HEADERS ${name} PARENT_SCOPE)
endfunction()

# faultlab_test(NAME SOURCES a_test.cc .. [APART b_test.cc ..] DEPS .. [LABELS ..] [SECONDS s] [REALTIME]): a
# GoogleTest program, one ctest entry. REALTIME: its processes must keep up with real time, so deploy/test runs
# it after the others. SECONDS: how long it takes about; the longest start first. The label `pure` (all of tests/core) says that it has no thread, socket
# or process: when it fails, it is not repeated. The time limit is a guard against hanging.
function(faultlab_test name)
  cmake_parse_arguments(ARG "REALTIME" "SECONDS" "SOURCES;APART;DEPS;LABELS" ${ARGN})
  find_package(GTest REQUIRED)
  faultlab_batches(ARG_SOURCES ${name} APART ${ARG_APART})
  add_executable(${name} ${ARG_SOURCES})
  target_compile_options(${name} PRIVATE -fpch-preprocess)
  target_link_libraries(${name} PRIVATE faultlab_flags test_paths ${ARG_DEPS} GTest::gmock GTest::gtest_main)
  target_precompile_headers(${name} REUSE_FROM ${FAULTLAB_TEST_HEADERS})
  add_test(NAME ${name} COMMAND ${name})
  if(NOT ARG_SECONDS)
    set(ARG_SECONDS 5)
  endif()
  if(ARG_REALTIME)
    list(APPEND ARG_LABELS realtime)
  endif()
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "/tests/core(/|$)")
    list(APPEND ARG_LABELS pure)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT 1500 LABELS "${ARG_LABELS}" COST ${ARG_SECONDS})
endfunction()

# faultlab_bench(NAME SOURCES .. DEPS ..): a Google Benchmark program, built but not run by ctest.
function(faultlab_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  find_package(benchmark REQUIRED)
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE faultlab_flags ${ARG_DEPS} benchmark::benchmark)
endfunction()
